//! A host reached over TCP, as a mission uses it.
//!
//! One thread reads percepts as they come, one writes commands; neither waits for the mission. While that
//! thinks, the newest commands are repeated once a period, for [`SILENCE_US`] of the robot's time at most: then
//! it is told once to stand, and the silence lets the host stop it in any case.

use crate::message_lines::{LINE, MessageLines, ReadLine, write_line};
use crate::transcript::Live;
use crossbeam::channel::{Receiver, RecvTimeoutError, Sender, bounded, unbounded};
use rpl_lang::visible::shortened;
use rpl_protocol::host::{
    Bye, CommandsMessage, FromHost, HostAnswer, HostHello, MissionHello, PROTOCOL, PerceptMessage, SILENCE_US, ToHost,
    read, written,
};
use rpl_protocol::line::LineFault;
use std::collections::VecDeque;
use std::io::ErrorKind;
use std::net::{Shutdown, TcpStream, ToSocketAddrs};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// How long a host may take to be reached and to answer the greeting, in all.
const GREETING: Duration = Duration::from_secs(5);

/// A host that says nothing for this time, and for two periods, is lost; and so is one that takes no commands.
const PATIENCE: Duration = Duration::from_secs(2);

/// Percepts that may be missing between two, at most: at 20 a second, more than half a day.
const MOST_MISSING: u64 = 1_000_000;

/// Decisions that follow each other so soon are as good as one, when it is asked whether a host takes any.
const SOON: Duration = Duration::from_millis(100);

/// Percepts that wait for a mission that is behind; of more, the oldest are given up.
const MOST_WAITING: usize = 200;

/// The same in bytes of their lines.
const MOST_WAITING_BYTES: usize = 32 << 20;

/// Messages of people in percepts that were given up, in bytes of their words: they wait for the mission.
const MOST_UNREAD_BYTES: usize = 1 << 20;

/// What the reader hands over.
#[derive(Debug)]
enum Heard {
    /// A percept, when it came, and how long its line was.
    Percept(Box<PerceptMessage>, Instant, usize),
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
    waiting: Arc<Waiting>,
    /// None, and nobody who writes, at its end.
    decisions: Option<Sender<Decision>>,
    writer: Option<JoinHandle<()>>,
    untaken: Untaken,
    pace: Pace,
}

/// The bytes of the percepts that wait for the mission.
#[derive(Debug)]
struct Waiting {
    bytes: AtomicUsize,
    /// No more are kept.
    most_bytes: usize,
}

impl Waiting {
    fn new(most_bytes: usize) -> Self {
        Self { bytes: AtomicUsize::new(0), most_bytes }
    }

    fn has_room(&self, bytes: usize) -> bool {
        self.bytes.load(Ordering::Relaxed) + bytes <= self.most_bytes
    }

    fn come(&self, bytes: usize) {
        self.bytes.fetch_add(bytes, Ordering::Relaxed);
    }

    fn gone(&self, bytes: usize) {
        self.bytes.fetch_sub(bytes, Ordering::Relaxed);
    }
}

/// Decisions of which the host has not said that they have taken effect.
#[derive(Debug)]
struct Untaken {
    /// How long one may wait.
    patience: Duration,
    /// The number of each, and when it was made; of those that follow each other within [`SOON`] the first.
    decisions: VecDeque<(u64, Instant)>,
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
        Self::connect_within(GREETING, address, hello)
    }

    fn connect_within(patience: Duration, address: &str, hello: MissionHello) -> Result<(HostHello, Self), LineFault> {
        let fault = |why: String| LineFault(format!("the host `{address}` {why}"));
        let until = Instant::now() + patience;
        let stream = reach(address, until).map_err(|why| fault(format!("cannot be reached: {why}")))?;
        let broken = |error: std::io::Error| fault(format!("cannot be spoken to: {error}"));
        stream.set_nodelay(true).map_err(broken)?;
        write_line(&stream, &written(&ToHost::Hello(hello.clone())), PATIENCE).map_err(broken)?;
        let stream = Arc::new(stream);
        let mut lines = MessageLines::new(stream.clone(), LINE);
        let greeting = greeting(&mut lines, patience, until, &hello).map_err(fault)?;

        let period = Duration::from_secs_f64(greeting.period_us as f64 / 1e6 / greeting.factor);
        // A robot whose time goes faster drives as much further blindly.
        let stale = Duration::from_micros(SILENCE_US).div_f64(greeting.factor.max(1.0)).max(2 * period);
        let (hear, heard) = bounded(MOST_WAITING + 1);
        let (decisions, decided) = unbounded();
        let (oldest, waiting) = (heard.clone(), Arc::new(Waiting::new(MOST_WAITING_BYTES)));
        let (reader_waiting, writer_hear) = (waiting.clone(), hear.clone());
        thread::spawn(move || read_percepts(&mut lines, &hear, &oldest, &reader_waiting));
        let writer = Some(thread::spawn(move || write_commands(&stream, period, stale, &decided, &writer_hear)));
        let pace = Pace { period, began: None, taken: None, next: 0 };
        let address = address.to_string();
        let untaken = Untaken { patience: PATIENCE + 2 * period, decisions: VecDeque::new() };
        Ok((greeting, Self { address, period, heard, waiting, decisions: Some(decisions), writer, untaken, pace }))
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
        self.untaken.decided(words.number, Instant::now());
        // A writer that is gone has said why.
        if let Some(decisions) = &self.decisions {
            decisions.send(decision).ok();
        }
        match self.heard.recv_timeout(PATIENCE + 2 * self.period) {
            Ok(Heard::Percept(percept, at, bytes)) => {
                self.waiting.gone(bytes);
                self.pace.follows(percept.number).map_err(|why| self.fault(&why))?;
                self.untaken.taken(percept.commands, at).map_err(|why| self.fault(&why))?;
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

impl Untaken {
    fn decided(&mut self, number: u64, now: Instant) {
        if self.decisions.back().is_none_or(|(_, made)| now.saturating_duration_since(*made) >= SOON) {
            self.decisions.push_back((number, now));
        }
    }

    /// The host has said at a time which commands have taken effect.
    ///
    /// # Errors
    /// It takes none any more.
    fn taken(&mut self, commands: Option<u64>, at: Instant) -> Result<(), String> {
        while self.decisions.pop_front_if(|(number, _)| Some(*number) <= commands).is_some() {}
        let Some((number, made)) = self.decisions.front() else { return Ok(()) };
        let waited = at.saturating_duration_since(*made);
        if waited <= self.patience {
            return Ok(());
        }
        Err(format!("has not taken the commands of number {number} for {:.1} s", waited.as_secs_f64()))
    }
}

impl Pace {
    /// Whether a percept of this number may come now.
    ///
    /// # Errors
    /// It was there, or too many would be missing.
    fn follows(&self, number: u64) -> Result<(), String> {
        let next = self.next;
        match number.checked_sub(next) {
            None => Err(format!("has sent percept {number} where {next} or a later one is expected")),
            Some(missing) if missing > MOST_MISSING => {
                Err(format!("has sent percept {number} where {next} is the next: more than {MOST_MISSING} are missing"))
            }
            Some(_) => Ok(()),
        }
    }

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

fn reach(address: &str, until: Instant) -> Result<TcpStream, String> {
    let addresses = address.to_socket_addrs().map_err(|error| format!("{error}; an address is `HOST:PORT`"))?;
    let mut why = "the name stands for no address".to_string();
    for address in addresses {
        let left = until.saturating_duration_since(Instant::now());
        if left.is_zero() {
            break;
        }
        match TcpStream::connect_timeout(&address, left) {
            Ok(stream) => return Ok(stream),
            Err(error) => why = error.to_string(),
        }
    }
    Err(why)
}

/// The host's answer to a greeting.
fn greeting(
    lines: &mut MessageLines,
    patience: Duration,
    until: Instant,
    hello: &MissionHello,
) -> Result<HostHello, String> {
    let line = match lines.next(Some(until)) {
        ReadLine::Text(line) => line,
        ReadLine::End => return Err("gives no greeting".to_string()),
        ReadLine::Silence => return Err(format!("gives no greeting within {:.1} s", patience.as_secs_f64())),
        ReadLine::Fault(what) => return Err(format!("greets with {what}")),
    };
    let greeting = match read(&line).map_err(|why| format!("greets with what is no message: {why}"))? {
        FromHost::Hello(greeting) => greeting,
        FromHost::Bye(bye) => return Err(bye.told()),
        FromHost::Percept(_) => return Err("gives no greeting before its first percept".to_string()),
    };
    if greeting.protocol != PROTOCOL {
        return Err(format!("speaks version {} of the messages, and this rpl {PROTOCOL}", greeting.protocol));
    }
    if greeting.robot != hello.robot {
        let (its, ours) = (shortened(&greeting.robot), &hello.robot);
        return Err(format!("moves the robot `{its}`, and the mission is for `{ours}`"));
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

/// Reads percepts until there are none. Of those that nobody takes, the oldest make room, but for what
/// people have sent with them.
fn read_percepts(lines: &mut MessageLines, hear: &Sender<Heard>, oldest: &Receiver<Heard>, waiting: &Waiting) {
    let mut unread = Vec::new();
    let end = loop {
        // Whoever takes the percepts looks at how long none comes.
        let line = match lines.next(None) {
            ReadLine::Text(line) => line,
            ReadLine::End | ReadLine::Silence => break "is gone: it has closed the line".to_string(),
            ReadLine::Fault(what) => break format!("has sent {what}"),
        };
        let at = Instant::now();
        let mut percept = match read(&line) {
            Ok(FromHost::Percept(percept)) => percept,
            Ok(FromHost::Bye(bye)) => break bye.told(),
            Ok(FromHost::Hello(_)) => break "greets a second time".to_string(),
            Err(why) => break format!("has sent what is no message: {why}"),
        };
        // One place is left for the end.
        while hear.len() >= MOST_WAITING || !waiting.has_room(line.len()) {
            let Ok(Heard::Percept(given_up, _, bytes)) = oldest.try_recv() else { break };
            waiting.gone(bytes);
            unread.extend(given_up.messages);
        }
        // An empty word takes room, too.
        let unread_bytes: usize =
            unread.iter().flatten().map(|word: &String| word.len() + 1).sum::<usize>() + unread.len();
        if unread_bytes > MOST_UNREAD_BYTES {
            break format!("has sent more than {MOST_UNREAD_BYTES} bytes of messages that nobody has taken");
        }
        percept.messages.splice(0..0, unread.drain(..));
        let bytes = line.len() + unread_bytes;
        waiting.come(bytes);
        if hear.try_send(Heard::Percept(percept, at, bytes)).is_err() {
            return;
        }
    };
    // What has come is taken in first.
    hear.try_send(Heard::End(end)).ok();
}

/// Writes what is decided, and says goodbye when nothing more will be.
fn write_commands(
    stream: &TcpStream,
    period: Duration,
    stale: Duration,
    decided: &Receiver<Decision>,
    hear: &Sender<Heard>,
) {
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
            && let Err(error) = write_line(stream, &written(&ToHost::Commands(message)), PATIENCE)
        {
            // Of a line that is closed the reader knows more.
            if error.kind() == ErrorKind::TimedOut {
                let why = format!("has not read what it is told for {:.1} s", PATIENCE.as_secs_f64());
                hear.try_send(Heard::End(why)).ok();
            }
            stream.shutdown(Shutdown::Both).ok();
            return;
        }
    }
    write_line(stream, &written(&ToHost::Bye(Bye::default())), PATIENCE).ok();
    stream.shutdown(Shutdown::Both).ok();
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
    use rpl_robot::simulator::Commands;
    use std::collections::BTreeMap;
    use std::io::{Read, Write};
    use std::net::TcpListener;

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

    /// A host that hears a greeting, says these lines, and then does what it is told with its end of the line.
    fn host(lines: Vec<String>, then: impl FnOnce(&mut TcpStream) + Send + 'static) -> String {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("it has one").to_string();
        thread::spawn(move || {
            let (mut stream, _) = listener.accept().expect("somebody comes");
            for line in lines {
                stream.write_all(line.as_bytes()).expect("it is heard");
            }
            then(&mut stream);
        });
        address
    }

    fn hello() -> MissionHello {
        let (rpl, robot) = ("1".to_string(), "fly".to_string());
        MissionHello { protocol: PROTOCOL, rpl, robot, mission: None, token: None }
    }

    fn greeting_of(factor: f64) -> String {
        let robot = "fly".to_string();
        written(&FromHost::Hello(HostHello { protocol: PROTOCOL, robot, period_us: 50_000, factor, start_known: true }))
    }

    fn percept_of(number: u64, messages: Vec<Vec<String>>) -> String {
        let line = format!(
            r#"{{"type":"percept","number":{number},"time_us":1,"odometry_in_odom":{{"x_m":0,"y_m":0,"heading_rad":0}},"translation_mps":0,"rotation_radps":0,"bumped":false,"gripper":"open","battery":1,"messages":"#
        );
        line + &serde_json::to_string(&messages).expect("JSON") + "}\n"
    }

    #[test]
    fn a_host_that_drips_or_is_silent_is_waited_for_in_all_so_long() {
        const SHORT: Duration = Duration::from_millis(100);
        for drips in [false, true] {
            let address = host(Vec::new(), move |stream| {
                stream.set_read_timeout(Some(Duration::from_millis(3))).expect("it may be set");
                // Until the mission has gone.
                while !drips || stream.write_all(b"x").is_ok() {
                    if matches!(stream.read(&mut [0; 1000]), Ok(0)) {
                        return;
                    }
                }
            });
            let LineFault(why) = TcpHost::connect_within(SHORT, &address, hello()).expect_err("it says nothing");
            assert!(why.contains("gives no greeting within 0.1 s"), "{why}");
        }
    }

    #[test]
    fn numbers_of_percepts_go_on_and_none_is_out_of_all_proportion() {
        for (numbers, expected) in [
            (vec![u64::MAX], "has sent percept 18446744073709551615 where 0 is the next"),
            (vec![3, 3], "has sent percept 3 where 4 or a later one is expected"),
        ] {
            let mut lines = vec![greeting_of(1e-3)];
            lines.extend(numbers.iter().map(|&number| percept_of(number, Vec::new())));
            let address = host(lines, |stream| while matches!(stream.read(&mut [0; 1000]), Ok(1..)) {});
            let (_, mut host) = TcpHost::connect(&address, hello()).expect("it greets");
            let commands = CommandsMessage::new(0, &Commands::default());
            let LineFault(why) = numbers.iter().find_map(|_| host.answer(&commands).err()).expect("it is lost");
            assert!(why.contains(expected), "{why}");
        }
    }

    #[test]
    fn percepts_that_nobody_takes_do_not_fill_the_memory() {
        let message = || vec![vec!["x".repeat(100_000)]];
        let lines = (0..60).map(|number| percept_of(number, message())).collect();
        let stream = TcpStream::connect(host(lines, |_| ())).expect("it listens");
        let (hear, heard) = bounded(MOST_WAITING + 1);
        let waiting = Waiting::new(MOST_UNREAD_BYTES);
        read_percepts(&mut MessageLines::new(stream, LINE), &hear, &heard.clone(), &waiting);
        assert!(waiting.bytes.load(Ordering::Relaxed) <= 2 * MOST_UNREAD_BYTES);
        let kept: Vec<Heard> = heard.try_iter().collect();
        let Some(Heard::End(why)) = kept.last() else { panic!("it is lost") };
        assert!(why.contains("has sent more than 1048576 bytes of messages"), "{why}");
        assert!(kept.len() < 12, "{}", kept.len());
    }

    #[test]
    fn a_host_that_takes_no_commands_is_found_out() {
        let (start, at) = (Instant::now(), |ms| Duration::from_millis(ms));
        let mut untaken = Untaken { patience: at(2_100), decisions: VecDeque::new() };
        for number in 0..40 {
            untaken.decided(number, start + at(50 * number));
        }
        assert_eq!(untaken.taken(Some(38), start + at(2_000)), Ok(()));
        untaken.decided(41, start + at(2_050));
        assert_eq!(untaken.taken(Some(40), start + at(4_150)), Ok(()));
        let why = untaken.taken(Some(40), start + at(4_151)).expect_err("it takes none");
        assert_eq!(why, "has not taken the commands of number 41 for 2.1 s");
        assert_eq!(untaken.taken(Some(41), start + at(9_000)), Ok(()));
        untaken.decided(42, start + at(9_000));
        assert!(untaken.taken(None, start + at(12_000)).is_err(), "it never says that it has taken any");
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
