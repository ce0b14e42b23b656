//! What a function asks for, found in its forms and through its calls.

use super::conflict::{conflicts_between, is_ordered};
use super::request::{SeenValve, ValveConflict, ValveNeed, ValveRequest, ValveSummary};
use crate::check::bindings::Bindings;
use crate::check::known::{Check, KnownFunction};
use crate::check::walk::each_form_within;
use crate::check::walk::{FormPart, parts};
use crate::code::GlobalKind;
use crate::compile::ir::{ArgumentIr, Callee, ConstructIr, Function, Ir, IrKind, ScopeIr, VarId};
use crate::source::Span;
use crate::stack::deep;
use std::collections::{BTreeMap, BTreeSet};

/// More requests than this of one function are not followed.
const MAX_REQUESTS: usize = 256;

/// Summaries of functions, made when they are asked for.
#[derive(Default)]
pub(in crate::check) struct Summaries {
    /// None while it is being made: a recursion adds nothing.
    known: BTreeMap<u32, Option<ValveSummary>>,
}

impl Summaries {
    fn of(&mut self, check: &Check<'_>, global: u32) -> ValveSummary {
        if let Some(known) = self.known.get(&global) {
            return known.clone().unwrap_or_default();
        }
        let Some(known) = check.known(global) else { return ValveSummary::default() };
        self.known.insert(global, None);
        let summary = summarize(check, self, known, &mut Vec::new());
        self.known.insert(global, Some(summary.clone()));
        summary
    }
}

/// What a function asks for, and the conflicts in it.
pub(in crate::check) fn summarize(
    check: &Check<'_>,
    summaries: &mut Summaries,
    known: KnownFunction<'_>,
    conflicts: &mut Vec<ValveConflict>,
) -> ValveSummary {
    let parameters = known.function.bindings.iter().map(|binding| binding.variable).collect();
    let mut search = Search::new(check, summaries, known.bindings, parameters, conflicts);
    search.form(&known.function.body);
    search.finish()
}

/// What forms that run one after the other ask for, and the conflicts in them.
pub(in crate::check) fn summarize_forms(
    check: &Check<'_>,
    summaries: &mut Summaries,
    forms: &[Function],
    conflicts: &mut Vec<ValveConflict>,
) -> ValveSummary {
    let mut search = Search::new(check, summaries, check.bindings(), Vec::new(), conflicts);
    forms.iter().for_each(|form| search.form(&form.body));
    search.finish()
}

struct Search<'c, 'a> {
    check: &'c Check<'a>,
    summaries: &'c mut Summaries,
    bindings: &'c Bindings<'a>,
    parameters: Vec<VarId>,
    conflicts: &'c mut Vec<ValveConflict>,
    found: ValveSummary,
    held: Vec<SeenValve>,
    /// Where in `held` the current task's own begin.
    task_base: usize,
    /// Valves that are held and not known.
    unknown_held: u32,
    protected: bool,
    priority: Option<Vec<i64>>,
    same_task: bool,
    after_task: bool,
    /// Spawned tasks: what they ask for, how many requests were known before, what was held.
    spawned: Vec<(Vec<ValveRequest>, usize, usize)>,
    /// Local functions that are being followed.
    followed: BTreeSet<VarId>,
}

impl<'c, 'a> Search<'c, 'a> {
    fn new(
        check: &'c Check<'a>,
        summaries: &'c mut Summaries,
        bindings: &'c Bindings<'a>,
        parameters: Vec<VarId>,
        conflicts: &'c mut Vec<ValveConflict>,
    ) -> Self {
        Self {
            check,
            summaries,
            bindings,
            parameters,
            conflicts,
            found: ValveSummary::default(),
            held: Vec::new(),
            task_base: 0,
            unknown_held: 0,
            protected: false,
            priority: Some(Vec::new()),
            same_task: true,
            after_task: false,
            spawned: Vec::new(),
            followed: BTreeSet::new(),
        }
    }

    fn finish(mut self) -> ValveSummary {
        self.compare_spawned();
        self.found
    }

    /// Spawned tasks run beside all that follows.
    fn compare_spawned(&mut self) {
        for (requests, before, base) in std::mem::take(&mut self.spawned) {
            let later = &self.found.requests[before.min(self.found.requests.len())..];
            self.conflicts.extend(conflicts_between(self.check, &requests, later, base));
        }
    }

    fn form(&mut self, ir: &Ir) {
        deep(|| self.form_here(ir));
    }

    fn form_here(&mut self, ir: &Ir) {
        match &ir.kind {
            IrKind::Scope(ScopeIr::Valve { valve, .. }, body) => self.with_valve(valve, body, ir.span),
            IrKind::Scope(ScopeIr::OnInterrupt(hook), body) => {
                self.protected(|search| search.form(&hook.body));
                self.form(body);
            }
            IrKind::Cleanup { body, cleanup, .. } => {
                self.form(body);
                self.protected(|search| search.form(cleanup));
            }
            IrKind::If(condition, then, otherwise) => {
                self.form(condition);
                // What is taken in one branch only may not be held behind it.
                for branch in [then, otherwise] {
                    let held = self.held.len();
                    self.form(branch);
                    self.held.truncate(held);
                }
            }
            IrKind::Construct(construct) => self.construct(construct),
            IrKind::ConstructMap(construct, list) => {
                self.form(list);
                let requests = self.children(construct).concat();
                // Two elements run the same body side by side.
                self.conflicts.extend(conflicts_between(self.check, &requests, &requests, self.held.len()));
                self.merge(requests);
            }
            IrKind::Spawn(construct) => {
                let requests = self.children(construct).concat();
                self.merge(requests.clone());
                self.spawned.push((requests, self.found.requests.len(), self.held.len()));
            }
            IrKind::Call(callee, arguments) => self.call(callee, arguments, ir.span),
            // A closure runs where it is called, if that can be seen.
            IrKind::Lambda(_) | IrKind::Network(_) => {}
            IrKind::WaitFor { fluent, .. } => {
                self.form(fluent);
                self.after_task |= mentions_task(self.check, fluent);
            }
            _ => parts(ir, &mut |part| match part {
                FormPart::Form(form) => self.form(form),
                FormPart::Function(function) => self.form(&function.body),
            }),
        }
    }

    fn protected(&mut self, inside: impl FnOnce(&mut Self)) {
        let before = std::mem::replace(&mut self.protected, true);
        inside(self);
        self.protected = before;
    }

    fn with_valve(&mut self, valve: &Ir, body: &Ir, span: Span) {
        self.form(valve);
        let held = self.held.len();
        match self.valve(valve) {
            Some(valve) => {
                self.request(valve, span);
                self.held.push(valve);
                self.form(body);
            }
            None => {
                self.unknown_held += 1;
                self.form(body);
                self.unknown_held -= 1;
            }
        }
        self.held.truncate(held);
    }

    fn valve(&self, ir: &Ir) -> Option<SeenValve> {
        match ir.kind {
            IrKind::Global(global) if matches!(self.check.kind(global), GlobalKind::Valve { .. }) => {
                Some(SeenValve::Global(global))
            }
            IrKind::Local(variable) => {
                let position = self.parameters.iter().position(|&parameter| parameter == variable)?;
                (self.bindings.get(variable).assignments == 0).then_some(SeenValve::Parameter(position))
            }
            _ => None,
        }
    }

    fn request(&mut self, valve: SeenValve, span: Span) {
        // The task holds it already.
        if self.held[self.task_base..].contains(&valve) {
            return;
        }
        let request = ValveRequest {
            held: self.held.clone(),
            valve,
            span,
            within: None,
            protected: self.protected,
            priority: self.priority.clone(),
            same_task: self.same_task,
            after_task: self.after_task,
        };
        self.note(request);
    }

    fn note(&mut self, request: ValveRequest) {
        let is_new = |known: &ValveRequest| {
            known.held != request.held
                || known.valve != request.valve
                || known.protected != request.protected
                || known.priority != request.priority
                || known.after_task != request.after_task
        };
        if self.found.requests.len() < MAX_REQUESTS && self.found.requests.iter().all(is_new) {
            self.found.requests.push(request);
        }
    }

    fn call(&mut self, callee: &Callee, arguments: &[Ir], span: Span) {
        arguments.iter().for_each(|argument| self.form(argument));
        // A function given to another one is called by it, or so it looks.
        for argument in arguments {
            if let IrKind::Lambda(function) = &argument.kind {
                self.form(&function.body);
            }
        }
        match callee {
            Callee::Global(global) => {
                let summary = self.summaries.of(self.check, *global);
                self.called(summary, arguments, span);
            }
            Callee::Native(native) => {
                let name = self.check.subject.natives[usize::from(*native)].name.as_str();
                self.native(name, arguments, span);
            }
            Callee::Value(value) => self.local_call(value),
        }
    }

    fn local_call(&mut self, value: &Ir) {
        self.form(value);
        match value.kind {
            IrKind::Local(variable) => {
                if let Some(function) = self.bindings.function(variable)
                    && self.followed.insert(variable)
                {
                    self.form(&function.body);
                    self.followed.remove(&variable);
                }
            }
            IrKind::Lambda(ref function) => self.form(&function.body),
            _ => {}
        }
    }

    /// What a called function asks for, seen from here.
    fn called(&mut self, summary: ValveSummary, arguments: &[Ir], span: Span) {
        for need in summary.needs {
            let within = Some(need.within.unwrap_or(need.span));
            self.need(ValveNeed { span, within, ..need });
        }
        for request in summary.requests {
            let seen = |valve: SeenValve| match valve {
                SeenValve::Global(_) => Some(valve),
                SeenValve::Parameter(position) => arguments.get(position).and_then(|argument| self.valve(argument)),
            };
            let Some(valve) = seen(request.valve) else { continue };
            let Some(held) = request.held.iter().map(|&held| seen(held)).collect::<Option<Vec<_>>>() else { continue };
            if request.same_task && self.held[self.task_base..].contains(&valve) {
                continue;
            }
            let priority = match (&self.priority, &request.priority) {
                (Some(outer), Some(inner)) => Some([&outer[..], inner].concat()),
                _ => None,
            };
            let request = ValveRequest {
                held: [&self.held[..], &held].concat(),
                valve,
                span,
                within: Some(request.within.unwrap_or(request.span)),
                protected: self.protected || request.protected,
                priority,
                same_task: self.same_task && request.same_task,
                after_task: self.after_task || request.after_task,
            };
            self.note(request);
        }
    }

    fn native(&mut self, name: &str, arguments: &[Ir], span: Span) {
        let valve = arguments.first().and_then(|argument| self.valve(argument));
        match (name, valve) {
            ("request-valve", Some(valve)) => {
                self.request(valve, span);
                self.held.push(valve);
            }
            ("request-valve", None) => self.unknown_held += 1,
            ("release-valve", Some(valve)) => {
                if let Some(at) = self.held.iter().rposition(|&held| held == valve) {
                    self.held.remove(at);
                    self.task_base = self.task_base.min(self.held.len());
                }
            }
            ("activate", _) => self.activate(arguments, span),
            _ => {}
        }
    }

    fn activate(&mut self, arguments: &[Ir], span: Span) {
        let Some(IrKind::Global(behaviour)) = arguments.first().map(|argument| &argument.kind) else { return };
        let GlobalKind::Behaviour(number) = *self.check.kind(*behaviour) else { return };
        let signature = self.check.subject.behaviours.get(usize::from(number));
        let valve = signature.and_then(|signature| signature.valve.as_deref());
        let global = valve
            .and_then(|valve| self.check.subject.symbols.find(valve))
            .and_then(|valve| self.check.subject.program.names.get(&valve));
        if let Some(&valve) = global {
            self.need(ValveNeed { valve, behaviour: *behaviour, span, within: None });
        }
    }

    fn need(&mut self, need: ValveNeed) {
        let is_held = self.unknown_held > 0
            || self
                .held
                .iter()
                .any(|&held| held == SeenValve::Global(need.valve) || matches!(held, SeenValve::Parameter(_)));
        if !is_held && !self.found.needs.contains(&need) {
            self.found.needs.push(need);
        }
    }

    fn construct(&mut self, construct: &ConstructIr) {
        construct.evaluated().for_each(|argument| self.form(argument));
        let children = self.children(construct);
        for (at, first) in children.iter().enumerate() {
            for (other, second) in children.iter().enumerate().skip(at + 1) {
                let found: Vec<ValveConflict> = conflicts_between(self.check, first, second, self.held.len()).collect();
                if !found.is_empty() && !is_ordered(construct, at, other) {
                    self.conflicts.extend(found);
                }
            }
        }
        self.merge(children.concat());
    }

    /// The requests of each child; those that only wait for their child are the same task in
    /// matters of valves.
    fn children(&mut self, construct: &ConstructIr) -> Vec<Vec<ValveRequest>> {
        let is_alone = construct.is_single();
        let bodies = construct.children.iter().enumerate();
        bodies.map(|(at, child)| self.child(&child.body, appended(construct, at), is_alone)).collect()
    }

    fn child(&mut self, body: &Function, appended: Option<Vec<i64>>, is_alone: bool) -> Vec<ValveRequest> {
        let outer = (self.task_base, self.same_task, self.after_task);
        let held = self.held.clone();
        let priority = self.priority.clone();
        let before = (std::mem::take(&mut self.found.requests), std::mem::take(&mut self.spawned));
        if !is_alone {
            (self.task_base, self.same_task) = (self.held.len(), false);
        }
        self.priority = match (&priority, appended) {
            (Some(outer), Some(inner)) => Some([&outer[..], &inner].concat()),
            _ => None,
        };
        self.form(&body.body);
        self.priority = priority;
        (self.task_base, self.same_task, self.after_task) = outer;
        // A child may give back what the task around it holds.
        self.held = held;
        self.compare_spawned();
        self.spawned = before.1;
        std::mem::replace(&mut self.found.requests, before.0)
    }

    fn merge(&mut self, requests: Vec<ValveRequest>) {
        requests.into_iter().for_each(|request| self.note(request));
    }
}

/// What a construct appends to the priority of a child; none if it is not visible.
fn appended(construct: &ConstructIr, child: usize) -> Option<Vec<i64>> {
    match &construct.argument {
        Some(ArgumentIr::Priority(number)) => match number.kind {
            IrKind::Int(number) => Some(vec![number]),
            _ => None,
        },
        None if construct.policy().is_some() => Some(vec![i64::from(child == 0)]),
        Some(ArgumentIr::Deadline { .. } | ArgumentIr::Quorum { .. } | ArgumentIr::Most(_)) | None => Some(Vec::new()),
    }
}

/// Whether a condition looks at a task.
fn mentions_task(check: &Check<'_>, ir: &Ir) -> bool {
    let mut found = false;
    each_form_within(ir, &mut |form| {
        let name = check.native_call(form).map(|(name, _)| name);
        found |= matches!(name, Some("status" | "result" | "begin-task" | "end-task"));
    });
    found
}
