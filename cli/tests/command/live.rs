//! The page of a run that goes on, when others take all that it has: `--live`.
#![cfg(target_os = "linux")]

use crate::folder::{folder, put, text_in};
use crate::rpl::{rpl, run_in};
use rustix::process::{Pid, Resource, Rlimit, Signal, getrlimit, kill_process, prlimit};
use std::io::{BufRead, BufReader, Lines, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, ChildStderr, ChildStdout, Command, Stdio};
use std::time::Duration;

/// How long an answer that comes at once is waited for.
const MOST_PATIENT: Duration = Duration::from_secs(20);

/// A run with a page, as it goes on.
struct Shown {
    child: Child,
    host: String,
    out: Lines<BufReader<ChildStdout>>,
    errors: Lines<BufReader<ChildStderr>>,
}

impl Shown {
    /// Of a process that may have `files` files open.
    fn start(folder: &Path, files: u32, arguments: &[&str]) -> Self {
        let rpl = rpl(arguments);
        let mut limited = Command::new("sh");
        limited.args(["-c", &format!("ulimit -S -n {files}; exec \"$0\" \"$@\"")]).arg(rpl.get_program());
        limited.args(rpl.get_args()).current_dir(folder).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = limited.spawn().expect("it starts");
        let out = BufReader::new(child.stdout.take().expect("it is piped")).lines();
        let mut errors = BufReader::new(child.stderr.take().expect("it is piped")).lines();
        let mut told = errors.by_ref().map_while(Result::ok);
        let link = told.find_map(|line| Some(line.split_once("shown at http://")?.1.to_string())).expect("a link");
        Self { child, host: link.trim_end_matches('/').to_string(), out, errors }
    }

    fn connect(&self) -> TcpStream {
        let line = TcpStream::connect(&self.host).expect("it is served");
        line.set_read_timeout(Some(MOST_PATIENT)).expect("it can be set");
        line
    }

    /// The page, asked for on a connection.
    fn page_by(&self, mut line: TcpStream) -> String {
        let asked = format!("GET / HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\r\n", self.host);
        line.write_all(asked.as_bytes()).expect("it can be asked");
        let mut answer = String::new();
        line.read_to_string(&mut answer).expect("it answers");
        answer
    }

    fn id(&self) -> Pid {
        Pid::from_child(&self.child)
    }

    /// Interrupts it; what it has said on standard error since the link.
    fn interrupt(mut self) -> Vec<String> {
        kill_process(self.id(), Signal::INT).expect("it is there");
        let said = self.errors.map_while(Result::ok).collect();
        assert!(self.child.wait().is_ok());
        said
    }
}

#[test]
fn a_page_that_hundreds_connect_to_is_served_and_the_journal_of_its_run_is_written() {
    let folder = folder("live-crowd");
    put(&folder, "plan.rpl", "(def-fluent n 0)\n(loop (wait-time 0.02) (incf (value n)) (print (value n)))\n");
    let journal = ["--journal", "j", "--realtime", "1", "--trace", "t.jsonl"];
    let mut shown = Shown::start(&folder, 256, &[&["run", "plan.rpl", "--live", ":0"], &journal[..]].concat());
    let crowd: Vec<TcpStream> = (0..300).map(|_| shown.connect()).collect();
    for _ in 0..3 {
        let page = shown.page_by(shown.connect());
        assert!(page.starts_with("HTTP/1.1 200"), "{page}");
        // The run goes on meanwhile.
        assert!(shown.out.by_ref().take(5).all(|line| line.is_ok()));
    }
    let said = shown.interrupt();
    drop(crowd);
    let troubles: Vec<&String> = said.iter().filter(|line| line.contains("page") || line.contains("journal")).collect();
    assert!(troubles.is_empty(), "{troubles:?}");
    // The journal has all of the run, whose time is then up.
    assert!(text_in(&folder, "t.jsonl").lines().count() > 15);
    let found = run_in(&folder, &["view", "j", "--report", "j.html"]);
    assert_eq!((found.status, found.errors.as_str()), (3, ""));
}

#[test]
fn it_is_told_why_the_page_lets_nobody_in_and_it_does_when_it_can() {
    let folder = folder("live-files");
    put(&folder, "plan.rpl", "(wait-time 1000)\n");
    let shown = |arguments: &[&str]| Shown::start(&folder, 256, arguments);
    put(&folder, "short.rpl", "(print 1)\n");
    for mut shown in
        [shown(&["run", "plan.rpl", "--live", ":0", "--realtime", "1"]), shown(&["run", "short.rpl", "--live", ":0"])]
    {
        let (run, maximum) = (shown.id(), getrlimit(Resource::Nofile).maximum);
        let may_open = |files| {
            let limit = Rlimit { current: Some(files), maximum };
            prlimit(Some(run), Resource::Nofile, limit).expect("its limit can be set");
        };
        may_open(3);
        let early = shown.connect();
        let mut told = shown.errors.by_ref().map_while(Result::ok);
        told.find(|line| line.contains("the page lets nobody in for now: Too many open files")).expect("it is told");
        may_open(256);
        assert!(shown.page_by(early).starts_with("HTTP/1.1 200"));
        shown.interrupt();
    }
}
