//! Instructions.

use serde::{Deserialize, Serialize};

// Every instruction fits eight bytes.
const _: () = assert!(size_of::<Op>() == 8);

/// A register of the current frame.
pub type Reg = u8;

/// No register, where one is optional.
pub const NO_REG: Reg = 255;

/// One instruction. Jumps are relative to the next instruction; a jump backwards and every call
/// burn one unit of the task's step budget.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Op {
    /// `r0 := nil`
    Nil(Reg),
    /// `r0 := t`
    True(Reg),
    /// `r0 := integer`
    Int(Reg, i32),
    /// `r0 := constants[i]`
    Const(Reg, u32),
    /// `r0 := globals[i]`; `unbound-variable` if it has no value yet
    Global(Reg, u32),
    /// `globals[i] := r0`
    SetGlobal(Reg, u32),
    /// `globals[i] := a fluent with the initial value r0`
    DefFluent(Reg, u32),
    /// `r0 := r1`
    Move(Reg, Reg),
    /// `r0 := a new cell holding r1`
    CellNew(Reg, Reg),
    /// `r0 := contents of cell r1`
    CellGet(Reg, Reg),
    /// contents of cell r0 `:= r1`
    CellSet(Reg, Reg),
    /// `r0 := r1 + r2`
    Add(Reg, Reg, Reg),
    /// `r0 := r1 − r2`
    Sub(Reg, Reg, Reg),
    /// `r0 := r1 · r2`
    Mul(Reg, Reg, Reg),
    /// `r0 := r1 / r2`, an integer where that is exact
    Div(Reg, Reg, Reg),
    /// `r0 := r1 mod r2`, with the sign of r2
    Mod(Reg, Reg, Reg),
    /// `r0 := r1 + integer`
    AddInt(Reg, Reg, i16),
    /// `r0 := r1 + r2 · r3`, and pass over the product and the sum that follow, which know more, if all are floats or
    /// integers
    AddProduct(Reg, Reg, Reg, Reg),
    /// `r0 := r1 − r2 · r3` in the same way
    SubProduct(Reg, Reg, Reg, Reg),
    /// return `r0 + r1`, if both are floats or integers; else go on with the sum and the return that follow, which know
    /// more
    ReturnAdd(Reg, Reg),
    /// return `r0 + integer` in the same way
    ReturnAddInt(Reg, i16),
    /// return `r0 − r1` in the same way
    ReturnSub(Reg, Reg),
    /// return `r0 · r1` in the same way
    ReturnMul(Reg, Reg),
    /// return `r0 < r1` in the same way
    ReturnLess(Reg, Reg),
    /// return `r0 ≤ r1` in the same way
    ReturnLessEq(Reg, Reg),
    /// return `r0 = r1` in the same way
    ReturnNumEq(Reg, Reg),
    /// `r0 := r1 < r2`
    Less(Reg, Reg, Reg),
    /// `r0 := r1 ≤ r2`
    LessEq(Reg, Reg, Reg),
    /// `r0 := r1 = r2`, numbers only
    NumEq(Reg, Reg, Reg),
    /// `r0 := r1 ≠ r2`, numbers only
    NumDiffer(Reg, Reg, Reg),
    /// `r0 := r1 eq r2`
    Eq(Reg, Reg, Reg),
    /// `r0 := not r1`
    Not(Reg, Reg),
    /// `r0 := (r1 . r2)`
    Cons(Reg, Reg, Reg),
    /// `r0 := car r1`
    Car(Reg, Reg),
    /// `r0 := cdr r1`
    Cdr(Reg, Reg),
    /// `r0 :=` the element of the record r1 at a place, the record's kind being `constants[i]`
    Slot(Reg, Reg, u8, u32),
    /// the element of the record r0 at a place `:= r1`, the record's kind being `constants[i]`
    SetSlot(Reg, Reg, u8, u32),
    /// `r0 :=` the element of the vector r1 at the position r2
    VectorRef(Reg, Reg, Reg),
    /// the element of the vector r0 at the position r1 `:= r2`
    SetVectorRef(Reg, Reg, Reg),
    /// `r0 :=` the value of the key r1 in the hash table r2, or r3, or nil where there is no such register
    TableRef(Reg, Reg, Reg, Reg),
    /// the value of the key r0 in the hash table r1 `:= r2`
    SetTableRef(Reg, Reg, Reg),
    /// the cdr of the pair r1 `:=` a new pair `(r2)`, and r0 as well
    Extend(Reg, Reg, Reg),
    /// unless the list r0 is nil: `r1 := car r0`, `r0 := cdr r0`, and go on elsewhere
    NextElement(Reg, Reg, i32),
    /// the sort with the state r0 goes on with what r2 says of its last question; unless all is in order, the next one
    /// goes to r2 and r3, r1 is the function to be asked, and go on elsewhere
    MergeStep(Reg, i32),
    /// go on elsewhere
    Jump(i32),
    /// if r0 is nil
    JumpIfNil(Reg, i32),
    /// if r0 is not nil
    JumpIfTrue(Reg, i32),
    /// if the optional parameter r0 was given
    JumpIfGiven(Reg, i32),
    /// unless `r0 < r1`
    JumpUnlessLess(Reg, Reg, i32),
    /// unless `r0 ≤ r1`
    JumpUnlessLessEq(Reg, Reg, i32),
    /// unless `r0 = r1`
    JumpUnlessNumEq(Reg, Reg, i32),
    /// unless `r0 ≠ r1`
    JumpUnlessNumDiffer(Reg, Reg, i32),
    /// unless `r0 eq r1`
    JumpUnlessEq(Reg, Reg, i32),
    /// unless `r0 < integer`
    JumpUnlessLessInt(Reg, i16, i32),
    /// unless `r0 ≤ integer`
    JumpUnlessLessEqInt(Reg, i16, i32),
    /// unless `r0 > integer`
    JumpUnlessGreaterInt(Reg, i16, i32),
    /// unless `r0 ≥ integer`
    JumpUnlessGreaterEqInt(Reg, i16, i32),
    /// unless `r0 = integer`
    JumpUnlessNumEqInt(Reg, i16, i32),
    /// unless `r0 ≠ integer`
    JumpUnlessNumDifferInt(Reg, i16, i32),
    /// if `r0 < r1`
    JumpIfLess(Reg, Reg, i32),
    /// if `r0 ≤ r1`
    JumpIfLessEq(Reg, Reg, i32),
    /// if `r0 < integer`
    JumpIfLessInt(Reg, i16, i32),
    /// if `r0 ≤ integer`
    JumpIfLessEqInt(Reg, i16, i32),
    /// if `r0 > integer`
    JumpIfGreaterInt(Reg, i16, i32),
    /// if `r0 ≥ integer`
    JumpIfGreaterEqInt(Reg, i16, i32),
    /// `r0 := r0 + 1`, and go on elsewhere if all are integers and `r0 < r1`; a test that knows more follows
    Count(Reg, Reg, i32),
    /// the same if `r0 < integer`
    CountInt(Reg, i16, i32),
    /// call the function in a global; arguments from r0, count, global; result in r0
    Call(Reg, u8, u32),
    /// the same with one argument, r1, which need not stand in r0, for what is likely to read a slot
    CallSlot(Reg, Reg, u32),
    /// the same with r1 and what stands behind r0, for what is likely to assign a slot
    CallSetSlot(Reg, Reg, u32),
    /// as `Call` in tail position
    TailCall(Reg, u8, u32),
    /// call the value in r1; arguments from r0, count; result in r0
    CallValue(Reg, Reg, u8),
    /// the same in tail position
    TailCallValue(Reg, Reg, u8),
    /// run code i, which takes no arguments; result in r0
    CallCode(Reg, u32),
    /// `r0 := native(arguments from r1, count)`
    CallNative(Reg, Reg, u8, u16),
    /// `r0 := closure over code i`, capturing the registers that code names
    Closure(Reg, u32),
    /// end the frame with the value r0
    Return(Reg),
    /// the body of a plan begins: a node of the task tree
    EnterPlan,
    /// the body of a plan has the value r0: children it spawned are evaporated first
    LeavePlan(Reg),
    /// `r0 := a task not yet reached`, for the tag with this name (a constant)
    TagNew(Reg, u32),
    /// run a construct of concurrent children, `constructs[i]`; its value goes to r0
    Parallel(Reg, u32),
    /// the same, one child for each element of the list in r1
    ParallelMap(Reg, Reg, u32),
    /// `r0 := spawn` of `constructs[i]`
    Spawn(Reg, u32),
    /// a block that is left from inside a closure: its identity goes to r0; when it is left, its
    /// value goes to r1 and execution goes on at the target
    PushBlock(Reg, Reg, i32),
    /// leave the block whose identity is in r0 with the value r1
    ReturnFrom(Reg, Reg),
    /// failures of `handlers[i]` are caught: failure in r0, number of the clause in r0 + 1
    PushHandler(Reg, u16, i32),
    /// clean-up at the target whenever the following is left early
    PushCleanup(i32),
    /// the protected part ended by itself: pop, and run the clean-up that follows
    BeginCleanup,
    /// the clean-up has run: go on with whatever was under way
    EndCleanup,
    /// wait for the valve in r0, at most r1 seconds, hold it until the scope ends
    PushValve(Reg, Reg),
    /// the closure in r0 runs when the subtree is interrupted
    PushOnInterrupt(Reg),
    /// the closure in r0 runs when the subtree gets its valve back
    PushOnResume(Reg),
    /// the task in r0 is suspended until the scope ends
    PushSuspended(Reg),
    /// no task around this is given another plan until the scope ends
    PushFence,
    /// count from now on how often the fluent in r0 becomes true; a network made for this alone
    /// dies with it
    PushWatch(Reg, Missed, bool),
    /// wait until the watched fluent has become true
    WatchWait,
    /// the body of the watch has run
    WatchDone,
    /// leave the innermost scopes: count
    PopScopes(u8),
    /// leave a number of scopes early, running their clean-ups, then jump
    LeaveScopes(u8, i32),
    /// `r0 := network` evaluated by code i
    Network(Reg, u32),
    /// `r0 := wait for the fluent r1`, at most r2 seconds; a network made for this wait alone dies
    /// with it
    WaitFor(Reg, Reg, Reg, bool),
    /// `r0 := value of r1` if that is a fluent, else r1
    Deref(Reg, Reg),
    /// assign r2 to the fluent r1; `r0 := r2`
    Assign(Reg, Reg, Reg),
    /// raise the failure in r0 again
    Refail(Reg),
}

impl Op {
    /// Whether a stepper stops before it: it calls, waits, assigns, or opens a construct.
    pub fn is_step(&self) -> bool {
        matches!(
            self,
            Op::Call(..)
                | Op::CallSlot(..)
                | Op::CallSetSlot(..)
                | Op::TailCall(..)
                | Op::CallValue(..)
                | Op::TailCallValue(..)
                | Op::CallNative(..)
                | Op::SetGlobal(..)
                | Op::DefFluent(..)
                | Op::CellSet(..)
                | Op::SetSlot(..)
                | Op::SetVectorRef(..)
                | Op::SetTableRef(..)
                | Op::Assign(..)
                | Op::Parallel(..)
                | Op::ParallelMap(..)
                | Op::Spawn(..)
                | Op::PushValve(..)
                | Op::PushSuspended(..)
                | Op::PushWatch(..)
                | Op::WaitFor(..)
                | Op::ReturnFrom(..)
                | Op::Refail(..)
        )
    }

    /// The register that has the value of the form when the instruction is done, if it has one.
    pub fn value_register(&self) -> Option<Reg> {
        match *self {
            Op::Call(reg, ..)
            | Op::CallSlot(reg, ..)
            | Op::CallSetSlot(reg, ..)
            | Op::CallValue(reg, ..)
            | Op::CallNative(reg, ..)
            | Op::SetGlobal(reg, _)
            | Op::DefFluent(reg, _)
            | Op::Parallel(reg, _)
            | Op::ParallelMap(reg, ..)
            | Op::Spawn(reg, _)
            | Op::WaitFor(reg, ..) => Some(reg),
            _ => None,
        }
    }
}

/// What a `whenever` does with events that come while its body runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Missed {
    /// One more round, however many there were.
    Once,
    /// One round for each.
    Always,
    /// None.
    Never,
}
