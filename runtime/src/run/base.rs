//! The program a run started from, which no save holds.

use rpl_lang::code::Program;
use std::sync::{Arc, OnceLock};

/// The program a run started from.
#[derive(Debug)]
pub(crate) struct Base {
    pub(crate) program: Arc<Program>,
    /// Computed by the first save.
    pub(crate) fingerprint: OnceLock<u32>,
}

impl Base {
    pub(crate) fn new(program: Arc<Program>) -> Self {
        Self { program, fingerprint: OnceLock::new() }
    }
}
