//! Everything that is the same in all runs of a mission: what plans can call, the world, and what
//! happens there.

use crate::cost::{MEMORY_GIB, TooLarge};
use crate::error::SiteError;
use crate::foreign_modules::{alone, composed};
use crate::libraries::{modules_library, robot_library, robotless_library, scenario_library};
use crate::modules::{SiteModules, own_modules};
use crate::robot::Robot;
use crate::run::silence_continuous_fluents;
use crate::scenario::Scenario;
use rpl_lang::compile::Loader;
use rpl_protocol::module::modules_alone::{ModulesAlone, PERIOD_US};
use rpl_protocol::module::process_modules::{ModuleSource, ProcessModules};
use rpl_protocol::remote_host::RemoteHost;
use rpl_robot::office::{Composition, Module, OfficeModel, OfficeRobot, OfficeSettings, SimulatedHost};
use rpl_robot::world::World;
use rpl_runtime::robot::NoRobot;
use rpl_runtime::run::library::{Library, Loaded, Rejected};
use rpl_runtime::run::system::System;
use rpl_runtime::step::native::Native;
use rpl_rupart::RupartSettings;
use std::sync::Arc;

/// What a site is made of.
#[derive(Clone)]
pub struct Setup {
    /// The world the robot is in; a site without a robot has none.
    pub world: Option<World>,
    /// Robot, simulator and filters.
    pub settings: OfficeSettings,
    /// The memory that the models of the world may take.
    pub memory_gib: f64,
    /// Functions of the embedding program that plans can call, beside all others.
    pub natives: Vec<Native>,
    /// What it remembers at the start of driving by cases, and how it drives by them.
    pub rupart: RupartSettings,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            world: None,
            settings: OfficeSettings::default(),
            memory_gib: MEMORY_GIB,
            natives: Vec::new(),
            rupart: RupartSettings::default(),
        }
    }
}

/// Everything that is the same in all runs of a mission. A copy shares what was built.
#[derive(Clone)]
pub struct Site<M: Module = SiteModules> {
    /// What plans can call here.
    pub library: Arc<Library>,
    modules: Arc<Composition<M>>,
    premises: Premises,
}

/// Where the plans of a site run.
#[derive(Clone)]
enum Premises {
    /// There is no robot, and plans cannot name one.
    Robotless,
    /// Plans can name a robot, and there is none.
    Unbuilt,
    /// There are modules in other processes and no robot.
    Modules(Arc<Composition<ProcessModules>>),
    /// The robot is in a world.
    Office { model: Arc<OfficeModel>, scenario: Option<Scenario> },
}

impl Site {
    /// A site with the office robot in a world; without a world it is one without a robot. Cost: that of
    /// the world's models, which [`crate::cost::LargeWorld`] knows beforehand.
    ///
    /// # Errors
    /// The world is too large or cannot be localized in, the robot has no room at its start, or a native
    /// function has a name that is taken.
    pub fn new(setup: Setup) -> Result<Self, SiteError> {
        Self::with_processes(setup, Vec::new())
    }

    /// The same with modules in other processes, beside those of the office robot or, without a world, alone.
    ///
    /// # Errors
    /// As for [`Site::new`]; names of the modules are taken, their plans have faults, or one needs a robot and there is
    /// none.
    pub fn with_processes(setup: Setup, sources: Vec<ModuleSource>) -> Result<Self, SiteError> {
        if sources.is_empty() {
            return Self::with_modules(setup.clone(), composed(setup.rupart, sources)?);
        }
        let (has_world, known) = (setup.world.is_some(), sources.clone());
        let site = match has_world {
            true => Self::with_modules(setup.clone(), composed(setup.rupart, sources)?),
            false => Self::of_modules(alone(sources)?, setup.natives),
        };
        site.map_err(|error| match error {
            SiteError::Prelude(_) if !has_world && Self::for_checking(known).is_ok() => {
                SiteError::ModuleWithoutRobot("the plans of a module need a robot".to_string())
            }
            SiteError::Prelude(rejected) => SiteError::ModulePlans(rejected),
            other => other,
        })
    }

    fn of_modules(alone: Arc<Composition<ProcessModules>>, natives: Vec<Native>) -> Result<Self, SiteError> {
        let library = modules_library(&alone, natives)?;
        Ok(Self { library, modules: own_modules().clone(), premises: Premises::Modules(alone) })
    }

    /// A site without a robot.
    ///
    /// # Errors
    /// The prelude does not compile.
    pub fn without_robot() -> Result<Self, SiteError> {
        Self::robotless(own_modules().clone(), Vec::new())
    }

    /// A site with what plans can call on a robot with these modules in other processes, but with no world to
    /// run them in.
    ///
    /// # Errors
    /// As for [`Site::with_processes`].
    pub fn for_checking(sources: Vec<ModuleSource>) -> Result<Self, SiteError> {
        let modules = composed(RupartSettings::default(), sources)?;
        Ok(Self { library: robot_library(&modules, Vec::new())?, modules, premises: Premises::Unbuilt })
    }

    /// The sites that a plan may be for where no world is named, with these modules in other processes: one without a
    /// robot, unless a module needs one, and one for checking.
    ///
    /// # Errors
    /// As for [`Site::with_processes`].
    pub fn without_world(sources: Vec<ModuleSource>) -> Result<Vec<Self>, SiteError> {
        let checking = Self::for_checking(sources.clone());
        match Self::with_processes(Setup::default(), sources) {
            // On our robot their names may be taken, and then no plan with them is for it.
            Ok(site) => Ok([Ok(site), checking].into_iter().flatten().collect()),
            Err(SiteError::ModuleWithoutRobot(_)) => Ok(vec![checking?]),
            Err(other) => Err(other),
        }
    }

    /// A site with what scenarios can call, but with no world to meddle with.
    ///
    /// # Errors
    /// The prelude does not compile.
    pub fn for_checking_scenarios() -> Result<Self, SiteError> {
        let modules = own_modules().clone();
        Ok(Self { library: scenario_library()?, modules, premises: Premises::Unbuilt })
    }
}

impl<M: Module> Site<M> {
    /// A site of a library that [`robot_library`] has made for these modules, and of the models of a world: who
    /// runs in many worlds, or one world in many ways, builds each of them once.
    pub fn of(library: Arc<Library>, model: Arc<OfficeModel>, modules: Arc<Composition<M>>) -> Self {
        Self { library, modules, premises: Premises::Office { model, scenario: None } }
    }

    fn robotless(modules: Arc<Composition<M>>, natives: Vec<Native>) -> Result<Self, SiteError> {
        Ok(Self { library: robotless_library(&modules, natives)?, modules, premises: Premises::Robotless })
    }

    /// A site whose robot has these modules, with the settings that they have already.
    ///
    /// # Errors
    /// As for [`Site::new`].
    pub fn with_modules(setup: Setup, modules: Arc<Composition<M>>) -> Result<Self, SiteError> {
        let Setup { world, settings, memory_gib, natives, rupart: _ } = setup;
        let Some(world) = world else {
            return Self::robotless(modules, natives);
        };
        if let Some(too_large) = TooLarge::of(&world, &settings, memory_gib) {
            return Err(Box::new(too_large).into());
        }
        let name = world.name.clone();
        if let Err(source) = world.room_at_start(settings.robot.radius_m) {
            return Err(SiteError::NoRoom { world: name, source });
        }
        let model = OfficeModel::new(world, settings).map_err(|source| SiteError::Unfit { world: name, source })?;
        let premises = Premises::Office { model: Arc::new(model), scenario: None };
        Ok(Self { library: robot_library(&modules, natives)?, modules, premises })
    }

    /// The same place with another scenario: the experimenter's plan, which runs beside the plans and
    /// can meddle with the world. The loader finds the texts it loads.
    ///
    /// ```
    /// # use rpl_lang::compile::NoFiles;
    /// # use rpl_mission::run::run_to;
    /// # use rpl_mission::site::{Setup, Site};
    /// # use rpl_robot::world::World;
    /// # use std::ops::ControlFlow::Continue;
    /// let site = Site::new(Setup { world: World::builtin("test-room"), ..Setup::default() })?
    ///     .with_scenario("turn.rpl", "(wait-time 2) (rotate-robot! 90deg)", &mut NoFiles)?;
    /// let mut run = site.start_traced(site.compile("plan.rpl", "(wait-time 4)", &mut NoFiles)?, 1);
    /// run_to(&mut run, 10_000_000, |_| Continue(()));
    /// let events = run.machine.trace.take();
    /// assert!(events.iter().any(|event| event.to_string().contains("rotated by hand")));
    /// # Ok::<(), rpl_mission::error::SiteError>(())
    /// ```
    ///
    /// # Errors
    /// There is no robot, or the scenario's text is wrong.
    pub fn with_scenario(&self, name: &str, text: &str, loader: &mut dyn Loader) -> Result<Self, SiteError> {
        let Premises::Office { model, .. } = &self.premises else {
            return Err(SiteError::ScenarioWithoutRobot(name.to_string()));
        };
        let scenario = Some(Scenario::compile(name, text, loader)?);
        let premises = Premises::Office { model: model.clone(), scenario };
        Ok(Self { library: self.library.clone(), modules: self.modules.clone(), premises })
    }

    /// Whether plans can name a robot here, and there is none.
    pub fn lacks_world(&self) -> bool {
        matches!(self.premises, Premises::Unbuilt)
    }

    /// What was built from the world, if there is one.
    pub fn office(&self) -> Option<&Arc<OfficeModel>> {
        match &self.premises {
            Premises::Office { model, .. } => Some(model),
            Premises::Robotless | Premises::Unbuilt | Premises::Modules(_) => None,
        }
    }

    /// Microseconds between two steps of what is outside of a run; none if there is nothing.
    pub fn period_us(&self) -> Option<u64> {
        match &self.premises {
            Premises::Office { model, .. } => Some(model.settings.robot.step_us),
            Premises::Modules(_) => Some(PERIOD_US),
            Premises::Robotless | Premises::Unbuilt => None,
        }
    }

    /// Whether time has to pass as it does on the clock: there is no world of ours, and a module does not wait for the
    /// run.
    pub fn goes_by_clock(&self) -> bool {
        matches!(&self.premises, Premises::Modules(modules) if modules.settings.are_live())
    }

    /// Compiles a plan; the loader finds the texts it loads.
    ///
    /// # Errors
    /// All findings in its text.
    pub fn compile(&self, name: &str, text: &str, loader: &mut dyn Loader) -> Result<Loaded, SiteError> {
        self.library.load(name, text, loader).map_err(SiteError::Plan)
    }

    /// The simulated robot in its world at the start of a run, if there is one. Everything that it leaves to
    /// chance follows from the seed.
    pub fn office_robot(&self, seed: u64) -> Option<OfficeRobot<SimulatedHost, M>> {
        let Premises::Office { model, scenario } = &self.premises else { return None };
        let scenario = scenario.as_ref().map(|scenario| scenario.start(model, seed));
        self.robot_on(SimulatedHost::new(model.simulator.clone(), seed, scenario), seed)
    }

    /// The robot at the start of a run, moved by a host of your own, if there is a robot here.
    pub fn robot_on<H>(&self, host: H, seed: u64) -> Option<OfficeRobot<H, M>> {
        let Premises::Office { model, .. } = &self.premises else { return None };
        Some(OfficeRobot::with_modules(self.modules.clone(), model.clone(), host, seed))
    }

    /// The robot at the start of a run, if there is one; or the modules that stand for it.
    pub fn robot(&self, seed: u64) -> Robot<M> {
        if let Premises::Modules(modules) = &self.premises {
            return Robot::Modules(Box::new(ModulesAlone::new(modules.clone(), seed)));
        }
        match self.office_robot(seed) {
            Some(robot) => Robot::Office(Box::new(robot)),
            None => Robot::Absent(NoRobot),
        }
    }

    /// The same robot, moved by a host in another process; none without a world. If the host does not know
    /// that the robot stands where the world says it starts, the robot is not told where it is.
    pub fn robot_of(&self, host: RemoteHost, start_known: bool, seed: u64) -> Option<Robot<M>> {
        let mut robot = self.robot_on(host, seed)?;
        if !start_known {
            robot.forget_position();
        }
        Some(Robot::Remote(Box::new(robot)))
    }

    /// A run of a plan at its start, which keeps no trace. The same plan and seed give the same run.
    pub fn start(&self, plan: Loaded, seed: u64) -> System<Robot<M>> {
        System::new(self.library.clone(), plan, self.robot(seed), seed)
    }

    /// The same run with its trace from the first event on, but for the fluents that change in every
    /// step ([`rpl_runtime::robot::FluentSpec::continuous`]). Who goes on with it takes the events out.
    pub fn start_traced(&self, plan: Loaded, seed: u64) -> System<Robot<M>> {
        self.start_traced_with(self.robot(seed), plan, seed)
    }

    /// The same with a robot that was changed, such as one that starts elsewhere.
    pub fn start_traced_with(&self, robot: Robot<M>, plan: Loaded, seed: u64) -> System<Robot<M>> {
        let mut system = System::traced(self.library.clone(), plan, robot, seed);
        silence_continuous_fluents(&mut system);
        system
    }

    /// A run with a robot of this site, whose main task waits for forms ([`rpl_runtime::run::session`]).
    ///
    /// # Errors
    /// The session's own text does not compile.
    pub fn session(&self, robot: Robot<M>, seed: u64) -> Result<System<Robot<M>>, Rejected> {
        let mut system = System::session(&self.library, robot, seed)?;
        silence_continuous_fluents(&mut system);
        Ok(system)
    }
}
