//! A host served over TCP at the pace of the clock on the wall.
//!
//! One thread, that of the caller, owns the host: it steps it when it is time, with the newest commands that
//! have come, and a [`Guard`] between them and the motors. For each mission there is a thread that reads and
//! one that writes, so that no mission can keep the host waiting.
//!
//! The world stands still until the first mission gives its first commands, and goes on from then, whether a
//! mission is there or not. Time and odometry begin anew for each mission; only the first is told that the
//! robot stands where the world says it starts.

use crate::message_lines::{ReadLine, read_line};
use crossbeam::channel::{Receiver, Sender, bounded};
use rpl_protocol::guard::{Guard, Halt, HaltCounts};
use rpl_protocol::host::{
    Bye, CommandsMessage, FromHost, HostHello, MissionHello, PROTOCOL, PerceptMessage, ToHost, read, written,
};
use rpl_robot::geometry::Pose;
use rpl_robot::office::{Host, HostLost, Report};
use rpl_robot::simulator::{Commands, GripperCommand, Percept};
use std::collections::VecDeque;
use std::io::{self, BufReader, ErrorKind, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

/// How often somebody who wants to connect is looked for.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// Whoever connects says who it is within this time, and takes what it is told within it.
const GREETING: Duration = Duration::from_secs(5);

/// Percepts that wait for a mission to take them; one that lets more wait is gone for the host.
const MOST_UNSENT: usize = 600;

/// Percepts whose commands are waited for, to tell how long they took.
const MOST_UNANSWERED: usize = 600;

/// What may come between two steps before one is made; whoever sends more has to wait.
const MOST_EVENTS: usize = 1_000;

/// A host that is so far behind the clock goes on from there and does not hurry.
const MOST_BEHIND: Duration = Duration::from_millis(500);

/// How a host is served.
#[derive(Clone, Debug, PartialEq)]
pub struct Service {
    /// The robot that it moves.
    pub robot: String,
    /// Time of the robot between two percepts.
    pub period_us: u64,
    /// Seconds of the robot for each second on the wall.
    pub factor: f64,
    /// Time of the robot at which it ends, if it does.
    pub until_us: Option<u64>,
    /// It ends when the first mission has gone and the robot stands.
    pub once: bool,
    /// The robot stands where the world says it starts; only the first mission is told.
    pub start_known: bool,
}

/// What is worth telling while a host is served.
#[derive(Clone, Debug, PartialEq)]
pub enum Notice {
    /// A mission has connected, from there.
    Came(SocketAddr),
    /// It has gone: one clause that says how.
    Went(String),
    /// Somebody was refused: one clause that says why.
    Refused(String),
    /// The motors are off.
    Halted(Halt),
    /// What happened in the host's world.
    Happened(Report),
}

/// How it went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ServiceRecord {
    /// Missions that gave commands.
    pub missions: u32,
    /// Percepts so far.
    pub percepts: u64,
    /// How often motors were cut.
    pub halts: HaltCounts,
    /// From each percept to the commands that answer it, in seconds on the wall.
    pub latencies_s: Vec<f32>,
    /// How often the host itself was too far behind the clock.
    pub delays: u32,
    /// Why the host could make no step any more, if that is how it ended.
    pub lost: Option<HostLost>,
}

/// What comes from those who are connected.
enum Event {
    Greeted(MissionHello),
    Commands(CommandsMessage, Instant),
    Closed(String),
}

/// A mission that is served.
struct Mission {
    /// By which its events are told from those of an earlier one.
    connection: u64,
    percepts: Sender<String>,
    stream: TcpStream,
    came: Instant,
    greeted: bool,
    /// Where time and odometry were when its first commands came; none before.
    began: Option<(u64, Pose)>,
    /// The number of its next percept.
    next: u64,
    newest: Option<CommandsMessage>,
    /// Since the last step the hand was told this.
    gripper: GripperCommand,
    /// Percepts that have not been answered, and when they were sent.
    unanswered: VecDeque<(u64, Instant)>,
}

/// Events of connections, each with the number of its connection.
type Events = (Sender<(u64, Event)>, Receiver<(u64, Event)>);

/// A host that is served.
struct Server<'a, H> {
    host: &'a mut H,
    listener: TcpListener,
    /// Whether it was told that nobody can be let in, since somebody was.
    is_full: bool,
    greeting: Duration,
    service: Service,
    tell: &'a mut dyn FnMut(Notice),
    events: Events,
    connections: u64,
    mission: Option<Mission>,
    guard: Guard,
    began: Instant,
    percept: Option<Percept>,
    record: ServiceRecord,
}

/// Serves a host until it is told to stop, or its time is up; then its motors are off. Somebody who
/// connects while a mission is there is refused.
///
/// # Errors
/// Nobody can be listened to.
pub fn serve<H: Host>(
    host: &mut H,
    listener: TcpListener,
    service: Service,
    is_stopped: &dyn Fn() -> bool,
    tell: &mut dyn FnMut(Notice),
) -> io::Result<ServiceRecord> {
    serve_greeted(GREETING, host, listener, service, is_stopped, tell)
}

/// As [`serve`], to whoever says within this time who it is.
fn serve_greeted<H: Host>(
    greeting: Duration,
    host: &mut H,
    listener: TcpListener,
    service: Service,
    is_stopped: &dyn Fn() -> bool,
    tell: &mut dyn FnMut(Notice),
) -> io::Result<ServiceRecord> {
    listener.set_nonblocking(true)?;
    let mut server = Server {
        host,
        listener,
        is_full: false,
        greeting,
        service,
        tell,
        events: bounded(MOST_EVENTS),
        connections: 0,
        mission: None,
        guard: Guard::default(),
        began: Instant::now(),
        percept: None,
        record: ServiceRecord::default(),
    };
    server.run(is_stopped);
    server.leave(None);
    server.record.halts = server.guard.counts;
    Ok(server.record)
}

impl<H: Host> Server<'_, H> {
    fn run(&mut self, is_stopped: &dyn Fn() -> bool) {
        let period = Duration::from_secs_f64(self.service.period_us as f64 / 1e6 / self.service.factor);
        // When the next step is due; none until the first commands.
        let mut next: Option<Instant> = None;
        while !is_stopped() && !self.is_over() {
            let look = Instant::now() + LOOK_EVERY;
            self.listen_until(next.map_or(look, |due| look.min(due)));
            self.look_for_missions();
            let now = Instant::now();
            if self.record.missions == 0 || next.is_some_and(|due| now < due) {
                continue;
            }
            if !self.step() {
                return;
            }
            let due = next.unwrap_or(now) + period;
            let is_behind = now > due + MOST_BEHIND;
            self.record.delays += u32::from(is_behind);
            next = Some(if is_behind { now } else { due });
        }
    }

    /// Takes what comes, up to a time; no longer than to the first commands, with which the world begins.
    fn listen_until(&mut self, wake: Instant) {
        let was_running = self.record.missions > 0;
        for _ in 0..MOST_EVENTS {
            let Ok((connection, event)) = self.events.1.recv_deadline(wake) else { return };
            self.take(connection, event);
            if self.record.missions > 0 && !was_running {
                return;
            }
        }
    }

    fn is_over(&self) -> bool {
        let percept = self.percept.as_ref();
        let time_is_up = |until_us| percept.is_some_and(|percept| percept.time_us >= until_us);
        let stands = percept.is_none_or(|percept| percept.translation_mps == 0.0 && percept.rotation_radps == 0.0);
        let has_gone = self.service.once && self.record.missions > 0 && self.mission.is_none() && stands;
        self.service.until_us.is_some_and(time_is_up) || has_gone
    }

    /// One step of the host; whether it can make another.
    fn step(&mut self) -> bool {
        let wanted = self.mission.as_mut().and_then(Mission::take_commands).unwrap_or_default();
        let now_us = self.now_us();
        let (permitted, halt) = self.guard.permitted(now_us, &wanted, self.percept.as_ref());
        if let Some(halt) = halt {
            (self.tell)(Notice::Halted(halt));
        }
        let mut reports = Vec::new();
        let percept = self.host.step(&permitted, &mut reports);
        reports.into_iter().for_each(|report| (self.tell)(Notice::Happened(report)));
        let percept = match percept {
            Ok(percept) => percept,
            Err(lost) => {
                self.leave(Some(lost.0.clone()));
                self.record.lost = Some(lost);
                return false;
            }
        };
        self.record.percepts += 1;
        if let Some(mission) = &mut self.mission
            && !mission.send(&percept)
        {
            self.leave(Some("it does not take what the robot perceives".to_string()));
        }
        self.percept = Some(percept);
        true
    }

    fn look_for_missions(&mut self) {
        let is_late = |mission: &Mission| !mission.greeted && mission.came.elapsed() > self.greeting;
        if self.mission.as_ref().is_some_and(is_late) {
            self.leave(Some(format!("it has not said who it is within {} s", self.greeting.as_secs_f64())));
        }
        for _ in 0..MOST_EVENTS {
            match self.listener.accept() {
                Ok((stream, address)) => {
                    self.is_full = false;
                    if let Err(error) = self.welcome(stream, address) {
                        (self.tell)(Notice::Refused(format!("{address} cannot be served: {error}")));
                    }
                }
                // Nobody is there; or whoever was has gone already.
                Err(error) if error.kind() == ErrorKind::WouldBlock => return,
                Err(error) if [ErrorKind::Interrupted, ErrorKind::ConnectionAborted].contains(&error.kind()) => {}
                Err(error) => {
                    if !std::mem::replace(&mut self.is_full, true) {
                        (self.tell)(Notice::Refused(format!("nobody can be let in for now: {error}")));
                    }
                    return;
                }
            }
        }
    }

    fn welcome(&mut self, stream: TcpStream, address: SocketAddr) -> io::Result<()> {
        if self.mission.is_some() {
            self.refuse(&stream, format!("another mission is here; {address} has to wait"));
            return Ok(());
        }
        stream.set_nonblocking(false)?;
        stream.set_nodelay(true)?;
        stream.set_write_timeout(Some(GREETING))?;
        let (reading, writing) = (stream.try_clone()?, stream.try_clone()?);
        self.connections += 1;
        let (connection, events) = (self.connections, self.events.0.clone());
        let (percepts, to_write) = bounded(MOST_UNSENT);
        // The writer ends with what it is told.
        thread::Builder::new().spawn(move || write_percepts(writing, &to_write))?;
        thread::Builder::new().spawn(move || read_commands(reading, connection, &events))?;
        self.mission = Some(Mission {
            connection,
            percepts,
            stream,
            came: Instant::now(),
            greeted: false,
            began: None,
            next: 0,
            newest: None,
            gripper: GripperCommand::None,
            unanswered: VecDeque::new(),
        });
        (self.tell)(Notice::Came(address));
        Ok(())
    }

    fn refuse(&mut self, mut stream: &TcpStream, why: String) {
        let bye = FromHost::Bye(Bye { reason: Some(why.clone()) });
        // Whoever was refused may have gone already.
        stream.write_all(written(&bye).as_bytes()).ok();
        stream.shutdown(Shutdown::Both).ok();
        (self.tell)(Notice::Refused(why));
    }

    fn take(&mut self, connection: u64, event: Event) {
        let Some(mission) = self.mission.as_mut().filter(|mission| mission.connection == connection) else { return };
        match event {
            Event::Greeted(_) if mission.greeted => self.leave(Some("it greets a second time".to_string())),
            Event::Greeted(hello) => match unfit(&hello, &self.service.robot) {
                Some(why) => self.leave(Some(why)),
                None => self.greet(),
            },
            Event::Commands(..) if !mission.greeted => self.leave(Some("it commands before it greets".to_string())),
            Event::Commands(commands, at) => self.command(commands, at),
            Event::Closed(why) => self.leave(Some(why)),
        }
    }

    fn greet(&mut self) {
        let Some(mission) = &mut self.mission else { return };
        mission.greeted = true;
        let hello = HostHello {
            protocol: PROTOCOL,
            robot: self.service.robot.clone(),
            period_us: self.service.period_us,
            factor: self.service.factor,
            start_known: self.service.start_known && self.percept.is_none(),
        };
        mission.percepts.try_send(written(&FromHost::Hello(hello))).ok();
    }

    fn command(&mut self, commands: CommandsMessage, at: Instant) {
        let heard_us = at.saturating_duration_since(self.began).as_micros() as u64;
        let Some(mission) = &mut self.mission else { return };
        if mission.began.is_none() {
            self.record.missions += 1;
            let here = self.percept.as_ref().map(|percept| (percept.time_us, percept.odometry_in_odom));
            mission.began = Some(here.unwrap_or_default());
        }
        if let Some(latency_s) = mission.answered(commands.number, at) {
            self.record.latencies_s.push(latency_s);
        }
        mission.newest_is(commands);
        self.guard.heard(heard_us);
    }

    /// The mission is gone, or has to go for this reason: the motors are off.
    fn leave(&mut self, why: Option<String>) {
        let Some(mission) = self.mission.take() else { return };
        if mission.began.is_some() {
            self.guard.line_closed();
        }
        mission.percepts.try_send(written(&FromHost::Bye(Bye { reason: why.clone() }))).ok();
        // The writer says what is left to say; the reader need not wait for more.
        mission.stream.shutdown(Shutdown::Read).ok();
        (self.tell)(Notice::Went(why.unwrap_or_else(|| "the host has ended".to_string())));
    }

    fn now_us(&self) -> u64 {
        self.began.elapsed().as_micros() as u64
    }
}

impl Mission {
    /// What the robot is to do; none before the first commands.
    fn take_commands(&mut self) -> Option<Commands> {
        let commands = self.newest.as_ref()?.commands();
        Some(Commands { gripper: std::mem::take(&mut self.gripper), ..commands })
    }

    /// Commands that come between two steps replace each other, but the hand is told what it was told.
    fn newest_is(&mut self, commands: CommandsMessage) {
        match commands.commands().gripper {
            GripperCommand::None => {}
            told => self.gripper = told,
        }
        self.newest = Some(commands);
    }

    /// How long commands took that answer a percept; none if others did before.
    fn answered(&mut self, number: u64, at: Instant) -> Option<f32> {
        // Decision n has taken in the percepts up to n - 1.
        let last = number.checked_sub(1)?;
        while self.unanswered.front().is_some_and(|(percept, _)| *percept < last) {
            self.unanswered.pop_front();
        }
        let (_, sent) = self.unanswered.pop_front_if(|(percept, _)| *percept == last)?;
        Some(at.saturating_duration_since(sent).as_secs_f32())
    }

    /// Hands a percept to the writer, as the mission counts time and way; whether there was room.
    fn send(&mut self, percept: &Percept) -> bool {
        let Some((began_us, odom)) = self.began else { return true };
        let percept = Percept {
            time_us: percept.time_us - began_us,
            odometry_in_odom: percept.odometry_in_odom.relative_to(odom),
            ..percept.clone()
        };
        let commands = self.newest.as_ref().map(|commands| commands.number);
        let message = PerceptMessage::new(self.next, commands, &percept);
        self.unanswered.push_back((self.next, Instant::now()));
        if self.unanswered.len() > MOST_UNANSWERED {
            self.unanswered.pop_front();
        }
        self.next += 1;
        self.percepts.try_send(written(&FromHost::Percept(Box::new(message)))).is_ok()
    }
}

/// Why a mission cannot be served, if it cannot.
fn unfit(hello: &MissionHello, robot: &str) -> Option<String> {
    if hello.protocol != PROTOCOL {
        return Some(format!("it speaks version {} of the messages, and this host {PROTOCOL}", hello.protocol));
    }
    (hello.robot != robot).then(|| format!("it is for the robot `{}`, and this host moves `{robot}`", hello.robot))
}

fn read_commands(stream: TcpStream, connection: u64, events: &Sender<(u64, Event)>) {
    let mut reading = BufReader::new(stream);
    let why = loop {
        let line = match read_line(&mut reading) {
            ReadLine::Text(line) => line,
            ReadLine::End => break "it has closed the line".to_string(),
            ReadLine::Fault(what) => break format!("it has sent {what}"),
        };
        let event = match read(&line) {
            Ok(ToHost::Commands(commands)) => Event::Commands(commands, Instant::now()),
            Ok(ToHost::Hello(hello)) => Event::Greeted(hello),
            Ok(ToHost::Bye(Bye { reason: None })) => break "it has said goodbye".to_string(),
            Ok(ToHost::Bye(Bye { reason: Some(reason) })) => break format!("it has said goodbye: {reason}"),
            Err(why) => break format!("it has sent what is no message: {why}"),
        };
        if events.send((connection, event)).is_err() {
            return;
        }
    };
    // A host that has ended asks no more.
    events.send((connection, Event::Closed(why))).ok();
}

fn write_percepts(mut stream: TcpStream, lines: &Receiver<String>) {
    // A line that cannot be written is the last: the reader of the mission sees that it is gone.
    lines.iter().try_for_each(|line| stream.write_all(line.as_bytes())).ok();
    stream.shutdown(Shutdown::Both).ok();
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_robot::simulator::{GripperMotion, GripperStatus};

    /// A host that makes one step.
    struct Mayfly {
        steps: u64,
    }

    impl Host for Mayfly {
        fn step(&mut self, _: &Commands, _: &mut Vec<Report>) -> Result<Percept, HostLost> {
            self.steps += 1;
            if self.steps > 1 {
                return Err(HostLost("the wheels say nothing".to_string()));
            }
            Ok(Percept {
                time_us: 1_000,
                odometry_in_odom: Pose::default(),
                translation_mps: 0.0,
                rotation_radps: 0.0,
                sonar_m: None,
                laser_m: None,
                camera: None,
                bumped: false,
                gripper: GripperStatus { motion: GripperMotion::Open, holding: None },
                battery: 1.0,
                messages: Vec::new(),
                others: Default::default(),
            })
        }
    }

    fn service() -> Service {
        Service {
            robot: "fly".to_string(),
            period_us: 1_000,
            factor: 1.0,
            until_us: None,
            once: false,
            start_known: false,
        }
    }

    /// All that a mission is told that greets and commands.
    fn told(address: SocketAddr) -> Vec<FromHost> {
        let mut stream = TcpStream::connect(address).expect("somebody listens");
        let hello = MissionHello { protocol: PROTOCOL, rpl: "1".to_string(), robot: "fly".to_string() };
        let commands = CommandsMessage::new(0, &Commands::default());
        for message in [ToHost::Hello(hello), ToHost::Commands(commands)] {
            stream.write_all(written(&message).as_bytes()).expect("it hears");
        }
        let mut reading = BufReader::new(stream);
        std::iter::from_fn(|| match read_line(&mut reading) {
            ReadLine::Text(line) => Some(read(&line).expect("a message")),
            ReadLine::End | ReadLine::Fault(_) => None,
        })
        .collect()
    }

    #[test]
    fn a_mission_is_told_why_its_host_is_lost() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address");
        let mission = thread::spawn(move || told(address));
        let record = serve(&mut Mayfly { steps: 0 }, listener, service(), &|| false, &mut |_| {}).expect("a listener");
        let told = mission.join().expect("a mission");
        assert!(matches!(&told[0], FromHost::Hello(hello) if !hello.start_known), "{told:?}");
        assert!(matches!(&told[1], FromHost::Percept(percept) if percept.number == 0), "{told:?}");
        let why = "the wheels say nothing".to_string();
        assert_eq!(told[2..], [FromHost::Bye(Bye { reason: Some(why.clone()) })]);
        assert_eq!((record.percepts, record.lost), (1, Some(HostLost(why))));
    }

    #[test]
    fn whoever_drips_a_greeting_keeps_no_mission_away() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address");
        let mission = thread::spawn(move || {
            let mut dripping = TcpStream::connect(address).expect("somebody listens");
            dripping.set_read_timeout(Some(Duration::from_millis(2))).expect("it can be set");
            // One byte after the other, until it is told something.
            let drips = (0..2_000).take_while(|_| dripping.write_all(b" ").is_ok() && dripping.peek(&mut [0]).is_err());
            assert!(drips.count() < 2_000, "it is let drip");
            told(address)
        });
        let mut notices = Vec::new();
        let greeting = Duration::from_millis(50);
        let mut tell = |notice| notices.push(notice);
        let is_stopped = || mission.is_finished();
        serve_greeted(greeting, &mut Mayfly { steps: 0 }, listener, service(), &is_stopped, &mut tell)
            .expect("a listener");
        assert!(matches!(&mission.join().expect("a mission")[0], FromHost::Hello(_)));
        assert_eq!(notices[1], Notice::Went("it has not said who it is within 0.05 s".to_string()));
    }
}
