//! The loop over instructions: arithmetic, data, jumps and calls. What is about plans is one line here.

use crate::state::failure::Raise;
use crate::state::machine::{Machine, SCRATCH_TASK};
use crate::state::quotient::{quotient, remainder};
use crate::state::scratch::Cursor;
use crate::state::task::Frame;
use crate::state::value::{Value, assign};
use crate::step::exec::about_tables::{assign_entry, read_entry};
use crate::step::exec::arithmetic::{arithmetic, compare, compare_int, overflow};
use crate::step::exec::calls::{clear_registers, place_captured};
use crate::step::exec::plan_instructions::{in_network, signal_plainly};
use crate::step::exec::{Exit, Proceed, REACH};
use crate::step::fluents::read;
use crate::step::native::{Reply, Surroundings};
use rpl_lang::code::{Code, CodeKind, NO_REG, Op, Program, SlotAccess};
use rpl_lang::kind::Kind;

/// What the function in a global does with a slot, if it does nothing else; it takes as many arguments as it needs for that.
#[inline(always)]
fn slot_of<'p>(program: &'p Program, global: &Value) -> Option<&'p SlotAccess> {
    let &Value::Function(number) = global else { return None };
    program.codes[number as usize].slot.as_ref()
}

impl Machine {
    /// The loop. Comes back with an exit, or with a failure to raise at `place`.
    #[allow(
        clippy::too_many_lines,
        reason = "one arm an instruction; the loop must be one function to keep its state in registers"
    )]
    pub(crate) fn instructions<const STEPPING: bool>(
        &mut self,
        around: &mut Surroundings<'_>,
        place: &mut Cursor,
        entry: usize,
    ) -> Result<Exit, Raise> {
        let program = around.program;
        let mut code: &Code = &program.codes[place.frame.code as usize];
        let mut code_number = place.frame.code;
        // What comes next in it.
        let mut rest = code.ops[place.frame.pc as usize..].iter();
        let mut base = place.frame.base as usize;
        let mut fuel = place.fuel;
        let few_frames = self.limits.frames_anywhere();

        macro_rules! frame {
            () => {
                Frame { code: code_number, pc: (code.ops.len() - rest.len()) as u32, base: base as u32 }
            };
        }
        macro_rules! save {
            () => {
                place.frame = frame!();
                place.fuel = fuel;
                self.scratch.top = base + usize::from(code.registers);
            };
        }
        // Goes to the first instruction of a code, or to the next one of a frame.
        macro_rules! begin {
            ($code:expr, $number:expr, $base:expr) => {
                (code, code_number, base) = ($code, $number, $base);
                rest = code.ops.iter();
            };
        }
        macro_rules! resume {
            ($frame:expr) => {
                let frame = $frame;
                (code, code_number, base) = (&program.codes[frame.code as usize], frame.code, frame.base as usize);
                rest = code.ops[frame.pc as usize..].iter();
            };
        }
        // After an instruction that may have made a more important task ready, ended or suspended
        // this one.
        macro_rules! check_switch {
            () => {{
                if !self.scratch.status_changed.is_empty() {
                    save!();
                    self.flush_status(around);
                }
                if self.scratch.switch {
                    self.scratch.switch = false;
                    if self.current != SCRATCH_TASK && self.must_switch() {
                        save!();
                        return Ok(Exit::Switched);
                    }
                }
            }};
        }
        macro_rules! check_leaving {
            () => {
                if self.tasks[self.current].is_leaving() {
                    save!();
                    return Ok(Exit::Blocked);
                }
            };
        }
        // What a native or a network has burned, taken from the slice and then from what is behind it.
        macro_rules! spend {
            () => {
                spend!(std::mem::take(&mut self.scratch.burned))
            };
            ($steps:expr) => {{
                let steps = $steps;
                if steps > 0 {
                    place.reserve = place.reserve.saturating_sub(steps.saturating_sub(fuel));
                    fuel = fuel.saturating_sub(steps);
                }
            }};
        }
        // The registers within reach of the frame. They have numbers of 32 bits, in every frame: what is added to one does
        // not overflow.
        macro_rules! window {
            () => {{
                let start = base as u32 as usize;
                self.scratch.stack.get_mut(start..start + REACH).and_then(|above| above.first_chunk_mut::<REACH>())
            }};
        }
        macro_rules! fetch {
            () => {
                match rest.next() {
                    Some(op) => op,
                    None => unreachable!("code ends with an instruction that leaves it"),
                }
            };
        }
        'frame: loop {
            if STEPPING {
                save!();
                if self.stops_before(program, &rest.as_slice()[0], place.frame) {
                    return Ok(Exit::Paused);
                }
            }
            let Some(mut r) = window!() else {
                self.grow_stack(base);
                continue 'frame;
            };
            // What the loop below hands over, or cannot do, leaves it here: how to go on is decided in one place.
            let mut op = fetch!();
            let next = 'handed: loop {
                // Goes on with the next instruction.
                macro_rules! next {
                    () => {{
                        if STEPPING {
                            continue 'frame;
                        }
                        op = fetch!();
                        continue;
                    }};
                }
                // Goes on in another frame.
                macro_rules! enter {
                    () => {{
                        let Some(registers) = window!() else { continue 'frame };
                        r = registers;
                        next!();
                    }};
                }
                // The failure is made last, when nothing of the loop's state is needed any more.
                macro_rules! fail {
                    ($raise:expr) => {{
                        save!();
                        break 'handed Err($raise);
                    }};
                }
                macro_rules! attempt {
                    ($result:expr) => {
                        match $result {
                            Ok(value) => value,
                            Err(raise) => fail!(raise),
                        }
                    };
                }
                // What is not done here is handed over to a function, which says how to go on.
                macro_rules! hand_over {
                    ($instruction:expr) => {{
                        save!();
                        break 'handed $instruction;
                    }};
                }
                // Before anything of the instruction is done.
                macro_rules! burn {
                    () => {
                        match fuel.checked_sub(1) {
                            Some(less) => fuel = less,
                            None => hand_over!(self.spent::<STEPPING>(around, place)),
                        }
                    };
                }
                macro_rules! r {
                    ($register:expr) => {
                        r[$register as usize]
                    };
                }
                // Registers of a frame that starts at `$first`, save `$count` arguments.
                macro_rules! clear {
                    ($callee:expr, $first:expr, $count:expr) => {
                        clear_registers(r, $first + $count, $first + usize::from($callee.registers))
                    };
                }
                macro_rules! collect_in_frame {
                    () => {
                        if self.heap.is_full() {
                            attempt!(self.collect_here(base + usize::from(code.registers)));
                            continue 'frame;
                        }
                    };
                }
                macro_rules! jump {
                    ($distance:expr) => {
                        if $distance < 0 {
                            back!($distance);
                        } else {
                            skip!($distance);
                        }
                    };
                }
                macro_rules! skip {
                    ($distance:expr) => {
                        rest = rest.as_slice()[$distance as usize..].iter()
                    };
                }
                macro_rules! back {
                    ($distance:expr) => {{
                        burn!();
                        rest = code.ops[(code.ops.len() - rest.len()).wrapping_add_signed($distance as isize)..].iter();
                    }};
                }
                // One of the three above, where the condition holds.
                macro_rules! when {
                    ($condition:expr, $jump:ident, $distance:expr) => {{
                        if $condition {
                            $jump!($distance);
                        }
                        next!();
                    }};
                }
                // With nothing left to burn the test behind it is for the slice to come.
                macro_rules! count {
                    ($counter:expr, $count:expr, $end:expr, $distance:expr) => {{
                        let Some(count) = $count.checked_add(1) else { hand_over!(self.count_other(place, $counter)) };
                        r!($counter) = Value::Int(count);
                        if count < $end && fuel > 0 {
                            back!($distance);
                        }
                        next!();
                    }};
                }
                // With other operands, and where an integer is too large, the two instructions behind it do the work.
                macro_rules! with_product {
                    ($to:expr, $other:expr, $x:expr, $y:expr, $checked:ident, $operator:tt) => {{
                        match (&r!($other), &r!($x), &r!($y)) {
                            (&Value::Float(other), &Value::Float(x), &Value::Float(y)) => {
                                r!($to) = Value::Float(other $operator x * y);
                                skip!(2);
                                next!();
                            }
                            (&Value::Int(other), &Value::Int(x), &Value::Int(y)) => {
                                if let Some(product) = x.checked_mul(y)
                                    && let Some(value) = other.$checked(product)
                                {
                                    r!($to) = Value::Int(value);
                                    skip!(2);
                                }
                                next!();
                            }
                            _ => next!(),
                        }
                    }};
                }
                // Leaves the frame with a value, if there is one and a frame to go back to; if not, the two instructions
                // behind this one do so.
                macro_rules! return_at_once {
                    ($value:expr) => {{
                        if !STEPPING
                            && self.scratch.frames.len() > entry
                            && let Some(value) = $value
                            && let Some(frame) = self.scratch.frames.pop()
                        {
                            r!(0) = value;
                            resume!(frame);
                            enter!();
                        }
                        next!();
                    }};
                }
                macro_rules! return_result {
                    ($x:expr, $y:expr, $checked:ident, $operator:tt) => {
                        match (&r!($x), &r!($y)) {
                            (&Value::Int(x), &Value::Int(y)) => return_at_once!(x.$checked(y).map(Value::Int)),
                            (&Value::Float(x), &Value::Float(y)) => return_at_once!(Some(Value::Float(x $operator y))),
                            _ => next!(),
                        }
                    };
                }
                macro_rules! return_order {
                    ($x:expr, $y:expr, $operator:tt) => {
                        match (&r!($x), &r!($y)) {
                            (Value::Int(x), Value::Int(y)) => return_at_once!(Some(Value::truth(x $operator y))),
                            (Value::Float(x), Value::Float(y)) => return_at_once!(Some(Value::truth(x $operator y))),
                            _ => next!(),
                        }
                    };
                }
                // Enters a function with what it has captured, if nothing stands against it.
                macro_rules! enter_value {
                    ($first:expr, $count:expr, $number:expr, $captured:expr, $is_tail:literal) => {{
                        let (number, captured) = ($number, $captured);
                        let callee = &*program.codes[number as usize];
                        if callee.exact_count == u16::from($count) && self.scratch.frames.len() < few_frames {
                            let (first, count) = (usize::from($first), usize::from($count));
                            let start = if $is_tail && callee.kind != CodeKind::Plan {
                                r.copy_within(first..first + count, 0);
                                0
                            } else {
                                self.scratch.frames.push(frame!());
                                first
                            };
                            place_captured(r, start + count, captured);
                            clear!(callee, start, count + captured.len());
                            begin!(callee, number, base + start);
                            enter!();
                        }
                    }};
                }
                macro_rules! call_value {
                    ($first:expr, $callee:expr, $count:expr, $is_tail:literal) => {{
                        burn!();
                        let function = &r!($callee);
                        match *function {
                            Value::Function(number) => enter_value!($first, $count, number, &[][..], $is_tail),
                            Value::Closure(index) => {
                                let closure = &self.heap.closures[index];
                                enter_value!($first, $count, closure.code, &*closure.captured, $is_tail);
                            }
                            _ => {}
                        }
                        let function = *function;
                        hand_over!(self.call_any(around, place, function, $first, $count, $is_tail))
                    }};
                }
                match *op {
                    Op::Nil(a) => {
                        r!(a) = Value::Nil;
                        next!();
                    }
                    Op::True(a) => {
                        r!(a) = Value::True;
                        next!();
                    }
                    Op::Int(a, value) => {
                        r!(a) = Value::Int(i64::from(value));
                        next!();
                    }
                    Op::Const(a, constant) => {
                        r!(a) = self.constants[constant as usize];
                        next!();
                    }
                    Op::Global(a, global) => {
                        // By reference: a value taken apart and put together again is slow to read.
                        let value = &self.globals[global as usize];
                        if matches!(value, Value::Unbound) {
                            fail!(self.describe_global(around, global));
                        }
                        r!(a) = *value;
                        next!();
                    }
                    Op::SetGlobal(a, global) => {
                        let value = r!(a);
                        attempt!(self.refuse_in_network("a variable cannot be assigned"));
                        self.globals[global as usize] = value;
                        continue 'frame;
                    }
                    Op::Move(a, b) => {
                        assign!(r!(a), r!(b));
                        next!();
                    }
                    Op::CellNew(a, b) => {
                        r!(a) = self.heap.cell(r!(b).copied());
                        collect_in_frame!();
                    }
                    Op::CellGet(a, b) => {
                        if let Value::Cell(cell) = r!(b) {
                            assign!(r!(a), self.heap.cells[cell]);
                        }
                        next!();
                    }
                    Op::CellSet(a, b) => {
                        if let Value::Cell(cell) = r!(a) {
                            self.heap.cells[cell].set(&r!(b));
                        }
                        next!();
                    }
                    Op::Add(a, b, c) => arithmetic!(self, r!(a), r!(b), r!(c), "+", checked_add, +),
                    Op::Sub(a, b, c) => arithmetic!(self, r!(a), r!(b), r!(c), "-", checked_sub, -),
                    Op::Mul(a, b, c) => arithmetic!(self, r!(a), r!(b), r!(c), "*", checked_mul, *),
                    Op::AddProduct(a, b, c, d) => with_product!(a, b, c, d, checked_add, +),
                    Op::SubProduct(a, b, c, d) => with_product!(a, b, c, d, checked_sub, -),
                    Op::ReturnAdd(x, y) => return_result!(x, y, checked_add, +),
                    Op::ReturnSub(x, y) => return_result!(x, y, checked_sub, -),
                    Op::ReturnMul(x, y) => return_result!(x, y, checked_mul, *),
                    Op::ReturnAddInt(x, value) => match &r!(x) {
                        Value::Int(x) => return_at_once!(x.checked_add(i64::from(value)).map(Value::Int)),
                        _ => next!(),
                    },
                    Op::ReturnLess(x, y) => return_order!(x, y, <),
                    Op::ReturnLessEq(x, y) => return_order!(x, y, <=),
                    Op::ReturnNumEq(x, y) => return_order!(x, y, ==),
                    Op::Div(a, b, c) => match (&r!(b), &r!(c)) {
                        (&Value::Float(x), &Value::Float(y)) if y != 0.0 => {
                            r!(a) = Value::Float(x / y);
                            next!();
                        }
                        (&left, &right) => match attempt!(quotient(left, right)) {
                            Some(value) => r!(a) = value,
                            None => fail!(self.wrong_operands("`/`", left, right)),
                        },
                    },
                    Op::AddInt(a, b, value) => match r!(b) {
                        Value::Int(x) => match x.checked_add(i64::from(value)) {
                            Some(sum) => {
                                r!(a) = Value::Int(sum);
                                next!();
                            }
                            None => fail!(overflow("+")),
                        },
                        Value::Float(x) => r!(a) = Value::Float(x + f64::from(value)),
                        other => fail!(self.wrong_operands("`+`", other, other)),
                    },
                    Op::Count(a, end, to) => match (&r!(a), &r!(end)) {
                        (&Value::Int(count), &Value::Int(end)) => count!(a, count, end, to),
                        _ => hand_over!(self.count_other(place, a)),
                    },
                    Op::CountInt(a, end, to) => match r!(a) {
                        Value::Int(count) => count!(a, count, i64::from(end), to),
                        _ => hand_over!(self.count_other(place, a)),
                    },
                    Op::Less(a, b, c) => {
                        r!(a) = Value::truth(compare!(self, r!(b), r!(c), "a comparison", <));
                        next!();
                    }
                    Op::LessEq(a, b, c) => {
                        r!(a) = Value::truth(compare!(self, r!(b), r!(c), "a comparison", <=));
                        next!();
                    }
                    Op::NumEq(a, b, c) => {
                        r!(a) = Value::truth(compare!(self, r!(b), r!(c), "`=`", ==));
                        next!();
                    }
                    Op::NumDiffer(a, b, c) => {
                        r!(a) = Value::truth(compare!(self, r!(b), r!(c), "`/=`", !=));
                        next!();
                    }
                    Op::Eq(a, b, c) => {
                        r!(a) = Value::truth(r!(b).is_eq(&r!(c)));
                        next!();
                    }
                    Op::Mod(a, b, c) => match (&r!(b), &r!(c)) {
                        (&Value::Int(x), &Value::Int(y)) if y > 0 => r!(a) = Value::Int(x.rem_euclid(y)),
                        (&left, &right) => match attempt!(remainder(left, right, true)) {
                            Some(value) => r!(a) = value,
                            None => fail!(self.wrong_argument("mod", left, right)),
                        },
                    },
                    Op::Not(a, b) => {
                        r!(a) = Value::truth(matches!(r!(b), Value::Nil));
                        next!();
                    }
                    Op::Cons(a, b, c) => {
                        r!(a) = self.heap.cons(r!(b).copied(), r!(c).copied());
                        collect_in_frame!();
                        next!();
                    }
                    Op::Car(a, b) => match &r!(b) {
                        &Value::Cons(pair) => {
                            r!(a) = *self.heap.pairs.car(pair);
                            next!();
                        }
                        Value::Nil => r!(a) = Value::Nil,
                        &other => fail!(self.wrong_type("the argument of `car`", Kind::List.noun(), other)),
                    },
                    Op::Cdr(a, b) => match &r!(b) {
                        &Value::Cons(pair) => {
                            r!(a) = self.heap.pairs.cdr(pair);
                            next!();
                        }
                        Value::Nil => r!(a) = Value::Nil,
                        &other => fail!(self.wrong_type("the argument of `cdr`", Kind::List.noun(), other)),
                    },
                    Op::Slot(a, b, slot, kind) => {
                        let kind = &self.constants[kind as usize];
                        match self.heap.slot(&r!(b), kind, slot.into()) {
                            Some(pair) => assign!(r!(a), *self.heap.pairs.car(pair)),
                            None => hand_over!(self.plan_instruction(around, place, *op)),
                        }
                    }
                    Op::SetSlot(..) if self.current == SCRATCH_TASK => {
                        fail!(in_network("a slot cannot be assigned"))
                    }
                    Op::SetSlot(a, b, slot, kind) => {
                        let kind = &self.constants[kind as usize];
                        match self.heap.slot(&r!(a), kind, slot.into()) {
                            Some(pair) if !self.heap.pairs.is_frozen(pair) => {
                                self.heap.pairs.car_mut(pair).set(&r!(b));
                            }
                            _ => hand_over!(self.plan_instruction(around, place, *op)),
                        }
                    }
                    Op::VectorRef(a, vector, position) => match self.heap.element(&r!(vector), &r!(position)) {
                        Some(element) => {
                            r!(a) = *element;
                            next!();
                        }
                        None => {
                            let (vector, position) = (r!(vector), r!(position));
                            fail!(self.no_element("vref", vector, position))
                        }
                    },
                    Op::SetVectorRef(..) | Op::SetTableRef(..) if self.current == SCRATCH_TASK => {
                        fail!(in_network("an element or entry cannot be assigned"))
                    }
                    Op::SetVectorRef(vector, position, value) => {
                        match self.heap.element_mut(&r!(vector), &r!(position)) {
                            Some(element) => {
                                assign!(*element, r!(value));
                                next!();
                            }
                            None => {
                                let (vector, position) = (r!(vector), r!(position));
                                fail!(self.no_element("(setf vref)", vector, position))
                            }
                        }
                    }
                    Op::TableRef(a, key, of, default) => match read_entry(&mut self.heap, r, [a, key, of, default]) {
                        Some(steps) => spend!(steps),
                        None => hand_over!(self.plan_instruction(around, place, *op)),
                    },
                    Op::SetTableRef(key, table, value) => match assign_entry(&mut self.heap, r, [key, table, value]) {
                        Some(steps) => {
                            spend!(steps);
                            collect_in_frame!();
                        }
                        None => hand_over!(self.plan_instruction(around, place, *op)),
                    },
                    Op::Extend(a, end, value) => {
                        r!(a) = Value::Cons(self.heap.extend(&r!(end), &r!(value)));
                        collect_in_frame!();
                        next!();
                    }
                    Op::NextElement(at, to, distance) => match r!(at) {
                        Value::Cons(pair) => {
                            jump!(distance);
                            assign!(r!(to), *self.heap.pairs.car(pair));
                            match self.heap.pairs.next(pair) {
                                Some(next) => r!(at) = Value::Cons(next),
                                None => r!(at) = self.heap.pairs.cdr(pair),
                            }
                            next!();
                        }
                        Value::Nil => {}
                        other => fail!(self.wrong_type("the argument of `car`", Kind::List.noun(), other)),
                    },
                    Op::MergeStep(state, ask) => {
                        back!(ask);
                        if !self.heap.merge_on(&mut r[usize::from(state)..]) {
                            hand_over!(self.merge_step(place, state, ask))
                        }
                    }
                    Op::Jump(distance) => jump!(distance),
                    Op::JumpIfNil(a, distance) => when!(matches!(r!(a), Value::Nil), jump, distance),
                    Op::JumpIfTrue(a, distance) => when!(!matches!(r!(a), Value::Nil), jump, distance),
                    Op::JumpIfGiven(a, distance) => when!(!matches!(r!(a), Value::Unbound), skip, distance),
                    Op::JumpUnlessLess(a, b, to) => when!(!compare!(self, r!(a), r!(b), "a comparison", <), skip, to),
                    Op::JumpUnlessLessEq(a, b, to) => {
                        when!(!compare!(self, r!(a), r!(b), "a comparison", <=), skip, to)
                    }
                    Op::JumpUnlessNumEq(a, b, to) => when!(!compare!(self, r!(a), r!(b), "`=`", ==), skip, to),
                    Op::JumpUnlessNumDiffer(a, b, to) => when!(!compare!(self, r!(a), r!(b), "`/=`", !=), skip, to),
                    Op::JumpUnlessEq(a, b, to) => when!(!r!(a).is_eq(&r!(b)), skip, to),
                    Op::JumpUnlessLessInt(a, n, to) => {
                        when!(!compare_int!(self, r!(a), n, "a comparison", <), skip, to)
                    }
                    Op::JumpUnlessLessEqInt(a, n, to) => {
                        when!(!compare_int!(self, r!(a), n, "a comparison", <=), skip, to)
                    }
                    Op::JumpUnlessGreaterInt(a, n, to) => {
                        when!(!compare_int!(self, r!(a), n, "a comparison", >), skip, to)
                    }
                    Op::JumpUnlessGreaterEqInt(a, n, to) => {
                        when!(!compare_int!(self, r!(a), n, "a comparison", >=), skip, to)
                    }
                    Op::JumpUnlessNumEqInt(a, n, to) => when!(!compare_int!(self, r!(a), n, "`=`", ==), skip, to),
                    Op::JumpUnlessNumDifferInt(a, n, to) => when!(!compare_int!(self, r!(a), n, "`/=`", !=), skip, to),
                    Op::JumpIfLess(a, b, to) => when!(compare!(self, r!(a), r!(b), "a comparison", <), back, to),
                    Op::JumpIfLessEq(a, b, to) => when!(compare!(self, r!(a), r!(b), "a comparison", <=), back, to),
                    Op::JumpIfLessInt(a, n, to) => when!(compare_int!(self, r!(a), n, "a comparison", <), back, to),
                    Op::JumpIfLessEqInt(a, n, to) => when!(compare_int!(self, r!(a), n, "a comparison", <=), back, to),
                    Op::JumpIfGreaterInt(a, n, to) => when!(compare_int!(self, r!(a), n, "a comparison", >), back, to),
                    Op::JumpIfGreaterEqInt(a, n, to) => {
                        when!(compare_int!(self, r!(a), n, "a comparison", >=), back, to)
                    }
                    Op::Call(first, count, global) => {
                        burn!();
                        if let Value::Function(number) = self.globals[global as usize]
                            && let callee = &*program.codes[number as usize]
                        {
                            let from = usize::from(first);
                            if callee.framed_count == u16::from(count) && self.scratch.frames.len() < few_frames {
                                clear!(callee, from, usize::from(count));
                                self.scratch.frames.push(frame!());
                                begin!(callee, number, base + from);
                                enter!();
                            }
                            if !STEPPING
                                && let Some(slot) = &callee.slot
                                && callee.exact_count == u16::from(count)
                                && !(slot.assigns && self.current == SCRATCH_TASK)
                                && self.heap.access_slot(slot, &mut r[from..])
                            {
                                next!();
                            }
                        }
                        hand_over!(self.call_global(around, place, global, first, count, false))
                    }
                    Op::CallSlot(first, own, global) => {
                        burn!();
                        if !STEPPING
                            && let Some(slot) = slot_of(program, &self.globals[global as usize])
                            && !slot.assigns
                            && let Some(pair) = self.heap.slot_in_row(&r!(own), slot)
                        {
                            assign!(r!(first), *self.heap.pairs.car(pair));
                            next!();
                        }
                        assign!(r!(first), r!(own));
                        hand_over!(self.call_global(around, place, global, first, 1, false))
                    }
                    Op::CallSetSlot(first, own, global) => {
                        burn!();
                        if !STEPPING
                            && let Some(slot) = slot_of(program, &self.globals[global as usize])
                            && slot.assigns
                            && self.current != SCRATCH_TASK
                            && let Some(pair) = self.heap.slot_in_row(&r!(own), slot)
                            && !self.heap.pairs.is_frozen(pair)
                        {
                            let (at, value) = (usize::from(first), usize::from(first) + 1);
                            assign!(*self.heap.pairs.car_mut(pair), r[value]);
                            assign!(r[at], r[value]);
                            next!();
                        }
                        assign!(r!(first), r!(own));
                        hand_over!(self.call_global(around, place, global, first, 2, false))
                    }
                    Op::TailCall(first, count, global) => {
                        burn!();
                        if let Value::Function(number) = self.globals[global as usize]
                            && let callee = &*program.codes[number as usize]
                            && callee.exact_count == u16::from(count)
                            && callee.kind != CodeKind::Plan
                        {
                            let (first, count) = (usize::from(first), usize::from(count));
                            r.copy_within(first..first + count, 0);
                            clear!(callee, 0, count);
                            begin!(callee, number, base);
                            next!();
                        }
                        hand_over!(self.call_global(around, place, global, first, count, true))
                    }
                    Op::CallValue(first, callee, count) => call_value!(first, callee, count, false),
                    Op::TailCallValue(first, callee, count) => call_value!(first, callee, count, true),
                    Op::CallCode(first, number) => {
                        burn!();
                        self.scratch.frames.push(frame!());
                        begin!(&program.codes[number as usize], number, base + usize::from(first));
                        self.clear_frame(code, base);
                        continue 'frame;
                    }
                    Op::CallNative(to, first, count, native) => {
                        save!();
                        let reply = self.call_native_at(around, native, base + usize::from(first), count);
                        spend!();
                        let Ok(Reply::Value(value)) = reply else {
                            hand_over!(self.take_reply(around, place, to, first, count, native, reply))
                        };
                        self.scratch.stack[base + usize::from(to)] = value;
                        if self.heap.is_full() {
                            attempt!(self.collect_here(base + usize::from(code.registers)));
                        }
                        if self.scratch.switch || around.natives[usize::from(native)].effect.acts() {
                            check_leaving!();
                            check_switch!();
                        }
                        continue 'frame;
                    }
                    Op::Closure(a, number) => {
                        let inner = &program.codes[number as usize];
                        r!(a) = if inner.captures.is_empty() {
                            Value::Function(number)
                        } else {
                            let captured = inner.captures.iter().map(|&register| r!(register).copied()).collect();
                            self.heap.closure(number, captured).copied()
                        };
                        collect_in_frame!();
                    }
                    Op::Return(a) => {
                        if self.scratch.frames.len() > entry
                            && let Some(frame) = self.scratch.frames.pop()
                        {
                            assign!(r!(0), r!(a));
                            resume!(frame);
                            enter!();
                        }
                        let value = r!(a);
                        save!();
                        if self.current != SCRATCH_TASK
                            && !self.tasks[self.current].scopes.is_empty()
                            && self.end_spawned(around, place)
                        {
                            return Ok(Exit::Blocked);
                        }
                        return Ok(Exit::Returned(value));
                    }
                    Op::WaitFor(a, condition, seconds, owned) => {
                        let condition = std::mem::take(&mut r!(condition));
                        let seconds = if seconds == NO_REG { None } else { Some(std::mem::take(&mut r!(seconds))) };
                        hand_over!(self.wait_for(place, a, condition, seconds, owned))
                    }
                    Op::Deref(a, b) => match r!(b) {
                        Value::Fluent(fluent) => match read(&self.fluents, &mut self.scratch.reads, fluent) {
                            Ok(value) => assign!(r!(a), *value),
                            Err(failure) => fail!(Raise::Again(failure)),
                        },
                        value => r!(a) = value,
                    },
                    Op::Assign(a, fluent, value) => {
                        if let (Some(truth), &Value::Fluent(fluent)) = (r!(value).as_truth(), &r!(fluent))
                            && self.current != SCRATCH_TASK
                            && !self.trace.enabled
                            && let Some(is_awaited) = signal_plainly(&mut self.fluents, fluent, truth)
                        {
                            r!(a) = truth;
                            if !is_awaited {
                                next!();
                            }
                            hand_over!(self.serve_signal(fluent))
                        }
                        let (fluent, value) = (r!(fluent), r!(value));
                        r!(a) = value;
                        hand_over!(self.assign_instruction(around, place, fluent, value))
                    }
                    Op::Refail(a) => fail!(Raise::Again(r!(a))),
                    // One by one, so that no instruction is compared with the last of those above.
                    #[rustfmt::skip]
                    Op::DefFluent(..) | Op::EnterPlan | Op::LeavePlan(_) | Op::TagNew(..) | Op::Parallel(..)
                    | Op::ParallelMap(..) | Op::Spawn(..) | Op::PushBlock(..) | Op::ReturnFrom(..)
                    | Op::PushHandler(..) | Op::PushCleanup(_) | Op::BeginCleanup | Op::EndCleanup
                    | Op::PushValve(..) | Op::PushOnInterrupt(_) | Op::PushOnResume(_) | Op::PushSuspended(_)
                    | Op::PushFence | Op::PushWatch(..) | Op::WatchWait | Op::WatchDone | Op::PopScopes(_)
                    | Op::LeaveScopes(..) | Op::Network(..) => {
                        hand_over!(self.plan_instruction(around, place, *op))
                    }
                }
                if STEPPING {
                    continue 'frame;
                }
                op = fetch!();
            };
            fuel = place.fuel;
            match next? {
                Proceed::On => {}
                Proceed::Switch => check_switch!(),
                Proceed::Leave => {
                    check_leaving!();
                    check_switch!();
                }
                Proceed::Entered => {
                    resume!(place.frame);
                    spend!();
                    check_leaving!();
                    check_switch!();
                }
                Proceed::Blocked => return Ok(Exit::Blocked),
                Proceed::Pause => return Ok(Exit::Paused),
                Proceed::Ask(asked, to) => return Ok(Exit::Ask(asked, to)),
            }
        }
    }
}
