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
use rpl_lang::syntax::{NodeId, NodeKind, Tree};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Units are looked through when those made since the last time take this many bytes, or as many as the others.
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
    /// By what it is found, if equal data share it.
    key: Option<Vec<u8>>,
    bytes: usize,
}

/// All units of a program. What a datum defines stays: its code is in none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Units {
    by_key: BTreeMap<Vec<u8>, u32>,
    all: Slab<Unit>,
    /// Bytes of the units that were made since they were last looked through.
    fresh_bytes: usize,
}

impl Units {
    /// The code of a datum that was compiled before, by its key ([`datum_key`]).
    pub(crate) fn find(&self, key: &[u8]) -> Option<u32> {
        self.by_key.get(key).map(|&unit| self.all[unit].main)
    }

    /// Takes in what was compiled, with its key if equal data are to share it; gives its bytes.
    pub(crate) fn add(
        &mut self,
        program: &Program,
        compiled: &Compiled,
        source: SourceId,
        key: Option<Vec<u8>>,
    ) -> usize {
        let text = &program.sources.get(source).text;
        let keys = key.as_ref().map_or(0, |key| 2 * block(key.len()));
        let bytes = bytes_of(program, compiled) + block(text.len()) + keys + UNIT;
        self.fresh_bytes += bytes;
        if compiled.defines() {
            return bytes;
        }
        let unit = self.all.insert(Unit {
            main: compiled.main,
            codes: compiled.codes.clone(),
            constants: compiled.constants.clone(),
            source,
            key: key.clone(),
            bytes,
        });
        if let Some(key) = key {
            self.by_key.insert(key, unit);
        }
        bytes
    }

    /// Whether all units of an earlier copy are still here, in their places.
    pub(crate) fn extend(&self, earlier: &Units) -> bool {
        earlier.all.iter().all(|(number, unit)| self.all.get(number) == Some(unit))
    }

    /// Whether it is time to look for units that nothing refers to, where all take `bytes` bytes.
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
            if let Some(key) = unit.key.filter(|key| self.by_key.get(key) == Some(&number)) {
                self.by_key.remove(&key);
            }
            give_back(program, machine, &unit.codes, &unit.constants, unit.source);
            machine.unit_bytes = machine.unit_bytes.saturating_sub(unit.bytes);
        }
        self.all.shrink(machine.slack());
        self.fresh_bytes = 0;
    }
}

/// What tells data apart that become different code: the nodes in their order, each with its kind. It holds for the
/// symbols of one run. None with an object in it, which is itself and equal to no other.
pub(crate) fn datum_key(tree: &Tree, root: NodeId) -> Option<Vec<u8>> {
    let mut key = Vec::new();
    let mut open = vec![root];
    while let Some(node) = open.pop() {
        let mut put = |kind: u8, value: &[u8]| {
            key.push(kind);
            key.extend_from_slice(value);
        };
        match &tree.get(node).kind {
            NodeKind::Symbol(written) | NodeKind::Qualified { written, .. } => put(b's', &written.0.to_le_bytes()),
            NodeKind::Keyword(symbol) => put(b'k', &symbol.0.to_le_bytes()),
            NodeKind::Int(value) => put(b'i', &value.to_le_bytes()),
            NodeKind::Float(value) => put(b'f', &value.to_le_bytes()),
            NodeKind::Str(text) => {
                put(b'"', &text.len().to_le_bytes());
                key.extend_from_slice(text.as_bytes());
            }
            NodeKind::List { len, dotted, .. } => {
                put(if *dotted { b'.' } else { b'(' }, &len.to_le_bytes());
                open.extend(tree.items(node).iter().rev());
            }
            NodeKind::Vector { len, .. } => {
                put(b'#', &len.to_le_bytes());
                open.extend(tree.items(node).iter().rev());
            }
            NodeKind::Object(_) | NodeKind::Hole => return None,
        }
    }
    Some(key)
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
        Constant::Compound(parts) => size_of::<Constant>() + block(std::mem::size_of_val::<[Part]>(parts)),
    });
    codes.sum::<usize>() + constants.sum::<usize>()
}
