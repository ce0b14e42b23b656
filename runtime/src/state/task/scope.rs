//! Dynamic scopes of a task.

use super::children::Children;
use super::leaving::Then;
use crate::state::value::{TaskRef, Value};
use rpl_lang::code::Reg;
use rpl_lang::source::Span;
use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A plan call: a node of the task tree.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanCall {
    /// The plan.
    pub name: Symbol,
    /// How many calls of this name its surroundings had before, from 1.
    pub occurrence: u32,
    /// Where it was called.
    pub span: Option<Span>,
    /// How often each name was used in it.
    pub counters: BTreeMap<Symbol, u32>,
    /// Spawned children that live.
    pub spawned: u32,
    /// Tags that were made for it.
    pub tags: Vec<TaskRef>,
    /// How many of them there may be before they are looked through.
    pub most_tags: u32,
    /// The failure of a spawned child that came while nothing could stop the task.
    pub failure: Option<Value>,
}

impl PlanCall {
    /// A plan call that begins.
    pub(crate) fn new(name: Symbol, occurrence: u32, span: Option<Span>) -> Self {
        let (counters, tags) = (BTreeMap::new(), Vec::new());
        Self { name, occurrence, span, counters, spawned: 0, tags, most_tags: 0, failure: None }
    }
}

/// A dynamic scope of a task, left in the reverse order of entering.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ScopeKind {
    /// A block that can be left from inside a closure.
    Block {
        /// By which a closure names it.
        identity: u64,
        /// The register of its value.
        result: Reg,
        /// The instruction behind it.
        target: u32,
    },
    /// Catches failures.
    Handler {
        /// The code whose list of clauses it has.
        code: u32,
        /// Which of that code's lists.
        index: u32,
        /// The register of the failure; the next one gets the number of the clause.
        failure: Reg,
        /// The instruction where the clauses begin.
        target: u32,
    },
    /// A clean-up that runs when the scope is left early.
    Cleanup {
        /// The instruction where it begins.
        target: u32,
    },
    /// A clean-up is running.
    InCleanup(Box<Then>),
    /// A plan call.
    Call(Box<PlanCall>),
    /// A construct with children.
    Children(Box<Children>),
    /// A valve is held.
    Valve(u32),
    /// Runs when the subtree is interrupted.
    OnInterrupt(Value),
    /// Runs when the subtree gets its valve back.
    OnResume(Value),
    /// Another task is suspended.
    Suspended(TaskRef),
    /// A fluent is watched.
    Watch(u32),
    /// No task around is given another plan meanwhile.
    Fence,
}

/// A scope and the number of frames below the one that opened it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scope {
    /// What it is.
    pub kind: ScopeKind,
    /// Frames below its own.
    pub depth: u32,
}

/// The scopes of a task, innermost last. Where its clean-ups and its plan calls are is known without
/// looking through them, for they may be many.
#[derive(Clone, Debug, Default)]
pub struct Scopes(Option<Box<ScopeStack>>);

#[derive(Clone, Debug, Default)]
struct ScopeStack {
    all: Vec<Scope>,
    /// Which of them are clean-ups that run.
    clean_ups: Vec<u32>,
    /// Which of them are plan calls.
    calls: Vec<u32>,
}

impl ScopeStack {
    /// The places of all scopes of this kind, if they are kept.
    fn kept_with(&mut self, kind: &ScopeKind) -> Option<&mut Vec<u32>> {
        match kind {
            ScopeKind::InCleanup(_) => Some(&mut self.clean_ups),
            ScopeKind::Call(_) => Some(&mut self.calls),
            ScopeKind::Block { .. }
            | ScopeKind::Handler { .. }
            | ScopeKind::Cleanup { .. }
            | ScopeKind::Children(_)
            | ScopeKind::Valve(_)
            | ScopeKind::OnInterrupt(_)
            | ScopeKind::OnResume(_)
            | ScopeKind::Suspended(_)
            | ScopeKind::Watch(_)
            | ScopeKind::Fence => None,
        }
    }
}

impl Scopes {
    /// Enters a scope.
    pub fn push(&mut self, scope: Scope) {
        let stack = self.0.get_or_insert_default();
        let index = stack.all.len() as u32;
        if let Some(kept) = stack.kept_with(&scope.kind) {
            kept.push(index);
        }
        stack.all.push(scope);
    }

    /// Leaves the innermost scope.
    pub fn pop(&mut self) -> Option<Scope> {
        let stack = self.0.as_mut()?;
        let scope = stack.all.pop()?;
        if let Some(kept) = stack.kept_with(&scope.kind) {
            kept.pop();
        }
        Some(scope)
    }

    /// The clean-ups that run, outermost first, with their indices and what follows them.
    pub fn clean_ups(&self) -> impl Iterator<Item = (usize, &Then)> {
        let (all, clean_ups) = self.0.as_ref().map_or((&[][..], &[][..]), |stack| (&stack.all, &stack.clean_ups));
        clean_ups.iter().filter_map(|&clean_up| match &all[clean_up as usize].kind {
            ScopeKind::InCleanup(then) => Some((clean_up as usize, &**then)),
            _ => None,
        })
    }

    /// The outermost clean-up that runs.
    pub fn first_clean_up(&self) -> Option<u32> {
        self.0.as_ref()?.clean_ups.first().copied()
    }

    /// The innermost clean-up that runs.
    pub fn last_clean_up(&self) -> Option<u32> {
        self.0.as_ref()?.clean_ups.last().copied()
    }

    /// The innermost plan call among the first scopes.
    pub fn call_within(&self, scopes: usize) -> Option<usize> {
        self.calls_within(scopes).next().map(|(index, _)| index)
    }

    /// The plan calls among the first scopes, innermost first, with their indices.
    pub fn calls_within(&self, scopes: usize) -> impl Iterator<Item = (usize, &PlanCall)> {
        let (all, calls) = self.0.as_ref().map_or((&[][..], &[][..]), |stack| (&stack.all, &stack.calls));
        let within = calls.partition_point(|&call| (call as usize) < scopes);
        calls[..within].iter().rev().filter_map(|&call| match &all[call as usize].kind {
            ScopeKind::Call(record) => Some((call as usize, &**record)),
            _ => None,
        })
    }

    /// The innermost plan call.
    pub fn innermost_call(&mut self) -> Option<&mut PlanCall> {
        let index = self.call_within(usize::MAX)?;
        match &mut self[index].kind {
            ScopeKind::Call(call) => Some(call),
            _ => None,
        }
    }
}

impl PartialEq for Scopes {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl std::ops::Deref for Scopes {
    type Target = [Scope];

    fn deref(&self) -> &[Scope] {
        self.0.as_ref().map_or(&[], |stack| &stack.all)
    }
}

/// What a scope is does not change while it is entered.
impl std::ops::DerefMut for Scopes {
    fn deref_mut(&mut self) -> &mut [Scope] {
        self.0.as_mut().map_or(&mut [], |stack| &mut stack.all)
    }
}

impl Serialize for Scopes {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (**self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Scopes {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut scopes = Self::default();
        Vec::<Scope>::deserialize(deserializer)?.into_iter().for_each(|scope| scopes.push(scope));
        Ok(scopes)
    }
}
