//! What an experiment has found.

use rpl_shell::status::Status;
use rpl_shell::terminal::page::Block;
use serde_json::Value;

/// What an experiment has found.
pub struct Findings {
    /// Whether its runs have succeeded, or, where they may fail, whether they count.
    pub status: Status,
    /// For people.
    pub blocks: Vec<Block>,
    /// For programs: the same figures.
    pub figures: Value,
    /// Names of files and what is drawn or written there, if that was asked for.
    pub drawings: Vec<(String, String)>,
}
