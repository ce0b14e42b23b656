//! What plans see of it: the only part of this crate that knows the runtime.
//!
//! Read in this order: `errand` (a route that is driven), `data` (routes as plans have them), `fluents` and
//! `functions` (what plans have of all that).

mod data;
mod errand;
mod fluents;
mod functions;

use crate::beginning::tuned_alone;
use crate::control::{BehaviourParameters, CaseDrive};
use crate::memory::{CaseMemory, CaseNumber, Retrieval};
use crate::places::Places;
use crate::routes::Route;
use crate::situation::{RecentSonars, Situation};
use data::stops_of;
use errand::Errand;
use rpl_robot::geometry::Velocity;
use rpl_robot::office::{
    Commands, Module, ModuleSpec, Moment, OfficeModel, Phase, PlanText, Position, Raise, Start, StopReason, Telling,
    TravelMode,
};
use rpl_runtime::robot::{BehaviourSpec, Ending};
use rpl_runtime::state::value::Value;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::sync::Arc;

/// The plans that belong to it.
pub const PLANS: &str = include_str!("../../plans/cases.rpl");

/// Without getting nearer to its short-term goal for so long, it gives up, if it is told nothing else.
const PATIENCE_S: f64 = 30.0;

/// What can be set about it before a run.
#[derive(Clone, Debug, PartialEq)]
pub struct RupartSettings {
    /// What it remembers at the start; without, one behaviour case of tuned parameters.
    pub memory: Option<CaseMemory>,
    /// Whether the control brakes before what it hears.
    pub is_braked: bool,
}

impl Default for RupartSettings {
    fn default() -> Self {
        Self { memory: None, is_braked: true }
    }
}

/// The state of driving by cases. As long as no plan uses it, it does nothing and tells nothing.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Rupart {
    /// Those of the world, looked up when they are first needed.
    #[serde(skip)]
    places: Option<Arc<Places>>,
    memory: CaseMemory,
    drive: CaseDrive,
    recent: RecentSonars,
    /// The route that is driven.
    errand: Option<Errand>,
    /// The last route that was driven to its end, with the times it took.
    driven: Option<Route>,
    /// The behaviour case it drives by, since a plan has said so.
    used: Option<CaseNumber>,
    /// What was found last.
    retrieval: Option<Retrieval>,
    /// Whether something has changed since plans were told.
    has_news: bool,
}

/// What an experimenter sees of it.
impl Rupart {
    /// What it remembers.
    pub fn memory(&self) -> &CaseMemory {
        &self.memory
    }

    /// The places of the world.
    ///
    /// # Errors
    /// It has none, or the robot has no map.
    fn places(&mut self, model: &OfficeModel) -> Result<Arc<Places>, Raise> {
        if model.map.is_none() {
            let message =
                "the robot has no map, and routes lead over places of a map; run the plan without `--map none`";
            return Err(Raise::new("unreachable", message));
        }
        if let Some(places) = &self.places {
            return Ok(places.clone());
        }
        let places = Places::new(&model.world, model.limits.robot_radius_m);
        let places = Arc::new(places.map_err(|none| Raise::new("unreachable", none.to_string()))?);
        self.places = Some(places.clone());
        Ok(places)
    }

    /// The behaviour case in use has brought the robot to its short-term goal, or not.
    fn note_use(&mut self, succeeded: bool) {
        if let Some(number) = self.used {
            self.memory.change(number, |case| case.counts.note(succeeded));
        }
    }

    /// What a case is looked for by.
    fn situation(&self, model: &OfficeModel, position: &Position, now: Option<Velocity>) -> Situation {
        let errand = self.errand.as_ref();
        let situation = Situation {
            sonars_m: self.recent.last_m(),
            mean_sonars_m: self.recent.mean_m(),
            translation_mps: now.map(|velocity| velocity.translation_mps),
            rotation_radps: now.map(|velocity| velocity.rotation_radps),
            short_term_goal_in_map: errand.and_then(Errand::next_in_map),
            long_term_goal_in_map: errand.and_then(Errand::last_in_map),
            ..Situation::default()
        };
        situation.seen_from(position.estimate(model.map.as_ref()).pose_in_map)
    }
}

impl Module for Rupart {
    type Settings = RupartSettings;

    fn specs(_: &RupartSettings) -> Vec<ModuleSpec> {
        vec![ModuleSpec {
            name: "rupart".into(),
            behaviours: vec![BehaviourSpec {
                name: Cow::Borrowed("case-navigation"),
                doc: Cow::Borrowed(
                    "Drives along `:route`, a list of places and points (x y), each in sight of the one before, by the behaviours that the last `use-case` has set. Fails with blocked if for the time of `:patience`, without it 30 s, it gets no nearer to the next of them.",
                ),
                valve: Some(Cow::Borrowed("wheels")),
                parameters: Cow::Borrowed(":route :patience"),
            }],
            fluents: fluents::FLUENTS.to_vec(),
            functions: functions::functions(),
            plans: vec![PlanText { name: "cases".into(), text: PLANS.into() }],
            ..ModuleSpec::default()
        }]
    }

    fn new(settings: &RupartSettings, model: &OfficeModel, _: u64) -> Self {
        Self {
            places: None,
            memory: settings.memory.clone().unwrap_or_else(|| tuned_alone(&model.world, &model.sensors)),
            drive: CaseDrive::new(BehaviourParameters::TUNED, settings.is_braked),
            recent: RecentSonars::default(),
            errand: None,
            driven: None,
            used: None,
            retrieval: None,
            has_news: false,
        }
    }

    fn start(&mut self, _: usize, start: &Start<'_>, _: &mut Position, _: &mut Telling<'_>) -> Result<(), Raise> {
        if start.model.sensors.sonars.is_none() {
            let robot = &start.model.settings.robot.name;
            let message = format!("the robot `{robot}` has no sonars, by which cases are found; try pioneer-2dx");
            return Err(Raise::new("unreachable", message));
        }
        let places = self.places(start.model)?;
        let stops = stops_of(start.machine, start.argument("route").unwrap_or(Value::Nil), &places)?;
        let patience_s = match start.argument("patience").unwrap_or(Value::Nil) {
            Value::Nil => PATIENCE_S,
            value => value.as_f64().filter(|patience_s| *patience_s >= 0.0).ok_or_else(|| {
                Raise::type_error("`:patience` takes a time in seconds, at least 0, such as `:patience 2min`")
            })?,
        };
        self.errand = Some(Errand::begin(Route::new(stops), &places, patience_s));
        self.drive.begin_goal();
        self.has_news = true;
        Ok(())
    }

    fn stop(&mut self, _: usize, _: StopReason, _: &mut Telling<'_>) {
        self.errand = None;
        self.has_news = true;
    }

    /// What it keeps off it must hear, in doorways too.
    fn command(&mut self, _: TravelMode, phases: &[Phase], commands: &mut Commands) {
        commands.sonars_on |= phases.contains(&Phase::Active);
    }

    fn step(&mut self, now: &Moment<'_>, position: &mut Position, tell: &mut Telling<'_>) -> Option<Velocity> {
        if !now.phases.contains(&Phase::Active) {
            return None;
        }
        let readings = now.percept.sonar_m.iter().flatten().map(|&range_m| Some(f64::from(range_m)));
        self.recent.hear(&readings.collect::<Vec<_>>());
        let errand = self.errand.as_mut()?;
        let estimated_in_map = position.estimate(now.model.map.as_ref()).pose_in_map;
        let step = errand.step(&mut self.drive, now, estimated_in_map);
        self.has_news |= step.has_news;
        if step.has_news || step.ending.is_some() {
            self.note_use(step.has_news);
        }
        let Some(ending) = step.ending else { return Some(step.velocity) };
        let errand = self.errand.take()?;
        if ending == Ending::Success {
            self.driven = Some(errand.route);
        }
        self.has_news = true;
        tell.end(0, ending);
        Some(Velocity::default())
    }

    fn publish(&mut self, now: &Moment<'_>, _: &Position, tell: &mut Telling<'_>) {
        let is_at_work = now.phases.contains(&Phase::Active);
        if std::mem::take(&mut self.has_news) || is_at_work {
            self.tell(tell);
        }
    }
}
