//! Registration: the direction of the hallway the robot is in, by line segments fitted to what its sonars
//! hear at the sides (Gutierrez-Osuna and Luo, "Registration").
//!
//! Read in this order: `views` (what is kept of the drive), `walls` (what a direction explains of it),
//! `search` (the direction that explains most), `widths` (how wide the hallway is); `doubt` (whether the robot
//! looks another way than it believes) with `ring` (what was heard all around).

mod doubt;
mod ring;
mod search;
mod views;
mod walls;
mod widths;

#[cfg(test)]
mod tests;

pub use doubt::Doubt;
pub use ring::Ring;

use crate::feature::Side;
use rpl_robot::geometry::{Pose, wrap_angle_rad};
use rpl_robot::sensors::SonarScan;
use search::{best_axis_within, refined};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use views::Views;
pub use walls::HallwayAxis;
use walls::{Explained, explain};
use widths::HallwayWidths;

/// What registration goes by.
#[derive(Clone, Copy, Debug, PartialEq)]
struct RegistrationParameters {
    /// A heading that is guessed, by a door frame say, is off by less.
    guess_gate_rad: f64,
    /// A heading known from the way so far is off by less. 6° would never recover after a U-turn with slipping
    /// wheels, and beyond 20° the other walls of a crossing come into reach.
    known_gate_rad: f64,
    /// The robot's heading may have been turned against the axis by more than any gate; it still drives along
    /// the hallway rather than across.
    lost_gate_rad: f64,
    /// Wall on one side that must have been driven along: a leaf or a jamb passed at the start tilts a shorter
    /// fit by 5° to 9°.
    least_wall_m: f64,
    /// A standard deviation below this means that one line fits all of both sides. With doors on both the lines fit
    /// worse ...
    sure_deviation_rad: f64,
    /// ... and a longer wall is needed, this long ...
    long_wall_m: f64,
    /// ... and a direction good enough for the transducers to be chosen by it.
    most_deviation_rad: f64,
    /// Walls farther apart are those of a room.
    widest_m: f64,
    /// How far the robot drives between two fits.
    between_fits_m: f64,
    /// What is newer than this decides whether the axis still holds.
    recent_m: f64,
    /// The present axis is wrong when another explains more of the newest readings, by this factor.
    better_by: f64,
    /// Wall that another axis must explain on one side for that.
    lost_wall_m: f64,
    /// And the share of the readings.
    lost_share: f64,
    /// And how well its walls must be as far apart as those of the hallway were.
    width_m: f64,
}

const PARAMETERS: RegistrationParameters = RegistrationParameters {
    guess_gate_rad: 0.61,
    known_gate_rad: 0.3,
    lost_gate_rad: 0.79,
    least_wall_m: 0.8,
    sure_deviation_rad: 0.0052,
    long_wall_m: 1.4,
    most_deviation_rad: 0.015,
    widest_m: 3.2,
    between_fits_m: 0.1,
    recent_m: 0.5,
    better_by: 2.0,
    lost_wall_m: 0.3,
    lost_share: 0.6,
    width_m: 0.15,
};

/// What is known of the direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Knowledge {
    /// A guess, and how far off it may be.
    Guess { axis_in_odom_rad: f64, gate_rad: f64 },
    /// Fitted to walls.
    Registered(HallwayAxis),
}

/// The state of registration in a hallway. A plain value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Registration {
    knowledge: Knowledge,
    views: Views,
    fitted_at_m: f64,
    widths: HallwayWidths,
}

impl Registration {
    /// Begins in a hallway whose direction is roughly known, within about 35°: the way one will drive along
    /// it, in `odom`.
    pub fn start(heading_guess_in_odom_rad: f64) -> Self {
        let guess = wrap_angle_rad(heading_guess_in_odom_rad);
        Self {
            knowledge: Knowledge::Guess { axis_in_odom_rad: guess, gate_rad: PARAMETERS.guess_gate_rad },
            views: Views::default(),
            fitted_at_m: 0.0,
            widths: HallwayWidths::default(),
        }
    }

    /// The same hallway for a robot that turns round in it: it knows the axis, and has to see the walls anew.
    #[must_use]
    pub fn turned_round(&self) -> Self {
        let back_rad = wrap_angle_rad(self.heading_in_odom_rad() + PI);
        match self.knowledge {
            Knowledge::Guess { .. } => Self::start(back_rad),
            Knowledge::Registered(axis) => {
                let widths = self.widths.clone();
                Self { knowledge: Knowledge::Registered(axis.reversed()), widths, ..Self::start(back_rad) }
            }
        }
    }

    /// Takes in what the sonars hear. Cost: next to nothing on most steps; every 10 cm a fit, some 0.2 ms.
    pub fn take_in(&mut self, odometry_in_odom: Pose, scan: SonarScan<'_>) {
        self.views.take_in(odometry_in_odom, scan);
        if self.views.driven_m() - self.fitted_at_m < PARAMETERS.between_fits_m {
            return;
        }
        self.fitted_at_m = self.views.driven_m();
        self.knowledge = match self.knowledge {
            Knowledge::Guess { axis_in_odom_rad, gate_rad } => self.register(scan, axis_in_odom_rad, gate_rad),
            Knowledge::Registered(axis) => self.keep_up(scan, axis, odometry_in_odom),
        };
    }

    /// Takes in what the sonars hear and fits nothing: the axis that is answered runs as it was guessed, however the
    /// walls run, and they are as far away as they were heard last.
    pub fn keep_guess(&mut self, odometry_in_odom: Pose, scan: SonarScan<'_>) -> HallwayAxis {
        self.views.take_in(odometry_in_odom, scan);
        let heading_in_odom_rad = self.heading_in_odom_rad();
        let heard_m = Side::ALL.map(|side| self.wall_distance_m(scan, odometry_in_odom, side));
        HallwayAxis::guessed(heading_in_odom_rad, odometry_in_odom, heard_m)
    }

    /// The first registration.
    fn register(&mut self, scan: SonarScan<'_>, axis_in_odom_rad: f64, gate_rad: f64) -> Knowledge {
        let guess = Knowledge::Guess { axis_in_odom_rad, gate_rad };
        let views = self.views.latest(f64::INFINITY);
        if self.views.way_m() + PARAMETERS.between_fits_m < PARAMETERS.least_wall_m {
            return guess;
        }
        let Some(best_rad) = best_axis_within(views, scan.sonars, axis_in_odom_rad, gate_rad) else { return guess };
        let axis = refined(views, scan.sonars, best_rad);
        let p = &PARAMETERS;
        let is_sure = axis.wall_m >= p.least_wall_m && axis.deviation_rad <= p.sure_deviation_rad;
        let is_long = axis.wall_m >= p.long_wall_m && axis.deviation_rad <= p.most_deviation_rad;
        let is_room = axis.width_m.is_some_and(|width_m| width_m > p.widest_m);
        if is_room || !is_sure && !is_long {
            return guess;
        }
        if let Some(width_m) = axis.width_m {
            self.widths.add(width_m, axis.wall_m);
        }
        Knowledge::Registered(axis)
    }

    /// Later ones: the walls confirm the axis or correct it a little, are not to be heard, or show that it is
    /// wrong because the robot was turned by hand.
    fn keep_up(&mut self, scan: SonarScan<'_>, axis: HallwayAxis, odometry_in_odom: Pose) -> Knowledge {
        if let Some(other_rad) = self.contradiction(scan, &axis, odometry_in_odom) {
            self.views.forget_before(PARAMETERS.recent_m);
            return Knowledge::Guess { axis_in_odom_rad: other_rad, gate_rad: PARAMETERS.known_gate_rad };
        }
        let held =
            axis.after_driving(PARAMETERS.between_fits_m, self.views.turned_since_rad(PARAMETERS.between_fits_m));
        let fitted = refined(self.views.latest(f64::INFINITY), scan.sonars, held.heading_in_odom_rad);
        if fitted.wall_m < PARAMETERS.least_wall_m || fitted.deviation_rad > PARAMETERS.most_deviation_rad {
            return Knowledge::Registered(held);
        }
        // What is far off is a wall of something else.
        if !held.agrees_with(&fitted) {
            return Knowledge::Registered(held);
        }
        if let Some(width_m) = fitted.width_m {
            self.widths.add(width_m, PARAMETERS.between_fits_m);
        }
        Knowledge::Registered(held.corrected_by(&fitted, self.widths.likeliest_m(), odometry_in_odom))
    }

    /// Another axis, near to where the robot looks, that explains much more of what was heard last.
    fn contradiction(&self, scan: SonarScan<'_>, axis: &HallwayAxis, odometry_in_odom: Pose) -> Option<f64> {
        let p = &PARAMETERS;
        let recent = self.views.latest(p.recent_m);
        let held = explain(recent, scan.sonars, axis.heading_in_odom_rad);
        if p.better_by * held.share >= 1.0 {
            return None;
        }
        let heading_rad = odometry_in_odom.heading_rad;
        let other_rad = best_axis_within(recent, scan.sonars, heading_rad, p.lost_gate_rad)?;
        let off_rad = wrap_angle_rad(other_rad - axis.heading_in_odom_rad).abs();
        let other: Explained = explain(recent, scan.sonars, other_rad);
        let is_wall = other.wall_m >= p.lost_wall_m && other.share >= p.lost_share;
        let is_better = other.score > p.better_by * held.score && off_rad > p.known_gate_rad / 3.0;
        let widths_m = axis.width_m.zip(other.walls_apart_m());
        // In a crossing or a foyer there are walls in all directions, but not two as far apart as those of the
        // hallway.
        let is_hallway = widths_m.is_some_and(|(known_m, other_m)| (known_m - other_m).abs() <= p.width_m);
        (is_wall && is_better && is_hallway).then_some(other_rad)
    }

    /// The axis, as soon as enough wall was driven along; none again after the robot was found to look another
    /// way than its odometry says, until that is put right.
    pub fn axis(&self) -> Option<&HallwayAxis> {
        match &self.knowledge {
            Knowledge::Guess { .. } => None,
            Knowledge::Registered(axis) => Some(axis),
        }
    }

    /// The direction to drive in: the axis, or the guess as long as there is none. In `odom`.
    pub fn heading_in_odom_rad(&self) -> f64 {
        match self.knowledge {
            Knowledge::Guess { axis_in_odom_rad, .. } => axis_in_odom_rad,
            Knowledge::Registered(axis) => axis.heading_in_odom_rad,
        }
    }

    /// Distance to the wall on a side, from the middle of the robot: the median of what was heard over the last
    /// 25 cm. `None` where nothing was, as beside an opening that is deeper than the sonars hear.
    pub fn wall_distance_m(&self, scan: SonarScan<'_>, odometry_in_odom: Pose, side: Side) -> Option<f64> {
        walls::median_distance_m(&self.views, scan.sonars, self.heading_in_odom_rad(), odometry_in_odom, side)
    }
}
