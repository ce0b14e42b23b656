//! The loop around a session: reads what the editor says, and finds the time to look at texts.

use super::session::{Ending, Session};
use crate::surroundings::Surroundings;
use lsp_server::Connection;
use std::time::Duration;

/// A longer text is looked at when nothing has come for so long.
const PAUSE: Duration = Duration::from_millis(300);

/// Serves an editor until it says `exit` or is gone.
pub fn serve(surroundings: &dyn Surroundings, connection: &Connection) -> Ending {
    let mut session = Session::new(surroundings);
    loop {
        let message = match session.waits() {
            None => connection.receiver.recv().ok(),
            Some(is_long) => {
                let pause = if is_long { PAUSE } else { Duration::ZERO };
                match connection.receiver.recv_timeout(pause) {
                    Ok(message) => Some(message),
                    Err(error) if error.is_timeout() => {
                        session.look();
                        if !send(&mut session, connection) {
                            return session.ending();
                        }
                        continue;
                    }
                    Err(_) => None,
                }
            }
        };
        let Some(message) = message else { return session.ending() };
        let goes_on = session.hear(message);
        if !send(&mut session, connection) || !goes_on {
            return session.ending();
        }
    }
}

/// Sends what the session has to say; whether somebody is there to hear it.
fn send(session: &mut Session<'_>, connection: &Connection) -> bool {
    session.take_said().into_iter().all(|message| connection.sender.send(message).is_ok())
}
