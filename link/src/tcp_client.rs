//! A host reached over TCP, as a mission uses it.
//!
//! One thread reads percepts as they come, one writes commands; neither waits for the mission. While that
//! thinks, the newest commands are repeated once a period, for [`SILENCE_US`] of the robot's time at most: then
//! it is told once to stand, and the silence lets the host stop it in any case.

use crate::message_lines::{ReadLine, read_line};
use crate::transcript::Live;
use crossbeam::channel::{Receiver, RecvTimeoutError, Sender, bounded, unbounded};
use rpl_protocol::host::{
    Bye, CommandsMessage, FromHost, HostAnswer, HostHello, MissionHello, PROTOCOL, PerceptMessage, SILENCE_US, ToHost,
    read, written,
};
use rpl_protocol::line::LineFault;
use std::io::{BufReader, Write};
use std::net::{Shutdown, TcpStream, ToSocketAddrs};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// How long a host may take to answer the greeting, and to be reached.
const GREETING: Duration = Duration::from_secs(5);

/// A host that says nothing for so long, and for two periods, is lost.
const PATIENCE: Duration = Duration::from_secs(2);

/// Percepts that wait for a mission that is behind; of more, the oldest are given up.
const MOST_WAITING: usize = 200;

/// What the reader hands over.
#[derive(Debug)]
enum Heard {
    /// A percept, and when it came.
    Percept(Box<PerceptMessage>, Instant),
    /// Why no more will come.
    End(String),
}

/// A decision on its way to the host.
#[derive(Debug)]
struct Decision {
    commands: CommandsMessage,
    /// It rests on the newest percept; else one that does follows soon.
    is_newest: bool,
}

/// The line to a host over TCP.
#[derive(Debug)]
pub struct TcpHost {
    address: String,
    /// Of the clock on the wall.
    period: Duration,
    heard: Receiver<Heard>,
    /// None, and nobody who writes, at its end.
    decisions: Option<Sender<Decision>>,
    writer: Option<JoinHandle<()>>,
    pace: Pace,
}

/// When percepts came and decisions were made, and when they should have.
#[derive(Debug)]
struct Pace {
    period: Duration,
    /// When percept 0 came, as the newest percept in time tells it.
    began: Option<Instant>,
    /// When the last percept was handed to the mission.
    taken: Option<Instant>,
    /// The number of the next percept.
    next: u64,
}

impl TcpHost {
    /// Reaches a host and exchanges greetings.
    ///
    /// # Errors
    /// One sentence that names the address: nobody is there, nobody answers, or somebody who moves another
    /// robot or speaks another version.
    pub fn connect(address: &str, hello: MissionHello) -> Result<(HostHello, Self), LineFault> {
        let fault = |why: String| LineFault(format!("the host `{address}` {why}"));
        let stream = reach(address).map_err(|why| fault(format!("cannot be reached: {why}")))?;
        let broken = |error: std::io::Error| fault(format!("cannot be spoken to: {error}"));
        stream.set_nodelay(true).map_err(broken)?;
        stream.set_read_timeout(Some(GREETING)).map_err(broken)?;
        stream.set_write_timeout(Some(PATIENCE)).map_err(broken)?;
        let mut writing = stream.try_clone().map_err(broken)?;
        writing.write_all(written(&ToHost::Hello(hello.clone())).as_bytes()).map_err(broken)?;
        let mut reading = BufReader::new(stream.try_clone().map_err(broken)?);
        let greeting = greeting(&mut reading, &hello).map_err(fault)?;
        stream.set_read_timeout(None).map_err(broken)?;

        let period = Duration::from_secs_f64(greeting.period_us as f64 / 1e6 / greeting.factor);
        // A robot whose time goes faster drives as much further blindly.
        let stale = Duration::from_micros(SILENCE_US).div_f64(greeting.factor.max(1.0)).max(2 * period);
        let (hear, heard) = bounded(MOST_WAITING + 1);
        let (decisions, decided) = unbounded();
        let oldest = heard.clone();
        thread::spawn(move || read_percepts(&mut reading, &hear, &oldest));
        let writer = Some(thread::spawn(move || write_commands(writing, period, stale, &decided)));
        let pace = Pace { period, began: None, taken: None, next: 0 };
        let address = address.to_string();
        Ok((greeting, Self { address, period, heard, decisions: Some(decisions), writer, pace }))
    }

    fn fault(&self, why: &str) -> LineFault {
        LineFault(format!("the host `{}` {why}", self.address))
    }
}

impl Drop for TcpHost {
    /// The host hears a goodbye, if it can be told one.
    fn drop(&mut self) {
        self.decisions = None;
        // It ends by itself, and has nothing to say.
        self.writer.take().map(JoinHandle::join);
    }
}

impl Live<CommandsMessage, HostAnswer> for TcpHost {
    fn answer(&mut self, words: &CommandsMessage) -> Result<HostAnswer, LineFault> {
        let decided_in_s = self.pace.decided(Instant::now());
        let decision = Decision { commands: words.clone(), is_newest: self.heard.is_empty() };
        // A writer that is gone has left because the line is broken, and the reader says so.
        if let Some(decisions) = &self.decisions {
            decisions.send(decision).ok();
        }
        match self.heard.recv_timeout(PATIENCE + 2 * self.period) {
            Ok(Heard::Percept(percept, at)) => {
                let (late_s, missing) = self.pace.came(percept.number, at, Instant::now());
                Ok(HostAnswer { percept: *percept, late_s, missing, decided_in_s })
            }
            Ok(Heard::End(why)) => Err(self.fault(&why)),
            Err(RecvTimeoutError::Timeout) => {
                Err(self.fault(&format!("has said nothing for {:.1} s", (PATIENCE + 2 * self.period).as_secs_f64())))
            }
            Err(RecvTimeoutError::Disconnected) => Err(self.fault("is gone")),
        }
    }
}

impl Pace {
    /// The mission has decided: how long it took since it was handed a percept, if that is too long.
    fn decided(&self, now: Instant) -> Option<f64> {
        let took = now.duration_since(self.taken?);
        (took > self.period).then_some(took.as_secs_f64())
    }

    /// A percept that came at a time is handed over: by how much it was late, and how many before it are
    /// missing. A delay is told once: from then on it is the rhythm.
    fn came(&mut self, number: u64, at: Instant, now: Instant) -> (Option<f64>, u64) {
        let missing = number.saturating_sub(self.next);
        self.next = number.saturating_add(1);
        self.taken = Some(now);
        let since = self.period.mul_f64(number as f64);
        let due = *self.began.get_or_insert(at.checked_sub(since).unwrap_or(at)) + since;
        let late = at.saturating_duration_since(due);
        let is_late = late > self.period;
        if is_late || at < due {
            self.began = at.checked_sub(since);
        }
        (is_late.then_some(late.as_secs_f64()), missing)
    }
}

fn reach(address: &str) -> Result<TcpStream, String> {
    let addresses = address.to_socket_addrs().map_err(|error| format!("{error}; an address is `HOST:PORT`"))?;
    let mut why = "the name stands for no address".to_string();
    for address in addresses {
        match TcpStream::connect_timeout(&address, GREETING) {
            Ok(stream) => return Ok(stream),
            Err(error) => why = error.to_string(),
        }
    }
    Err(why)
}

/// The host's answer to a greeting.
fn greeting(reading: &mut BufReader<TcpStream>, hello: &MissionHello) -> Result<HostHello, String> {
    let line = match read_line(reading) {
        ReadLine::Text(line) => line,
        ReadLine::End => return Err("gives no greeting".to_string()),
        ReadLine::Fault(what) => return Err(format!("greets with {what}")),
    };
    let greeting = match read(&line).map_err(|why| format!("greets with what is no message: {why}"))? {
        FromHost::Hello(greeting) => greeting,
        FromHost::Bye(Bye { reason }) => return Err(refusal(reason)),
        FromHost::Percept(_) => return Err("gives no greeting before its first percept".to_string()),
    };
    if greeting.protocol != PROTOCOL {
        return Err(format!("speaks version {} of the messages, and this rpl {PROTOCOL}", greeting.protocol));
    }
    if greeting.robot != hello.robot {
        return Err(format!("moves the robot `{}`, and the mission is for `{}`", greeting.robot, hello.robot));
    }
    let is_period = (1_000..=10_000_000).contains(&greeting.period_us);
    if !is_period || !(1e-3..=1e3).contains(&greeting.factor) {
        let HostHello { period_us, factor, .. } = greeting;
        return Err(format!(
            "greets with a period of {period_us} us and a factor of {factor}; 1 ms to 10 s, and 0.001 to 1000, are \
             possible"
        ));
    }
    Ok(greeting)
}

fn refusal(reason: Option<String>) -> String {
    match reason {
        Some(reason) => format!("says goodbye: {reason}"),
        None => "says goodbye".to_string(),
    }
}

/// Reads percepts until there are none. Of those that nobody takes, the oldest make room, but for what
/// people have sent with them.
fn read_percepts(reading: &mut BufReader<TcpStream>, hear: &Sender<Heard>, oldest: &Receiver<Heard>) {
    let mut unread = Vec::new();
    let end = loop {
        let line = match read_line(reading) {
            ReadLine::Text(line) => line,
            ReadLine::End => break "is gone: it has closed the line".to_string(),
            ReadLine::Fault(what) => break format!("has sent {what}"),
        };
        let at = Instant::now();
        let mut percept = match read(&line) {
            Ok(FromHost::Percept(percept)) => percept,
            Ok(FromHost::Bye(Bye { reason })) => break refusal(reason),
            Ok(FromHost::Hello(_)) => break "greets a second time".to_string(),
            Err(why) => break format!("has sent what is no message: {why}"),
        };
        // One place is left for the end.
        if hear.len() >= MOST_WAITING
            && let Ok(Heard::Percept(given_up, _)) = oldest.try_recv()
        {
            unread.extend(given_up.messages);
        }
        percept.messages.splice(0..0, unread.drain(..));
        if hear.try_send(Heard::Percept(percept, at)).is_err() {
            return;
        }
    };
    // What has come is taken in first.
    hear.try_send(Heard::End(end)).ok();
}

/// Writes what is decided, and says goodbye when nothing more will be.
fn write_commands(mut writing: TcpStream, period: Duration, stale: Duration, decided: &Receiver<Decision>) {
    let mut newest: Option<Standing> = None;
    let mut due = Instant::now();
    loop {
        let is_urgent = match decided.recv_deadline(due) {
            Ok(Decision { mut commands, is_newest }) => {
                // What the gripper was told and nobody has heard yet is told with the next.
                let unsent = newest.take().and_then(|earlier| earlier.commands.gripper);
                commands.gripper = commands.gripper.or(unsent);
                newest = Some(Standing { commands, since: Instant::now(), is_silent: false });
                is_newest
            }
            Err(RecvTimeoutError::Timeout) => true,
            Err(RecvTimeoutError::Disconnected) => break,
        };
        if !is_urgent {
            continue;
        }
        due = Instant::now() + period;
        if let Some(message) = newest.as_mut().and_then(|newest| newest.next(Instant::now(), stale))
            && writing.write_all(written(&ToHost::Commands(message)).as_bytes()).is_err()
        {
            break;
        }
    }
    writing.write_all(written(&ToHost::Bye(Bye::default())).as_bytes()).ok();
    writing.shutdown(Shutdown::Both).ok();
}

/// The newest decision, as it is told again and again.
struct Standing {
    commands: CommandsMessage,
    since: Instant,
    /// The robot was told to stand for want of a newer one.
    is_silent: bool,
}

impl Standing {
    /// What the host is told now, if anything.
    fn next(&mut self, now: Instant, stale: Duration) -> Option<CommandsMessage> {
        if self.is_silent {
            return None;
        }
        let mut message = self.commands.clone();
        // The hand is told once.
        self.commands.gripper = None;
        if now.duration_since(self.since) >= stale {
            self.is_silent = true;
            (message.translation_mps, message.rotation_radps) = (0.0, 0.0);
        }
        Some(message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_protocol::host::GripperOrder;
    use std::collections::BTreeMap;

    const PERIOD: Duration = Duration::from_millis(50);

    fn pace() -> Pace {
        Pace { period: PERIOD, began: None, taken: None, next: 0 }
    }

    #[test]
    fn a_delay_is_told_once() {
        let (mut pace, start) = (pace(), Instant::now());
        let mut came = |number: u64, ms: u64| {
            let at = start + Duration::from_millis(ms);
            pace.came(number, at, at)
        };
        assert_eq!(came(0, 0), (None, 0));
        assert_eq!(came(1, 99), (None, 0), "a period late is not late");
        assert_eq!(came(2, 201), (Some(0.101), 0));
        assert_eq!(came(3, 251), (None, 0));
        assert_eq!(came(4, 260), (None, 0), "it has caught up");
        assert_eq!(came(5, 361), (Some(0.051), 0), "and is late again by what it was early");
    }

    #[test]
    fn a_decision_is_repeated_until_it_is_stale_and_then_the_robot_is_to_stand() {
        let (start, stale) = (Instant::now(), Duration::from_millis(300));
        let commands = CommandsMessage {
            number: 7,
            translation_mps: 0.5,
            rotation_radps: 0.1,
            sonars_on: true,
            gripper: Some(GripperOrder::Release),
            camera: None,
            others: BTreeMap::new(),
        };
        let mut standing = Standing { commands, since: start, is_silent: false };
        let mut told = |ms: u64| {
            let message = standing.next(start + Duration::from_millis(ms), stale)?;
            Some((message.number, message.translation_mps, message.gripper.is_some()))
        };
        assert_eq!(told(0), Some((7, 0.5, true)));
        assert_eq!(told(250), Some((7, 0.5, false)), "the hand is told once");
        assert_eq!(told(300), Some((7, 0.0, false)));
        assert_eq!(told(350), None);
    }

    #[test]
    fn what_is_missing_is_counted() {
        let (mut pace, start) = (pace(), Instant::now());
        let counts = [0, 1, 4, 5].map(|number| pace.came(number, start, start).1);
        assert_eq!(counts, [0, 0, 2, 0]);
    }

    #[test]
    fn a_decision_longer_than_a_period_is_told() {
        let (mut pace, start) = (pace(), Instant::now());
        assert_eq!(pace.decided(start), None, "there was nothing to decide on");
        pace.came(0, start, start);
        assert_eq!(pace.decided(start + PERIOD), None);
        assert_eq!(pace.decided(start + 2 * PERIOD), Some(0.1));
    }
}
