//! Saved runs with changed bytes and a checksum that fits: they are refused, or run on.

use super::drive::said;
use super::robot::{Whim, library};
use super::{Dice, grammar};
use rpl_lang::compile::NoFiles;
use rpl_runtime::run::save::SaveError;
use rpl_runtime::run::system::System;
use rpl_runtime::state::limits::Limits;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Bytes of a saved run before its payload; the checksum is the last word of them.
const HEADER: usize = 19;

/// How many were refused, and how many ran on.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// Refused by `load`.
    pub refused: usize,
    /// Loaded, and then run for some steps.
    pub ran: usize,
}

/// Runs a generated program for some steps, saves it, and loads forgeries of that.
///
/// # Errors
/// What a panic said, or that bytes were read as what they are not.
pub fn judge(seed: u64, forgeries: usize, tally: &mut Tally) -> Result<(), String> {
    let mut dice = Dice::new(seed);
    let text = grammar::program(seed);
    let Ok(loaded) = library().load("generated.rpl", &text, &mut NoFiles) else { return Ok(()) };
    let mut system = System::new(library().clone(), loaded.clone(), Whim::default(), 0);
    system.machine.limits = Limits { steps: 300, frames: 60, ..Limits::default() };
    for _ in 0..dice.below(24) {
        if system.outcome().is_none() && !system.step_task() {
            system.next_instant();
        }
    }
    let saved = system.save();
    for _ in 0..forgeries {
        let bytes = forged(&saved, &mut dice);
        let forged = AssertUnwindSafe(|| -> Result<bool, SaveError> {
            let mut system = System::load(&bytes, library().clone(), loaded.clone(), Whim::default())?;
            system.machine.limits = Limits { steps: 300, frames: 60, ..Limits::default() };
            for _ in 0..40 {
                if system.outcome().is_none() && !system.step_task() {
                    system.next_instant();
                }
            }
            Ok(true)
        });
        match catch_unwind(forged) {
            Ok(Ok(_)) => tally.ran += 1,
            Ok(Err(_)) => tally.refused += 1,
            Err(panic) => return Err(format!("panic: {}", said(&*panic))),
        }
    }
    Ok(())
}

/// The bytes with a few of them changed, left out or doubled, and the checksum of that.
fn forged(saved: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut payload = saved[HEADER..].to_vec();
    for _ in 0..1 + dice.below(3) {
        let at = dice.below(payload.len());
        match dice.below(8) {
            0..=2 => payload[at] = dice.below(256) as u8,
            3 | 4 => payload[at] = payload[at].wrapping_add(1),
            5 => payload[at] = payload[dice.below(saved.len() - HEADER)],
            6 => drop(payload.remove(at)),
            _ => payload.insert(at, dice.below(256) as u8),
        }
    }
    let checksum = crc32fast::hash(&payload).to_le_bytes();
    [&saved[..HEADER - 4], &checksum, &payload].concat()
}
