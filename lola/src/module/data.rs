//! Percepts, poses and instructions as plans have them.

use crate::feature::{Feature, Percept, Side};
use crate::instruction::{Instruction, MOST_ORDINAL};
use crate::judgement::{Judgement, Verdict};
use rpl_robot::geometry::Pose;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;

/// A list (x y heading).
pub(super) fn pose_data(machine: &mut Machine, pose: Pose) -> Value {
    machine.heap.list(&[pose.x_m, pose.y_m, pose.heading_rad].map(Value::Float))
}

/// A list (number side kind from to).
pub(super) fn percept_data(machine: &mut Machine, percept: &Percept) -> Value {
    let [side, seen] = [percept.side.in_words(), percept.seen.name()].map(|name| symbol(machine, name));
    let number = Value::Int(i64::try_from(percept.number).unwrap_or(i64::MAX));
    machine.heap.list(&[number, side, seen, Value::Float(percept.from_m), Value::Float(percept.to_m)])
}

/// The percept of such a list.
///
/// # Errors
/// It is none.
pub(super) fn percept_of(machine: &Machine, data: Value) -> Result<Percept, Raise> {
    let understood = machine.heap.elements(data).ok().and_then(|elements| match elements[..] {
        [Value::Int(number), Value::Symbol(side), Value::Symbol(seen), from, to] => Some(Percept {
            number: u64::try_from(number).ok()?,
            side: side_named(machine.symbols.name(side))?,
            seen: Feature::ALL.into_iter().find(|feature| feature.name() == machine.symbols.name(seen))?,
            from_m: from.as_f64()?,
            to_m: to.as_f64()?,
            depth_m: f64::INFINITY,
            marked: false,
        }),
        _ => None,
    });
    understood.ok_or_else(|| {
        Raise::type_error(format!("{} is no percept; it is a list (number side kind from to)", machine.described(data)))
    })
}

/// A list that says the instruction.
pub(super) fn instruction_data(machine: &mut Machine, instruction: Instruction) -> Value {
    let elements = match instruction {
        Instruction::Leave(side) => vec![symbol(machine, "leave"), symbol(machine, side.in_words())],
        Instruction::Turn { ordinal, side } => {
            vec![symbol(machine, "turn"), Value::Int(ordinal.into()), symbol(machine, side.in_words())]
        }
        Instruction::Enter { ordinal, side } => {
            vec![symbol(machine, "enter"), Value::Int(ordinal.into()), symbol(machine, side.in_words())]
        }
        Instruction::GoPastFoyer => vec![symbol(machine, "past"), symbol(machine, "foyer")],
        Instruction::GoHallwayEnd => vec![symbol(machine, "hallway-end")],
    };
    machine.heap.list(&elements)
}

fn symbol(machine: &mut Machine, name: &str) -> Value {
    Value::Symbol(machine.symbols.intern(name))
}

/// A word of an instruction.
#[derive(Debug)]
enum Word<'m> {
    Name(&'m str),
    Ordinal(u8),
}

/// The instruction that a list says.
///
/// # Errors
/// It says none.
pub(super) fn instruction_of(machine: &Machine, data: Value) -> Result<Instruction, Raise> {
    let understood = words(machine, data).and_then(|words| match words[..] {
        [Word::Name("leave"), Word::Name(side)] => Some(Instruction::Leave(side_named(side)?)),
        [Word::Name("turn"), Word::Ordinal(ordinal), Word::Name(side)] => {
            Some(Instruction::Turn { ordinal, side: side_named(side)? })
        }
        [Word::Name("enter"), Word::Ordinal(ordinal), Word::Name(side)] => {
            Some(Instruction::Enter { ordinal, side: side_named(side)? })
        }
        [Word::Name("past"), Word::Name("foyer")] => Some(Instruction::GoPastFoyer),
        [Word::Name("hallway-end")] => Some(Instruction::GoHallwayEnd),
        _ => None,
    });
    understood.ok_or_else(|| {
        Raise::type_error(format!(
            "{} is no instruction; there are (leave SIDE), (turn N SIDE), (enter N SIDE), (past foyer) and \
             (hallway-end), where a SIDE is left or right and N is from 1 to {MOST_ORDINAL}",
            machine.described(data)
        ))
    })
}

fn words(machine: &Machine, data: Value) -> Option<Vec<Word<'_>>> {
    let word = |value: Value| match value {
        Value::Symbol(symbol) => Some(Word::Name(machine.symbols.name(symbol))),
        Value::Int(ordinal) => u8::try_from(ordinal).ok().filter(|n| (1..=MOST_ORDINAL).contains(n)).map(Word::Ordinal),
        _ => None,
    };
    machine.heap.elements(data).ok()?.into_iter().map(word).collect()
}

/// The side of a name.
pub(super) fn side_named(name: &str) -> Option<Side> {
    Side::ALL.into_iter().find(|side| side.in_words() == name)
}

/// A list (verdict sentence probability kind opening meant).
pub(super) fn judgement_data(machine: &mut Machine, judgement: &Judgement, opening: Option<Percept>) -> Value {
    let verdict = match judgement.verdict() {
        Verdict::Right => "right",
        Verdict::Wrong(_) => "wrong",
        Verdict::LookAgain => "look-again",
    };
    let elements = [
        symbol(machine, verdict),
        machine.heap.string(&judgement.sentence),
        Value::Float(judgement.wrong()),
        symbol(machine, judgement.likeliest_fault().name()),
        opening.map_or(Value::Nil, |percept| percept_data(machine, &percept)),
        judgement.likeliest_reading().map_or(Value::Nil, |meant| instruction_data(machine, meant.goal.instruction())),
    ];
    machine.heap.list(&elements)
}

/// The words of a message, or a text, as one text.
pub(super) fn said(machine: &Machine, given: Value) -> Option<String> {
    match given {
        Value::Str(index) => Some(machine.heap.strings[index].to_string()),
        given => {
            let word = |value: Value| match value {
                Value::Symbol(symbol) => Some(machine.symbols.name(symbol).to_string()),
                Value::Str(index) => Some(machine.heap.strings[index].to_string()),
                _ => None,
            };
            let words: Option<Vec<String>> = machine.heap.elements(given).ok()?.into_iter().map(word).collect();
            Some(words?.join(" ")).filter(|text| !text.is_empty())
        }
    }
}
