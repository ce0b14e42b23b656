//! Driving, and what stops it.

use super::arc::drive_arc;
use super::commands::Commands;
use super::model::SimulatorModel;
use super::state::{SimulatorState, SteppedBefore};
use super::walker::PERSON_RADIUS_M;
use crate::geometry::{Point, Pose, distance_m};
use crate::world::{SeenBy, SolidOrigin};

/// How far a body may reach into another: the rounding of the bisection below.
const PENETRATION_M: f64 = 1e-9;

/// A touch is over when this much air is between.
const PARTED_M: f64 = 0.01;

/// Steps until the robot brakes for what is there from one moment to the next: one to see it, two until a command takes
/// effect.
const REACTION_STEPS: u64 = 3;

/// A robot that brakes does so at least with this share of its usual deceleration: the rest is rounding.
const BRAKES_SHARE: f64 = 0.9;

/// What is nearest to the body.
#[derive(Clone, Copy)]
struct Nearest {
    distance_m: f64,
    seen_by: SeenBy,
    kind: NearestKind,
}

/// Of which kind that is.
#[derive(Clone, Copy, PartialEq)]
enum NearestKind {
    /// It was always there.
    Lasting,
    /// It can come up from one moment to the next.
    Sudden,
    /// `people[i]`.
    Person(usize),
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
        if commands.motors_off || state.time_us < state.wheels_held_until_us {
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

    /// The way the robot still makes until it stands, if something is there from now on.
    pub(super) fn stopping_m(&self, state: &SimulatorState) -> f64 {
        let speed_mps = state.translation_mps.abs();
        let braking_m = speed_mps * speed_mps / (2.0 * self.robot().motors.translation_deceleration_mps2);
        REACTION_STEPS as f64 * speed_mps * self.robot().step_s() + braking_m
    }

    /// Remembers if a person's step has brought him so near before the moving robot that it cannot stop in time, and he
    /// was not before: a robot that comes so near to somebody itself had time to brake.
    pub(super) fn notice_step(&self, state: &mut SimulatorState, person: usize, before: Point) {
        let robot_in_map = state.robot_in_map;
        let gap_m = |at: Point| distance_m(at, robot_in_map.point()) - self.robot().radius_m - PERSON_RADIUS_M;
        let ahead = robot_in_map.inverse().transform(before).x * state.translation_mps;
        let stopping_m = self.stopping_m(state);
        if ahead > 0.0 && gap_m(state.people[person].at_in_map) <= stopping_m && gap_m(before) > stopping_m {
            let brakes_from_us = state.time_us + REACTION_STEPS * self.robot().step_us;
            state.stepped_before = Some(SteppedBefore { person, brakes_from_us });
        }
    }

    /// A robot that stands, or does not brake as it usually does although it could by now, has no excuse.
    pub(super) fn judge_braking(&self, state: &mut SimulatorState, before_mps: f64) {
        let braked_mps = BRAKES_SHARE * self.robot().driving.translation_deceleration_mps2 * self.robot().step_s();
        let is_slower = state.translation_mps.abs() <= before_mps.abs() - braked_mps;
        let is_braking = state.translation_mps != 0.0 && is_slower;
        state.stepped_before =
            state.stepped_before.filter(|stepped| is_braking || state.time_us < stepped.brakes_from_us);
    }

    fn attribute(&self, state: &mut SimulatorState, touched: Nearest) {
        let sonar_works = self.sensors.sonars.is_some() && !self.have_sonars_failed(state);
        let Nearest { seen_by, kind, .. } = touched;
        let is_sudden = match kind {
            NearestKind::Lasting => false,
            NearestKind::Sudden => state.time_us < state.sudden_until_us,
            NearestKind::Person(index) => state.stepped_before.is_some_and(|stepped| stepped.person == index),
        };
        if is_sudden {
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
        let mut nearest = Nearest { distance_m: f64::INFINITY, seen_by: everything_sees, kind: NearestKind::Lasting };
        let mut consider = |distance_m: f64, seen_by: SeenBy, kind: NearestKind| {
            if distance_m < nearest.distance_m {
                nearest = Nearest { distance_m, seen_by, kind };
            }
        };
        for index in self.candidates.touchable(point) {
            let surface = &self.surfaces[*index as usize];
            if state.is_there(surface.origin) {
                let kind = match surface.origin {
                    SolidOrigin::Door(_) => NearestKind::Sudden,
                    SolidOrigin::Wall | SolidOrigin::Object(_) => NearestKind::Lasting,
                };
                consider(surface.form.distance_m(point), surface.seen_by, kind);
            }
        }
        for object in &state.objects_added {
            consider(object.outline().distance_m(point), object.seen_by, NearestKind::Sudden);
        }
        let away2 = |index: usize| (state.people[index].at_in_map - point).norm_squared();
        let person = (0..state.people.len()).map(|index| (away2(index), index)).min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((distance2, index)) = person {
            consider(distance2.sqrt() - PERSON_RADIUS_M, everything_sees, NearestKind::Person(index));
        }
        nearest
    }
}

fn towards(from: f64, to: f64, most: f64) -> f64 {
    from + (to - from).clamp(-most, most)
}
