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

mod connection;
mod door;
mod mission;
mod notice;
mod service;
#[cfg(test)]
mod tests;

pub use notice::{Notice, Who};
pub use service::{PATIENCE, Service};

use connection::{Event, write_percepts};
use crossbeam::channel::{Receiver, bounded};
use door::{Door, LOOK_EVERY, Visitor};
use mission::Mission;
use rpl_protocol::guard::{Guard, HaltCounts};
use rpl_protocol::host::{Bye, CommandsMessage, FromHost, HostHello, MissionHello, PROTOCOL, written};
use rpl_robot::office::{Host, HostLost};
use rpl_robot::simulator::Percept;
use std::io;
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};

/// What may come between two steps before one is made; whoever sends more has to wait.
const MOST_EVENTS: usize = 1_000;

/// A host that is so far behind the clock goes on from there and does not hurry.
const MOST_BEHIND: Duration = Duration::from_millis(500);

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

/// A host that is served.
struct Server<'a, H> {
    host: &'a mut H,
    service: Service,
    tell: &'a mut dyn FnMut(Notice),
    /// From those who are connected, each with the number of its connection.
    events: Receiver<(u64, Event)>,
    door: Door,
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
    let (to_server, events) = bounded(MOST_EVENTS);
    let mut server = Server {
        host,
        service,
        tell,
        events,
        door: Door::new(listener, to_server)?,
        mission: None,
        guard: Guard::default(),
        began: Instant::now(),
        percept: None,
        record: ServiceRecord::default(),
    };
    server.run(is_stopped);
    server.leave(None);
    server.door.close(server.tell);
    server.door.tell_refusals(true, server.tell);
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
            more_come = self.door.let_in_who_has_come(&self.service, self.tell);
            self.look_at_mission();
            self.door.tell_refusals(false, self.tell);
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
            let Ok((connection, event)) = self.events.recv_deadline(wake) else { return };
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

    /// The mission has lost the robot if it was silent for too long, whatever came of it or did not.
    fn look_at_mission(&mut self) {
        let patience = self.service.patience;
        if self.mission.as_ref().is_some_and(|mission| mission.heard.elapsed() > patience) {
            self.leave(Some(format!("it has given no commands for {:.1} s", patience.as_secs_f64())));
        }
    }

    fn take(&mut self, connection: u64, event: Event) {
        if let Some(visitor) = self.door.take(connection) {
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
        self.door.refuse(&stream, refused, self.tell);
    }

    fn welcome(
        &mut self,
        connection: u64,
        stream: Arc<TcpStream>,
        address: SocketAddr,
        said: MissionHello,
        at: Instant,
    ) {
        let (percepts, to_write) = bounded(self.service.most_unsent());
        let (_, line) = self.service.times();
        let who = Who { address, mission: said.mission };
        let mission = Mission::new(connection, percepts, stream, who, at);
        let (writing, is_leaving) = (mission.stream.clone(), mission.is_leaving.clone());
        let writer = thread::Builder::new().spawn(move || write_percepts(&writing, line, &to_write, &is_leaving));
        if let Err(error) = writer {
            let why = format!("{address} cannot be spoken to: {error}");
            return self.door.refuse(&mission.stream, why, self.tell);
        }
        let hello = HostHello {
            protocol: PROTOCOL,
            robot: self.service.robot.clone(),
            period_us: self.service.period_us,
            factor: self.service.factor,
            start_known: self.service.start_known && self.percept.is_none(),
        };
        mission.percepts.try_send(written(&FromHost::Hello(hello))).ok();
        (self.tell)(Notice::Came(mission.who.clone()));
        self.mission = Some(mission);
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
        // The writer says what is left to say, if it is heard soon; the reader need not wait for more.
        mission.is_leaving.store(true, Ordering::Relaxed);
        let is_heard = mission.percepts.try_send(bye).is_ok();
        mission.stream.shutdown(if is_heard { Shutdown::Read } else { Shutdown::Both }).ok();
        (self.tell)(Notice::Went(why.unwrap_or_else(|| "the host has ended".to_string())));
    }

    fn now_us(&self) -> u64 {
        self.began.elapsed().as_micros() as u64
    }
}
