//! The server as those see it who connect: some look and steer, others want to keep them from it.

use super::news::{RunState, Standing};
use super::*;
use crate::series::{Head, Seen, Series, SeriesWriter};
use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream as Line};

/// How long an answer that comes at once is waited for, on whatever machine.
const MOST_PATIENT: Duration = Duration::from_secs(20);

const LOOKING: Access = Access { token: None, control: false };

const STEERING: Access = Access { token: None, control: true };

const MOMENT: Duration = Duration::from_millis(30);

const ROOM: usize = 8;

const LONG: usize = 16 << 20;

/// Few places, and limits of time that no test comes to.
fn roomy() -> Limits {
    let long = Duration::from_secs(600);
    let limits = Limits::of_process();
    Limits { connections: ROOM, head: long, question: long, requests: long, last_answer: long, ..limits }
}

struct Served {
    server: Server,
    address: SocketAddr,
    writer: SeriesWriter,
    /// How long the lines are that were told.
    bytes: usize,
}

impl Served {
    fn new(access: Access, limits: Limits, page: &str) -> Self {
        let head = Series::new(&Head { plan: "p.rpl".into(), ..Head::default() }).head().to_string();
        let server = Server::start_within(limits, ([127, 0, 0, 1], 0).into(), access, page.into(), head);
        let server = server.expect("it starts");
        let address = server.link["http://".len()..].split('/').next().and_then(|host| host.parse().ok());
        let address = address.expect("the link has an address");
        let mut served = Self { server, address, writer: SeriesWriter::default(), bytes: 0 };
        served.tell(7, &[[1, 2]]);
        served
    }

    /// The run tells of targets.
    fn tell(&mut self, time_us: u64, targets: &[[i32; 2]]) {
        let lines = self.writer.lines(time_us, [Seen::Targets(targets.to_vec())]);
        self.bytes += lines.len();
        self.server.news.send(News::Lines(lines)).expect("the page hears");
    }

    /// The run tells more than the system takes in for somebody who does not read.
    fn tell_long(&self) {
        let line = format!("{}\n", "x".repeat(LONG));
        self.server.news.send(News::Lines(line)).expect("the page hears");
    }

    /// Waits whether something is asked for.
    fn nothing_is_asked(&self, time_ms: u64) -> bool {
        self.server.asked.recv_timeout(Duration::from_millis(time_ms)).is_err()
    }

    fn connect(&self) -> Line {
        let line = Line::connect(self.address).expect("it listens");
        line.set_read_timeout(Some(MOST_PATIENT)).expect("it can be set");
        line
    }

    /// A request with a body, whose connection is closed by the answer.
    fn request(&self, first: &str, more: &str, body: &str) -> String {
        let (host, length) = (self.address, body.len());
        format!("{first} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\nContent-Length: {length}\r\n{more}\r\n{body}")
    }

    /// The status and the body of an answer.
    fn ask(&self, first: &str, more: &str, body: &str) -> (String, String) {
        let mut line = self.connect();
        line.write_all(self.request(first, more, body).as_bytes()).expect("it hears");
        let said = all_said(&mut line).expect("it answers");
        let (head, body) = said.split_once("\r\n\r\n").expect("an answer has a head");
        (head.split(' ').nth(1).unwrap_or_default().to_string(), body.to_string())
    }
}

/// What is said until the connection is closed; none if it stays open.
fn all_said(line: &mut Line) -> Option<String> {
    let mut said = Vec::new();
    match line.read_to_end(&mut said) {
        Err(error) if [ErrorKind::WouldBlock, ErrorKind::TimedOut].contains(&error.kind()) => None,
        // Whoever says more than is heard is cut off.
        Ok(_) | Err(_) => Some(String::from_utf8_lossy(&said).into_owned()),
    }
}

#[test]
fn lines_come_from_where_a_page_has_them_and_the_head_comes_first() {
    let mut served = Served::new(LOOKING, Limits::of_process(), "<p>");
    let (status, body) = served.ask("GET /lines?from=0", "", "");
    assert_eq!(status, "200");
    assert!(body.contains("\"plan\":\"p.rpl\"") && body.ends_with("[7,{\"targets\":[[1,2]]}]\n"), "{body}");
    let next = served.bytes;
    served.tell(8, &[]);
    let (_, body) = served.ask(&format!("GET /lines?from={next}&revision=0"), "", "");
    assert!(body.contains("\"head\":false") && body.ends_with("}\n[8,{\"targets\":[]}]\n"), "{body}");
}

#[test]
fn who_has_no_token_or_comes_from_another_page_is_refused() {
    let served = Served::new(LOOKING, Limits::of_process(), "<p>");
    let address = served.address;
    let status_of = |text: String| {
        let mut line = served.connect();
        line.write_all(text.as_bytes()).expect("it hears");
        all_said(&mut line).expect("it answers").split(' ').nth(1).map(str::to_string)
    };
    for first in ["GET / HTTP/1.1\r\nHost: evil.example", "GET / HTTP/1.1", "GET / HTTP/1.0"] {
        let status = status_of(format!("{first}\r\nConnection: close\r\n\r\n"));
        assert_eq!(status.as_deref(), Some("403"), "{first}");
    }
    for url in ["http://evil.example/".to_string(), format!("http://{address}/")] {
        let status = status_of(format!("GET {url} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n"));
        assert_eq!(status.as_deref(), Some("403"), "{url}");
    }
    assert_eq!(served.ask("GET /", "Origin: http://evil.example\r\n", "").0, "403");
    assert_eq!(served.ask("GET /", "Origin: \u{e9}\r\n", "").0, "403");
    assert_eq!(served.ask("GET /", &format!("Origin: http://{address}\r\n"), "").0, "200");
    assert_eq!(served.ask("POST /ask", "", "\"pause\"").0, "403");
    let served = Served::new(Access { token: Some("secret".into()), control: true }, Limits::of_process(), "<p>");
    assert_eq!(served.ask("GET /", "", "").0, "403");
    assert_eq!(served.ask("POST /ask?token=secreT", "", "\"pause\"").0, "403");
    assert_eq!(served.ask("GET /?token=secret", "", "").0, "200");
    assert_eq!(served.ask("POST /ask?token=secret", "", "{\"pace\":2.5}").0, "204");
    assert_eq!(served.ask("POST /ask?token=secret", "", "\"fly\"").0, "400");
    assert_eq!(served.server.asked.recv().expect("it was heard"), Asked::Pace(Some(2.5)));
}

#[test]
fn what_is_asked_for_is_kept_within_bounds_until_the_run_comes_to_it() {
    let served = Served::new(STEERING, Limits::of_process(), "<p>");
    let many = (0..=MOST_ASKED).map(|_| served.ask("POST /ask", "", "\"pause\"").0);
    let statuses: Vec<String> = many.collect();
    assert!(statuses[..MOST_ASKED].iter().all(|status| status == "204") && statuses[MOST_ASKED] == "503");
    assert_eq!(served.server.asked.try_iter().count(), MOST_ASKED);
    assert_eq!(served.ask("POST /ask", "", &format!("{:5000}", "\"pause\"")).0, "413");
    let over = Standing { state: RunState::Ended, ..Standing::default() };
    served.server.news.send(News::Standing(Box::new(over))).expect("the page hears");
    assert_eq!(served.ask("POST /ask", "", "\"pause\"").0, "409");
    assert_eq!(served.server.asked.try_iter().count(), 0);
}

/// How somebody keeps a connection that came to nothing, by what is said on it. `HOST` is the server.
const STALLS: [(&str, &str); 12] = [
    ("says nothing", ""),
    ("the head is slow", "GET / HTTP/1.1\r\nHos"),
    ("a body of a request that has none", "GET / HTTP/1.1\r\nHost: HOST\r\nContent-Length: 1000000\r\n\r\n"),
    (
        "a body that waits to be wanted",
        "POST /ask?T HTTP/1.1\r\nHost: HOST\r\nExpect: 100-continue\r\nContent-Length: 9\r\n\r\n",
    ),
    ("a body that breaks off", "POST /ask?T HTTP/1.1\r\nHost: HOST\r\nContent-Length: 9\r\n\r\n\"sto"),
    ("a body without an end", "POST /ask?T HTTP/1.1\r\nHost: HOST\r\nTransfer-Encoding: chunked\r\n\r\n1\r\n\"\r\n"),
    ("a body for what is not there", "POST /x HTTP/1.1\r\nHost: HOST\r\nContent-Length: 1000000\r\n\r\n"),
    ("lines that nobody takes", "GET /lines?from=0 HTTP/1.1\r\nHost: HOST\r\n\r\n"),
    ("lines that are long in coming", "GET /lines?from=99999999&revision=0 HTTP/1.1\r\nHost: HOST\r\n\r\n"),
    ("the page and more of it", "GET / HTTP/1.1\r\nHost: HOST\r\n\r\n"),
    ("HTTP/0.9", "GET /\r\n"),
    ("TLS", "\u{16}\u{3}\u{1}\u{2}\u{0}\u{1}\u{0}\u{1}"),
];

#[test]
fn nobody_keeps_others_from_the_page() {
    let control = |token: Option<&str>| Access { token: token.map(str::to_string), control: true };
    for access in [control(None), control(Some("secret"))] {
        let query = access.token.as_ref().map_or(String::new(), |token| format!("?token={token}"));
        let mut served = Served::new(access, roomy(), "<p>");
        served.tell_long();
        for (name, said) in STALLS {
            let said = said.replace("HOST", &served.address.to_string());
            let stalled: Vec<Line> = (0..3 * ROOM)
                .map(|_| {
                    let mut line = served.connect();
                    // Pipelined; and whoever has been shown the door cannot say more.
                    (0..4).try_for_each(|_| line.write_all(said.as_bytes())).ok();
                    line
                })
                .collect();
            stalled[..ROOM].iter().for_each(|line| line.shutdown(Shutdown::Write).unwrap_or(()));
            assert_eq!(served.ask(&format!("GET /{query}"), "", "").1, "<p>", "{name}{query}");
            assert_eq!(served.ask(&format!("POST /ask{query}"), "", "\"stop\"").0, "204", "{name}{query}");
            assert_eq!(served.server.asked.recv_timeout(MOST_PATIENT), Ok(Asked::Stop), "{name}{query}");
            assert!(served.server.trouble().is_none(), "{name}{query}");
        }
    }
}

#[test]
fn heads_have_bounds() {
    let served = Served::new(LOOKING, roomy(), "<p>");
    let headers = |count: usize| (0..count).map(|number| format!("X-{number}: y\r\n")).collect::<String>();
    assert_eq!(served.ask("GET /", &headers(50), "").0, "200");
    for (first, more) in [
        ("GET /", headers(10_000)),
        ("GET /", headers(200)),
        ("GET /", format!("X: {}\r\n", "y".repeat(64 << 10))),
        ("GET /", format!("X: {}\r\n", "y".repeat(20 << 20))),
        (&*format!("GET /{}", "y".repeat(20 << 20)), String::new()),
    ] {
        let mut line = served.connect();
        // The connection is closed at the bound, so that the rest is not heard.
        line.write_all(served.request(first, &more, "").as_bytes()).ok();
        let said = all_said(&mut line).expect("it is closed");
        assert!(said.is_empty() || said.starts_with("HTTP/1.1 4"), "{said}");
    }
}

#[test]
fn there_are_only_so_many_connections_and_whoever_may_look_keeps_one() {
    let served = Served::new(Access { token: Some("secret".into()), control: true }, roomy(), "<p>");
    let mut person = served.connect();
    let look = format!("GET /?token=secret HTTP/1.1\r\nHost: {}\r\n\r\n", served.address);
    let mut look = || {
        person.write_all(look.as_bytes()).expect("it is open");
        let mut said = String::new();
        while !said.ends_with("<p>") {
            let mut bytes = [0; 1024];
            let read = person.read(&mut bytes).expect("it answers");
            assert!(read > 0, "it stays open");
            said.push_str(&String::from_utf8_lossy(&bytes[..read]));
        }
    };
    look();
    let mut others: Vec<Line> = (0..20 * ROOM).map(|_| served.connect()).collect();
    others.iter().for_each(|line| line.set_nonblocking(true).expect("it can be set"));
    // All have been let in when whoever came after them is answered.
    assert_eq!(served.ask("GET /?token=secret", "", "").0, "200");
    let mut turns = 0;
    while others.len() >= ROOM {
        look();
        others.retain_mut(|line| line.read(&mut [0]).is_err_and(|error| error.kind() == ErrorKind::WouldBlock));
        turns += 1;
        assert!(turns < 1_000, "{} are still connected", others.len());
    }
}

/// What is said to whoever stalls, at the end of the connection.
fn stalled(served: &Served, said: &str) -> String {
    let mut line = served.connect();
    line.write_all(said.replace("HOST", &served.address.to_string()).as_bytes()).expect("it hears");
    all_said(&mut line).unwrap_or_else(|| panic!("{said} keeps the connection"))
}

/// Whether the connection is closed to whoever stalls and then says one byte after the other.
fn is_dripping_ended(served: &Served, said: &str) -> bool {
    let mut line = served.connect();
    line.write_all(said.replace("HOST", &served.address.to_string()).as_bytes()).expect("it hears");
    line.set_read_timeout(Some(Duration::from_millis(2))).expect("it can be set");
    (0..4000).take_while(|_| line.write_all(b"y").is_ok() && all_said(&mut line).is_none()).count() < 4000
}

#[test]
fn a_request_begins_in_time() {
    let served = Served::new(LOOKING, Limits { head: MOMENT, ..roomy() }, "<p>");
    assert_eq!(stalled(&served, ""), "");
    assert_eq!(stalled(&served, "GET / HTTP/1.1\r\nHos"), "");
    assert!(is_dripping_ended(&served, "GET / HTTP/1.1\r\nX: "));
    // The next one, too.
    stalled(&served, "GET / HTTP/1.1\r\nHost: HOST\r\n\r\n");
}

#[test]
fn what_is_asked_for_comes_in_time() {
    let served = Served::new(STEERING, Limits { question: MOMENT, ..roomy() }, "<p>");
    for (name, said) in STALLS.iter().filter(|(_, said)| said.starts_with("POST /ask")) {
        let said = stalled(&served, &said.replace("?T", ""));
        assert!(said.contains("HTTP/1.1 408"), "{name}: {said}");
    }
    assert!(is_dripping_ended(&served, "POST /ask HTTP/1.1\r\nHost: HOST\r\nContent-Length: 4000\r\n\r\n"));
}

#[test]
fn every_connection_has_an_end() {
    let served = Served::new(STEERING, Limits { requests: MOMENT, last_answer: MOMENT, ..roomy() }, "<p>");
    served.tell_long();
    for (name, said) in STALLS {
        // Whoever reads is told the end.
        assert!(!stalled(&served, said).contains("HTTP/1.1 5"), "{name}");
    }
    // Nobody reads: only what is said back shows that the other end is closed.
    let mut deaf = served.connect();
    let lines = format!("GET /lines?from=0 HTTP/1.1\r\nHost: {}\r\n\r\n", served.address);
    deaf.write_all(lines.as_bytes()).expect("it hears");
    let open = (0..4000).take_while(|_| deaf.write_all(b"y").is_ok() && served.nothing_is_asked(2));
    assert!(open.count() < 4000, "whoever does not read keeps the connection");
    // One request after the other.
    let mut line = served.connect();
    let look = format!("GET / HTTP/1.1\r\nHost: {}\r\n\r\n", served.address);
    let answered = (0..1_000_000).take_while(|_| {
        line.write_all(look.as_bytes()).is_ok() && line.read(&mut [0; 4096]).is_ok_and(|read| read > 0)
    });
    assert!((1..1_000_000).contains(&answered.count()));
}

#[test]
fn an_answer_that_was_begun_is_sent_to_its_end() {
    let served = Served::new(LOOKING, Limits { requests: MOMENT, ..roomy() }, "<p>");
    served.tell_long();
    // On a machine that is busy, the time may be over before the request is there.
    let begun = (0..1000).find_map(|_| {
        let mut line = served.connect();
        line.write_all(served.request("GET /lines?from=0", "", "").as_bytes()).expect("it hears");
        line.peek(&mut [0]).is_ok_and(|read| read > 0).then_some(line)
    });
    assert!(served.nothing_is_asked(60));
    let answer = begun.and_then(|mut line| all_said(&mut line)).expect("it is sent");
    assert!(answer.len() > LONG, "{}", answer.len());
}

#[test]
fn files_that_are_left_are_for_the_run_and_that_is_told_once() {
    let mut served = Served::new(LOOKING, Limits { files: 100, first_of_run: 0, ..roomy() }, "<p>");
    for _ in 0..3 {
        assert_eq!(all_said(&mut served.connect()).as_deref(), Some(""));
    }
    let told = served.server.trouble().expect("it is told").to_string();
    assert!(told.contains("nearly all of the 100 files"), "{told}");
    assert!(served.server.trouble().is_none());
    for files in [0, 1, 10, 256, 1024, u64::MAX] {
        let limits = Limits::within(files);
        assert!((1..=64).contains(&limits.connections) && limits.first_of_run <= files);
        assert!(files < 4 || files - limits.first_of_run >= (files / 4).min(64), "{files}");
    }
}

#[test]
fn a_page_that_breaks_off_is_told_of_once() {
    let mut served = Served::new(LOOKING, Limits::of_process(), "<p>");
    assert!(served.server.trouble().is_none());
    // What its thread would do.
    served.server.troubles = channel().1;
    assert!(matches!(served.server.trouble(), Some(Trouble::Ended)));
    assert!(served.server.trouble().is_none());
}
