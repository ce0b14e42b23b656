//! The loop around a session: reads what the editor says, and finds the time to look at texts.

use super::messages::{ErrorCode, Heard};
use super::session::{Ending, Session};
use crate::frames::{self, Frames, Malformed};
use crate::surroundings::Surroundings;
use std::io::{self, BufRead, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::Duration;

/// A longer text is looked at when nothing has come for this time.
const PAUSE: Duration = Duration::from_millis(300);

/// Messages that are read ahead.
const MOST_AHEAD: usize = 8;

/// Serves an editor until it says `exit` or is gone.
///
/// # Errors
/// What the editor says breaks off in the midst of a message, or it does not hear any more.
pub fn serve(
    surroundings: &dyn Surroundings,
    from: impl BufRead + Send + 'static,
    mut to: impl Write,
) -> io::Result<Ending> {
    let (sender, heard) = sync_channel(MOST_AHEAD);
    thread::spawn(move || read_on(from, &sender));
    let mut session = Session::new(surroundings);
    loop {
        let goes_on = match next(&session, &heard) {
            Some(message) => session.hear(message?),
            None => {
                session.look();
                true
            }
        };
        session.take_said().iter().try_for_each(|said| frames::write(said, &mut to))?;
        if !goes_on {
            return Ok(session.ending());
        }
    }
}

/// What the editor says next; none if a text waits to be looked at, and there is time for it.
fn next(session: &Session<'_>, heard: &Receiver<io::Result<Heard>>) -> Option<io::Result<Heard>> {
    let Some(is_long) = session.waits() else { return Some(heard.recv().unwrap_or(Ok(Heard::End))) };
    let pause = if is_long { PAUSE } else { Duration::ZERO };
    match heard.recv_timeout(pause) {
        Ok(message) => Some(message),
        Err(RecvTimeoutError::Disconnected) => Some(Ok(Heard::End)),
        Err(RecvTimeoutError::Timeout) => None,
    }
}

/// Reads to the end of the stream, or as long as somebody wants to hear.
fn read_on(from: impl BufRead, heard: &SyncSender<io::Result<Heard>>) {
    let mut frames = Frames::new(from);
    loop {
        let message = match frames.read() {
            Ok(Some(Ok(message))) => Ok(Heard::of(message)),
            Ok(Some(Err(Malformed(why)))) => Ok(Heard::malformed(ErrorCode::ParseError, why)),
            Ok(None) => return,
            Err(error) => Err(error),
        };
        let is_last = message.is_err();
        if heard.send(message).is_err() || is_last {
            return;
        }
    }
}
