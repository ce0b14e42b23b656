//! Ctrl-C and SIGTERM: the first asks for an orderly end, the second ends the process at once.

use crate::status::Status;
use std::sync::atomic::{AtomicBool, Ordering};

static ASKED_TO_STOP: AtomicBool = AtomicBool::new(false);

/// Catches the signals from now on. Where that is impossible they keep their usual effect.
pub fn catch() {
    ctrlc::set_handler(|| {
        if ASKED_TO_STOP.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(Status::Interrupted.code()));
        }
        crate::console::note("stopping: the clean-ups of the plan run; once more to exit at once");
    })
    .ok();
}

/// Catches Ctrl-C from now on for a prompt: it interrupts what runs and ends nothing. Where that is
/// impossible it keeps its usual effect.
pub fn catch_for_prompt() {
    ctrlc::set_handler(|| ASKED_TO_STOP.store(true, Ordering::SeqCst)).ok();
}

/// What was asked has been done.
pub fn forget() {
    ASKED_TO_STOP.store(false, Ordering::SeqCst);
}

/// Whether the process was told to stop.
pub fn is_asked() -> bool {
    ASKED_TO_STOP.load(Ordering::SeqCst)
}
