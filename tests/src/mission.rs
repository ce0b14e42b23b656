//! A plan on the office robot: library, world, scenario and seed put together.

use crate::{detail, outcome_text, output_text};
use rpl_lang::compile::NoFiles;
use rpl_mission::libraries;
use rpl_mission::modules::{SiteModules, SiteRobot, own_modules};
use rpl_mission::run::{Reached, fluent_value, run_to, silence_continuous_fluents};
use rpl_mission::site::Site;
use rpl_robot::localization::LocalizationParameters;
use rpl_robot::office::{AbstractSetting, AbstractWorld, OfficeModel, OfficeSettings};
use rpl_robot::world::World;
use rpl_runtime::run::library::{Library, Loaded};
use rpl_runtime::run::system::System;
use rpl_runtime::state::trace::{Event, EventKind};
use std::ops::ControlFlow;
use std::sync::{Arc, OnceLock};

/// How fine the grid of the belief is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grid {
    /// 30 cm and 6°: a step takes little time.
    Coarse,
    /// 15 cm and 2°, as users have it.
    Full,
}

impl Grid {
    /// Settings of a robot with this grid.
    pub fn settings(self) -> OfficeSettings {
        let localization = match self {
            Grid::Coarse => LocalizationParameters::coarse(),
            Grid::Full => LocalizationParameters::default(),
        };
        OfficeSettings { localization, ..OfficeSettings::default() }
    }
}

/// The models of a world.
pub fn model(world: World, settings: OfficeSettings) -> Arc<OfficeModel> {
    let name = world.name.clone();
    let model = OfficeModel::new(world, settings);
    Arc::new(model.unwrap_or_else(|error| panic!("the world `{name}` has no models: {error}")))
}

/// The models of a built-in world.
pub fn builtin(name: &str, grid: Grid) -> Arc<OfficeModel> {
    let world = World::builtin(name).unwrap_or_else(|| panic!("there is no built-in world `{name}`"));
    model(world, grid.settings())
}

/// The department on the coarse grid, built once.
pub fn dept() -> Arc<OfficeModel> {
    static MODEL: OnceLock<Arc<OfficeModel>> = OnceLock::new();
    MODEL.get_or_init(|| builtin("dept", Grid::Coarse)).clone()
}

/// Two small rooms on the coarse grid, built once.
pub fn test_room() -> Arc<OfficeModel> {
    static MODEL: OnceLock<Arc<OfficeModel>> = OnceLock::new();
    MODEL.get_or_init(|| builtin("test-room", Grid::Coarse)).clone()
}

/// What plans can call on a robot, compiled once.
pub fn robot_library() -> Arc<Library> {
    static LIBRARY: OnceLock<Arc<Library>> = OnceLock::new();
    let compile = || libraries::robot_library(own_modules(), Vec::new()).unwrap_or_else(|error| panic!("{error}"));
    LIBRARY.get_or_init(compile).clone()
}

/// A run of a plan in the abstract world of a map, traced, from the seed 1 to its end, which it comes to within an hour.
pub fn in_abstract_world(
    model: Arc<OfficeModel>,
    setting: AbstractSetting,
    plan: &str,
) -> System<AbstractWorld<SiteModules>> {
    let site = Site::of(robot_library(), model, own_modules().clone());
    let loaded = site.compile("plan.rpl", plan, &mut NoFiles).unwrap_or_else(|error| panic!("{error}"));
    let robot = site.office_robot(1).expect("there is a world");
    let world = robot.abstract_world(setting, 1).unwrap_or_else(|_| panic!("there is a map"));
    let mut system = System::traced(site.library.clone(), loaded, world, 1);
    match run_to(&mut system, 3_600_000_000, |_| ControlFlow::Continue(())) {
        Reached::End(_) => system,
        other => panic!("{other:?}"),
    }
}

/// A plan, the world it runs in, and the experimenter's plan beside it.
#[derive(Clone)]
pub struct Mission {
    /// The plan, compiled.
    pub plan: Loaded,
    site: Site<SiteModules>,
}

impl Mission {
    /// A plan in a world.
    pub fn new(model: Arc<OfficeModel>, plan: &str) -> Self {
        let site = Site::of(robot_library(), model, own_modules().clone());
        let plan = site.compile("plan.rpl", plan, &mut NoFiles);
        Self { plan: plan.unwrap_or_else(|error| panic!("{error}")), site }
    }

    /// With a scenario beside it.
    #[must_use]
    pub fn with_scenario(mut self, text: &str) -> Self {
        let site = self.site.with_scenario("scenario.rpl", text, &mut NoFiles);
        self.site = site.unwrap_or_else(|error| panic!("{error}"));
        self
    }

    /// The robot at the start.
    pub fn robot(&self, seed: u64) -> SiteRobot {
        let Some(robot) = self.site.office_robot(seed) else { panic!("a world has a robot") };
        robot
    }

    /// The run at its start, with its trace switched on.
    pub fn start(&self, seed: u64) -> System<SiteRobot> {
        self.start_with(self.robot(seed), seed)
    }

    /// The run at its start, with a robot that was changed.
    pub fn start_with(&self, robot: SiteRobot, seed: u64) -> System<SiteRobot> {
        let mut system = System::new(robot_library(), self.plan.clone(), robot, seed);
        system.machine.trace.enabled = true;
        silence_continuous_fluents(&mut system);
        system
    }

    /// A run read back from its saved bytes, as another process would.
    pub fn load(&self, bytes: &[u8], seed: u64) -> System<SiteRobot> {
        match System::load(bytes, robot_library(), self.plan.clone(), self.robot(seed)) {
            Ok(system) => system,
            Err(error) => panic!("{error}"),
        }
    }

    /// Runs to the end, or to a time.
    pub fn run(&self, seed: u64, until_s: f64) -> Run {
        let mut system = self.start(seed);
        system.run_until((until_s * 1e6) as u64);
        Run::of(system)
    }
}

/// The value of a robot's fluent, as it could be read.
pub fn fluent_text(system: &System<SiteRobot>, name: &str) -> String {
    match fluent_value(system, name) {
        Some(value) => system.machine.write(&system.program, value),
        None => panic!("there is no fluent `{name}`"),
    }
}

/// Goes on until something is true of the run, or it ends; tells whether it became true.
pub fn run_until(
    system: &mut System<SiteRobot>,
    until_s: f64,
    mut stop: impl FnMut(&mut System<SiteRobot>) -> bool,
) -> bool {
    let mut is_met = false;
    let reached = run_to(system, (until_s * 1e6) as u64, |system| {
        is_met = stop(system);
        if is_met { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    match reached {
        Reached::Stop => true,
        Reached::End(_) => is_met,
        Reached::Time => false,
    }
}

/// What came of a run.
pub struct Run {
    /// The run as it stands.
    pub system: System<SiteRobot>,
    /// Its trace.
    pub events: Vec<Event>,
    /// What it printed and logged.
    pub output: Vec<String>,
}

impl Run {
    /// Takes trace and output out of a run.
    pub fn of(mut system: System<SiteRobot>) -> Self {
        let events = system.machine.trace.take();
        let output = std::mem::take(&mut system.machine.output).into_iter().map(output_text).collect();
        Self { system, events, output }
    }

    /// Its value or failure, in one line.
    pub fn outcome(&self) -> String {
        outcome_text(&self.system)
    }

    /// The trace, one event a line.
    pub fn trace(&self) -> String {
        lines(&self.events)
    }

    /// The place in the trace, from an event on, of the next one for which this holds.
    ///
    /// # Panics
    /// If there is none: the message tells what was looked for and what is there.
    pub fn find(&self, from: usize, what: &str, mut holds: impl FnMut(&Event) -> bool) -> usize {
        let found = self.events[from.min(self.events.len())..].iter().position(&mut holds);
        match found {
            Some(offset) => from + offset,
            None => {
                let rest = lines(&self.events[from.min(self.events.len())..]);
                let rest: String = rest.chars().take(20_000).collect();
                panic!("{what} is not in the trace after event {from}; {}\n{rest}", self.outcome())
            }
        }
    }

    /// How many events are like this.
    pub fn count(&self, mut holds: impl FnMut(&Event) -> bool) -> usize {
        self.events.iter().filter(|event| holds(event)).count()
    }
}

/// Events as text, one a line.
pub fn lines(events: &[Event]) -> String {
    events.iter().map(|event| format!("{event}\n")).collect()
}

/// Whether an event is of a kind and has these details.
pub fn is(event: &Event, kind: EventKind, details: &[(&str, &str)]) -> bool {
    event.kind == kind && details.iter().all(|(name, value)| detail(event, name) == *value)
}
