//! How the map, and what is seen besides it, leads the driver.

use super::model::NavigationModel;
use super::progress::WayLeft;
use super::ways::MapWays;
use crate::avoidance::CollisionAvoidance;
use crate::geometry::{Point, Pose, Transform, distance_m};
use crate::navigation::driver::{Driver, Guidance, Guide};
use crate::navigation::input::NavigationInput;
use crate::navigation::profile::DrivingProfile;
use crate::obstacles::{aligned, aligned_in_narrow};
use crate::planning::{Patch, Target, is_passed};
use crate::world::TravelMode;

/// How far along the way the point lies that the collision avoidance heads for.
const LOOKAHEAD_M: f64 = 2.0;
/// And no nearer than this: towards a corner at its side the robot would turn to and fro.
const AT_HAND_M: f64 = 0.3;
/// The time without a way in the map that counts as unreachable; the estimate may be wrong for a moment.
const UNREACHABLE_S: f64 = 1.0;
/// The way ahead is checked for unmapped obstacles this often.
const LOOK_S: f64 = 0.5;
/// And this far.
const LOOK_M: f64 = 2.0;
/// What comes this much nearer to the way than the robot's disc stands in it.
const BESIDE_WAY_M: f64 = 0.03;
/// Obstacles of the map are looked up this far around the robot while it sees nothing, and its open edge always.
const MAP_SUPPORT_M: f64 = 1.2;

/// Surfaces of narrow places are looked up this far around the robot ...
const SURFACES_M: f64 = 0.9;
/// ... and a reading is off them by no more.
const OFF_SURFACE_M: f64 = 0.08;

/// The guide of one step.
pub(super) struct MapGuide<'s> {
    pub ways: &'s mut MapWays,
    pub model: &'s NavigationModel,
    pub estimated_in_map: Pose,
    pub input: &'s NavigationInput<'s>,
    pub mode: TravelMode,
}

impl Guide for MapGuide<'_> {
    const LEFT_AGAIN_M: f64 = 0.4;

    fn pose(&self) -> Pose {
        self.estimated_in_map
    }

    fn driving_pose(&self) -> Pose {
        let narrow = self.model.planner.narrow_places(self.estimated_in_map.point());
        if !narrow.is_empty() {
            aligned_in_narrow(&narrow, &self.ways.memory, self.input.odometry_in_odom, self.estimated_in_map)
        } else if self.input.sees() {
            self.estimated_in_map
        } else {
            aligned(&self.model.planner, &self.ways.memory, self.input.odometry_in_odom, self.estimated_in_map)
        }
    }

    fn is_passed(&self, here: Point, target: Point, next: Point) -> bool {
        is_passed(&self.model.planner, here, target, next)
    }

    fn take_next_target(&mut self, _: f64) {
        self.ways.progress.measure_other_way();
    }

    fn direct(&mut self, driver: &mut Driver, first: Target, robot: Pose) -> Guidance {
        self.look_for_blockages(driver, robot, first);
        match self.towards(driver, robot.point(), first) {
            Some(point) => {
                self.ways.without_way_s = 0.0;
                Guidance::Towards(point)
            }
            None => {
                self.ways.without_way_s += self.model.limits.step_s;
                if self.ways.without_way_s > UNREACHABLE_S { Guidance::NoWay } else { Guidance::Wait }
            }
        }
    }

    /// Whether the robot has not come nearer for long. If so for a while, it begins anew.
    fn has_stalled(&mut self, driver: &mut Driver, first: Target, here: Point) -> bool {
        let now_s = driver.now_s;
        let costs = self.ways.costs(self.model, first, now_s);
        if let Some(cost_m) = costs.mapped.cost_m(here) {
            let left = WayLeft {
                cost_m,
                avoided_doors: self.ways.avoided_doors(now_s),
                around_m: costs.around.cost_m(here),
                is_at_closed_door: self.ways.is_at_closed_door(self.model, here, now_s),
            };
            self.ways.progress.measure(now_s, &left);
            if self.ways.progress.is_time_to_begin_anew(now_s) {
                self.begin_anew(driver);
            }
        }
        self.ways.progress.has_stalled(now_s)
    }

    fn stalled_s(&self, now_s: f64) -> f64 {
        self.ways.progress.since_s(now_s)
    }

    fn obstacles_in_base(&self, robot: Pose) -> Vec<Point> {
        let mut obstacles_in_base = Vec::new();
        self.ways.memory.append_in_base(self.input.odometry_in_odom, &mut obstacles_in_base);
        let narrow = self.model.planner.narrow_places(robot.point());
        if !narrow.is_empty() {
            put_onto_map(&narrow, robot, &mut obstacles_in_base);
        }
        let map_in_base = Transform::new(robot.inverse());
        if !self.input.sees() {
            let mapped = self.model.planner.obstacle_edges_near(robot.point(), MAP_SUPPORT_M);
            obstacles_in_base.extend(mapped.into_iter().map(|point| map_in_base.apply(point)));
        }
        // No sensor finds it.
        let edge = self.model.planner.open_edge_near(robot.point(), MAP_SUPPORT_M);
        obstacles_in_base.extend(edge.map(|point| map_in_base.apply(point)));
        obstacles_in_base
    }

    fn speed_limit_mps(&self, obstacles_in_base: &[Point]) -> f64 {
        let limit_mps = self.model.limits.speed_limit_mps(self.mode);
        match self.is_narrow() {
            true => limit_mps.min(DrivingProfile::IN_NARROW.speed_in_gap_mps(&self.model.limits, obstacles_in_base)),
            false => limit_mps,
        }
    }
}

/// In a narrow place the air there is is less than the noise of single readings. What is seen within reach of a surface
/// of the map is of it, and the surface is where the map has it.
fn put_onto_map(narrow: &[&Patch], robot: Pose, obstacles_in_base: &mut Vec<Point>) {
    let base_in_map = Transform::new(robot);
    obstacles_in_base.retain(|&point| {
        let at = base_in_map.apply(point);
        narrow.iter().filter_map(|patch| patch.off_surface_m(at)).all(|off_m| off_m > OFF_SURFACE_M)
    });
    let map_in_base = Transform::new(robot.inverse());
    let surfaces = narrow.iter().enumerate().flat_map(|(number, patch)| {
        // Patches overlap.
        patch.surfaces().filter(move |&at| narrow[..number].iter().all(|other| other.off_surface_m(at).is_none()))
    });
    let near = surfaces.filter(|at| distance_m(*at, robot.point()) < SURFACES_M);
    obstacles_in_base.extend(near.map(|at| map_in_base.apply(at)));
}

impl MapGuide<'_> {
    /// Whether the robot is beside a narrow place.
    pub fn is_narrow(&self) -> bool {
        !self.model.planner.narrow_places(self.estimated_in_map.point()).is_empty()
    }

    /// The point to head for. If something stands at an intermediate target, the next target is
    /// headed for instead. Without any way the blockages are forgotten, for some may have gone. If
    /// there still is none, doors found closed are tried: somebody may open them.
    fn towards(&mut self, driver: &mut Driver, here: Point, first: Target) -> Option<Point> {
        let now_s = driver.now_s;
        let towards = self.ahead(now_s, here, first);
        if towards.is_some() || (self.ways.blockages.is_empty() && self.ways.avoided_doors(now_s).is_empty()) {
            return towards;
        }
        if let [_, next, ..] = driver.targets[..]
            && let Some(towards) = self.ahead(now_s, here, next)
        {
            driver.targets.remove(0);
            self.ways.progress.measure_other_way();
            return Some(towards);
        }
        self.ways.trust_map(now_s);
        if let Some(towards) = self.ahead(now_s, here, first) {
            return Some(towards);
        }
        self.ways.try_doors(now_s);
        self.ahead(now_s, here, first)
    }

    fn ahead(&mut self, now_s: f64, here: Point, target: Target) -> Option<Point> {
        self.ways.costs(self.model, target, now_s).around.lookahead(here, AT_HAND_M, LOOKAHEAD_M)
    }

    /// What holds the robot up may be an echo long gone: it looks again, and tries the map's way.
    fn begin_anew(&mut self, driver: &mut Driver) {
        self.ways.progress.begin_anew(driver.now_s);
        self.ways.memory.forget();
        driver.avoidance = CollisionAvoidance::default();
        self.ways.trust_map(driver.now_s);
        self.ways.want_sonars(driver.now_s);
    }

    /// Turns unmapped obstacle points into blockages if any of them stands on the way ahead. People
    /// who walk are left to the collision avoidance: until a way around them is planned they are
    /// elsewhere, and with twenty of them about the ways would never be the same for a second.
    fn look_for_blockages(&mut self, driver: &mut Driver, robot: Pose, first: Target) {
        let (now_s, odometry_in_odom) = (driver.now_s, self.input.odometry_in_odom);
        if now_s < self.ways.next_look_s {
            return;
        }
        self.ways.next_look_s = now_s + LOOK_S;
        let seen = self.ways.sharp_points(robot, odometry_in_odom);
        self.ways.blockages.forget(robot.point(), &seen, now_s);
        self.look_at_doors(driver, robot, &seen);
        if self.ways.doubts_map(now_s) {
            let unmapped = self.ways.unmapped_points(self.model, robot, odometry_in_odom);
            let costs = self.ways.costs(self.model, first, now_s);
            let way = costs.around.way_ahead(robot.point(), LOOK_M).unwrap_or_default();
            let reach_m = self.model.limits.robot_radius_m + BESIDE_WAY_M;
            // What the robot touches was in its way.
            let stands_in_way = |&(point, is_felt): &(Point, bool)| {
                is_felt || way.iter().any(|&on_way| distance_m(on_way, point) < reach_m)
            };
            if unmapped.iter().any(stands_in_way) {
                self.ways.blockages.add(&unmapped, now_s);
            }
        }
    }

    /// A door found closed, or open again, is a new task: there is nothing to escape from.
    fn look_at_doors(&mut self, driver: &mut Driver, robot: Pose, seen_in_map: &[Point]) {
        let now_s = driver.now_s;
        let before = self.ways.closed_doors(now_s);
        let robot_width_m = 2.0 * self.model.limits.robot_radius_m;
        self.ways.doors.look(&self.model.doorways, robot.point(), seen_in_map, robot_width_m, now_s, LOOK_S);
        let closed = self.ways.closed_doors(now_s);
        if closed != before {
            self.ways.progress.find_doors(now_s, &before, &closed);
            driver.avoidance = CollisionAvoidance::default();
        }
    }
}
