//! What plans see of it: the only part of this crate that knows the runtime.
//!
//! Read in this order: `errand` (a route that is driven), `landmarks` (what is seen on the way), `data` (routes as
//! plans have them), `fluents`, `functions` and `goals` (what plans have of all that).

mod data;
mod errand;
mod fluents;
mod functions;
mod goals;
mod landmarks;

use crate::beginning::{first_cases, to_be_trained};
use crate::case::Kind;
use crate::control::{BLOCKED_S, BehaviourParameters, CaseDrive, DriveEvent};
use crate::forgetting::{Capacity, forget_beyond};
use crate::memory::{CaseMemory, CaseNumber, Retrieval};
use crate::places::Places;
use crate::routes::{Blockage, BlockedAt, Route, TravelTimes, learn_route, learn_times};
use crate::situation::{RecentSonars, Situation};
use data::stops_of;
use errand::{Errand, ErrandStep, Made};
use landmarks::{Looking, can_look};
use rpl_robot::geometry::{Pose, Velocity};
use rpl_robot::office::{
    Commands, Module, ModuleSpec, Moment, OfficeModel, Phase, PlanText, Position, Raise, Start, StopReason, Telling,
    TravelMode,
};
use rpl_robot::simulator::Percept;
use rpl_runtime::robot::{BehaviourSpec, Ending};
use rpl_runtime::state::value::Value;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::sync::Arc;

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

/// A route that was driven to its end.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Driven {
    /// With the times it took.
    route: Route,
    /// How it was made, if it is one that was.
    made: Option<Made>,
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
    /// What has blocked it.
    blockage: Blockage,
    /// The route that was made last.
    made: Option<Made>,
    /// The route that was driven last, with the times it took, if it was driven to its end.
    driven: Option<Driven>,
    /// The behaviour case it drives by, since a plan has said so.
    used: Option<CaseNumber>,
    /// What was found last.
    retrieval: Option<Retrieval>,
    /// What it knows of landmarks.
    looking: Looking,
    /// Whether something has changed since plans were told.
    has_news: bool,
}

/// The places of its behaviours.
const CASE_NAVIGATION: usize = 0;
const LANDMARK_LOCALIZATION: usize = 1;

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

    /// The errand has made a step. An unexpected landmark erases its route.
    fn go_on(&mut self, step: ErrandStep, is_elsewhere: bool, tell: &mut Telling<'_>) -> Option<Velocity> {
        self.has_news |= step.has_news;
        if step.has_news || step.ending.is_some() {
            self.note_use(step.has_news);
        }
        let erased = is_elsewhere.then(|| {
            Ending::failure("unexpected-landmark", "a landmark says that the robot is not where its route leads")
        });
        let has_arrived = step.ending.as_ref().map(|ending| *ending == Ending::Success);
        let Some(ending) = step.ending.or(erased) else { return Some(step.velocity) };
        let errand = self.errand.take()?;
        if let Some(has_arrived) = has_arrived {
            self.note_route(&errand, has_arrived);
        }
        if has_arrived == Some(true) {
            self.blockage = Blockage::default();
            self.driven = Some(Driven { route: errand.underway.route, made: errand.made });
        }
        self.has_news = true;
        tell.end(CASE_NAVIGATION, ending);
        Some(Velocity::default())
    }

    /// How a route that was driven turned out tells how good the case is that it was made from.
    fn note_route(&mut self, errand: &Errand, succeeded: bool) {
        if let Some(number) = errand.made.as_ref().and_then(|made| made.case) {
            self.memory.change(number, |case| case.counts.note(succeeded));
        }
    }

    /// How long stretches take, as far as it remembers.
    fn times(&self, model: &OfficeModel, places: &Places) -> TravelTimes {
        TravelTimes::of_routes(places, model.limits.hallway_mps, self.memory.routes().map(|(_, route)| route))
    }

    /// Notes how long a driven route took, and keeps it, or another for it, if it has steps that no case has.
    fn keep(
        &mut self,
        model: &OfficeModel,
        places: &Places,
        driven: Route,
        instead: Option<Route>,
    ) -> Option<CaseNumber> {
        learn_times(&mut self.memory, &driven);
        let route = instead.unwrap_or(driven);
        let is_new = route.stops.len() > 1 && self.memory.routes().all(|(_, known)| route.steps_beyond(known) > 0);
        let number = if is_new { learn_route(&mut self.memory, places, route) } else { None };
        self.make_room(Kind::Route, model, places);
        number
    }

    /// Forgets what can be done without, if a kind has more cases than the robot remembers.
    fn make_room(&mut self, kind: Kind, model: &OfficeModel, places: &Places) {
        let most = Capacity::USUAL.of(kind);
        if self.memory.count(kind) > most {
            let times = self.times(model, places);
            forget_beyond(&mut self.memory, kind, most, Some((places, &times)));
        }
    }

    /// What the robot perceives and where it is; a robot that has lost its position is at no place.
    fn situation(&self, seen: &Seen) -> Situation {
        let situation = Situation {
            sonars_m: self.recent.last_m(),
            mean_sonars_m: self.recent.mean_m(),
            translation_mps: seen.velocity.map(|velocity| velocity.translation_mps),
            rotation_radps: seen.velocity.map(|velocity| velocity.rotation_radps),
            ..Situation::default()
        };
        if seen.is_lost { situation } else { situation.seen_from(seen.robot_in_map) }
    }

    /// The situation on the way of the errand, or without one.
    fn situation_on_the_way(&self, seen: &Seen) -> Situation {
        let errand = self.errand.as_ref();
        let whole = Situation {
            short_term_goal_in_map: errand.and_then(|errand| errand.underway.next_in_map()),
            long_term_goal_in_map: errand.and_then(|errand| errand.underway.last_in_map()),
            ..self.situation(seen)
        };
        // How the short-term goal lies counts even where the robot doubts where both are.
        let place_in_map = whole.place_in_map;
        Situation { place_in_map, ..whole.seen_from(seen.robot_in_map) }
    }

    /// No behaviour has brought the robot on from here: one is to be trained, if that is not known yet. The stretch
    /// has taken so long, and there may be a way round.
    fn note_blocked(&mut self, now: &Moment<'_>, seen: &Seen, places: &Places) {
        if let (Some(errand), Some(map)) = (&self.errand, &now.model.map) {
            let heard_in_base = self.drive.heard_in_base(now.percept.odometry_in_odom);
            let at = BlockedAt {
                planner: &map.navigation.planner,
                places,
                times: &self.times(now.model, places),
                robot_radius_m: now.model.limits.robot_radius_m,
                robot_in_map: seen.robot_in_map.point(),
                heard_in_map: heard_in_base.into_iter().map(|at| seen.robot_in_map.transform(at)).collect(),
            };
            if let Some(driven) = self.blockage.note(&errand.underway, at) {
                self.keep(now.model, places, driven, None);
            }
        }
        let here = self.situation_on_the_way(seen);
        let best = self.memory.retrieve(&here).map(|found| found.best.kind);
        if here.place_in_map.is_some() && best != Some(Kind::MetaPlan) {
            self.memory.retain(to_be_trained(here));
            self.make_room(Kind::MetaPlan, now.model, places);
        }
    }
}

/// What the robot knows of itself.
struct Seen {
    robot_in_map: Pose,
    is_lost: bool,
    velocity: Option<Velocity>,
}

impl Seen {
    fn of(model: &OfficeModel, position: &Position, percept: Option<&Percept>) -> Self {
        let estimate = position.estimate(model.map.as_ref());
        let velocity = |percept: &Percept| Velocity {
            translation_mps: percept.translation_mps,
            rotation_radps: percept.rotation_radps,
        };
        Self {
            robot_in_map: estimate.pose_in_map,
            is_lost: position.tracking(model.map.as_ref()) <= model.settings.active.certainty,
            velocity: percept.map(velocity),
        }
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
        if step.ending.as_ref().is_some_and(|ending| *ending != Ending::Success) {
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
