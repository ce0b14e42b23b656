//! A process of somebody else that is spoken to over its standard input and output: started, fed, heard
//! within a time, and ended for certain.
//!
//! Nothing here waits without end, and nothing grows with what the process writes: its pipes are looked
//! at while somebody waits for it, and in between the system holds them.

use rpl_lang::visible::visible;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use rustix::process::{Pid, Signal, WaitId, WaitIdOptions, kill_process_group, waitid};
use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, IsTerminal, Read, Write};
use std::net::{Shutdown, TcpStream, ToSocketAddrs};
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering as AtomicOrdering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// What is kept of standard error: the newest bytes.
const MOST_LAST_WORDS: usize = 4 << 10;

/// Lines of it that are told.
const MOST_LAST_LINES: usize = 12;

/// Lines of standard error that are passed on of all processes together, however many runs start some, and bytes of each.
const MOST_PASSED_LINES: usize = 1_000;
const MOST_PASSED_BYTES: usize = 2_000;

/// Bytes taken from a pipe at once.
const CHUNK: usize = 64 << 10;

/// How often a process that says nothing is looked after: what it has started may keep its pipes open when it has ended.
const LOOKED_AFTER: Duration = Duration::from_millis(20);

/// How long a process that has closed a pipe is waited for to end, to be able to say how it ended.
const DYING: Duration = Duration::from_millis(300);

/// Processes that run, by the number of their group: their own number.
static RUNNING: Mutex<BTreeSet<i32>> = Mutex::new(BTreeSet::new());

/// A thread that panicked has left the set whole.
fn running() -> MutexGuard<'static, BTreeSet<i32>> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Ends all processes at once, for an exit of this one that drops nothing.
pub fn end_all() {
    // While the set is held no process in it is reaped, so that each number is still that of ours.
    for &group in running().iter() {
        kill(group);
    }
}

fn kill(group: i32) {
    if let Some(group) = Pid::from_raw(group) {
        // Whoever has ended already needs no signal.
        kill_process_group(group, Signal::KILL).ok();
    }
}

/// What came of waiting for a line.
#[derive(Debug, PartialEq, Eq)]
pub enum Heard {
    /// A line, without its end.
    Line(Vec<u8>),
    /// A line longer than it may be.
    TooLong,
    /// The time is over.
    Nothing,
    /// It has closed its standard output, or has ended; what came after the last line.
    Closed(Vec<u8>),
}

/// A process with a group of its own, spoken to by lines. It ends when this is dropped.
#[derive(Debug)]
pub struct Process {
    /// None where it was not started by us, but connected to.
    child: Option<Child>,
    /// None once it has been closed, by us or by the process.
    input: Option<File>,
    output: File,
    errors: Option<File>,
    /// What is still to be written, from `written` on.
    outgoing: Vec<u8>,
    written: usize,
    /// What was read, from `taken` on; `searched` bytes of it have no end of line.
    incoming: Vec<u8>,
    taken: usize,
    searched: usize,
    last_words: Vec<u8>,
    /// What it writes to standard error is passed on under this name.
    passes_on: Option<PassedOn>,
    most_line: usize,
    /// How it ended, once it has been reaped.
    ended: Option<ExitStatus>,
}

/// Lines that were passed on.
static PASSED_LINES: AtomicUsize = AtomicUsize::new(0);

/// Lines of standard error on their way.
#[derive(Debug)]
struct PassedOn {
    name: String,
    /// A line that has not ended.
    begun: Vec<u8>,
}

impl PassedOn {
    fn take(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            if byte == b'\n' || self.begun.len() >= MOST_PASSED_BYTES {
                self.end_line();
            }
            if byte != b'\n' {
                self.begun.push(byte);
            }
        }
    }

    fn end_line(&mut self) {
        let number = PASSED_LINES.fetch_add(1, AtomicOrdering::Relaxed) + 1;
        let text = match number.cmp(&MOST_PASSED_LINES) {
            Ordering::Less => visible(&String::from_utf8_lossy(&self.begun)).into_owned(),
            Ordering::Equal => "what modules write from here on is left out".to_string(),
            Ordering::Greater => String::new(),
        };
        self.begun.clear();
        if number <= MOST_PASSED_LINES {
            // A status line may stand there. Nobody listens if this fails.
            let clear = if io::stderr().is_terminal() { "\r\x1b[K" } else { "" };
            writeln!(io::stderr(), "{clear}{}: {text}", self.name).ok();
        }
    }
}

impl Process {
    /// Starts a program in a folder; a program whose name has a `/` lies below that folder. A line of it may have
    /// `most_line` bytes.
    ///
    /// # Errors
    /// There is no such program, or it cannot be started.
    pub fn start(command: &[String], folder: &Path, most_line: usize) -> io::Result<Self> {
        let (program, arguments) = command.split_first().ok_or(io::ErrorKind::InvalidInput)?;
        let folder = folder.canonicalize()?;
        let program = if program.contains('/') { folder.join(program) } else { program.into() };
        let mut starting = Command::new(program);
        starting.args(arguments).current_dir(folder).process_group(0);
        starting.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut running = running();
        let mut child = starting.spawn()?;
        running.insert(child.id().cast_signed());
        drop(running);
        let (input, output, errors) = (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let (Some(input), Some(output), Some(errors)) = (input, output, errors) else {
            unreachable!("all three were asked for as pipes")
        };
        let [input, output, errors] = [OwnedFd::from(input), output.into(), errors.into()].map(File::from);
        Self::of(Some(child), input, output, Some(errors), most_line)
    }

    /// Connects to a process that waits at an address, for up to a time.
    ///
    /// # Errors
    /// There is no such address, or nobody waits there.
    pub fn connect(address: &str, patience: Duration, most_line: usize) -> io::Result<Self> {
        let mut last = io::Error::from(io::ErrorKind::NotFound);
        for at in address.to_socket_addrs()? {
            match TcpStream::connect_timeout(&at, patience) {
                Ok(stream) => {
                    // What belongs to one turn goes out at once, and is waited for.
                    stream.set_nodelay(true)?;
                    let input = OwnedFd::from(stream.try_clone()?).into();
                    return Self::of(None, input, OwnedFd::from(stream).into(), None, most_line);
                }
                Err(error) => last = error,
            }
        }
        Err(last)
    }

    fn of(child: Option<Child>, input: File, output: File, errors: Option<File>, most_line: usize) -> io::Result<Self> {
        let process = Self {
            child,
            input: Some(input),
            output,
            errors,
            outgoing: Vec::new(),
            written: 0,
            incoming: Vec::new(),
            taken: 0,
            searched: 0,
            last_words: Vec::new(),
            passes_on: None,
            most_line,
            ended: None,
        };
        let pipes = [process.input.as_ref().map(AsFd::as_fd), Some(process.output.as_fd())];
        for pipe in pipes.into_iter().flatten().chain(process.errors.as_ref().map(AsFd::as_fd)) {
            rustix::io::ioctl_fionbio(pipe, true)?;
        }
        Ok(process)
    }

    /// What it has written and writes to standard error is written to that of this process too, under a name.
    pub fn pass_errors_on(&mut self, name: &str) {
        let mut passes_on = PassedOn { name: name.to_string(), begun: Vec::new() };
        passes_on.take(&self.last_words);
        self.passes_on = Some(passes_on);
    }

    /// Its number, and that of its group; none if it was not started by us.
    pub fn number(&self) -> Option<u32> {
        self.child.as_ref().map(Child::id)
    }

    /// Adds a line to what it is told; it goes out while somebody listens.
    pub fn tell(&mut self, line: &[u8]) {
        if self.input.is_none() {
            return;
        }
        if self.written == self.outgoing.len() {
            self.outgoing.clear();
            self.written = 0;
        }
        self.outgoing.extend_from_slice(line);
        self.outgoing.push(b'\n');
    }

    /// Bytes that it was told and has not taken.
    pub fn untaken(&self) -> usize {
        self.outgoing.len() - self.written
    }

    /// The next line it says, waited for up to a time; what it was told goes out meanwhile.
    ///
    /// # Errors
    /// A pipe fails for a reason of the system.
    pub fn listen(&mut self, until: Instant) -> io::Result<Heard> {
        self.write()?;
        loop {
            if let Some(heard) = self.next_line() {
                return Ok(heard);
            }
            let left = until.saturating_duration_since(Instant::now());
            let ready = self.wait(left.min(LOOKED_AFTER))?;
            if ready.output && !self.read()? {
                return Ok(Heard::Closed(self.incoming.split_off(self.taken)));
            }
            if !ready.output && self.has_ended() {
                // What it wrote before it ended is in the pipe by now; nothing that comes later is its own.
                let had = self.incoming.len() - self.taken;
                if !self.read()? || self.incoming.len() == had {
                    return Ok(Heard::Closed(self.incoming.split_off(self.taken)));
                }
                continue;
            }
            if ready.input {
                self.write()?;
            }
            if ready.errors {
                self.hear_errors()?;
            }
            if left.is_zero() && !ready.output {
                return Ok(Heard::Nothing);
            }
        }
    }

    fn next_line(&mut self) -> Option<Heard> {
        let rest = &self.incoming[self.taken..];
        let Some(end) = rest[self.searched..].iter().position(|&byte| byte == b'\n') else {
            self.searched = rest.len();
            return (rest.len() > self.most_line).then_some(Heard::TooLong);
        };
        let end = self.searched + end;
        let line = rest[..end].to_vec();
        (self.taken, self.searched) = (self.taken + end + 1, 0);
        Some(if line.len() > self.most_line { Heard::TooLong } else { Heard::Line(line) })
    }

    /// Takes in what has come of standard output; tells whether that may go on, or is closed.
    fn read(&mut self) -> io::Result<bool> {
        self.incoming.drain(..self.taken);
        self.taken = 0;
        let had = self.incoming.len();
        self.incoming.resize(had + CHUNK, 0);
        let read = read_some(&mut self.output, &mut self.incoming[had..]);
        self.incoming.truncate(had + read.as_ref().ok().copied().flatten().unwrap_or(0));
        Ok(read? != Some(0))
    }

    fn write(&mut self) -> io::Result<()> {
        while self.written < self.outgoing.len() {
            let Some(input) = &mut self.input else { return Ok(()) };
            match input.write(&self.outgoing[self.written..]) {
                Ok(written) => self.written += written,
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Ok(()),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                // It does not listen any more. What it says about that may still come.
                Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {
                    self.input = None;
                    self.outgoing.clear();
                    self.written = 0;
                }
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    fn hear_errors(&mut self) -> io::Result<()> {
        let mut chunk = [0; 4096];
        // A process that writes faster than it is read is not read for ever.
        for _ in 0..CHUNK / chunk.len() {
            let Some(errors) = &mut self.errors else { return Ok(()) };
            match read_some(errors, &mut chunk)? {
                None => return Ok(()),
                Some(0) => self.errors = None,
                Some(read) => {
                    if let Some(passes_on) = &mut self.passes_on {
                        passes_on.take(&chunk[..read]);
                    }
                    self.last_words.extend_from_slice(&chunk[..read]);
                    let too_many = self.last_words.len().saturating_sub(MOST_LAST_WORDS);
                    self.last_words.drain(..too_many);
                }
            }
        }
        Ok(())
    }

    /// Waits until a pipe is ready, up to a time.
    fn wait(&self, left: Duration) -> io::Result<Ready> {
        let input = self.input.as_ref().filter(|_| self.untaken() > 0);
        let mut polled = vec![PollFd::new(&self.output, PollFlags::IN)];
        polled.extend(self.errors.as_ref().map(|errors| PollFd::new(errors, PollFlags::IN)));
        polled.extend(input.map(|input| PollFd::new(input, PollFlags::OUT)));
        let left = Timespec::try_from(left).map_err(io::Error::other)?;
        match poll(&mut polled, Some(&left)) {
            // A signal: whoever waits looks at the clock and comes back.
            Err(Errno::INTR) => return Ok(Ready::default()),
            Err(error) => return Err(error.into()),
            Ok(_) => {}
        }
        let mut ready = polled.iter().map(|polled| !polled.revents().is_empty());
        let output = ready.next() == Some(true);
        let errors = self.errors.is_some() && ready.next() == Some(true);
        let input = input.is_some() && ready.next() == Some(true);
        Ok(Ready { output, errors, input })
    }

    /// Tells it nothing more and gives it a time to end by itself; then it is ended, and whoever it has
    /// started in its group.
    pub fn end(&mut self, patience: Duration) {
        if self.ended.is_some() {
            return;
        }
        let until = Instant::now() + patience;
        // What cannot be written any more is not worth an error: it ends.
        self.write().ok();
        self.input = None;
        if self.child.is_none() {
            // It may wait for another run.
            self.ended = Some(ExitStatus::default());
            if let Ok(stream) = self.output.try_clone() {
                TcpStream::from(OwnedFd::from(stream)).shutdown(Shutdown::Both).ok();
            }
            return;
        }
        while !self.has_ended() && Instant::now() < until {
            // It may have to get rid of what it says before it can end.
            self.incoming.clear();
            (self.taken, self.searched) = (0, 0);
            let pause = Duration::from_millis(2);
            let closed = match self.wait(pause) {
                Ok(ready) => {
                    let is_closed = ready.output && !matches!(self.read(), Ok(true));
                    is_closed | (ready.errors && self.hear_errors().is_err())
                }
                Err(_) => true,
            };
            if closed {
                std::thread::sleep(pause);
            }
        }
        // What it wrote last is there before it ends.
        self.hear_errors().ok();
        self.reap();
    }

    fn reap(&mut self) {
        let Some(child) = &mut self.child else { return };
        let group = child.id().cast_signed();
        kill(group);
        // From here on the number may become that of another process: it leaves the set before that.
        running().remove(&group);
        // Nothing outlives that signal; a failure means that somebody else has reaped it.
        self.ended = Some(child.wait().unwrap_or_default());
        self.hear_errors().ok();
    }

    /// Whether it has ended; its number stays its own.
    fn has_ended(&self) -> bool {
        let Some(child) = &self.child else { return false };
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOWAIT | WaitIdOptions::NOHANG;
        waitid(WaitId::Pid(Pid::from_child(child)), options).map_or(true, |status| status.is_some())
    }

    /// Ends it after it has closed its standard output or ended, and tells how that came, as a clause.
    pub fn autopsy(&mut self) -> String {
        if self.child.is_none() {
            self.end(Duration::ZERO);
            return "closed the connection".to_string();
        }
        let until = Instant::now() + DYING;
        while !self.has_ended() && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(1));
        }
        let by_itself = self.has_ended();
        let is_open = matches!(self.read(), Ok(true));
        self.end(Duration::ZERO);
        let (true, Some(status)) = (by_itself, self.ended) else { return "closed its standard output".to_string() };
        let how = match (status.code(), status.signal()) {
            (Some(code), _) => format!("ended with exit status {code}"),
            (None, Some(signal)) => format!("was ended by signal {signal}"),
            (None, None) => "ended".to_string(),
        };
        if is_open { format!("{how}, while a process that it had started still has its standard output") } else { how }
    }

    /// The last lines that it wrote to its standard error, further in than what we say ourselves.
    pub fn last_words(&self) -> String {
        let text = String::from_utf8_lossy(&self.last_words);
        let lines: Vec<&str> = text.lines().map(str::trim_end).filter(|line| !line.is_empty()).collect();
        let lines = &lines[lines.len().saturating_sub(MOST_LAST_LINES)..];
        lines.iter().map(|line| format!("  {}", visible(line))).collect::<Vec<_>>().join("\n")
    }
}

/// Which pipes are ready.
#[derive(Default)]
struct Ready {
    output: bool,
    errors: bool,
    input: bool,
}

/// What can be read now: none if nothing is there, 0 bytes at the end.
fn read_some(pipe: &mut impl Read, into: &mut [u8]) -> io::Result<Option<usize>> {
    loop {
        match pipe.read(into) {
            Ok(read) => return Ok(Some(read)),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Ok(None),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.end(Duration::ZERO);
    }
}
