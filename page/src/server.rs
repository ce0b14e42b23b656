//! Serves the page of a run that goes on. One thread hears requests and answers them; a request for lines waits until there
//! are some. A browser that was away, or loads the page anew, asks for what it has not got.
//!
//! | request | answer |
//! | --- | --- |
//! | `GET /` | the page |
//! | `GET /lines?from=N` | the lines behind byte N of the series, with the head if N is 0 |
//! | `POST /ask` | nothing: what is asked for comes to the driver of the run |
//!
//! Who is on this machine may look. From elsewhere, and to steer, a token is needed, which is part of the link. What another
//! page has a browser send is refused: it does not name this host, or comes from another origin.

use crate::series::Series;
use serde::{Deserialize, Serialize};
use std::io;
use std::net::{IpAddr, SocketAddr};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};
use subtle::ConstantTimeEq;
use tiny_http::{Header, Method, Request, Response, StatusCode};

/// A request for lines is answered after so long, whether there are any or not.
const PATIENCE: Duration = Duration::from_secs(10);

/// A page that was answered gets the next answer no sooner: what one screen can show.
const BETWEEN: Duration = Duration::from_millis(30);

/// How long the server sleeps while nobody asks for anything new.
const NAP: Duration = Duration::from_millis(15);

/// At most so much of a series in one answer.
const MOST_AT_ONCE: usize = 4 << 20;

/// Nothing longer is asked for.
const LONGEST_QUESTION: u64 = 4096;

/// More requests do not wait at a time.
const MOST_WAITING: usize = 64;

/// What somebody at the page asks for.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Asked {
    /// Stand still between two instants.
    Pause,
    /// Go on.
    Go,
    /// Keep pace with the clock, so many times as fast; none is as fast as possible.
    Pace(Option<f64>),
    /// Go to the next form, in whatever task.
    Step,
    /// Go to the next form of the same task that is not deeper in calls.
    Over,
    /// Go to the next form of the caller.
    Out,
    /// Stop at a line, a plan, or where a condition becomes true.
    Break(String),
    /// Stop there no more.
    Unbreak(String),
    /// End the run; its clean-ups run.
    Stop,
}

/// How a run goes on.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Standing {
    /// What it does.
    pub state: RunState,
    /// Times as fast as the clock; none is as fast as possible.
    pub pace: Option<f64>,
    /// The form it stands before: text, line and column.
    pub at: Option<String>,
    /// Why it stands still, or what was wrong with what was asked for.
    pub note: Option<String>,
    /// Where it stops.
    pub breakpoints: Vec<String>,
    /// Whether it can be steered.
    pub control: bool,
    /// Virtual time.
    pub time_us: u64,
}

/// What a run does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum RunState {
    /// It goes on.
    #[default]
    Running,
    /// It stands still.
    Paused,
    /// It is over.
    Ended,
}

/// A run that is seen: written by its driver, read by the server.
#[derive(Debug, Default)]
pub struct SeenRun {
    /// What there is to see.
    pub series: Series,
    /// How it goes on.
    pub standing: Standing,
    /// Counts the changes of `standing`.
    pub revision: u64,
}

/// A run shared with the server.
pub type Shared = Arc<Mutex<SeenRun>>;

/// The run, whoever had it last.
pub fn lock(shared: &Shared) -> MutexGuard<'_, SeenRun> {
    // Nothing in it can be left half done: lines are added whole.
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Who may do what.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Access {
    /// What the link must have in it; none if whoever reaches the server may look.
    pub token: Option<String>,
    /// Whether the run can be steered.
    pub control: bool,
}

/// A server at work; it ends with the process.
#[derive(Debug)]
pub struct Server {
    /// What to open in a browser.
    pub link: String,
    /// What is asked for.
    pub asked: Receiver<Asked>,
}

impl Server {
    /// Serves a page at an address, and the run that it asks for.
    ///
    /// # Errors
    /// The address is taken, or is none of this machine.
    pub fn start(address: SocketAddr, access: Access, page: String, shared: Shared) -> io::Result<Self> {
        let http = tiny_http::Server::http(address).map_err(io::Error::other)?;
        let address = http.server_addr().to_ip().unwrap_or(address);
        let token = access.token.as_ref().map_or(String::new(), |token| format!("?token={token}"));
        let link = format!("http://{address}/{token}");
        let (sender, asked) = channel();
        let mut desk = Desk { page, access, address, shared, sender, waiting: Vec::new() };
        thread::Builder::new().name("page".into()).spawn(move || desk.serve(&http))?;
        Ok(Self { link, asked })
    }
}

/// A request for lines that waits.
struct Waiting {
    request: Request,
    from: usize,
    revision: u64,
    since: Instant,
}

/// Where requests are answered.
struct Desk {
    page: String,
    access: Access,
    address: SocketAddr,
    shared: Shared,
    sender: Sender<Asked>,
    waiting: Vec<Waiting>,
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
    fn serve(&mut self, http: &tiny_http::Server) {
        loop {
            let patience = if self.waiting.is_empty() { PATIENCE } else { NAP };
            match http.recv_timeout(patience) {
                Ok(Some(request)) => self.hear(request),
                Ok(None) => {}
                Err(_) => return,
            }
            self.answer_waiting();
        }
    }

    fn hear(&mut self, mut request: Request) {
        let url = request.url().to_string();
        let (path, query) = url.split_once('?').unwrap_or((&url, ""));
        let method = request.method().clone();
        match (method, path) {
            _ if !self.is_ours(&request) => refuse(request, 403, "the page is served under another name"),
            _ if !self.is_allowed(query) => {
                refuse(request, 403, "the link needs its token: it was printed where the run was started");
            }
            (Method::Get, "/") => {
                let html =
                    Response::from_string(&self.page).with_header(header("Content-Type", "text/html; charset=utf-8"));
                request.respond(html).ok();
            }
            (Method::Get, "/lines") => {
                let number = |name| value(query, name).and_then(|text| text.parse().ok());
                let from = number("from").unwrap_or(0) as usize;
                let revision = number("revision").unwrap_or(u64::MAX);
                if self.waiting.len() >= MOST_WAITING {
                    return refuse(request, 503, "too many pages look at this run");
                }
                self.waiting.push(Waiting { request, from, revision, since: Instant::now() });
            }
            (Method::Post, "/ask") if !self.access.control => {
                refuse(request, 403, "this page only looks; `--control` lets it steer");
            }
            (Method::Post, "/ask") => {
                let mut text = String::new();
                let read =
                    io::Read::read_to_string(&mut io::Read::take(request.as_reader(), LONGEST_QUESTION), &mut text);
                match read.ok().and_then(|_| serde_json::from_str::<Asked>(&text).ok()) {
                    Some(asked) => {
                        self.sender.send(asked).ok();
                        request.respond(Response::empty(204)).ok();
                    }
                    None => refuse(request, 400, "that cannot be asked for"),
                }
            }
            _ => refuse(request, 404, "there is nothing here; the page is at /"),
        }
    }

    /// Whether a request was meant for this server: a page of somebody else can have a browser ask under that page's name, or
    /// send something from its origin.
    fn is_ours(&self, request: &Request) -> bool {
        let field = |name: &'static str| {
            let header = request.headers().iter().find(|header| header.field.equiv(name));
            header.map(|header| header.value.as_str().to_string())
        };
        let is_here = |host: &str| {
            let name = host.rsplit_once(':').map_or(host, |(name, _)| name).trim_matches(['[', ']']);
            name == "localhost"
                || name.parse::<IpAddr>().is_ok_and(|ip| ip == self.address.ip() || !self.address.ip().is_loopback())
        };
        // Behind an address for all networks the machine has names we do not know; there is the token.
        let is_named = field("Host").is_some_and(|host| is_here(&host) || self.access.token.is_some());
        let origin = field("Origin").filter(|origin| origin != "null");
        is_named && origin.is_none_or(|origin| Some(origin.trim_start_matches("http://").to_string()) == field("Host"))
    }

    fn is_allowed(&self, query: &str) -> bool {
        self.access.token.as_deref().is_none_or(|token| value(query, "token").is_some_and(|said| is_same(said, token)))
    }

    fn answer_waiting(&mut self) {
        for waiting in std::mem::take(&mut self.waiting) {
            let waited = waiting.since.elapsed();
            let run = lock(&self.shared);
            let is_news = run.series.lines().len() > waiting.from || run.revision != waiting.revision;
            if waited < BETWEEN && waiting.from > 0 || !is_news && waited < PATIENCE {
                drop(run);
                self.waiting.push(waiting);
                continue;
            }
            let body = answer(&run, waiting.from);
            drop(run);
            let lines = Response::from_data(body).with_header(header("Cache-Control", "no-store"));
            // Who is gone will ask again.
            waiting.request.respond(lines).ok();
        }
    }
}

/// The lines from a byte on, behind a line that says how things stand.
fn answer(run: &SeenRun, from: usize) -> Vec<u8> {
    let lines = run.series.lines();
    let from = from.min(lines.len());
    let mut next = lines.len().min(from + MOST_AT_ONCE);
    // Lines are not torn.
    while next < lines.len() && lines[next - 1] != b'\n' {
        next += 1;
    }
    let (head, more) = (from == 0, next < lines.len());
    let answer = Answer { next, revision: run.revision, standing: &run.standing, more, head };
    let mut body = serde_json::to_vec(&answer).unwrap_or_default();
    body.push(b'\n');
    if head {
        body.extend_from_slice(run.series.head().as_bytes());
        body.push(b'\n');
    }
    body.extend_from_slice(&lines[from..next]);
    body
}

fn header(name: &'static str, value: &'static str) -> Header {
    let [field, value] = [name, value].map(str::as_bytes);
    match Header::from_bytes(field, value) {
        Ok(header) => header,
        Err(()) => unreachable!("names and values of headers are ASCII"),
    }
}

fn refuse(request: Request, status: u16, why: &str) {
    request.respond(Response::from_string(why).with_status_code(StatusCode(status))).ok();
}

/// A value of a query.
fn value<'q>(query: &'q str, name: &str) -> Option<&'q str> {
    query.split('&').find_map(|pair| pair.strip_prefix(name)?.strip_prefix('='))
}

/// Whether two secrets are the same, in a time that does not tell how far they are.
fn is_same(said: &str, token: &str) -> bool {
    said.as_bytes().ct_eq(token.as_bytes()).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::{Head, Seen};
    use std::io::{Read, Write};
    use std::net::TcpStream;

    fn served(access: Access) -> (Server, SocketAddr, Shared) {
        let shared = Shared::default();
        lock(&shared).series = Series::new(&Head { plan: "p.rpl".into(), ..Head::default() });
        lock(&shared).series.add(7, &Seen::Targets(vec![[1, 2]]));
        let server =
            Server::start(([127, 0, 0, 1], 0).into(), access, "<p>".into(), shared.clone()).expect("it starts");
        let address = server.link["http://".len()..].split('/').next().and_then(|host| host.parse().ok());
        (server, address.expect("the link has an address"), shared)
    }

    /// The status and the body of an answer.
    fn ask(address: SocketAddr, line: &str, host: &str, more: &str) -> (String, String) {
        let mut stream = TcpStream::connect(address).expect("it listens");
        let body = more.split_once("\r\n\r\n").map_or("", |(_, body)| body);
        let fields = more.split_once("\r\n\r\n").map_or(more, |(fields, _)| fields);
        let length = body.len();
        write!(
            stream,
            "{line} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\nContent-Length: {length}\r\n{fields}\r\n\r\n{body}"
        )
        .expect("it hears");
        let mut said = String::new();
        stream.read_to_string(&mut said).expect("it answers");
        let (head, body) = said.split_once("\r\n\r\n").expect("an answer has a head");
        (head.split(' ').nth(1).unwrap_or_default().to_string(), body.to_string())
    }

    const LOOKING: Access = Access { token: None, control: false };

    #[test]
    fn lines_come_from_where_a_page_has_them_and_the_head_comes_first() {
        let (_server, address, shared) = served(LOOKING);
        let host = address.to_string();
        let (status, body) = ask(address, "GET /lines?from=0", &host, "X: y");
        assert_eq!(status, "200");
        assert!(body.contains("\"plan\":\"p.rpl\"") && body.ends_with("[7,{\"targets\":[[1,2]]}]\n"), "{body}");
        let next = lock(&shared).series.lines().len();
        lock(&shared).series.add(8, &Seen::Targets(Vec::new()));
        let (_, body) = ask(address, &format!("GET /lines?from={next}&revision=0"), &host, "X: y");
        assert!(body.contains("\"head\":false") && body.ends_with("}\n[8,{\"targets\":[]}]\n"), "{body}");
    }

    #[test]
    fn who_has_no_token_or_comes_from_another_page_is_refused() {
        let (_server, address, _) = served(LOOKING);
        assert_eq!(ask(address, "GET /", "evil.example", "X: y").0, "403");
        assert_eq!(ask(address, "GET /", &address.to_string(), "Origin: http://evil.example").0, "403");
        assert_eq!(ask(address, "POST /ask", &address.to_string(), "X: y\r\n\r\n\"pause\"").0, "403");
        let (server, address, _) = served(Access { token: Some("secret".into()), control: true });
        let host = address.to_string();
        assert_eq!(ask(address, "GET /", &host, "X: y").0, "403");
        assert_eq!(ask(address, "POST /ask?token=secreT", &host, "X: y\r\n\r\n\"pause\"").0, "403");
        assert_eq!(ask(address, "GET /?token=secret", &host, "X: y").0, "200");
        assert_eq!(ask(address, "POST /ask?token=secret", &host, "X: y\r\n\r\n{\"pace\":2.5}").0, "204");
        assert_eq!(ask(address, "POST /ask?token=secret", &host, "X: y\r\n\r\n\"fly\"").0, "400");
        assert_eq!(server.asked.recv().expect("it was heard"), Asked::Pace(Some(2.5)));
    }
}
