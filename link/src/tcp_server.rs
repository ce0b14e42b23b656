//! A host served over TCP at the pace of the clock on the wall.
//!
//! One thread, that of the caller, owns the host: it steps it when it is time, with the newest commands that
//! have come, and a [`Guard`] between them and the motors. For each mission there is a thread that reads and
//! one that writes, so that no mission can keep the host waiting.
//!
//! Whoever connects stands at the door until a greeting has come; only a greeting takes the robot. All that is
//! waited for has an end: a greeting, a line, a percept that is taken, commands of a mission.
//!
//! The world stands still until the first mission gives its first commands, and goes on from then, whether a
//! mission is there or not. Time and odometry begin anew for each mission; only the first is told that the
//! robot stands where the world says it starts.

use crate::message_lines::{LINE, MessageLines, ReadLine, write_line};
use crossbeam::channel::{Receiver, Sender, bounded};
use rpl_lang::visible::shortened;
use rpl_protocol::guard::{Guard, Halt, HaltCounts};
use rpl_protocol::host::{
    Bye, CommandsMessage, FromHost, HostHello, MissionHello, PROTOCOL, PerceptMessage, ToHost, read, written,
};
use rpl_protocol::token::Token;
use rpl_robot::geometry::Pose;
use rpl_robot::office::{Host, HostLost, Report};
use rpl_robot::simulator::{Commands, GripperCommand, Percept};
use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::io::{self, ErrorKind};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

/// How often somebody who wants to connect is looked for.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// Whoever connects says who it is within this time.
const GREETING: Duration = Duration::from_secs(5);

/// More cannot stand at the door: whoever has waited longest there has to go.
const MOST_AT_DOOR: usize = 64;

/// Connections let in between two looks at the robot.
const MOST_LET_IN: usize = 64;

/// How often those who were refused are told of.
const REFUSALS_EVERY: Duration = Duration::from_secs(1);

/// How often it is told that nobody can be let in, which may be true and false many times a second.
const FULL_EVERY: Duration = Duration::from_secs(60);

/// A mission that has not taken in the percepts of this time drives blindly: its commands count for nothing, and it is
/// gone for the host once as many wait to be sent.
const BLIND: Duration = Duration::from_secs(2);

/// The same in percepts, however fast the time of the robot goes.
const MOST_UNSENT: usize = 600;

/// A mission that gives no commands for this time has lost the robot, if no other time is given.
pub const PATIENCE: Duration = Duration::from_secs(60);

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
    /// A mission that gives no commands for this time has lost the robot.
    pub patience: Duration,
    /// What missions have to know.
    pub token: Option<Token>,
}

impl Service {
    fn period(&self) -> Duration {
        Duration::from_secs_f64(self.period_us as f64 / 1e6 / self.factor)
    }

    /// How long a greeting may take, and a line: no longer than a mission may be silent.
    fn times(&self) -> (Duration, Duration) {
        (GREETING.min(self.patience), LINE.min(self.patience))
    }

    /// Whether a mission that has not taken in `behind` percepts drives blindly.
    fn is_blind(&self, behind: u64) -> bool {
        self.period().mul_f64(behind as f64) > BLIND.min(self.patience)
    }

    /// Percepts of [`BLIND`].
    fn most_unsent(&self) -> usize {
        (BLIND.div_duration_f64(self.period()) as usize).clamp(4, MOST_UNSENT)
    }
}

/// A mission, for those who find the robot in use, and for whoever watches the host.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Who {
    /// From where it has come.
    pub address: SocketAddr,
    /// What it is called, as it has said; it may be any text.
    pub mission: Option<String>,
}

impl fmt::Display for Who {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.mission {
            Some(mission) => write!(out, "`{}` from {}", shortened(mission), self.address),
            None => write!(out, "a mission without a name from {}", self.address),
        }
    }
}

/// What is worth telling while a host is served.
#[derive(Clone, Debug, PartialEq)]
pub enum Notice {
    /// A mission has come: the robot is its own.
    Came(Who),
    /// It has gone: one clause that says how.
    Went(String),
    /// Somebody was refused: one clause that says why.
    Refused(String),
    /// How many more were refused since that was last told.
    RefusedMore(u64),
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
    Greeted(MissionHello, Instant),
    Commands(CommandsMessage, Instant),
    Closed(String),
}

/// Somebody who has connected and not greeted yet.
struct Visitor {
    stream: TcpStream,
    address: SocketAddr,
}

/// A mission that is served.
struct Mission {
    /// By which its events are told from those of an earlier one.
    connection: u64,
    percepts: Sender<String>,
    stream: TcpStream,
    who: Who,
    since: Instant,
    /// When it last said something.
    heard: Instant,
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
    /// When it was told last that nobody can be let in.
    told_full: Option<Instant>,
    service: Service,
    tell: &'a mut dyn FnMut(Notice),
    events: Events,
    connections: u64,
    /// Those who have connected, by their numbers, which follow each other.
    door: BTreeMap<u64, Visitor>,
    mission: Option<Mission>,
    refusals: Refusals,
    guard: Guard,
    began: Instant,
    percept: Option<Percept>,
    record: ServiceRecord,
}

/// Those who were refused: some are told of, and the others are counted.
#[derive(Default)]
struct Refusals {
    told: Option<Instant>,
    untold: u64,
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
    listener.set_nonblocking(true)?;
    let mut server = Server {
        host,
        listener,
        told_full: None,
        service,
        tell,
        events: bounded(MOST_EVENTS),
        connections: 0,
        door: BTreeMap::new(),
        mission: None,
        refusals: Refusals::default(),
        guard: Guard::default(),
        began: Instant::now(),
        percept: None,
        record: ServiceRecord::default(),
    };
    server.run(is_stopped);
    server.leave(None);
    server.close_door();
    server.tell_refusals(true);
    server.record.halts = server.guard.counts;
    Ok(server.record)
}

impl<H: Host> Server<'_, H> {
    fn run(&mut self, is_stopped: &dyn Fn() -> bool) {
        let period = self.service.period();
        // When the next step is due; none until the first commands.
        let mut next: Option<Instant> = None;
        let mut more_come = false;
        while !is_stopped() && !self.is_over() {
            let look = Instant::now() + if more_come { Duration::ZERO } else { LOOK_EVERY };
            self.listen_until(next.map_or(look, |due| look.min(due)));
            more_come = self.look_for_missions();
            self.look_at_mission();
            self.tell_refusals(false);
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

    /// Lets in who has come; whether there may be more of them.
    fn look_for_missions(&mut self) -> bool {
        for _ in 0..MOST_LET_IN {
            match self.listener.accept() {
                Ok((stream, address)) => self.let_in(stream, address),
                Err(error) if error.kind() == ErrorKind::WouldBlock => return false,
                // Whoever was there has gone already.
                Err(error) if [ErrorKind::Interrupted, ErrorKind::ConnectionAborted].contains(&error.kind()) => {}
                Err(error) => {
                    if self.told_full.is_none_or(|told| told.elapsed() > FULL_EVERY) {
                        self.told_full = Some(Instant::now());
                        (self.tell)(Notice::Refused(format!("nobody can be let in for now: {error}")));
                    }
                    return false;
                }
            }
        }
        true
    }

    /// The mission has lost the robot if it was silent for too long, whatever came of it or did not.
    fn look_at_mission(&mut self) {
        let patience = self.service.patience;
        if self.mission.as_ref().is_some_and(|mission| mission.heard.elapsed() > patience) {
            self.leave(Some(format!("it has given no commands for {:.1} s", patience.as_secs_f64())));
        }
    }

    fn let_in(&mut self, stream: TcpStream, address: SocketAddr) {
        if self.door.len() >= MOST_AT_DOOR
            && let Some((_, longest)) = self.door.pop_first()
        {
            self.refuse(&longest.stream, format!("{MOST_AT_DOOR} wait without a greeting; {}", longest.address));
        }
        let (greeting, line) = self.service.times();
        let ready = stream
            .set_nonblocking(false)
            .and_then(|()| stream.set_nodelay(true))
            .and_then(|()| Ok(MessageLines::new(stream.try_clone()?, line)));
        let lines = match ready {
            Ok(lines) => lines,
            Err(error) => return self.refuse(&stream, format!("{address} cannot be listened to: {error}")),
        };
        self.connections += 1;
        let (connection, events) = (self.connections, self.events.0.clone());
        let reader = thread::Builder::new().spawn(move || read_commands(lines, greeting, connection, &events));
        match reader {
            Ok(_) => {
                self.door.insert(connection, Visitor { stream, address });
            }
            Err(error) => self.refuse(&stream, format!("{address} cannot be listened to: {error}")),
        }
    }

    fn refuse(&mut self, stream: &TcpStream, why: String) {
        let bye = FromHost::Bye(Bye { reason: Some(why.clone()) });
        // Whoever was refused may have gone already.
        write_line(stream, &written(&bye), LOOK_EVERY).ok();
        stream.shutdown(Shutdown::Both).ok();
        if self.refusals.told.is_none_or(|told| told.elapsed() > REFUSALS_EVERY) {
            self.tell_refusals(true);
            self.refusals.told = Some(Instant::now());
            (self.tell)(Notice::Refused(why));
        } else {
            self.refusals.untold += 1;
        }
    }

    /// Tells of those who were refused and not told of, if that is due, or in any case.
    fn tell_refusals(&mut self, in_any_case: bool) {
        let is_due = self.refusals.told.is_some_and(|told| told.elapsed() > REFUSALS_EVERY);
        if self.refusals.untold > 0 && (is_due || in_any_case) {
            (self.tell)(Notice::RefusedMore(self.refusals.untold));
            self.refusals = Refusals { told: Some(Instant::now()), untold: 0 };
        }
    }

    /// The host has ended: whoever waits is told.
    fn close_door(&mut self) {
        for (_, visitor) in std::mem::take(&mut self.door) {
            self.refuse(&visitor.stream, format!("the host has ended; {}", visitor.address));
        }
    }

    fn take(&mut self, connection: u64, event: Event) {
        if let Some(visitor) = self.door.remove(&connection) {
            return self.take_from_door(connection, visitor, event);
        }
        if self.mission.as_ref().is_none_or(|mission| mission.connection != connection) {
            return;
        }
        match event {
            Event::Greeted(..) => self.leave(Some("it greets a second time".to_string())),
            Event::Commands(commands, at) => self.command(commands, at),
            Event::Closed(why) => self.leave(Some(why)),
        }
    }

    fn take_from_door(&mut self, connection: u64, Visitor { stream, address }: Visitor, event: Event) {
        let refused = match event {
            Event::Greeted(hello, at) => match hello.unfit(&self.service.robot, self.service.token.as_ref()) {
                Some(why) => format!("{address} {why}"),
                None => match &self.mission {
                    Some(Mission { who, since, .. }) => format!(
                        "another mission is here: {who}, since {} s; {address} has to wait",
                        since.elapsed().as_secs()
                    ),
                    None => return self.welcome(connection, stream, address, hello, at),
                },
            },
            Event::Commands(..) => format!("{address} commands before it greets"),
            Event::Closed(why) => format!("{address}: {why}"),
        };
        self.refuse(&stream, refused);
    }

    fn welcome(&mut self, connection: u64, stream: TcpStream, address: SocketAddr, said: MissionHello, at: Instant) {
        let (percepts, to_write) = bounded(self.service.most_unsent());
        let (_, line) = self.service.times();
        let writer = stream
            .try_clone()
            .and_then(|writing| thread::Builder::new().spawn(move || write_percepts(&writing, line, &to_write)));
        if let Err(error) = writer {
            return self.refuse(&stream, format!("{address} cannot be spoken to: {error}"));
        }
        let hello = HostHello {
            protocol: PROTOCOL,
            robot: self.service.robot.clone(),
            period_us: self.service.period_us,
            factor: self.service.factor,
            start_known: self.service.start_known && self.percept.is_none(),
        };
        percepts.try_send(written(&FromHost::Hello(hello))).ok();
        let who = Who { address, mission: said.mission };
        (self.tell)(Notice::Came(who.clone()));
        self.mission = Some(Mission {
            connection,
            percepts,
            stream,
            who,
            since: at,
            heard: at,
            began: None,
            next: 0,
            newest: None,
            gripper: GripperCommand::None,
            unanswered: VecDeque::new(),
        });
    }

    fn command(&mut self, commands: CommandsMessage, at: Instant) {
        let heard_us = at.saturating_duration_since(self.began).as_micros() as u64;
        let Some(mission) = &mut self.mission else { return };
        let Some(behind) = mission.next.checked_sub(commands.number) else {
            let (number, next) = (commands.number, mission.next);
            return self.leave(Some(format!("it answers up to percept {number}, and {next} is the next that is sent")));
        };
        // Who has not seen where the robot is now is as good as silent.
        let counts = !self.service.is_blind(behind);
        if counts {
            mission.heard = at;
        }
        if mission.began.is_none() {
            self.record.missions += 1;
            let here = self.percept.as_ref().map(|percept| (percept.time_us, percept.odometry_in_odom));
            mission.began = Some(here.unwrap_or_default());
        }
        if let Some(latency_s) = mission.answered(commands.number, at) {
            self.record.latencies_s.push(latency_s);
        }
        mission.newest_is(commands);
        if counts {
            self.guard.heard(heard_us);
        }
    }

    /// The mission is gone, or has to go for this reason: the motors are off.
    fn leave(&mut self, why: Option<String>) {
        let Some(mission) = self.mission.take() else { return };
        if mission.began.is_some() {
            self.guard.line_closed();
        }
        let bye = written(&FromHost::Bye(Bye { reason: why.clone() }));
        // The writer says what is left to say, if it is heard; the reader need not wait for more.
        let is_heard = mission.percepts.len() <= 1 && mission.percepts.try_send(bye).is_ok();
        mission.stream.shutdown(if is_heard { Shutdown::Read } else { Shutdown::Both }).ok();
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

fn read_commands(mut lines: MessageLines, greeting: Duration, connection: u64, events: &Sender<(u64, Event)>) {
    // Once the greeting is there, the server looks at how long nothing comes.
    let mut until = Some(Instant::now() + greeting);
    let why = loop {
        let line = match lines.next(until) {
            ReadLine::Text(line) => line,
            ReadLine::End => break "it has closed the line".to_string(),
            ReadLine::Silence => break format!("it has not greeted within {:.1} s", greeting.as_secs_f64()),
            ReadLine::Fault(what) => break format!("it has sent {what}"),
        };
        let event = match read(&line) {
            Ok(ToHost::Commands(commands)) => Event::Commands(commands, Instant::now()),
            Ok(ToHost::Hello(hello)) => {
                until = None;
                Event::Greeted(hello, Instant::now())
            }
            Ok(ToHost::Bye(bye)) => break format!("it {}", bye.told()),
            Err(why) => break format!("it has sent what is no message: {why}"),
        };
        if events.send((connection, event)).is_err() {
            return;
        }
    };
    // A host that has ended asks no more.
    events.send((connection, Event::Closed(why))).ok();
}

fn write_percepts(stream: &TcpStream, within: Duration, lines: &Receiver<String>) {
    // A line that cannot be written is the last: the reader of the mission sees that it is gone.
    lines.iter().try_for_each(|line| write_line(stream, &line, within)).ok();
    stream.shutdown(Shutdown::Both).ok();
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_robot::simulator::{GripperMotion, GripperStatus};
    use std::io::Write;

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
                failed: Default::default(),
                bumped: false,
                gripper: GripperStatus { motion: GripperMotion::Open, holding: None },
                battery: 1.0,
                messages: Vec::new(),
                others: Default::default(),
            })
        }
    }

    /// A host whose robot drives as it is told, at once, and notes whether its motors are off.
    #[derive(Default)]
    struct Obedient {
        steps: u64,
        drove: u64,
    }

    impl Host for Obedient {
        fn step(&mut self, commands: &Commands, _: &mut Vec<Report>) -> Result<Percept, HostLost> {
            self.steps += 1;
            self.drove += u64::from(!commands.motors_off);
            Ok(Percept { time_us: self.steps * 1_000, ..Mayfly { steps: 0 }.step(commands, &mut Vec::new())? })
        }
    }

    fn service(patience: Duration) -> Service {
        Service {
            robot: "fly".to_string(),
            period_us: 1_000,
            factor: 1.0,
            until_us: None,
            once: false,
            start_known: false,
            patience,
            token: None,
        }
    }

    fn hello() -> MissionHello {
        let (rpl, robot) = ("1".to_string(), "fly".to_string());
        MissionHello { protocol: PROTOCOL, rpl, robot, mission: Some("a\nb".to_string()), token: None }
    }

    /// A host that is served in a thread of its own until somebody says that it is to end.
    struct Served {
        address: SocketAddr,
        ends: Sender<()>,
        serving: thread::JoinHandle<(Obedient, ServiceRecord, Vec<Notice>)>,
    }

    impl Served {
        fn start(service: Service) -> Self {
            let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
            let address = listener.local_addr().expect("an address");
            let (ends, ended) = bounded::<()>(1);
            let serving = thread::spawn(move || {
                let (mut host, mut notices) = (Obedient::default(), Vec::new());
                let tell = &mut |notice| notices.push(notice);
                let record = serve(&mut host, listener, service, &|| !ended.is_empty(), tell).expect("a listener");
                (host, record, notices)
            });
            Self { address, ends, serving }
        }

        fn connect(&self) -> Client {
            let stream = TcpStream::connect(self.address).expect("somebody listens");
            let lines = MessageLines::new(stream.try_clone().expect("a second handle"), LINE);
            Client { stream, lines }
        }

        fn end(self) -> (Obedient, ServiceRecord, Vec<Notice>) {
            self.ends.send(()).expect("it serves");
            self.serving.join().expect("it ends")
        }
    }

    struct Client {
        stream: TcpStream,
        lines: MessageLines,
    }

    impl Client {
        fn say(&mut self, message: &ToHost) {
            self.stream.write_all(written(message).as_bytes()).expect("it hears");
        }

        /// Wants to drive; whether that can still be said.
        fn command(&mut self, number: u64) -> bool {
            let driving = Commands { translation_mps: 1.0, ..Commands::default() };
            let message = ToHost::Commands(CommandsMessage::new(number, &driving));
            self.stream.write_all(written(&message).as_bytes()).is_ok()
        }

        fn hear(&mut self) -> Option<FromHost> {
            match self.lines.next(None) {
                ReadLine::Text(line) => Some(read(&line).expect("a message")),
                ReadLine::End | ReadLine::Silence | ReadLine::Fault(_) => None,
            }
        }

        /// Why it has to go, whatever it hears before.
        fn goodbye(&mut self) -> String {
            loop {
                match self.hear().expect("it says why") {
                    FromHost::Bye(bye) => return bye.reason.expect("there is a reason"),
                    FromHost::Hello(_) | FromHost::Percept(_) => {}
                }
            }
        }

        /// Says nothing whole, a byte now and then, until it has to go.
        fn drip(&mut self) -> String {
            self.stream.set_nonblocking(true).expect("it may be set");
            while self.stream.write_all(b"x").is_ok() && self.stream.peek(&mut [0]).is_err() {
                thread::park_timeout(Duration::from_millis(3));
            }
            self.stream.set_nonblocking(false).expect("it may be set");
            self.goodbye()
        }
    }

    /// As long as tests wait for what has to come.
    const SHORT: Duration = Duration::from_millis(120);

    #[test]
    fn who_is_silent_or_drips_before_a_greeting_keeps_nobody_from_the_robot() {
        let served = Served::start(service(SHORT));
        let (mut silent, mut dripping) = (served.connect(), served.connect());
        let mut mission = served.connect();
        mission.say(&ToHost::Hello(hello()));
        assert!(matches!(mission.hear(), Some(FromHost::Hello(_))), "the robot is free");
        let why = silent.goodbye();
        assert!(why.contains("has not greeted within 0.1 s"), "{why}");
        let why = dripping.drip();
        assert!(why.contains("within 0.1 s"), "{why}");
        served.end();
    }

    #[test]
    fn a_mission_that_is_silent_or_drips_loses_the_robot() {
        let served = Served::start(service(SHORT));
        for drips in [false, true] {
            let mut mission = served.connect();
            mission.say(&ToHost::Hello(hello()));
            mission.command(0);
            let why = if drips { mission.drip() } else { mission.goodbye() };
            let either = ["has given no commands for 0.1 s", "a line that has not ended within 0.1 s"];
            assert!(either.iter().any(|expected| why.contains(expected)), "{why}");
        }
        let (_, record, _) = served.end();
        assert_eq!((record.missions, record.halts.closed_lines), (2, 2));
    }

    #[test]
    fn a_mission_that_does_not_take_in_what_the_robot_perceives_does_not_drive_it_on() {
        let served = Served::start(Service { period_us: 10_000, ..service(Duration::from_millis(400)) });
        let mut mission = served.connect();
        mission.say(&ToHost::Hello(hello()));
        mission.command(0);
        assert!(matches!(mission.hear(), Some(FromHost::Hello(_))));
        // It reads, and decides by the first percept for ever: the line shows nothing of that.
        while let Some(FromHost::Percept(_)) = mission.hear()
            && mission.command(1)
        {}
        let (host, record, notices) = served.end();
        assert!(notices.contains(&Notice::Halted(Halt::Silence)), "{notices:?}");
        assert!(record.halts.silences == 1 && host.drove < 100, "it drove for {} steps of 0.01 s", host.drove);
        let has_lost_it = |notice: &Notice| matches!(notice, Notice::Went(why) if why.contains("given no commands"));
        assert!(notices.iter().any(has_lost_it), "{notices:?}");
    }

    #[test]
    fn what_was_never_said_is_not_answered() {
        let served = Served::start(service(SHORT));
        let mut mission = served.connect();
        mission.say(&ToHost::Hello(hello()));
        mission.command(1_000_000);
        let why = mission.goodbye();
        assert!(why.contains("it answers up to percept 1000000"), "{why}");
        served.end();
    }

    #[test]
    fn who_finds_the_robot_in_use_hears_by_whom_and_nothing_is_forged() {
        let served = Served::start(service(Duration::from_secs(60)));
        let mut mission = served.connect();
        mission.say(&ToHost::Hello(hello()));
        assert!(matches!(mission.hear(), Some(FromHost::Hello(_))));
        let mut second = served.connect();
        second.say(&ToHost::Hello(hello()));
        let (why, from) = (second.goodbye(), mission.stream.local_addr().expect("it has one"));
        assert!(why.contains(&format!("another mission is here: `a\\nb` from {from}, since 0 s")), "{why}");
        mission.say(&ToHost::Bye(Bye { reason: Some("\u{1b}[2J\nerror: forged\u{202e}".to_string()) }));
        mission.goodbye();
        let (_, _, notices) = served.end();
        let told = "it says goodbye: \\u{1b}[2J\\nerror: forged\\u{202e}";
        assert!(notices.contains(&Notice::Went(told.to_string())), "{notices:?}");
    }

    #[test]
    fn only_who_knows_the_token_is_served_and_nobody_else_learns_who_is() {
        let token = |text: &str| Some(Token::new(text).expect("a token"));
        let served = Served::start(Service { token: token("0123456789abcdef"), ..service(Duration::from_secs(60)) });
        let mut mission = served.connect();
        mission.say(&ToHost::Hello(MissionHello { token: token("0123456789abcdef"), ..hello() }));
        assert!(matches!(mission.hear(), Some(FromHost::Hello(_))));
        for (said, expected) in [(None, "has no token"), (token("0123456789abcdeF"), "has another token")] {
            let mut stranger = served.connect();
            stranger.say(&ToHost::Hello(MissionHello { token: said, ..hello() }));
            let why = stranger.goodbye();
            assert!(why.contains(expected) && !why.contains("another mission"), "{why}");
        }
        served.end();
    }

    #[test]
    fn hundreds_who_connect_and_say_nothing_keep_no_mission_out_and_are_told_of_in_a_few_lines() {
        let served = Served::start(service(Duration::from_secs(60)));
        // More than may stand at the door.
        let mut silent = VecDeque::new();
        let mut connect = |count| {
            for _ in 0..count {
                silent.push_back(TcpStream::connect(served.address).expect("it listens"));
                if silent.len() > 200 {
                    silent.pop_front();
                }
            }
        };
        connect(400);
        let mut mission = served.connect();
        mission.say(&ToHost::Hello(hello()));
        assert!(matches!(mission.hear(), Some(FromHost::Hello(_))));
        connect(400);
        mission.command(0);
        assert!(matches!(mission.hear(), Some(FromHost::Percept(_))), "it still has the robot");
        let (_, _, notices) = served.end();
        let lines = notices.iter().filter(|notice| matches!(notice, Notice::Refused(_) | Notice::RefusedMore(_)));
        assert!(lines.count() < 100, "{notices:?}");
    }

    #[test]
    fn a_line_of_a_thousand_megabytes_is_refused_after_one() {
        let served = Served::start(service(Duration::from_secs(60)));
        let mut client = served.connect();
        let sent = (0..1_000).take_while(|_| client.stream.write_all(&[b'x'; 1 << 20]).is_ok()).count();
        assert!(sent < 100, "{sent} MiB were taken");
        served.end();
    }

    #[test]
    fn a_mission_is_told_why_its_host_is_lost() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address");
        let mission = thread::spawn(move || {
            let mut stream = TcpStream::connect(address).expect("somebody listens");
            let commands = CommandsMessage::new(0, &Commands::default());
            for message in [ToHost::Hello(hello()), ToHost::Commands(commands)] {
                stream.write_all(written(&message).as_bytes()).expect("it hears");
            }
            let mut lines = MessageLines::new(stream, LINE);
            std::iter::from_fn(|| match lines.next(None) {
                ReadLine::Text(line) => Some(read(&line).expect("a message")),
                ReadLine::End | ReadLine::Silence | ReadLine::Fault(_) => None,
            })
            .collect::<Vec<FromHost>>()
        });
        let service = service(PATIENCE);
        let record = serve(&mut Mayfly { steps: 0 }, listener, service, &|| false, &mut |_| {}).expect("a listener");
        let told = mission.join().expect("a mission");
        assert!(matches!(&told[0], FromHost::Hello(hello) if !hello.start_known), "{told:?}");
        assert!(matches!(&told[1], FromHost::Percept(percept) if percept.number == 0), "{told:?}");
        let why = "the wheels say nothing".to_string();
        assert_eq!(told[2..], [FromHost::Bye(Bye { reason: Some(why.clone()) })]);
        assert_eq!((record.percepts, record.lost), (1, Some(HostLost(why))));
    }
}
