//! Journals of runs: a run written down while it goes on, and gone on with (`docs/journal.md`).
//!
//! `head` says what the run is, `ledgers` are the files that grow, `outside` what came from other processes,
//! `checkpoints` the saved runs and `cadence` when there is one, `end` how it ended; `run_journal` writes all of them while the run is driven.
//! `session_journal` is what there is of a session at the prompt.

mod cadence;
mod changes;
mod checkpoints;
mod driver_state;
mod end;
mod foreign;
mod head;
mod kept_file;
mod ledgers;
mod outside;
mod run_journal;
mod session_journal;

pub use changes::{Change, changed_files, of_journal as changes};
pub use checkpoints::{Resumption, newest, reached_us, times as checkpoint_times};
pub use driver_state::DriverState;
pub use end::{EndKind, GoingOn, JournalEnd, go_on, went_on};
pub use foreign::ask as ask_about_foreign;
pub use head::{KeptRun, KeptText, Writing};
pub use ledgers::{LOG, OUTPUT};
pub use outside::{Outside, inputs_from_start};
pub use run_journal::{RunJournal, take};
pub use session_journal::{PastSession, SessionJournal, is_there, refuse_run};
