//! What plans see of it: the only part of this crate that knows the runtime.
//!
//! Read in this order: `errand` (a route that is driven), `landmarks` (what is seen on the way), `data` (routes as
//! plans have them), `state`, `fluents`, `functions` and `goals` (what plans have of all that).

mod data;
mod errand;
mod fluents;
mod functions;
mod goals;
mod landmarks;
mod state;

pub use state::Rupart;

use crate::beginning::first_cases;
use crate::control::{BLOCKED_S, BehaviourParameters, CaseDrive, DriveEvent};
use crate::memory::CaseMemory;
use crate::route::Route;
use crate::routes::Blockage;
use crate::situation::RecentSonars;
use data::stops_of;
use errand::Errand;
use landmarks::{Looking, can_look};
use rpl_robot::geometry::Velocity;
use rpl_robot::office::{
    Commands, Module, ModuleSpec, Moment, OfficeModel, Phase, PlanText, Position, Raise, Start, StopReason, Telling,
    TravelMode,
};
use rpl_runtime::robot::{BehaviourSpec, Ending};
use rpl_runtime::state::value::Value;
use state::{CASE_NAVIGATION, LANDMARK_LOCALIZATION, Seen};
use std::borrow::Cow;

/// The plans that belong to it.
pub const PLANS: &str = include_str!("../../plans/cases.rpl");

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

impl Module for Rupart {
    type Settings = RupartSettings;

    fn specs(_: &RupartSettings) -> Vec<ModuleSpec> {
        vec![ModuleSpec {
            name: "rupart".into(),
            behaviours: vec![
                BehaviourSpec {
                    name: Cow::Borrowed("case-navigation"),
                    doc: Cow::Borrowed(
                        "Drives along `:route`, a list of places and points (x y), each in sight of the one before, by the behaviours that the last `use-case` has set. Fails with blocked if for the time of `:patience`, without it 30 s, it gets no nearer to the next of them, and with unexpected-landmark if `landmark-localization` finds that the robot is elsewhere.",
                    ),
                    valve: Some(Cow::Borrowed("wheels")),
                    parameters: Cow::Borrowed(":route :patience"),
                },
                BehaviourSpec {
                    name: Cow::Borrowed("landmark-localization"),
                    doc: Cow::Borrowed(
                        "Looks for the landmarks of the world with the camera, keeps in view what it finds, and localizes by it. Needs no valve, and never ends by itself.",
                    ),
                    valve: None,
                    parameters: Cow::Borrowed(""),
                },
            ],
            fluents: fluents::FLUENTS.to_vec(),
            functions: functions::functions().into_iter().chain(goals::functions()).collect(),
            plans: vec![PlanText { name: "cases".into(), text: PLANS.into() }],
            ..ModuleSpec::default()
        }]
    }

    fn new(settings: &RupartSettings, model: &OfficeModel, _: u64) -> Self {
        Self {
            places: None,
            memory: settings.memory.clone().unwrap_or_else(|| first_cases(&model.world, &model.sensors)),
            drive: CaseDrive::new(BehaviourParameters::TUNED, settings.is_braked),
            recent: RecentSonars::default(),
            errand: None,
            blockage: Blockage::default(),
            made: None,
            driven: None,
            used: None,
            retrieval: None,
            looking: Looking::default(),
            has_news: false,
        }
    }

    fn start(
        &mut self,
        behaviour: usize,
        start: &Start<'_>,
        _: &mut Position,
        _: &mut Telling<'_>,
    ) -> Result<(), Raise> {
        if behaviour == LANDMARK_LOCALIZATION {
            return can_look(start.model);
        }
        if start.model.sensors.sonars.is_none() {
            let robot = &start.model.settings.robot.name;
            let message = format!("the robot `{robot}` has no sonars, by which cases are found; try pioneer-2dx");
            return Err(Raise::new("unreachable", message));
        }
        let places = self.places(start.model)?;
        let stops = stops_of(start.machine, start.argument("route").unwrap_or(Value::Nil), &places)?;
        let patience_s = match start.argument("patience").unwrap_or(Value::Nil) {
            Value::Nil => BLOCKED_S,
            value => value.as_f64().filter(|patience_s| *patience_s >= 0.0).ok_or_else(|| {
                Raise::type_error("`:patience` takes a time in seconds, at least 0, such as `:patience 2min`")
            })?,
        };
        let made = self.made.take().filter(|made| made.stops == stops);
        self.errand = Some(Errand::begin(Route::new(stops), made, &places, patience_s));
        self.driven = None;
        self.drive.begin_goal();
        self.has_news = true;
        Ok(())
    }

    fn stop(&mut self, behaviour: usize, _: StopReason, _: &mut Telling<'_>) {
        if behaviour == CASE_NAVIGATION {
            self.errand = None;
        } else {
            self.looking.end();
        }
        self.has_news = true;
    }

    /// What it keeps off it must hear, in doorways too.
    fn command(&mut self, _: TravelMode, phases: &[Phase], commands: &mut Commands) {
        commands.sonars_on |= phases[CASE_NAVIGATION] == Phase::Active;
        if phases[LANDMARK_LOCALIZATION] == Phase::Active {
            commands.camera = Some(self.looking.command());
        }
    }

    fn step(&mut self, now: &Moment<'_>, position: &mut Position, tell: &mut Telling<'_>) -> Option<Velocity> {
        let is_driving = now.phases[CASE_NAVIGATION] == Phase::Active;
        let mut is_elsewhere = false;
        if now.phases[LANDMARK_LOCALIZATION] == Phase::Active {
            let before = self.looking.in_view(now.model).map(|landmark| &landmark.name);
            is_elsewhere = self.looking.take_in(now, position, &mut self.drive, is_driving);
            self.has_news |= before != self.looking.in_view(now.model).map(|landmark| &landmark.name);
        }
        if !is_driving {
            return None;
        }
        let readings = now.percept.sonar_m.iter().flatten().map(|&range_m| Some(f64::from(range_m)));
        self.recent.hear(&readings.collect::<Vec<_>>());
        let places = self.places(now.model).ok()?;
        let errand = self.errand.as_mut()?;
        let estimated_in_map = position.estimate(now.model.map.as_ref()).pose_in_map;
        let step = errand.step(&mut self.drive, now, estimated_in_map, &places);
        if let Some(DriveEvent::Localized(fix)) = &step.event {
            is_elsewhere |= self.looking.localized(now.model, position, fix);
        }
        if step.ending.as_ref().is_some_and(|ending| *ending != Ending::DONE) {
            self.note_blocked(now, &Seen::of(now.model, position, Some(now.percept)), &places);
        }
        self.go_on(step, is_elsewhere, tell)
    }

    fn publish(&mut self, now: &Moment<'_>, _: &Position, tell: &mut Telling<'_>) {
        let is_at_work = now.phases[CASE_NAVIGATION] == Phase::Active;
        if std::mem::take(&mut self.has_news) || is_at_work {
            self.tell(now.model, tell);
        }
    }
}
