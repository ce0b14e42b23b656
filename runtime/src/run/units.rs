//! Units: code made at run time by `execute-plan`. Equal data share a unit, and one that nothing
//! refers to any more gives its places in the program back.

use crate::state::block::block;
use crate::state::machine::Machine;
use crate::state::slab::Slab;
use crate::state::value::Value;
use crate::step::memory::gc::CodeMarks;
use rpl_lang::code::{Constant, Part, Program};
use rpl_lang::compile::Compiled;
use rpl_lang::source::SourceId;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Units are looked through when those made since the last time take so much, or as much as the
/// others.
const MIN_FRESH_BYTES: usize = 1 << 20;

/// Bytes of a unit beside its code and text: its tables, the name of its text, its places in maps.
const UNIT: usize = 400;

/// The code of one datum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Unit {
    /// The code that runs the datum.
    main: u32,
    /// All its codes.
    codes: Vec<u32>,
    /// Its constants.
    constants: Vec<u32>,
    /// The printed datum.
    source: SourceId,
    bytes: usize,
}

/// All units of a program. What a datum defines stays: its code is in none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Units {
    by_text: BTreeMap<String, u32>,
    all: Slab<Unit>,
    /// Bytes of the units that were made since they were last looked through.
    fresh_bytes: usize,
}

impl Units {
    /// The code of a datum that was compiled before.
    pub(crate) fn find(&self, text: &str) -> Option<u32> {
        self.by_text.get(text).map(|&unit| self.all[unit].main)
    }

    /// Takes in what was compiled; gives its bytes.
    pub(crate) fn add(&mut self, program: &Program, compiled: &Compiled, source: SourceId, is_shared: bool) -> usize {
        let text = &program.sources.get(source).text;
        let bytes = bytes_of(program, compiled) + 2 * block(text.len()) + UNIT;
        self.fresh_bytes += bytes;
        if compiled.defines() {
            return bytes;
        }
        let unit = self.all.insert(Unit {
            main: compiled.main,
            codes: compiled.codes.clone(),
            constants: compiled.constants.clone(),
            source,
            bytes,
        });
        if is_shared {
            self.by_text.insert(text.to_string(), unit);
        }
        bytes
    }

    /// Whether all units of an earlier copy are still here, in their places.
    pub(crate) fn extend(&self, earlier: &Units) -> bool {
        earlier.all.iter().all(|(number, unit)| self.all.get(number) == Some(unit))
    }

    /// Whether it is time to look for units that nothing refers to, where all take so many bytes.
    pub(crate) fn are_due(&self, bytes: usize) -> bool {
        self.fresh_bytes > MIN_FRESH_BYTES.max(bytes.saturating_sub(self.fresh_bytes))
    }

    /// Gives the places of units back that are not marked.
    pub(crate) fn sweep(&mut self, program: &mut Program, machine: &mut Machine, marks: &CodeMarks) {
        let is_dead = |unit: &Unit| {
            !unit.codes.iter().any(|&code| marks.codes.is_set(code)) && !marks.sources.is_set(unit.source.0)
        };
        let dead: Vec<u32> = self.all.iter().filter(|(_, unit)| is_dead(unit)).map(|(number, _)| number).collect();
        for number in dead {
            let Some(unit) = self.all.remove(number) else { continue };
            let text = program.sources.get(unit.source).text.clone();
            if self.by_text.get(&*text) == Some(&number) {
                self.by_text.remove(&*text);
            }
            give_back(program, machine, &unit.codes, &unit.constants, unit.source);
            machine.unit_bytes = machine.unit_bytes.saturating_sub(unit.bytes);
        }
        self.all.shrink(machine.slack());
        self.fresh_bytes = 0;
    }
}

/// Frees the places of code that nothing refers to.
pub(crate) fn give_back(
    program: &mut Program,
    machine: &mut Machine,
    codes: &[u32],
    constants: &[u32],
    source: SourceId,
) {
    codes.iter().for_each(|&code| program.free_code(code));
    for &constant in constants {
        program.free_constant(constant);
        if let Some(value) = machine.constants.get_mut(constant as usize) {
            *value = Value::Nil;
        }
    }
    program.sources.free(source);
}

fn bytes_of(program: &Program, compiled: &Compiled) -> usize {
    let codes = compiled.codes.iter().map(|&code| program.codes[code as usize].bytes());
    let constants = compiled.constants.iter().map(|&constant| match &program.constants[constant as usize] {
        Constant::Atom(_) => size_of::<Constant>(),
        Constant::List(parts) => size_of::<Constant>() + block(std::mem::size_of_val::<[Part]>(parts)),
    });
    codes.sum::<usize>() + constants.sum::<usize>()
}
