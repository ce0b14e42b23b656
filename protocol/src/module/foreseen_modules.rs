//! Modules in other processes as projected runs have them where there is no robot: by what their manifests say of their
//! behaviours. Nobody outside is asked.

use super::process_modules::ProcessModules;
use rpl_lang::symbol::Symbol;
use rpl_random::Stream;
use rpl_robot::office::{Composition, Module};
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::robot::{Ending, Foreseen, NEVER_US, Outbox, Outside, RobotTables, StopReason};
use rpl_runtime::state::activation::{Phase, Phases};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use std::any::{Any, TypeId};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Modules of a projected run.
#[derive(Clone)]
pub(super) struct ForeseenModules {
    composition: Arc<Composition<ProcessModules>>,
    modules: ProcessModules,
    /// What goes on when the run begins: it is projected as if it began then.
    begun: Vec<u16>,
    now_us: u64,
    under_way: BTreeMap<u16, UnderWay>,
    stream: Stream,
    has_drawn: bool,
    unforeseen: Option<String>,
}

/// A behaviour at work.
#[derive(Clone)]
struct UnderWay {
    ends_us: u64,
    /// The class of the failure that it ends with, if it does.
    failure: Option<String>,
    /// What it sets when it succeeds, by the places of fluents.
    sets: Vec<(usize, Reading)>,
}

impl ForeseenModules {
    /// What is foreseen of modules from a time on.
    ///
    /// # Errors
    /// Something goes on for which there is no model.
    pub(super) fn new(
        composition: Arc<Composition<ProcessModules>>,
        mut modules: ProcessModules,
        now_us: u64,
        phases: Phases<'_>,
    ) -> Result<Self, Raise> {
        modules.foresee();
        let behaviours = 0..composition.tables.behaviours.len() as u16;
        let begun: Vec<u16> = behaviours.filter(|&behaviour| phases.of(behaviour) == Phase::Active).collect();
        if let Some(behaviour) = begun.iter().find(|behaviour| !composition.models.contains_key(behaviour)) {
            return Err(Raise::new("projection-failure", without_model(&composition, *behaviour)));
        }
        let (under_way, stream) = (BTreeMap::new(), Stream::new(0, "acts"));
        Ok(Self { composition, modules, begun, now_us, under_way, stream, has_drawn: false, unforeseen: None })
    }

    fn begin(&mut self, behaviour: u16, sets: Vec<(usize, Reading)>, now_us: u64) {
        let model = &self.composition.models[&behaviour];
        self.has_drawn |= !model.is_certain();
        let (takes_s, failure) = model.drawn(&mut self.stream);
        let ends_us = now_us + (takes_s * 1e6) as u64;
        let failure = failure.map(str::to_string);
        self.under_way.insert(behaviour, UnderWay { ends_us, failure, sets });
    }
}

fn without_model(composition: &Composition<ProcessModules>, behaviour: u16) -> String {
    let name = &composition.tables.behaviours[usize::from(behaviour)].name;
    format!(
        "there is no model of what the behaviour `{name}` does, so no plan that needs it is projected; its module says \
         `takes` of it in its manifest"
    )
}

impl Foreseen for ForeseenModules {
    fn copied(&self) -> Box<dyn Foreseen> {
        Box::new(self.clone())
    }

    fn begin_run(&mut self, seed: u64) {
        self.stream = Stream::new(seed, "acts");
        for behaviour in self.begun.clone() {
            self.begin(behaviour, Vec::new(), self.now_us);
        }
    }

    fn unforeseen(&self) -> Option<&str> {
        self.unforeseen.as_deref()
    }

    fn has_drawn(&self) -> bool {
        self.has_drawn
    }
}

impl Outside for ForeseenModules {
    fn tables(&self) -> &RobotTables {
        &self.composition.tables
    }

    fn start(
        &mut self,
        machine: &Machine,
        behaviour: u16,
        arguments: &[(Symbol, Value)],
        _: &mut Outbox,
    ) -> Result<(), Raise> {
        let Some(model) = self.composition.models.get(&behaviour) else {
            let why = without_model(&self.composition, behaviour);
            self.unforeseen.get_or_insert_with(|| why.clone());
            return Err(Raise::new("projection-failure", why));
        };
        let sets = model.effects(self.tables(), machine, arguments);
        self.begin(behaviour, sets, machine.now_us);
        Ok(())
    }

    fn stop(&mut self, behaviour: u16, _: StopReason, _: &mut Outbox) {
        self.under_way.remove(&behaviour);
    }

    fn next_event_us(&self, _: u64) -> Option<u64> {
        Some(self.under_way.values().map(|act| act.ends_us).min().unwrap_or(NEVER_US))
    }

    fn step(&mut self, now_us: u64, _: Phases<'_>, outbox: &mut Outbox) {
        let ended: Vec<u16> =
            self.under_way.iter().filter(|(_, act)| act.ends_us <= now_us).map(|(&behaviour, _)| behaviour).collect();
        for behaviour in ended {
            let Some(UnderWay { failure, sets, .. }) = self.under_way.remove(&behaviour) else { continue };
            outbox.endings.push((
                behaviour,
                match failure {
                    Some(class) => Ending::failure(&class, "its module says that it fails at times"),
                    None => {
                        outbox.fluents.extend(sets);
                        Ending::DONE
                    }
                },
            ));
        }
    }

    fn part(&mut self, of: TypeId) -> Option<&mut dyn Any> {
        Module::part(&mut self.modules, of)
    }
}
