//! Journals of runs: a run written down while it goes on, and gone on with (`docs/journal.md`).
//!
//! A journal has the description of the run with all texts, a saved system now and then, and the files that the run
//! writes on and on. A run is a value that gives the same bytes again; so nothing is written for each instant. The
//! stretch behind the last checkpoint is computed again, compared with the files, and handed out from where the two
//! part. The time of a checkpoint depends on its cost, and the run cannot tell.
//!
//! The words of other processes stand beside the checkpoints, with a mark for each instant that followed from them. A
//! transcript hears them again; the new processes are spoken to only when all of them were heard. Going on there is
//! itself written down, as the last thing that came.
//!
//! Read in this order: `head` (the description, with its `kept_file`s), `ledgers` (the files that grow), `outside` (the
//! words of other processes), `driver_state`, `checkpoints` and `cadence` (the saved runs, and when there is one),
//! `end`, `changes` (new definitions) and `foreign` (journals of somebody else); `run_journal` writes all of them while
//! the run is driven, and `session_journal` is that of a session at the prompt. The files themselves are those of
//! `journal` in the crate `link`.

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
