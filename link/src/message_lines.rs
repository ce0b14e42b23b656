//! Lines of messages on a socket, each with a bound on its length and on the time that it takes as a whole:
//! whoever sends one without an end, or a byte now and then, fills no memory and holds nobody up.

use rpl_protocol::host::LONGEST_LINE;
use std::io::{self, BufRead, BufReader, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// From its first byte to its end a line takes no longer, whoever sends it.
pub const LINE: Duration = Duration::from_secs(2);

/// What was read.
#[derive(Debug, PartialEq, Eq)]
pub enum ReadLine {
    /// A line, without its end.
    Text(String),
    /// There is nothing more; half a line is nothing.
    End,
    /// No line was there by the time that was given.
    Silence,
    /// One clause that says why it is no line.
    Fault(String),
}

/// The reading end of a socket. It shares the descriptor with the writing one: a connection that has been
/// accepted needs no second file, which there might not be.
#[derive(Debug)]
struct ReadingEnd(Arc<TcpStream>);

impl Read for ReadingEnd {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        (&*self.0).read(buffer)
    }
}

/// The lines that come from a socket.
#[derive(Debug)]
pub struct MessageLines {
    reading: BufReader<ReadingEnd>,
    /// How long a line may take, from its first byte on.
    line: Duration,
}

impl MessageLines {
    /// The lines of a socket that waits when it is read; each may take this time.
    pub fn new(stream: impl Into<Arc<TcpStream>>, line: Duration) -> Self {
        Self { reading: BufReader::new(ReadingEnd(stream.into())), line }
    }

    /// Reads the next line. Without a time by which it has to be there its beginning is waited for for ever.
    pub fn next(&mut self, until: Option<Instant>) -> ReadLine {
        let mut line = Vec::new();
        // Once it has begun.
        let mut end_by: Option<Instant> = None;
        loop {
            if self.reading.buffer().is_empty() {
                let by = end_by.into_iter().chain(until).min();
                let is_line_late = end_by.is_some() && by == end_by;
                let left = by.map(|by| by.saturating_duration_since(Instant::now()));
                // No time at all would be none for the system.
                if left.is_some_and(|left| left.is_zero()) || self.reading.get_ref().0.set_read_timeout(left).is_err() {
                    return if is_line_late { self.late() } else { ReadLine::Silence };
                }
            }
            let available = match self.reading.fill_buf() {
                Ok(available) => available,
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                // The next turn finds that the time is over.
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => continue,
                // The other end was killed: what the system says of it does not matter.
                Err(_) => return ReadLine::End,
            };
            if available.is_empty() {
                return ReadLine::End;
            }
            let end = available.iter().position(|&byte| byte == b'\n');
            let taken = end.unwrap_or(available.len());
            line.extend_from_slice(&available[..taken]);
            self.reading.consume(end.map_or(taken, |end| end + 1));
            if line.len() > LONGEST_LINE {
                return ReadLine::Fault(format!("a line of more than {LONGEST_LINE} bytes"));
            }
            if end.is_some() {
                return match String::from_utf8(line) {
                    Ok(text) => ReadLine::Text(text),
                    Err(_) => ReadLine::Fault("a line that is not UTF-8".to_string()),
                };
            }
            end_by.get_or_insert_with(|| Instant::now() + self.line);
        }
    }

    fn late(&self) -> ReadLine {
        ReadLine::Fault(format!("a line that has not ended within {:.1} s", self.line.as_secs_f64()))
    }
}

/// Writes a line as a whole within a time.
///
/// # Errors
/// The other end is gone, or has not taken it in time.
pub fn write_line(mut stream: &TcpStream, line: &str, within: Duration) -> io::Result<()> {
    let until = Instant::now() + within;
    let mut rest = line.as_bytes();
    while !rest.is_empty() {
        let left = until.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(ErrorKind::TimedOut.into());
        }
        stream.set_write_timeout(Some(left))?;
        match stream.write(rest) {
            Ok(0) => return Err(ErrorKind::WriteZero.into()),
            Ok(written) => rest = &rest[written..],
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            // The next turn finds that the time is over.
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::TcpListener;
    use std::thread;

    /// Two ends of a line.
    fn ends() -> (TcpStream, TcpStream) {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let one = TcpStream::connect(listener.local_addr().expect("an address")).expect("it listens");
        (one, listener.accept().expect("somebody comes").0)
    }

    #[test]
    fn lines_have_an_end_and_a_bound() {
        let (mut one, other) = ends();
        let mut lines = MessageLines::new(other, LINE);
        one.write_all(b"one\ntwo\n\xff\n").expect("it is taken");
        assert_eq!(lines.next(None), ReadLine::Text("one".to_string()));
        assert_eq!(lines.next(None), ReadLine::Text("two".to_string()));
        assert!(matches!(lines.next(None), ReadLine::Fault(_)));
        // Whoever writes a line without an end writes until nobody reads it any more.
        let endless = thread::spawn(move || while one.write_all(&[b'x'; 1 << 16]).is_ok() {});
        let ReadLine::Fault(why) = lines.next(None) else { panic!("it has no end") };
        assert!(why.contains("1048576 bytes"), "{why}");
        drop(lines);
        endless.join().expect("it was cut off");
    }

    #[test]
    fn half_a_line_at_the_end_is_nothing() {
        let (mut one, other) = ends();
        one.write_all(b"thr").expect("it is taken");
        drop(one);
        assert_eq!(MessageLines::new(other, LINE).next(None), ReadLine::End);
    }

    #[test]
    fn a_line_that_drips_and_one_that_never_begins_are_waited_for_in_all_so_long() {
        const WITHIN: Duration = Duration::from_millis(40);
        let (one, other) = ends();
        let mut lines = MessageLines::new(other, WITHIN);
        assert_eq!(lines.next(Some(Instant::now() + WITHIN)), ReadLine::Silence);
        let drips = thread::spawn(move || {
            let mut one = one;
            one.set_read_timeout(Some(WITHIN / 8)).expect("it may be set");
            // Each wait for an answer that does not come is a fraction of what a line may take.
            (0..400).all(|_| one.write_all(b"x").is_ok() && !matches!(io::Read::read(&mut one, &mut [0]), Ok(0)))
        });
        let heard = lines.next(None);
        drop(lines);
        assert_eq!(heard, ReadLine::Fault("a line that has not ended within 0.0 s".to_string()));
        assert!(!drips.join().expect("it ends"), "it was cut off in the midst of its line");
    }

    #[test]
    fn who_does_not_read_is_written_to_for_so_long_and_no_longer() {
        let (one, _unread) = ends();
        let line = "x".repeat(1 << 16);
        let found = (0..10_000).find_map(|_| write_line(&one, &line, Duration::from_millis(20)).err());
        assert!(found.is_some_and(|error| error.kind() == ErrorKind::TimedOut));
    }
}
