//! How a run is written down so that it can be gone on with.

use clap::ValueHint;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Whether a run is written down while it goes on.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct JournalArguments {
    /// Record the run in this folder, so that `rpl resume` can resume it after a crash
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath, conflicts_with = "record")]
    pub journal: Option<PathBuf>,
    /// What a power cut may cost: nothing that was printed (`always`), the output of the last second,
    /// which is then printed again (`second`), or the whole run (`never`). If only the process is killed,
    /// nothing is lost
    #[arg(
        long,
        value_name = "WHEN",
        requires = "journal",
        value_enum,
        default_value_t = SyncArgument::Second,
        hide_possible_values = true
    )]
    pub sync: SyncArgument,
    /// Stop the run, with its clean-ups, when the journal cannot be written (default: continue, and try
    /// the journal again)
    #[arg(long, requires = "journal")]
    pub journal_must: bool,
}

/// When what is written is brought to the disk.
#[derive(clap::ValueEnum, Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SyncArgument {
    /// At the end of each instant in which something was printed
    Always,
    /// Once a second
    #[default]
    Second,
    /// When the system likes
    Never,
}
