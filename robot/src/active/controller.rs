//! The state machine: wander, choose, follow, choose again, until the pose is known.

use super::choice::{ActionField, Choice, choose, consider};
use super::parameters::{ActiveParameters, Exploration};
use crate::geometry::{Point, Pose, distance_m};
use crate::localization::{Localization, LocalizationModel, Maximum};
use serde::{Deserialize, Serialize};

/// How far in front of a blocked robot the obstacle is assumed.
const OBSTACLE_AHEAD_M: f64 = 0.5;

/// Obstacles older than this many are forgotten.
const MAX_OBSTACLES: usize = 8;

/// Wandering that follows a choice without a way.
const WANDER_AGAIN_M: f64 = 3.0;

/// What active localization wants the robot to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Intent {
    /// Move about in a way that is not chosen for what can be learnt, without touching anything.
    Explore(Exploration),
    /// Follow these points, the nearest first, the target last.
    FollowPath {
        /// Points of the odometry frame, which stays put however the belief jumps.
        path_in_odom: Vec<Point>,
    },
    /// The pose is known.
    Done,
    /// `localization-failure`: the time is over.
    Failed,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum SearchPhase {
    /// Moving about until the belief has few maxima.
    Wander {
        /// Way still to go at most.
        left_m: f64,
    },
    /// On the way to a target.
    Follow {
        path_in_odom: Vec<Point>,
        /// The maxima the choice was made for ...
        maxima: Vec<Maximum>,
        /// ... and where odometry said the robot was then.
        chosen_at_in_odom: Pose,
    },
    Done,
    Failed,
}

/// The state of active localization.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActiveLocalization {
    parameters: ActiveParameters,
    phase: SearchPhase,
    started_at_us: u64,
    /// Whether the belief was given up, for the position was lost; once in a search.
    is_given_up: bool,
    odometry_in_odom: Pose,
    /// Updates of the filter seen so far, and at the last look at the maxima.
    updates: u64,
    looked_at: u64,
    /// Updates in a row with a certainty above the limit.
    confirmed: u32,
    obstacles_in_odom: Vec<Point>,
    /// The last choice, for whoever looks on.
    choice: Option<Choice>,
}

impl ActiveLocalization {
    /// Starts. Where the position is not lost there is nothing to wander for: the first step chooses.
    pub fn start(
        model: &LocalizationModel,
        localization: &mut Localization,
        odometry_in_odom: Pose,
        time_us: u64,
        parameters: ActiveParameters,
    ) -> Self {
        let mut search = Self {
            phase: SearchPhase::Wander { left_m: 0.0 },
            parameters,
            started_at_us: time_us,
            is_given_up: false,
            odometry_in_odom,
            updates: localization.updates(),
            looked_at: localization.updates(),
            confirmed: 0,
            obstacles_in_odom: Vec::new(),
            choice: None,
        };
        search.give_up_if_lost(model, localization);
        search
    }

    /// Resets the belief for relocalization if the position is lost, and wanders.
    fn give_up_if_lost(&mut self, model: &LocalizationModel, localization: &mut Localization) {
        if !self.is_given_up && localization.tracking(model) <= self.parameters.certainty {
            localization.reset_for_relocalization(model);
            self.is_given_up = true;
            self.phase = SearchPhase::Wander { left_m: self.parameters.max_wander_m };
        }
    }

    /// The last choice that was made.
    pub fn last_choice(&self) -> Option<&Choice> {
        self.choice.as_ref()
    }

    /// What to do now; resets the belief if the position is lost only now. `blocked` says that the robot cannot get on
    /// along the path it was given. A step costs next to nothing, but for one that chooses.
    pub fn step(
        &mut self,
        model: &LocalizationModel,
        localization: &mut Localization,
        odometry_in_odom: Pose,
        blocked: bool,
        time_us: u64,
    ) -> Intent {
        let moved_m = self.odometry_in_odom.distance_m(odometry_in_odom);
        self.odometry_in_odom = odometry_in_odom;
        self.give_up_if_lost(model, localization);
        self.confirm(model, localization);
        let elapsed_us = time_us.saturating_sub(self.started_at_us);
        if self.confirmed >= self.parameters.confirmations {
            self.phase = SearchPhase::Done;
        } else if elapsed_us as f64 >= self.parameters.timeout_s * 1e6 {
            self.phase = SearchPhase::Failed;
        }
        if blocked {
            self.remember_obstacle();
        }
        let choose_now = match &mut self.phase {
            SearchPhase::Wander { left_m } => {
                *left_m -= moved_m;
                let tired = *left_m <= 0.0;
                tired || (self.is_time_to_look(localization) && self.is_concentrated(model, localization))
            }
            SearchPhase::Follow { path_in_odom, .. } => {
                let arrival_m = self.parameters.arrival_m;
                let here = odometry_in_odom.point();
                while path_in_odom.len() > 1 && distance_m(path_in_odom[0], here) < arrival_m {
                    path_in_odom.remove(0);
                }
                let arrived = path_in_odom.iter().all(|&point| distance_m(point, here) < arrival_m);
                arrived || blocked || (self.is_time_to_look(localization) && self.has_changed(model, localization))
            }
            SearchPhase::Done | SearchPhase::Failed => false,
        };
        if choose_now && self.parameters.exploration == Exploration::Active {
            self.choose(model, localization);
        }
        self.intent()
    }

    fn intent(&self) -> Intent {
        match &self.phase {
            SearchPhase::Wander { .. } if self.parameters.exploration == Exploration::Active => {
                Intent::Explore(Exploration::Wander)
            }
            SearchPhase::Wander { .. } => Intent::Explore(self.parameters.exploration),
            SearchPhase::Follow { path_in_odom, .. } => Intent::FollowPath { path_in_odom: path_in_odom.clone() },
            SearchPhase::Done => Intent::Done,
            SearchPhase::Failed => Intent::Failed,
        }
    }

    /// Counts updates in a row that are certain enough; one alone may be a fluke.
    fn confirm(&mut self, model: &LocalizationModel, localization: &Localization) {
        if localization.updates() == self.updates {
            return;
        }
        self.updates = localization.updates();
        let certain = localization.estimate(model).certainty > self.parameters.found_certainty;
        self.confirmed = if certain { self.confirmed + 1 } else { 0 };
    }

    fn is_time_to_look(&mut self, localization: &Localization) -> bool {
        let due = localization.updates() >= self.looked_at + u64::from(self.parameters.look_every);
        if due {
            self.looked_at = localization.updates();
        }
        due
    }

    fn maxima(&self, model: &LocalizationModel, localization: &Localization) -> Vec<Maximum> {
        localization.maxima(model, self.parameters.max_maxima, self.parameters.min_mass)
    }

    fn is_concentrated(&self, model: &LocalizationModel, localization: &Localization) -> bool {
        let mass: f64 = self.maxima(model, localization).iter().map(|maximum| maximum.mass).sum();
        mass >= self.parameters.concentrated_mass
    }

    /// Whether much of the belief is at maxima the choice did not know.
    fn has_changed(&self, model: &LocalizationModel, localization: &Localization) -> bool {
        let SearchPhase::Follow { maxima, chosen_at_in_odom, .. } = &self.phase else { return false };
        let since = self.odometry_in_odom.relative_to(*chosen_at_in_odom);
        let share = |maxima: &[Maximum]| -> f64 { maxima.iter().map(|maximum| maximum.mass).sum::<f64>().max(1e-9) };
        let now = self.maxima(model, localization);
        let (then_total, now_total) = (share(maxima), share(&now));
        let gained: f64 = now
            .iter()
            .map(|maximum| {
                let known: f64 = maxima
                    .iter()
                    .filter(|old| old.is_near(maximum.pose_in_map, since))
                    .map(|old| old.mass / then_total)
                    .sum();
                (maximum.mass / now_total - known).max(0.0)
            })
            .sum();
        gained > self.parameters.changed_mass
    }

    fn remember_obstacle(&mut self) {
        if let SearchPhase::Follow { path_in_odom, .. } = &self.phase
            && let Some(&next) = path_in_odom.first()
        {
            let here = self.odometry_in_odom.point();
            let away_m = distance_m(next, here);
            let ahead =
                if away_m > OBSTACLE_AHEAD_M { here + (next - here) * (OBSTACLE_AHEAD_M / away_m) } else { next };
            self.obstacles_in_odom.push(ahead);
            if self.obstacles_in_odom.len() > MAX_OBSTACLES {
                self.obstacles_in_odom.remove(0);
            }
        }
    }

    /// What it would choose now, and all that there is to choose from.
    pub fn considered(&self, model: &LocalizationModel, localization: &Localization) -> Option<(Choice, ActionField)> {
        consider(model, &self.maxima(model, localization), &self.obstacles_in_base(), &self.parameters)
    }

    fn obstacles_in_base(&self) -> Vec<Point> {
        let odom_in_base = self.odometry_in_odom.inverse();
        self.obstacles_in_odom.iter().map(|&point| odom_in_base.transform(point)).collect()
    }

    fn choose(&mut self, model: &LocalizationModel, localization: &Localization) {
        let maxima = self.maxima(model, localization);
        let robot = self.odometry_in_odom;
        self.looked_at = localization.updates();
        match choose(model, &maxima, &self.obstacles_in_base(), &self.parameters) {
            Some(choice) => {
                let path_in_odom = choice.path_in_base.iter().map(|&point| robot.transform(point)).collect();
                self.phase = SearchPhase::Follow { path_in_odom, maxima, chosen_at_in_odom: robot };
                self.choice = Some(choice);
            }
            None => self.phase = SearchPhase::Wander { left_m: WANDER_AGAIN_M },
        }
    }
}
