//! The messages of ROS 2 that robots are driven and runs are recorded by: as types, as bytes (CDR), and as the texts by
//! which other programs read these bytes. Each is written once, and its text follows from the type.
//!
//! Read in this order: `definition` (from a type to its text), `messages`, `text`. It opens no file and knows no robot.

mod definition;
pub mod messages;
pub mod text;

pub use definition::{Definitions, Field, Message};

use byteorder::LittleEndian;
use serde::Serialize;

/// Before the bytes of a message: CDR, little-endian, no options (RTPS 2.3, 10.2).
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// A message as ROS 2 sends and records it.
///
/// # Panics
/// Never: every message has numbers, texts and sequences only.
pub fn cdr<M: Message + Serialize>(message: &M) -> Vec<u8> {
    let body = cdr_encoding::to_vec::<M, LittleEndian>(message);
    let body = body.expect("a message has numbers, texts and sequences of known length");
    [&ENCAPSULATION[..], &body].concat()
}

/// A message from such bytes; none if they are of another kind, or end too early. Options are not asked: some
/// middleware counts there the bytes that fill up the last word (RTPS 2.5, 10.2).
pub fn from_cdr<M: Message + serde::de::DeserializeOwned>(bytes: &[u8]) -> Option<M> {
    let [0, 1, _, _, body @ ..] = bytes else { return None };
    cdr_encoding::from_bytes::<M, LittleEndian>(body).ok().map(|(message, _)| message)
}
