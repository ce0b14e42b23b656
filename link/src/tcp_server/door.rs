//! The door of a host: who has connected and not greeted yet, and who is refused.

use super::connection::{Event, read_commands};
use super::notice::Notice;
use super::service::Service;
use crate::message_lines::{MessageLines, write_line};
use crossbeam::channel::Sender;
use rpl_protocol::host::{Bye, FromHost, written};
use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

/// How often somebody who wants to connect is looked for.
pub(super) const LOOK_EVERY: Duration = Duration::from_millis(10);

/// More cannot stand at the door: whoever has waited longest there has to go.
const MOST_AT_DOOR: usize = 64;

/// Connections let in between two looks at the robot.
const MOST_LET_IN: usize = 64;

/// How often those who were refused are told of.
const REFUSALS_EVERY: Duration = Duration::from_secs(1);

/// How often it is told that nobody can be let in, which may be true and false many times a second.
const FULL_EVERY: Duration = Duration::from_secs(60);

/// Somebody who has connected and not greeted yet.
pub(super) struct Visitor {
    pub stream: Arc<TcpStream>,
    pub address: SocketAddr,
}

/// Those who were refused: some are told of, and the others are counted.
#[derive(Default)]
struct Refusals {
    told: Option<Instant>,
    untold: u64,
}

/// The door of a host.
pub(super) struct Door {
    listener: TcpListener,
    events: Sender<(u64, Event)>,
    connections: u64,
    /// Those who have connected, by their numbers, which follow each other.
    visitors: BTreeMap<u64, Visitor>,
    refusals: Refusals,
    /// When it was told last that nobody can be let in.
    told_full: Option<Instant>,
}

impl Door {
    /// Where nobody stands yet.
    ///
    /// # Errors
    /// Nobody can be listened to.
    pub fn new(listener: TcpListener, events: Sender<(u64, Event)>) -> io::Result<Self> {
        listener.set_nonblocking(true)?;
        Ok(Self {
            listener,
            events,
            connections: 0,
            visitors: BTreeMap::new(),
            refusals: Refusals::default(),
            told_full: None,
        })
    }

    /// Whoever stands there under a number, and no longer does.
    pub fn take(&mut self, connection: u64) -> Option<Visitor> {
        self.visitors.remove(&connection)
    }

    /// Lets in who has come; whether there may be more of them.
    pub fn let_in_who_has_come(&mut self, service: &Service, tell: &mut dyn FnMut(Notice)) -> bool {
        for _ in 0..MOST_LET_IN {
            match self.listener.accept() {
                Ok((stream, address)) => self.let_in(stream, address, service, tell),
                Err(error) if error.kind() == ErrorKind::WouldBlock => return false,
                // Whoever was there has gone already.
                Err(error) if [ErrorKind::Interrupted, ErrorKind::ConnectionAborted].contains(&error.kind()) => {}
                Err(error) => {
                    if self.told_full.is_none_or(|told| told.elapsed() > FULL_EVERY) {
                        self.told_full = Some(Instant::now());
                        tell(Notice::Refused(format!("nobody can be let in for now: {error}")));
                    }
                    return false;
                }
            }
        }
        true
    }

    fn let_in(&mut self, stream: TcpStream, address: SocketAddr, service: &Service, tell: &mut dyn FnMut(Notice)) {
        if self.visitors.len() >= MOST_AT_DOOR
            && let Some((_, longest)) = self.visitors.pop_first()
        {
            self.refuse(&longest.stream, format!("{MOST_AT_DOOR} wait without a greeting; {}", longest.address), tell);
        }
        let (greeting, line) = service.times();
        self.connections += 1;
        let (connection, events) = (self.connections, self.events.clone());
        let stream = Arc::new(stream);
        let lines = MessageLines::new(stream.clone(), line);
        let reader = stream
            .set_nonblocking(false)
            .and_then(|()| stream.set_nodelay(true))
            .and_then(|()| thread::Builder::new().spawn(move || read_commands(lines, greeting, connection, &events)));
        match reader {
            Ok(_) => {
                self.visitors.insert(connection, Visitor { stream, address });
            }
            Err(error) => self.refuse(&stream, format!("{address} cannot be listened to: {error}"), tell),
        }
    }

    /// Tells somebody why to go.
    pub fn refuse(&mut self, stream: &TcpStream, why: String, tell: &mut dyn FnMut(Notice)) {
        let bye = FromHost::Bye(Bye { reason: Some(why.clone()) });
        // Whoever was refused may have gone already.
        write_line(stream, &written(&bye), LOOK_EVERY).ok();
        stream.shutdown(Shutdown::Both).ok();
        if self.refusals.told.is_none_or(|told| told.elapsed() > REFUSALS_EVERY) {
            self.tell_refusals(true, tell);
            self.refusals.told = Some(Instant::now());
            tell(Notice::Refused(why));
        } else {
            self.refusals.untold += 1;
        }
    }

    /// Tells of those who were refused and not told of, if that is due, or in any case.
    pub fn tell_refusals(&mut self, in_any_case: bool, tell: &mut dyn FnMut(Notice)) {
        let is_due = self.refusals.told.is_some_and(|told| told.elapsed() > REFUSALS_EVERY);
        if self.refusals.untold > 0 && (is_due || in_any_case) {
            tell(Notice::RefusedMore(self.refusals.untold));
            self.refusals = Refusals { told: Some(Instant::now()), untold: 0 };
        }
    }

    /// The host has ended: whoever waits is told.
    pub fn close(&mut self, tell: &mut dyn FnMut(Notice)) {
        for (_, visitor) in std::mem::take(&mut self.visitors) {
            self.refuse(&visitor.stream, format!("the host has ended; {}", visitor.address), tell);
        }
    }
}
