//! How what has been seen leads the driver.

use super::ways::SeenWays;
use crate::avoidance::{CollisionAvoidance, DriveLimits};
use crate::geometry::{Point, Pose, distance_m};
use crate::navigation::driver::{Driver, Guidance, Guide};
use crate::navigation::input::NavigationInput;
use crate::obstacles::{is_seen, points_in_base};
use crate::planning::Target;

/// The guide of one step.
pub(super) struct SeenGuide<'s> {
    pub ways: &'s mut SeenWays,
    pub limits: &'s DriveLimits,
    /// With a smoothed scan.
    pub input: &'s NavigationInput<'s>,
    pub speed_limit_mps: f64,
}

impl Guide for SeenGuide<'_> {
    /// Odometry does not jump: who stands there still does.
    const LEFT_AGAIN_M: f64 = f64::INFINITY;

    fn pose(&self) -> Pose {
        self.input.odometry_in_odom
    }

    fn driving_pose(&self) -> Pose {
        self.input.odometry_in_odom
    }

    /// What has been seen of the way to the next target may be little.
    fn is_passed(&self, _: Point, _: Point, _: Point) -> bool {
        false
    }

    fn take_next_target(&mut self, now_s: f64) {
        self.ways.take_next_target(now_s);
    }

    /// Without a way the robot goes for the next target, then looks around, then gives up.
    fn direct(&mut self, driver: &mut Driver, first: Target, robot: Pose) -> Guidance {
        let (here, now_s) = (robot.point(), driver.now_s);
        self.ways.look_at_way(self.limits, here, first.point_in_frame, now_s);
        let lookahead_m = self.ways.profile().lookahead_m;
        let costs = self.ways.costs(self.limits);
        if let Some(point) = costs.and_then(|costs| costs.lookahead(here, 0.0, lookahead_m)) {
            return Guidance::Towards(point);
        }
        if driver.targets.len() > 1 {
            driver.targets.remove(0);
            self.ways.take_next_target(now_s);
            return Guidance::Wait;
        }
        if self.ways.progress.looked_around {
            return Guidance::NoWay;
        }
        self.ways.progress.looked_around = true;
        self.ways.doubt(here);
        self.ways.look_soon(now_s);
        Guidance::LookAround
    }

    /// Whether the robot has neither come nearer nor seen anything new for long. Nearer to a target at hand is nearer
    /// as the crow flies, and what is forgotten to wait there is not new when it is seen again.
    fn has_stalled(&mut self, driver: &mut Driver, first: Target, here: Point) -> bool {
        let now_s = driver.now_s;
        let (cost_m, seen_cells) = if self.ways.is_nearby() {
            (Some(distance_m(here, first.point_in_frame)), 0)
        } else {
            let cost_m = self.ways.costs(self.limits).and_then(|costs| costs.cost_m(here));
            (cost_m, self.ways.seen.seen_cells())
        };
        self.ways.progress.measure(now_s, cost_m, seen_cells);
        if self.ways.progress.is_time_to_begin_anew(now_s) {
            self.begin_anew(driver, here);
        }
        self.ways.progress.has_stalled(now_s, cost_m)
    }

    fn stalled_s(&self, now_s: f64) -> f64 {
        self.ways.progress.since_s(now_s)
    }

    /// What the laser sees, and what is remembered of the surfaces it does not see now: a reading a
    /// little short of a surface would close a narrow gap for as long as it is remembered.
    fn obstacles_in_base(&self, robot: Pose) -> Vec<Point> {
        let mut obstacles_in_base = Vec::new();
        self.ways.scanned.append_in_base(robot, &mut obstacles_in_base);
        if let Some(scan) = self.input.laser {
            obstacles_in_base.retain(|&point| !is_seen(scan, point));
            obstacles_in_base.extend(points_in_base(scan));
        }
        self.ways.heard.append_in_base(robot, &mut obstacles_in_base);
        obstacles_in_base
    }

    fn speed_limit_mps(&self, obstacles_in_base: &[Point]) -> f64 {
        self.speed_limit_mps.min(self.ways.profile().speed_in_gap_mps(self.limits, obstacles_in_base))
    }
}

impl SeenGuide<'_> {
    /// What holds the robot up may be an echo long gone.
    fn begin_anew(&mut self, driver: &mut Driver, here: Point) {
        self.ways.progress.begin_anew();
        self.ways.heard.forget();
        self.ways.scanned.forget();
        driver.avoidance = CollisionAvoidance::default();
        self.ways.doubt(here);
    }
}
