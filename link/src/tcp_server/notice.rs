//! What is told while a host is served.

use rpl_lang::visible::shortened;
use rpl_protocol::guard::Halt;
use rpl_robot::office::Report;
use std::fmt;
use std::net::SocketAddr;

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
