//! How the command ends, as its exit status says.

use std::process::ExitCode;

/// What the exit status of the command means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The plan succeeded, or the command did what it was asked to.
    Succeeded,
    /// The plan failed.
    Failed,
    /// The text or the command line is wrong.
    Wrong,
    /// `--until` was reached.
    TimeUp,
    /// Interrupted from outside; clean-ups have run.
    Interrupted,
}

impl Status {
    /// The number the shell sees.
    pub fn code(self) -> u8 {
        match self {
            Status::Succeeded => 0,
            Status::Failed => 1,
            Status::Wrong => 2,
            Status::TimeUp => 3,
            Status::Interrupted => 130,
        }
    }
}

impl From<Status> for ExitCode {
    fn from(status: Status) -> Self {
        ExitCode::from(status.code())
    }
}
