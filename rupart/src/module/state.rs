//! What is kept while the robot drives by cases, and what becomes of it.

use super::errand::{Errand, ErrandStep, Made};
use super::landmarks::Looking;
use crate::beginning::to_be_trained;
use crate::case::Kind;
use crate::control::CaseDrive;
use crate::forgetting::{Capacity, forget_beyond};
use crate::memory::{CaseMemory, CaseNumber, Retrieval};
use crate::places::Places;
use crate::route::Route;
use crate::routes::{Blockage, BlockedAt, TravelTimes, learn_route, learn_times};
use crate::situation::{RecentSonars, Situation};
use rpl_robot::geometry::{Pose, Velocity};
use rpl_robot::office::{Moment, OfficeModel, Position, Raise, Telling};
use rpl_robot::simulator::Percept;
use rpl_runtime::robot::Ending;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A route that was driven to its end.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Driven {
    /// With the times it took.
    pub(super) route: Route,
    /// How it was made, if it is one that was.
    pub(super) made: Option<Made>,
}

/// The state of driving by cases. As long as no plan uses it, it does nothing and tells nothing.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Rupart {
    /// Those of the world, looked up when they are first needed.
    #[serde(skip)]
    pub(super) places: Option<Arc<Places>>,
    pub(super) memory: CaseMemory,
    pub(super) drive: CaseDrive,
    pub(super) recent: RecentSonars,
    /// The route that is driven.
    pub(super) errand: Option<Errand>,
    /// What has blocked it.
    pub(super) blockage: Blockage,
    /// The route that was made last.
    pub(super) made: Option<Made>,
    /// The route that was driven last, with the times it took, if it was driven to its end.
    pub(super) driven: Option<Driven>,
    /// The behaviour case it drives by, since a plan has said so.
    pub(super) used: Option<CaseNumber>,
    /// What was found last.
    pub(super) retrieval: Option<Retrieval>,
    /// What it knows of landmarks.
    pub(super) looking: Looking,
    /// Whether something has changed since plans were told.
    pub(super) has_news: bool,
}

/// The places of its behaviours.
pub(super) const CASE_NAVIGATION: usize = 0;
pub(super) const LANDMARK_LOCALIZATION: usize = 1;

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
    pub(super) fn places(&mut self, model: &OfficeModel) -> Result<Arc<Places>, Raise> {
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
    pub(super) fn go_on(&mut self, step: ErrandStep, is_elsewhere: bool, tell: &mut Telling<'_>) -> Option<Velocity> {
        self.has_news |= step.has_news;
        if step.has_news || step.ending.is_some() {
            self.note_use(step.has_news);
        }
        let erased = is_elsewhere.then(|| {
            Ending::failure("unexpected-landmark", "a landmark says that the robot is not where its route leads")
        });
        let has_arrived = step.ending.as_ref().map(|ending| *ending == Ending::DONE);
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
    pub(super) fn times(&self, model: &OfficeModel, places: &Places) -> TravelTimes {
        TravelTimes::of_routes(places, model.limits.hallway_mps, self.memory.routes().map(|(_, route)| route))
    }

    /// Notes how long a driven route took, and keeps it, or another for it, if it has steps that no case has.
    pub(super) fn keep(
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
    pub(super) fn make_room(&mut self, kind: Kind, model: &OfficeModel, places: &Places) {
        let most = Capacity::USUAL.of(kind);
        if self.memory.count(kind) > most {
            let times = self.times(model, places);
            forget_beyond(&mut self.memory, kind, most, Some((places, &times)));
        }
    }

    /// What the robot perceives and where it is; a robot that has lost its position is at no place.
    pub(super) fn situation(&self, seen: &Seen) -> Situation {
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
    pub(super) fn situation_on_the_way(&self, seen: &Seen) -> Situation {
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

    /// No behaviour has brought the robot on from here: one is to be trained, if that is not known yet. The time the
    /// stretch has taken is noted, and there may be a way round.
    pub(super) fn note_blocked(&mut self, now: &Moment<'_>, seen: &Seen, places: &Places) {
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
pub(super) struct Seen {
    pub(super) robot_in_map: Pose,
    pub(super) is_lost: bool,
    pub(super) velocity: Option<Velocity>,
}

impl Seen {
    pub(super) fn of(model: &OfficeModel, position: &Position, percept: Option<&Percept>) -> Self {
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
