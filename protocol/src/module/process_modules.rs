//! The modules in other processes that a robot has, as one module of it.

use super::manifest::Manifest;
use super::message::{Greeting, ModuleAnswer, ModuleWords};
use super::process_module::{ProcessModule, SavedModule};
use super::queries;
use crate::line::{Conversation, Line};
use crate::value::Spoken;
use rpl_lang::symbol::Symbol;
use rpl_robot::geometry::Velocity;
use rpl_robot::localization::Estimate;
use rpl_robot::office::{
    Layout, Module, ModuleSpec, Moment, NameTaken, OfficeModel, Part, PlanText, Position, Raise, Start, StopReason,
    Telling,
};
use rpl_robot::simulator::Percept;
use rpl_runtime::robot::Ending;
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native, Reply};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Gives a line to a module that has just been started for a run. One that does not start answers its first
/// turn with its loss.
pub type OpenLine = dyn Fn(Greeting) -> Arc<dyn Line<ModuleWords, ModuleAnswer>> + Send + Sync;

/// A module in another process before any run.
#[derive(Clone)]
pub struct ModuleSource {
    /// What it offers.
    pub manifest: Arc<Manifest>,
    /// The plans that belong to it.
    pub plans: Option<PlanText>,
    /// Starts it.
    pub open: Arc<OpenLine>,
    /// Whether it waits for the run: in lock step, and where a recording speaks for it.
    pub waits: bool,
    /// Its queries, as functions of plans.
    pub queries: Vec<Native>,
}

impl ModuleSource {
    /// A module with this manifest.
    pub fn new(manifest: Arc<Manifest>, plans: Option<PlanText>, open: Arc<OpenLine>, waits: bool) -> Self {
        let queries = queries::natives(&manifest, ask);
        Self { manifest, plans, open, waits, queries }
    }

    fn spec(&self) -> ModuleSpec {
        let Manifest { name, behaviours, models, fluents, valves, .. } = &*self.manifest;
        ModuleSpec {
            name: name.clone().into(),
            behaviours: behaviours.clone(),
            fluents: fluents.iter().map(|fluent| fluent.spec.clone()).collect(),
            valves: valves.iter().cloned().map(Into::into).collect(),
            functions: self.queries.clone(),
            plans: self.plans.iter().cloned().collect(),
            models: models.clone(),
        }
    }
}

/// The sources of all modules in other processes.
#[derive(Clone, Default)]
pub struct ModuleSources(pub Vec<ModuleSource>);

impl ModuleSources {
    /// What one of them wants of a robot, as a clause with its manifest; none if they get along without one.
    pub fn wants_robot(&self) -> Option<String> {
        self.0.iter().find_map(|source| {
            let Manifest { name, file, .. } = &*source.manifest;
            let wanted = match (source.manifest.wants_position, source.manifest.wants_percept) {
                (true, _) => "position",
                (false, true) => "percept",
                (false, false) => return None,
            };
            Some(format!("the module `{name}` ({file}) wants the robot's {wanted}"))
        })
    }

    /// Whether one of them does not wait for the run.
    pub fn are_live(&self) -> bool {
        self.0.iter().any(|source| !source.waits)
    }

    /// What is said of names that do not fit, with the places in the manifests.
    pub fn told(&self, fault: &NameTaken) -> String {
        let place = |module: &str, name: &str| self.places(module, name);
        match fault {
            NameTaken::Twice { name, first, second } if first == second => {
                format!("two modules are called `{first}` and have `{name}`{}; rename one", place(first, name))
            }
            NameTaken::Twice { name, first, second } => {
                let (there, here) = (place(first, name), place(second, name));
                format!(
                    "`{name}` of the module `{second}`{here} has a meaning already: the module `{first}`{there} has one of that name"
                )
            }
            NameTaken::NoValve { behaviour, module, .. } => {
                let here = place(module, behaviour);
                format!("{fault}{here}; add it to the `valves` of its manifest, or name one that is there")
            }
        }
    }
}

/// Where names stand in manifests.
impl ModuleSources {
    /// Where a name of the modules of a name stands, behind a space and in parentheses; nothing if it stands nowhere.
    pub fn places(&self, module: &str, name: &str) -> String {
        let manifests = self.0.iter().map(|source| &source.manifest);
        let places: Vec<String> =
            manifests.filter(|known| known.name == module).map(|known| known.place(name)).collect();
        if places.is_empty() { String::new() } else { format!(" ({})", places.join(", ")) }
    }
}

/// A query that a plan calls.
fn ask(call: &mut Call<'_, '_>, module: &str) -> Result<Reply, Raise> {
    let query = call.native.name;
    let arguments = queries::said(call)?;
    let time_us = call.machine.now_us;
    match call.part::<ProcessModules>()?.ask(module, query, arguments, time_us) {
        Ok(reading) => Ok(Reply::Value(call.value_of(&reading))),
        Err(Ending::Failure { class, message, slots }) => Err(call.failure(class, message, slots)),
        Err(Ending::Success(_)) => unreachable!("a success is no failure"),
    }
}

/// The modules in other processes of a run. What they are is theirs: a saved run has what was said to them and
/// what is expected of them.
#[derive(Clone, Serialize, Deserialize)]
#[serde(into = "Vec<SavedModule>", from = "Vec<SavedModule>")]
pub struct ProcessModules {
    modules: Vec<ProcessModule>,
    layout: Layout,
    /// What was loaded, and has no modules yet.
    saved: Vec<SavedModule>,
    /// Whether they are those of a projected run, which asks nobody.
    is_foreseen: bool,
}

impl From<ProcessModules> for Vec<SavedModule> {
    fn from(modules: ProcessModules) -> Self {
        modules.modules.iter().map(ProcessModule::saved).collect()
    }
}

impl From<Vec<SavedModule>> for ProcessModules {
    fn from(saved: Vec<SavedModule>) -> Self {
        Self { modules: Vec::new(), layout: Layout::default(), saved, is_foreseen: false }
    }
}

impl ProcessModules {
    fn layout(sources: &ModuleSources) -> Layout {
        let mut layout = Layout::default();
        for source in &sources.0 {
            layout.push(&[source.spec()]);
        }
        layout
    }

    /// The modules of a run that greets them so.
    pub(super) fn greeted(sources: &ModuleSources, greeting: Greeting) -> Self {
        let opened = sources.0.iter().map(|ModuleSource { manifest, open, .. }| {
            ProcessModule::new(manifest.clone(), greeting, Conversation::new(open(greeting)))
        });
        Self { modules: opened.collect(), layout: Self::layout(sources), saved: Vec::new(), is_foreseen: false }
    }

    /// Starts a behaviour of all.
    ///
    /// # Errors
    /// As for [`ProcessModule::start`].
    pub(super) fn start_one(
        &mut self,
        behaviour: usize,
        (machine, arguments): (&Machine, &[(Symbol, Value)]),
        time_us: u64,
        tell: &mut Telling<'_>,
    ) -> Result<(), Raise> {
        let (module, own, part) = self.with_behaviour(behaviour);
        if let Some(ending) = module.start(machine, own, arguments, time_us)? {
            tell.of(part).end(own, ending);
        }
        Ok(())
    }

    /// Asks a module, by its name.
    ///
    /// # Errors
    /// As for [`ProcessModule::ask`]; or the run is a projected one.
    pub(super) fn ask(
        &mut self,
        module: &str,
        query: &str,
        arguments: Vec<Spoken>,
        time_us: u64,
    ) -> Result<Reading, Ending> {
        if self.is_foreseen {
            let why =
                format!("there is no model of what the query `{query}` answers, so no plan that asks it is projected");
            return Err(Ending::failure("projection-failure", why));
        }
        let found = self.modules.iter_mut().find(|known| known.manifest().name == module);
        let Some(found) = found else { unreachable!("a query belongs to a module of the run") };
        found.ask(query, arguments, time_us)
    }

    /// Stops a behaviour of all.
    pub(super) fn stop_one(&mut self, behaviour: usize, why: StopReason) {
        let (module, own, _) = self.with_behaviour(behaviour);
        module.stop(own, why);
    }

    /// Each module has its turn: it hears of a tick, and what it says is told. What the robot's wheels are to do, if
    /// there is a robot.
    pub(super) fn turn(
        &mut self,
        time_us: u64,
        robot: Option<(Estimate, &Percept)>,
        tell: &mut Telling<'_>,
    ) -> Option<Velocity> {
        let mut wanted = None;
        for (part, module) in self.layout.parts().zip(&mut self.modules) {
            let news = module.step(time_us, robot);
            let mut tell = tell.of(part);
            for (fluent, reading) in news.fluents {
                tell.fluent(fluent, reading);
            }
            for (behaviour, ending) in news.endings {
                tell.end(behaviour, ending);
            }
            for event in news.events {
                tell.event(event);
            }
            wanted = news.velocity.or(wanted);
        }
        wanted
    }

    /// The module with a behaviour of all, and the behaviour's place in it.
    fn with_behaviour(&mut self, behaviour: usize) -> (&mut ProcessModule, usize, &Part) {
        let parts = self.layout.parts().zip(&mut self.modules);
        let found = parts.into_iter().find(|(part, _)| part.behaviours.contains(&behaviour));
        let Some((part, module)) = found else { unreachable!("no module has a behaviour {behaviour}") };
        (module, behaviour - part.behaviours.start, part)
    }
}

impl Module for ProcessModules {
    type Settings = ModuleSources;

    fn specs(sources: &ModuleSources) -> Vec<ModuleSpec> {
        sources.0.iter().map(ModuleSource::spec).collect()
    }

    fn new(sources: &ModuleSources, model: &OfficeModel, seed: u64) -> Self {
        Self::greeted(sources, Greeting { period_us: model.settings.robot.step_us, seed })
    }

    fn foresee(&mut self) {
        self.is_foreseen = true;
    }

    fn resume(&mut self, at_start: &Self) -> Result<(), String> {
        let saved = std::mem::take(&mut self.saved);
        if saved.len() != at_start.modules.len() {
            return Err("the run was saved with other modules in other processes".into());
        }
        (self.modules, self.layout) = (at_start.modules.clone(), at_start.layout.clone());
        self.modules.iter_mut().zip(saved).try_for_each(|(module, saved)| module.restore(saved))
    }

    fn renew(&mut self, tell: &mut Telling<'_>) -> bool {
        for (part, module) in self.layout.parts().zip(&mut self.modules) {
            let mut tell = tell.of(part);
            module.renew().into_iter().for_each(|behaviour| tell.interrupt(behaviour));
        }
        !self.modules.is_empty()
    }

    fn start(
        &mut self,
        behaviour: usize,
        start: &Start<'_>,
        _: &mut Position,
        tell: &mut Telling<'_>,
    ) -> Result<(), Raise> {
        self.start_one(behaviour, (start.machine, start.arguments), start.time_us, tell)
    }

    fn stop(&mut self, behaviour: usize, why: StopReason, _: &mut Telling<'_>) {
        self.stop_one(behaviour, why);
    }

    fn step(&mut self, now: &Moment<'_>, position: &mut Position, tell: &mut Telling<'_>) -> Option<Velocity> {
        let estimate = position.estimate(now.model.map.as_ref());
        self.turn(now.percept.time_us, Some((estimate, now.percept)), tell)
    }
}
