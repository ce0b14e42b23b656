//! What those who connect may take of the server, and the server of the process.

use rustix::process::{Resource, getrlimit};
use std::time::Duration;

/// More connections are never served at a time.
const MOST_CONNECTIONS: u64 = 64;

/// Files that can always be opened by the run, or a quarter of those that the process may have open, if that is less.
const FILES_OF_RUN: u64 = 64;

/// What is served, and how long it is waited for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Connections at a time.
    pub connections: usize,
    /// Files that the process may have open.
    pub files: u64,
    /// The lowest number of a file that is left to the run. New files get the lowest number that is free.
    pub first_of_run: u64,
    /// The head of a request is there this long after the answer to the one before, or after the connection was made.
    pub head: Duration,
    /// The question is there this long after the head.
    pub question: Duration,
    /// A connection is used for new requests for this time.
    pub requests: Duration,
    /// The last answer of a connection is taken within this time.
    pub last_answer: Duration,
}

impl Limits {
    /// Those of this process.
    pub fn of_process() -> Self {
        let files = getrlimit(Resource::Nofile).current.unwrap_or(u64::MAX);
        Self::within(files)
    }

    /// Those of a process that may have `files` files open.
    pub fn within(files: u64) -> Self {
        let quarter = files / 4;
        Self {
            connections: MOST_CONNECTIONS.min(quarter).max(1) as usize,
            files,
            first_of_run: files - FILES_OF_RUN.min(quarter),
            head: Duration::from_secs(10),
            question: Duration::from_secs(5),
            requests: Duration::from_secs(60),
            last_answer: Duration::from_secs(60),
        }
    }
}
