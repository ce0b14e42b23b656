//! Collision avoidance by the dynamic window (Fox, Burgard, Thrun 1997): of the speeds that can be
//! reached within a moment, and from which the robot can still stop before the next obstacle on its
//! arc, the one that best combines heading, clearance and speed.

use super::clearance::{CLEARANCE_HORIZON_M, Obstacle, clearance_m, near_obstacles, open_distance_m, stops_in_time};
use crate::geometry::{Point, Pose, wrap_angle_rad};
use crate::world::TravelMode;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Speeds of the synchro drive: forward and counter-clockwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Speeds {
    /// Forward.
    pub translation_mps: f64,
    /// Counter-clockwise.
    pub rotation_radps: f64,
}

/// What the robot can do, and what it is allowed to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveLimits {
    /// Of the robot's disc.
    pub robot_radius_m: f64,
    /// Counter-clockwise and clockwise alike.
    pub max_rotation_radps: f64,
    /// For speeding up.
    pub translation_acceleration_mps2: f64,
    /// For braking.
    pub translation_deceleration_mps2: f64,
    /// For speeding up and for braking.
    pub rotation_acceleration_radps2: f64,
    /// From one command to the next.
    pub step_s: f64,
    /// A sonar reading of so much saw nothing.
    pub sonar_max_range_m: f64,
    /// Air kept between the robot's disc and an obstacle point when it stands.
    pub margin_m: f64,
    /// Air kept besides for each metre per second.
    pub margin_s: f64,
    /// Speed in a hallway.
    pub hallway_mps: f64,
    /// Speed among furniture.
    pub office_mps: f64,
    /// Speed through a door.
    pub doorway_mps: f64,
}

impl Default for DriveLimits {
    fn default() -> Self {
        Self {
            robot_radius_m: 0.265,
            max_rotation_radps: 1.0,
            translation_acceleration_mps2: 0.5,
            translation_deceleration_mps2: 0.9,
            rotation_acceleration_radps2: 1.5,
            step_s: 0.05,
            sonar_max_range_m: 5.0,
            margin_m: 0.02,
            margin_s: 0.1,
            hallway_mps: 0.7,
            office_mps: 0.35,
            doorway_mps: 0.3,
        }
    }
}

impl DriveLimits {
    /// The speed allowed in a travel mode.
    pub fn speed_limit_mps(&self, mode: TravelMode) -> f64 {
        match mode {
            TravelMode::Hallway => self.hallway_mps,
            TravelMode::Office => self.office_mps,
            TravelMode::Doorway => self.doorway_mps,
        }
    }

    /// The way the robot still makes at a speed before it stands: two steps until a command takes
    /// effect, then braking.
    pub fn stopping_distance_m(&self, translation_mps: f64) -> f64 {
        translation_mps * 2.0 * self.step_s
            + translation_mps * translation_mps / (2.0 * self.translation_deceleration_mps2)
    }

    /// The speeds a step later when others are wanted.
    pub fn towards(&self, now: Speeds, wanted: Speeds) -> Speeds {
        let towards = |from: f64, to: f64, most: f64| from + (to - from).clamp(-most, most);
        let speeds_up = wanted.translation_mps > now.translation_mps;
        let change_mps2 =
            if speeds_up { self.translation_acceleration_mps2 } else { self.translation_deceleration_mps2 };
        let change_radps = self.rotation_acceleration_radps2 * self.step_s;
        Speeds {
            translation_mps: towards(now.translation_mps, wanted.translation_mps, change_mps2 * self.step_s),
            rotation_radps: towards(now.rotation_radps, wanted.rotation_radps, change_radps),
        }
    }

    /// The rotation from which a turn by an angle can still be braked in time, with a reserve.
    pub fn braked_turn_radps(&self, turn_rad: f64) -> f64 {
        let timely_radps = libm::sqrt(2.0 * 0.7 * self.rotation_acceleration_radps2 * turn_rad.abs());
        libm::copysign(timely_radps.min(self.max_rotation_radps), turn_rad)
    }

    /// How near the middle of the robot may come to an obstacle point at a speed: the disc and a
    /// margin that grows with the speed.
    pub fn safe_radius_m(&self, translation_mps: f64) -> f64 {
        self.robot_radius_m + self.margin_m + self.margin_s * translation_mps
    }

    /// The least distance of an obstacle point that is still approached at all.
    pub(super) fn hard_radius_m(&self) -> f64 {
        self.robot_radius_m + 0.01
    }
}

/// What one decision is made from.
#[derive(Clone, Copy, Debug)]
pub struct WindowInput<'a> {
    /// For the memory of which way an escape goes.
    pub odometry_in_odom: Pose,
    /// Of the last percept.
    pub speeds: Speeds,
    /// Everything known to stand around the robot.
    pub obstacles_in_base: &'a [Point],
    /// Where to go.
    pub target_in_base: Point,
    /// Of the travel mode.
    pub speed_limit_mps: f64,
    /// How far it is still to the place where the robot is to stand.
    pub remaining_m: f64,
}

/// How the collision avoidance gets on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum WindowStatus {
    /// On the way to the target.
    Driving,
    /// Going where there is room, away from the target if need be.
    Escaping,
    /// Has not got away for several seconds.
    Stuck,
}

/// A decision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindowChoice {
    /// The speeds to command.
    pub speeds: Speeds,
    /// How it gets on.
    pub status: WindowStatus,
}

/// State of the collision avoidance: whether it is held up, and which way out it is trying.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DynamicWindow {
    /// For how long it has hardly moved though it should.
    held_up_s: f64,
    /// For how long it has not been driving freely.
    stuck_s: f64,
    escape: Option<Escape>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Escape {
    heading_in_odom_rad: f64,
    from_in_odom: Point,
    left_s: f64,
}

/// Speeds within reach of this moment are considered.
const WINDOW_S: f64 = 0.25;
const TRANSLATIONS: usize = 11;
const ROTATIONS: usize = 21;

/// How many speeds a decision looks at.
pub const CANDIDATES: usize = TRANSLATIONS * (ROTATIONS + 2);

/// Weights of the objective, summing to 1: heading, clearance, speed.
const HEADING_WEIGHT: f64 = 0.7;
const CLEARANCE_WEIGHT: f64 = 0.12;
const SPEED_WEIGHT: f64 = 0.18;

/// Held up for so long, the robot looks for another way out.
const PATIENCE_S: f64 = 1.0;
/// After so long without driving freely it is stuck.
const STUCK_S: f64 = 8.0;
/// An escape ends after so many metres or seconds.
const ESCAPE_M: f64 = 0.4;
const ESCAPE_S: f64 = 5.0;

impl Escape {
    fn speeds(&mut self, limits: &DriveLimits, input: &WindowInput<'_>) -> Speeds {
        let turn_rad = wrap_angle_rad(self.heading_in_odom_rad - input.odometry_in_odom.heading_rad);
        let target_in_base = Point::new(libm::cos(turn_rad), libm::sin(turn_rad));
        let speed_limit_mps = input.speed_limit_mps.min(0.2);
        let speeds = best_speeds(limits, &WindowInput { target_in_base, remaining_m: 1.0, speed_limit_mps, ..*input });
        if turn_rad.abs() < 0.15 && speeds.translation_mps <= 0.0 {
            self.heading_in_odom_rad = input.odometry_in_odom.heading_rad + way_out_rad(limits, input);
        }
        speeds
    }
}

impl DynamicWindow {
    /// One decision. Cost: [`best_speeds`], and when held up a look around.
    pub fn step(&mut self, limits: &DriveLimits, input: &WindowInput<'_>) -> WindowChoice {
        self.end_escape(limits, input);
        if let Some(escape) = &mut self.escape {
            self.stuck_s += limits.step_s;
            return WindowChoice { speeds: escape.speeds(limits, input), status: self.status() };
        }
        let speeds = best_speeds(limits, input);
        self.watch(limits, input, speeds);
        WindowChoice { speeds, status: self.status() }
    }

    /// Whether the robot does not get on as it should.
    pub fn is_held_up(&self) -> bool {
        self.escape.is_some() || self.held_up_s > 0.25 || self.stuck_s > 0.5
    }

    fn status(&self) -> WindowStatus {
        if self.stuck_s > STUCK_S {
            WindowStatus::Stuck
        } else if self.escape.is_some() {
            WindowStatus::Escaping
        } else {
            WindowStatus::Driving
        }
    }

    fn watch(&mut self, limits: &DriveLimits, input: &WindowInput<'_>, speeds: Speeds) {
        let bearing_rad = libm::atan2(input.target_in_base.y, input.target_in_base.x);
        let crawls = speeds.translation_mps < 0.04 && input.speeds.translation_mps < 0.04;
        if !crawls || input.remaining_m < 0.1 {
            self.held_up_s = 0.0;
            self.stuck_s = (self.stuck_s - limits.step_s).max(0.0);
            return;
        }
        // Turning towards a target at the side is not being held up, but it must not last.
        let weight = if bearing_rad.abs() < TURN_IN_PLACE_RAD { 1.0 } else { 0.2 };
        self.held_up_s += weight * limits.step_s;
        self.stuck_s += weight * limits.step_s;
        if self.held_up_s > PATIENCE_S {
            self.held_up_s = 0.0;
            self.escape = Some(Escape {
                heading_in_odom_rad: input.odometry_in_odom.heading_rad + way_out_rad(limits, input),
                from_in_odom: input.odometry_in_odom.point(),
                left_s: ESCAPE_S,
            });
        }
    }

    fn end_escape(&mut self, limits: &DriveLimits, input: &WindowInput<'_>) {
        if let Some(escape) = &mut self.escape {
            escape.left_s -= limits.step_s;
            let gone_m = (input.odometry_in_odom.point() - escape.from_in_odom).norm();
            if gone_m > ESCAPE_M || escape.left_s <= 0.0 {
                self.escape = None;
            }
        }
    }
}

/// Beyond this bearing the robot turns before it drives.
const TURN_IN_PLACE_RAD: f64 = 0.9;

/// The direction that is open and least off the target; straight back if none is open.
fn way_out_rad(limits: &DriveLimits, input: &WindowInput<'_>) -> f64 {
    let bearing_rad = libm::atan2(input.target_in_base.y, input.target_in_base.x);
    let mut best = (f64::NEG_INFINITY, PI);
    for step in 0..36 {
        let direction_rad = wrap_angle_rad(f64::from(step) * PI / 18.0);
        // A gap that is open in one direction only closes with the noise of the next reading.
        let open_m = [-0.15, 0.0, 0.15]
            .map(|aside_rad| open_distance_m(limits, input.obstacles_in_base, direction_rad + aside_rad, 1.2))
            .into_iter()
            .fold(1.2, f64::min);
        let off_rad = wrap_angle_rad(direction_rad - bearing_rad).abs();
        let score = open_m / 1.2 - 0.5 * off_rad / PI;
        if open_m > 0.15 && score > best.0 {
            best = (score, direction_rad);
        }
    }
    best.1
}

/// The best of the admissible speeds; a full stop of the translation if none is. Cost: [`CANDIDATES`] × obstacle
/// points nearer than the clearance, and fewer where a speed cannot be the best whatever its
/// clearance.
///
/// # Deviation
/// The paper's clearance is the distance to the next obstacle on the arc; here speeds are admissible
/// if the robot can stop within that distance after two more steps, which a command needs to take
/// effect. The paper takes the speeds to change at once; here the best ones are driven ahead with the
/// true accelerations, until the robot stands, before they are chosen. So there is always a way to stop
/// short of everything known. Towards a target at the side or behind the robot turns in place, for paths of the planner
/// may start with a turn in a narrow place.
pub fn best_speeds(limits: &DriveLimits, input: &WindowInput<'_>) -> Speeds {
    let bearing_rad = libm::atan2(input.target_in_base.y, input.target_in_base.x);
    let window = Window::around(limits, input, bearing_rad);
    let near = near_obstacles(limits, input.obstacles_in_base, window.fastest_mps);
    let mut best: Option<(f64, Speeds)> = None;
    for rotation_radps in window.rotations() {
        let look = Look::after_turning(limits, input, rotation_radps);
        for translation_mps in window.translations() {
            let speeds = Speeds { translation_mps, rotation_radps };
            let without_clearance = look.value(translation_mps);
            if best.is_some_and(|(most, _)| without_clearance + CLEARANCE_WEIGHT <= most) {
                continue;
            }
            if let Some(clearance_m) = clearance_m(limits, &near, speeds) {
                let value = without_clearance + CLEARANCE_WEIGHT * clearance_m / CLEARANCE_HORIZON_M;
                if best.is_none_or(|(most, _)| value > most) && stops_in_time(limits, &near, input.speeds, speeds) {
                    best = Some((value, speeds));
                }
            }
        }
    }
    best.map_or_else(|| brake(limits, &near, input.speeds, window.straightest_turn_radps), |(_, speeds)| speeds)
}

/// As hard as possible; turning towards the target meanwhile only if that does not bend the way into
/// something.
fn brake(limits: &DriveLimits, near: &[Obstacle], now: Speeds, straightest_turn_radps: f64) -> Speeds {
    let turning = Speeds { translation_mps: 0.0, rotation_radps: straightest_turn_radps };
    if stops_in_time(limits, near, now, turning) { turning } else { Speeds::default() }
}

/// The target as the robot will see it once it has driven at a rotation for a moment and stopped
/// turning.
struct Look {
    /// Where half the turn points, in a frame turned by the whole turn.
    way_cos: f64,
    way_sin: f64,
    /// The target in that frame, from where the robot is now.
    target: Point,
    longest_way_m: f64,
    speed_limit_mps: f64,
}

impl Look {
    fn after_turning(limits: &DriveLimits, input: &WindowInput<'_>, rotation_radps: f64) -> Self {
        let braking_rad = rotation_radps * rotation_radps.abs() / (2.0 * limits.rotation_acceleration_radps2);
        let turned_rad = rotation_radps * WINDOW_S + braking_rad;
        let (sin, cos) = libm::sincos(turned_rad);
        let (half_sin, half_cos) = libm::sincos(turned_rad / 2.0);
        let target = input.target_in_base;
        Self {
            way_cos: half_cos,
            way_sin: -half_sin,
            target: Point::new(cos * target.x + sin * target.y, cos * target.y - sin * target.x),
            longest_way_m: target.coords.norm() * 0.5,
            speed_limit_mps: input.speed_limit_mps,
        }
    }

    /// The objective but for the clearance: how well the robot looks at the target, and how fast it
    /// goes.
    fn value(&self, translation_mps: f64) -> f64 {
        let way_m = (translation_mps * WINDOW_S).min(self.longest_way_m);
        let off_rad = libm::atan2(self.target.y - way_m * self.way_sin, self.target.x - way_m * self.way_cos).abs();
        let speed = if self.speed_limit_mps > 0.0 { translation_mps / self.speed_limit_mps } else { 0.0 };
        HEADING_WEIGHT * (1.0 - off_rad / PI) + SPEED_WEIGHT * speed
    }
}

/// The speeds within reach.
struct Window {
    slowest_mps: f64,
    fastest_mps: f64,
    rightmost_radps: f64,
    leftmost_radps: f64,
    /// The rotation that ends just at the bearing of the target when braked in time.
    straightest_turn_radps: f64,
}

impl Window {
    fn around(limits: &DriveLimits, input: &WindowInput<'_>, bearing_rad: f64) -> Self {
        let gain_mps = limits.translation_acceleration_mps2 * WINDOW_S;
        let loss_mps = limits.translation_deceleration_mps2 * WINDOW_S;
        let gain_radps = limits.rotation_acceleration_radps2 * WINDOW_S;
        let braked_mps = libm::sqrt(2.0 * limits.translation_acceleration_mps2 * 0.6 * input.remaining_m.max(0.0));
        let turning = if bearing_rad.abs() > TURN_IN_PLACE_RAD { 0.0 } else { libm::cos(bearing_rad) };
        let allowed_mps = (input.speed_limit_mps * turning).min(braked_mps.max(0.03));
        let slowest_mps = (input.speeds.translation_mps - loss_mps).max(0.0);
        let fastest_mps = (input.speeds.translation_mps + gain_mps).min(allowed_mps).max(slowest_mps);
        let most_radps = limits.max_rotation_radps;
        let rotation_radps = input.speeds.rotation_radps.clamp(-most_radps, most_radps);
        let rightmost_radps = (rotation_radps - gain_radps).max(-most_radps);
        let leftmost_radps = (rotation_radps + gain_radps).min(most_radps);
        let straightest_turn_radps = limits.braked_turn_radps(bearing_rad).clamp(rightmost_radps, leftmost_radps);
        Self { slowest_mps, fastest_mps, rightmost_radps, leftmost_radps, straightest_turn_radps }
    }

    fn translations(&self) -> impl Iterator<Item = f64> + use<> {
        let (least, most) = (self.slowest_mps, self.fastest_mps);
        (0..TRANSLATIONS).map(move |step| least + (most - least) * step as f64 / (TRANSLATIONS - 1) as f64)
    }

    /// Evenly spread, and besides these straight on and the turn to the target.
    fn rotations(&self) -> impl Iterator<Item = f64> + use<> {
        let (least, most) = (self.rightmost_radps, self.leftmost_radps);
        (0..ROTATIONS)
            .map(move |step| least + (most - least) * step as f64 / (ROTATIONS - 1) as f64)
            .chain([0.0_f64.clamp(least, most), self.straightest_turn_radps])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn input(obstacles_in_base: &[Point], target_in_base: Point, speeds: Speeds) -> WindowInput<'_> {
        WindowInput {
            odometry_in_odom: Pose::default(),
            speeds,
            obstacles_in_base,
            target_in_base,
            speed_limit_mps: 0.65,
            remaining_m: 5.0,
        }
    }

    /// Where the robot is after some way on the arc of its speeds.
    fn on_arc(speeds: Speeds, way_m: f64) -> Point {
        let curvature_per_m = speeds.rotation_radps / speeds.translation_mps;
        if curvature_per_m.abs() < 1e-9 {
            return Point::new(way_m, 0.0);
        }
        let (sin, cos) = libm::sincos(way_m * curvature_per_m);
        Point::new(sin / curvature_per_m, (1.0 - cos) / curvature_per_m)
    }

    proptest! {
        #[test]
        fn the_stopping_arc_touches_no_obstacle(
            obstacles in proptest::collection::vec((-2.0..2.0f64, -2.0..2.0f64), 0..30),
            target in (-2.0..2.0f64, -2.0..2.0f64),
            speeds in (0.0..0.7f64, -1.0..1.0f64),
        ) {
            let limits = DriveLimits::default();
            let obstacles: Vec<Point> = obstacles
                .into_iter()
                .map(|(x, y)| Point::new(x, y))
                .filter(|point| point.coords.norm() > limits.robot_radius_m)
                .collect();
            let speeds = Speeds { translation_mps: speeds.0, rotation_radps: speeds.1 };
            let chosen = best_speeds(&limits, &input(&obstacles, Point::new(target.0, target.1), speeds));
            if chosen.translation_mps > 0.0 {
                let stopping_m = limits.stopping_distance_m(chosen.translation_mps);
                for step in 0..=200 {
                    let robot = on_arc(chosen, stopping_m * f64::from(step) / 200.0);
                    for obstacle in &obstacles {
                        let away_m = (obstacle - robot).norm();
                        prop_assert!(away_m > limits.robot_radius_m, "{chosen:?} {obstacle} {away_m}");
                    }
                }
            }
        }
    }

    #[test]
    fn free_distance_agrees_with_small_steps_along_the_arc() {
        let limits = DriveLimits::default();
        for (x, y, rotation_radps) in
            [(1.0, 0.0, 0.0), (1.0, 0.3, 0.0), (0.7, 0.6, 0.8), (0.3, -0.9, -1.0), (0.0, 1.2, 0.9)]
        {
            let speeds = Speeds { translation_mps: 0.5, rotation_radps };
            let obstacle = Point::new(x, y);
            let radius_m = limits.safe_radius_m(0.5);
            let stepped = (0..40_000)
                .map(|step| f64::from(step) * 1e-4)
                .find(|&way_m| (on_arc(speeds, way_m) - obstacle).norm() <= radius_m);
            let free_m = Obstacle::new(&limits, obstacle).free_distance_m(radius_m, rotation_radps / 0.5);
            match stepped {
                Some(way_m) => assert!((way_m - free_m).abs() < 2e-4, "{way_m} {free_m}"),
                None => assert!(free_m > 3.9),
            }
        }
    }

    #[test]
    fn a_free_robot_speeds_up_straight_ahead() {
        let chosen = best_speeds(&DriveLimits::default(), &input(&[], Point::new(3.0, 0.0), Speeds::default()));
        assert!(chosen.translation_mps > 0.1 && chosen.rotation_radps.abs() < 1e-9, "{chosen:?}");
    }

    #[test]
    fn a_target_behind_is_turned_to_in_place() {
        let limits = DriveLimits::default();
        for y in [0.1, -0.1] {
            let chosen = best_speeds(&limits, &input(&[], Point::new(-2.0, y), Speeds::default()));
            assert_eq!(chosen.translation_mps, 0.0);
            assert!(chosen.rotation_radps * y > 0.0, "{chosen:?}");
        }
    }

    #[test]
    fn a_wall_ahead_stops_the_robot() {
        let wall: Vec<Point> = (-20..=20).map(|step| Point::new(0.3, f64::from(step) * 0.05)).collect();
        let speeds = Speeds { translation_mps: 0.4, rotation_radps: 0.0 };
        let chosen = best_speeds(&DriveLimits::default(), &input(&wall, Point::new(2.0, 0.0), speeds));
        assert_eq!(chosen.translation_mps, 0.0);
    }

    #[test]
    fn mirrored_scenes_give_mirrored_speeds() {
        let obstacles = [Point::new(0.9, 0.2), Point::new(0.6, -0.7)];
        let mirrored = obstacles.map(|point| Point::new(point.x, -point.y));
        let limits = DriveLimits::default();
        let left = best_speeds(&limits, &input(&obstacles, Point::new(1.5, 0.4), Speeds::default()));
        let right = best_speeds(&limits, &input(&mirrored, Point::new(1.5, -0.4), Speeds::default()));
        assert_eq!(left.translation_mps, right.translation_mps);
        assert!((left.rotation_radps + right.rotation_radps).abs() < 1e-9);
    }

    #[test]
    fn a_walled_in_robot_is_stuck_after_a_while() {
        let ring: Vec<Point> = (0..72)
            .map(|step| Pose::new(0.0, 0.0, f64::from(step) * PI / 36.0).transform(Point::new(0.28, 0.0)))
            .collect();
        let mut window = DynamicWindow::default();
        let limits = DriveLimits::default();
        let statuses: Vec<WindowStatus> = (0..300)
            .map(|_| window.step(&limits, &input(&ring, Point::new(1.0, 0.0), Speeds::default())).status)
            .collect();
        assert_eq!(statuses[0], WindowStatus::Driving);
        assert_eq!(statuses[299], WindowStatus::Stuck);
    }
}
