//! Where requests are answered.

use super::access::{Access, value};
use super::answer::{Parts, answered, refused};
use super::limits::Limits;
use super::lines::Lines;
use super::news::{Asked, News, RunState, Standing};
use hyper::body::{Body, Bytes, Incoming};
use hyper::header::{CACHE_CONTROL, CONTENT_TYPE};
use hyper::http::StatusCode;
use hyper::{Method, Request, Response};
use serde::Serialize;
use std::cell::RefCell;
use std::future::poll_fn;
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError};
use std::time::Duration;
use tokio::time::{Instant, sleep, timeout};

/// A request for lines is answered after this time, whether there are any or not.
const PATIENCE: Duration = Duration::from_secs(10);

/// A page that was answered gets the next answer no sooner: what one screen can show.
const BETWEEN: Duration = Duration::from_millis(30);

/// The least of a series that is in one answer, if there is as much.
const LONG_ANSWER: usize = 1 << 20;

/// Nothing longer is asked for.
const LONGEST_QUESTION: usize = 4096;

/// The most of a run's news that is taken in before somebody is answered.
const MOST_NEWS: usize = 10_000;

/// A run as far as the page knows of it.
struct SeenRun {
    /// The head of its series, with the end of the line.
    head: Bytes,
    lines: Lines,
    standing: Standing,
    /// Counts the changes of `standing`.
    revision: u64,
}

/// Where requests are answered.
pub struct Desk {
    page: Bytes,
    access: Access,
    address: SocketAddr,
    question: Duration,
    run: RefCell<SeenRun>,
    news: Receiver<News>,
    asked: SyncSender<Asked>,
}

/// The answer to a request for lines: they follow it, behind the head of the series if there is none before them.
#[derive(Serialize)]
struct Answer<'a> {
    /// Where the lines after these begin.
    next: usize,
    revision: u64,
    standing: &'a Standing,
    /// Whether there are more lines already.
    more: bool,
    /// Whether the head comes first.
    head: bool,
}

impl Desk {
    /// Before a run, whose series has this head.
    pub fn new(
        (page, head): (String, String),
        (access, address): (Access, SocketAddr),
        limits: &Limits,
        news: Receiver<News>,
        asked: SyncSender<Asked>,
    ) -> Self {
        let head = Bytes::from(head + "\n");
        let run = SeenRun { head, lines: Lines::default(), standing: Standing::default(), revision: 0 };
        Self { page: page.into(), access, address, question: limits.question, run: RefCell::new(run), news, asked }
    }

    /// Takes in what the run has told since.
    pub fn catch_up(&self) {
        let mut run = self.run.borrow_mut();
        for news in self.news.try_iter().take(MOST_NEWS) {
            match news {
                News::Lines(lines) => run.lines.push(&lines),
                News::Standing(standing) => {
                    run.standing = *standing;
                    run.revision += 1;
                }
            }
        }
    }

    /// What a request is answered that is not from somebody who may look.
    pub fn refusal(&self, request: &Request<Incoming>) -> Option<Response<Parts>> {
        let why = if !self.access.is_meant(request.uri(), request.headers(), self.address) {
            "the page is served under another name"
        } else if !self.access.allows(request.uri().query().unwrap_or("")) {
            "the link needs its token: it was printed where the run was started"
        } else {
            return None;
        };
        Some(refused(StatusCode::FORBIDDEN, why))
    }

    /// The answer to a request of somebody who may look.
    pub async fn answer(&self, request: Request<Incoming>) -> Response<Parts> {
        match (request.method(), request.uri().path()) {
            (&Method::GET, "/") => answered(vec![self.page.clone()], (CONTENT_TYPE, "text/html; charset=utf-8")),
            (&Method::GET, "/lines") => {
                let query = request.uri().query().unwrap_or("");
                let number = |name| value(query, name).and_then(|text| text.parse::<u64>().ok());
                let from = number("from").unwrap_or(0) as usize;
                self.lines(from, number("revision").unwrap_or(u64::MAX)).await
            }
            (&Method::POST, "/ask") if !self.access.control => {
                refused(StatusCode::FORBIDDEN, "this page only looks; `--control` lets it steer")
            }
            (&Method::POST, "/ask") => match timeout(self.question, question(request.into_body())).await {
                Ok(Ok(question)) => self.ask(&question),
                Ok(Err((status, why))) => refused(status, why),
                Err(_) => refused(StatusCode::REQUEST_TIMEOUT, "what is asked for did not come"),
            },
            _ => refused(StatusCode::NOT_FOUND, "there is nothing here; the page is at /"),
        }
    }

    /// What has become known since, as soon as there is something.
    async fn lines(&self, from: usize, revision: u64) -> Response<Parts> {
        let began = Instant::now();
        loop {
            self.catch_up();
            let waited = began.elapsed();
            let is_soon = from > 0 && waited < BETWEEN;
            if !is_soon && (self.run.borrow().has_news(from, revision) || waited >= PATIENCE) {
                return answered(self.run.borrow().answer(from), (CACHE_CONTROL, "no-store"));
            }
            sleep(BETWEEN).await;
        }
    }

    fn ask(&self, question: &[u8]) -> Response<Parts> {
        let Ok(asked) = serde_json::from_slice(question) else {
            return refused(StatusCode::BAD_REQUEST, "that cannot be asked for");
        };
        self.catch_up();
        if self.run.borrow().standing.state == RunState::Ended {
            return refused(StatusCode::CONFLICT, "the run is over");
        }
        match self.asked.try_send(asked) {
            Ok(()) => {
                let mut response = Response::new(Parts::default());
                *response.status_mut() = StatusCode::NO_CONTENT;
                response
            }
            Err(TrySendError::Full(_)) => {
                refused(StatusCode::SERVICE_UNAVAILABLE, "the run has not come to what was asked for before")
            }
            Err(TrySendError::Disconnected(_)) => refused(StatusCode::CONFLICT, "the run is over"),
        }
    }
}

/// The body of a request, which is short.
async fn question(mut body: Incoming) -> Result<Vec<u8>, (StatusCode, &'static str)> {
    let mut question = Vec::new();
    while let Some(frame) = poll_fn(|context| Pin::new(&mut body).poll_frame(context)).await {
        let Ok(frame) = frame else {
            return Err((StatusCode::BAD_REQUEST, "what is asked for was cut off"));
        };
        question.extend_from_slice(frame.data_ref().map_or(&[], |data| data));
        if question.len() > LONGEST_QUESTION {
            return Err((StatusCode::PAYLOAD_TOO_LARGE, "nothing that long can be asked for"));
        }
    }
    Ok(question)
}

impl SeenRun {
    fn has_news(&self, from: usize, revision: u64) -> bool {
        self.lines.bytes() > from || self.revision != revision
    }

    /// The lines from a byte on, behind a line that says how things stand.
    fn answer(&self, from: usize) -> Vec<Bytes> {
        let (lines, next) = self.lines.from(from, LONG_ANSWER);
        let (head, more) = (from == 0, next < self.lines.bytes());
        let answer = Answer { next, revision: self.revision, standing: &self.standing, more, head };
        // Structures of names and numbers can always be written.
        let mut first = serde_json::to_vec(&answer).unwrap_or_default();
        first.push(b'\n');
        let mut parts = vec![Bytes::from(first)];
        parts.extend(head.then(|| self.head.clone()));
        parts.extend(lines);
        parts
    }
}
