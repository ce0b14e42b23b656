//! `(setf (nth 0 (value F)) V)`: a place within the value of a fluent. The value itself never changes: a copy that
//! differs there is assigned, and shares with it what lies elsewhere.

use crate::state::failure::Raise;
use crate::state::heap::{Entry, PAIR, table_entry, vector_elements};
use crate::state::machine::Machine;
use crate::state::value::Value;
use crate::step::native::{Call, Effect, Native, NativeCode, Reply};
use rpl_lang::code::Program;
use rpl_lang::kind::Kind;

pub(super) const NATIVES: &[Native] = &[Native {
    name: "%set-within",
    parameters: "fluent value &rest values",
    doc: "Assigns a fluent a copy of its value that has another value at one place. Each step towards it is an accessor and its argument, or nil.",
    effect: Effect::Acts,
    code: NativeCode::Plain(set_within),
}];

/// One step from a value to a part of it.
enum Step {
    /// The element at a position of a list.
    Element(usize),
    /// The rest of a list behind this many elements.
    Rest(usize),
    /// An element of a list or vector.
    Position(Value),
    /// An element of a vector.
    VectorPosition(Value),
    /// The value of a key in a hash table.
    Entry(Value),
    /// A slot of a record of a kind, counted behind that.
    Slot(Value, usize),
}

/// Where a value is changed.
#[derive(Clone, Copy)]
struct Place<'p> {
    program: &'p Program,
    /// What was used before anything was made for it.
    begun_bytes: usize,
}

fn set_within(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let (fluent, new) = (call.argument(0), call.argument(1));
    let Value::Fluent(index) = fluent else {
        return Err(call.machine.wrong_type("argument 1 of `value`", Kind::Fluent.noun(), fluent));
    };
    let old = call.machine.fluents[index].value;
    let program = call.around.program;
    let steps = call.arguments[2..].chunks(2).rev().map(|step| call.machine.step(program, step[0], step[1]));
    let steps: Vec<Step> = steps.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
    let place = Place { program, begun_bytes: call.machine.used_bytes() };
    let changed = call.machine.changed(place, old, &steps, new)?;
    // What was looked at was copied.
    call.burn(call.machine.used_bytes().saturating_sub(place.begun_bytes) / PAIR);
    call.machine.assign_fluent(call.around, fluent, changed)?;
    Ok(Reply::Value(new))
}

impl Machine {
    /// The steps of one accessor with its argument.
    fn step(&self, program: &Program, accessor: Value, argument: Value) -> Result<Vec<Step>, Raise> {
        let name = match accessor {
            Value::Function(setter) => {
                let slot = program.codes[setter as usize].slot.as_ref().filter(|slot| slot.assigns);
                let slot = slot.ok_or_else(|| self.wrong_type("what is assigned", "a slot of a record", accessor))?;
                return Ok(vec![Step::Slot(Value::Symbol(slot.kind), slot.place.into())]);
            }
            Value::Symbol(name) => self.symbols.name(name),
            other => return Err(self.wrong_type("what is assigned", "a slot of a record", other)),
        };
        Ok(match name {
            "nth" => vec![Step::Element(self.position(argument)?)],
            "elt" => vec![Step::Position(argument)],
            "vref" => vec![Step::VectorPosition(argument)],
            "gethash" => vec![Step::Entry(argument)],
            "first" => vec![Step::Element(0)],
            "second" => vec![Step::Element(1)],
            "third" => vec![Step::Element(2)],
            "fourth" => vec![Step::Element(3)],
            "fifth" => vec![Step::Element(4)],
            "rest" => vec![Step::Rest(1)],
            // From the last letter to the first: each `d` goes on in the list, an `a` goes into an element.
            letters => {
                let (mut steps, mut passed) = (Vec::new(), 0);
                for letter in letters.bytes().rev() {
                    match letter {
                        b'd' => passed += 1,
                        b'a' => steps.push(Step::Element(std::mem::take(&mut passed))),
                        _ => {}
                    }
                }
                steps.extend((passed > 0).then_some(Step::Rest(passed)));
                steps
            }
        })
    }

    fn position(&self, value: Value) -> Result<usize, Raise> {
        match value {
            Value::Int(position) if position >= 0 => Ok(position as usize),
            other => Err(self.wrong_type("the position", "an integer from 0 on", other)),
        }
    }

    /// A value like another but for the place that the steps lead to. Cost: what lies before that place.
    fn changed(&mut self, place: Place<'_>, of: Value, steps: &[Step], new: Value) -> Result<Value, Raise> {
        let Some((step, further)) = steps.split_first() else { return Ok(new) };
        match step {
            Step::Element(position) => self.changed_element(place, of, *position, further, new),
            Step::Slot(kind, slot) => match self.check_record(place.program, of, *kind) {
                Err(raise) => Err(raise),
                Ok(()) => self.changed_element(place, of, *slot, further, new),
            },
            Step::Position(position) if matches!(of, Value::Nil | Value::Cons(_)) => {
                self.changed_element(place, of, self.position(*position)?, further, new)
            }
            Step::Position(position) | Step::VectorPosition(position) => {
                let Some(&part) = self.heap.element(&of, position) else {
                    return Err(self.no_element("(setf vref)", of, *position));
                };
                let part = self.changed(place, part, further, new)?;
                let (Value::Vector(vector), &Value::Int(position)) = (of, position) else { return Ok(of) };
                self.ask_room(place, vector_elements(self.heap.vectors[vector].elements().len()))?;
                let mut elements = self.heap.vectors[vector].elements().to_vec();
                elements[position as usize] = part;
                Ok(self.heap.vector(elements))
            }
            Step::Entry(of_key) => {
                let Value::Table(table) = of else {
                    return Err(self.wrong_type("argument 2 of `(setf gethash)`", Kind::Table.noun(), of));
                };
                let key = self.key_of(*of_key)?;
                let part = self.heap.table_value(table, &key).unwrap_or_default();
                let part = self.changed(place, part, further, new)?;
                let bytes: usize = self.heap.tables[table].entries().iter().map(Entry::bytes).sum();
                self.ask_room(place, bytes + table_entry(&key))?;
                let copy = self.heap.thawed_table(table);
                self.heap.enter(copy, key, part);
                Ok(Value::Table(copy))
            }
            Step::Rest(passed) => {
                let (before, rest) = self.split_list(place, of, *passed)?;
                let rest = self.changed(place, rest, further, new)?;
                Ok(self.heap.list_with_tail(&before, rest))
            }
        }
    }

    /// Asks for `bytes` bytes beside what was made on the way: where there is no room, all is done again when there is.
    fn ask_room(&self, place: Place<'_>, bytes: usize) -> Result<(), Raise> {
        match self.has_room(bytes) {
            true => Ok(()),
            false => Err(Raise::NoRoom(bytes + self.used_bytes().saturating_sub(place.begun_bytes))),
        }
    }

    fn changed_element(
        &mut self,
        place: Place<'_>,
        of: Value,
        position: usize,
        further: &[Step],
        new: Value,
    ) -> Result<Value, Raise> {
        let (mut before, at) = self.split_list(place, of, position)?;
        let Value::Cons(pair) = at else { return Err(self.no_element_to_set(of, position)) };
        let (part, rest) = self.heap.pair(pair);
        before.push(self.changed(place, part, further, new)?);
        Ok(self.heap.list_with_tail(&before, rest))
    }

    /// The first `count` elements of a list, and what follows them.
    fn split_list(&self, place: Place<'_>, list: Value, count: usize) -> Result<(Vec<Value>, Value), Raise> {
        if !matches!(list, Value::Nil | Value::Cons(_)) {
            return Err(self.wrong_type("what is assigned within the value of a fluent", Kind::List.noun(), list));
        }
        let (mut before, mut at) = (Vec::new(), list);
        while before.len() < count
            && let Value::Cons(pair) = at
        {
            let (car, cdr) = self.heap.pair(pair);
            before.push(car);
            at = cdr;
        }
        if before.len() < count {
            return Err(self.no_element_to_set(list, count));
        }
        self.ask_room(place, (before.len() + 1) * PAIR)?;
        Ok((before, at))
    }
}
