//! Journals of runs: a run written down while it goes on, and gone on with (`docs/journal.md`).
//!
//! `head` says what the run is, `ledgers` are the files that grow, `checkpoints` the saved runs, `end` how it
//! ended; `run_journal` writes all of them while the run is driven.

mod changes;
mod checkpoints;
mod driver_state;
mod end;
mod head;
mod ledgers;
mod run_journal;

pub use changes::{Change, of_journal as changes};
pub use checkpoints::{Resumption, newest, reached_us, times as checkpoint_times};
pub use driver_state::DriverState;
pub use end::{EndKind, JournalEnd, go_on, went_on_until};
pub use head::{KeptRun, KeptText, Writing};
pub use ledgers::{LOG, OUTPUT};
pub use run_journal::{RunJournal, take};
