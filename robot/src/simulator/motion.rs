//! Driving, and what stops it.

use super::arc::drive_arc;
use super::model::SimulatorModel;
use super::sensors::Commands;
use super::state::SimulatorState;
use super::walker::PERSON_RADIUS_M;
use crate::geometry::{Point, Pose};
use crate::world::{SeenBy, SolidOrigin};

/// How far a body may reach into another: the rounding of the bisection below.
const PENETRATION_M: f64 = 1e-9;

/// A touch is over when this much air is between.
const PARTED_M: f64 = 0.01;

/// What is nearest to the body.
#[derive(Clone, Copy)]
struct Nearest {
    distance_m: f64,
    seen_by: SeenBy,
    /// Whether it is of a kind that can come up from one moment to the next.
    may_be_sudden: bool,
}

/// What the robot really did in one step.
#[derive(Clone, Copy)]
pub(super) struct Driven {
    pub way_m: f64,
    pub turn_rad: f64,
}

impl SimulatorModel {
    /// Speeds after one step towards the commanded ones.
    pub(super) fn accelerate(&self, state: &mut SimulatorState, commands: &Commands) {
        let (motors, step_s) = (&self.robot().motors, self.robot().step_s());
        if commands.motors_off {
            state.translation_mps = towards(state.translation_mps, 0.0, motors.halt_deceleration_mps2 * step_s);
            state.rotation_radps = towards(state.rotation_radps, 0.0, motors.halt_deceleration_radps2 * step_s);
            return;
        }
        let has_power = state.battery > 0.0;
        let limited =
            |wanted: f64, limit: f64| if wanted.is_finite() && has_power { wanted.clamp(-limit, limit) } else { 0.0 };
        let wanted_mps = limited(commands.translation_mps, motors.max_translation_mps);
        let wanted_radps = limited(commands.rotation_radps, motors.max_rotation_radps);
        let speeds_up = wanted_mps.abs() > state.translation_mps.abs() && wanted_mps * state.translation_mps >= 0.0;
        let change_mps2 =
            if speeds_up { motors.translation_acceleration_mps2 } else { motors.translation_deceleration_mps2 };
        state.translation_mps = towards(state.translation_mps, wanted_mps, change_mps2 * step_s);
        let change_radps = motors.rotation_acceleration_radps2 * step_s;
        state.rotation_radps = towards(state.rotation_radps, wanted_radps, change_radps);
    }

    /// Drives one step at the present speeds, up to the first touch.
    pub(super) fn drive(&self, state: &mut SimulatorState) -> Driven {
        let step_s = self.robot().step_s();
        let (way_m, turn_rad) = (state.translation_mps * step_s, state.rotation_radps * step_s);
        let before = state.robot_in_map;
        let after = drive_arc(before, way_m, turn_rad);
        if way_m == 0.0 && !state.touching {
            state.robot_in_map = after;
            return Driven { way_m, turn_rad };
        }
        let nearest = self.nearest(state, after.point());
        if nearest.distance_m >= self.robot().radius_m - PENETRATION_M {
            state.robot_in_map = after;
            state.distance_driven_m += way_m.abs();
            state.touching &= nearest.distance_m < self.robot().radius_m + PARTED_M;
            return Driven { way_m, turn_rad };
        }
        let share = self.free_share(state, before, way_m, turn_rad);
        let stopped = drive_arc(before, share * way_m, share * turn_rad);
        // A touched body still turns in place: it is round.
        state.robot_in_map = Pose::new(stopped.x_m, stopped.y_m, after.heading_rad);
        state.distance_driven_m += share * way_m.abs();
        state.translation_mps = 0.0;
        if !state.touching {
            state.touching = true;
            self.attribute(state, nearest);
        }
        Driven { way_m: share * way_m, turn_rad }
    }

    /// The largest share of an arc that stays free, by bisection.
    fn free_share(&self, state: &SimulatorState, before: Pose, way_m: f64, turn_rad: f64) -> f64 {
        let (mut free, mut blocked) = (0.0, 1.0);
        for _ in 0..30 {
            let share = (free + blocked) / 2.0;
            let point = drive_arc(before, share * way_m, share * turn_rad).point();
            if self.nearest(state, point).distance_m >= self.robot().radius_m {
                free = share;
            } else {
                blocked = share;
            }
        }
        free
    }

    fn attribute(&self, state: &mut SimulatorState, touched: Nearest) {
        let sonar_works = self.sensors.sonars.is_some() && state.time_us >= state.sonars_fail_until_us;
        let Nearest { seen_by, may_be_sudden, .. } = touched;
        if may_be_sudden && state.time_us < state.sudden_until_us {
            state.contacts.run_into += 1;
        } else if seen_by.sonar && sonar_works || seen_by.laser && self.sensors.laser.is_some() {
            state.contacts.caused += 1;
        } else {
            state.contacts.unseen += 1;
        }
    }

    /// The body nearest to a point that is in none, as far as the robot could touch it.
    fn nearest(&self, state: &SimulatorState, point: Point) -> Nearest {
        let everything_sees = SeenBy { sonar: true, laser: true };
        let mut nearest = Nearest { distance_m: f64::INFINITY, seen_by: everything_sees, may_be_sudden: false };
        let mut consider = |distance_m: f64, seen_by: SeenBy, may_be_sudden: bool| {
            if distance_m < nearest.distance_m {
                nearest = Nearest { distance_m, seen_by, may_be_sudden };
            }
        };
        for index in self.candidates.touchable(point) {
            let surface = &self.surfaces[*index as usize];
            if state.is_there(surface.origin) {
                let is_door = matches!(surface.origin, SolidOrigin::Door(_));
                consider(surface.form.distance_m(point), surface.seen_by, is_door);
            }
        }
        for object in &state.objects_added {
            consider(object.outline().distance_m(point), object.seen_by, true);
        }
        let person2 = state.people.iter().map(|person| (person.at_in_map - point).norm_squared()).reduce(f64::min);
        if let Some(distance2) = person2 {
            consider(distance2.sqrt() - PERSON_RADIUS_M, everything_sees, false);
        }
        nearest
    }
}

fn towards(from: f64, to: f64, most: f64) -> f64 {
    from + (to - from).clamp(-most, most)
}
