//! The experimenter who moves the robot up and down the corridor, and sees where it is.

use rpl_random::Stream;
use rpl_robot::geometry::{Point, Pose, wrap_angle_rad};
use rpl_robot::simulator::Commands;

/// The paper's speed.
const SPEED_MPS: f64 = 0.3;

/// Turning at the ends.
const TURN_RADPS: f64 = 0.7;

/// Further off its heading than this, the robot turns on the spot.
const ASIDE_RAD: f64 = 0.3;

/// How far from the line between the ends a lane may run.
const BESIDE_M: f64 = 0.5;

/// A lane along the corridor, and the way the robot is going on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Shuttle {
    from: Point,
    to: Point,
}

impl Shuttle {
    /// A lane, a place on it and a way to go, all drawn.
    pub fn start([west, east]: [Point; 2], stream: &mut Stream) -> (Self, Pose) {
        let along = (east - west).normalize();
        let across = rpl_robot::geometry::Vector::new(-along.y, along.x) * stream.uniform_in(-BESIDE_M, BESIDE_M);
        let start = west + (east - west) * stream.uniform() + across;
        let (from, to) = if stream.chance(0.5) { (west, east) } else { (east, west) };
        let shuttle = Self { from: from + across, to: to + across };
        let heading_rad = shuttle.heading_rad();
        (shuttle, Pose::new(start.x, start.y, heading_rad))
    }

    fn heading_rad(&self) -> f64 {
        (self.to.y - self.from.y).atan2(self.to.x - self.from.x)
    }

    /// What to command where the robot is; turns round at the end of the lane.
    pub fn commands(&mut self, robot_in_map: Pose) -> Commands {
        let lane = Pose::new(self.from.x, self.from.y, self.heading_rad());
        let on_lane = robot_in_map.relative_to(lane);
        if on_lane.x_m >= (self.to - self.from).norm() {
            std::mem::swap(&mut self.from, &mut self.to);
            return self.commands(robot_in_map);
        }
        // Back to the lane at an angle that falls with the distance from it.
        let wanted_rad = (-on_lane.y_m).clamp(-0.5, 0.5);
        let off_rad = wrap_angle_rad(wanted_rad - on_lane.heading_rad);
        Commands {
            translation_mps: if off_rad.abs() > ASIDE_RAD { 0.0 } else { SPEED_MPS },
            rotation_radps: (2.0 * off_rad).clamp(-TURN_RADPS, TURN_RADPS),
            ..Commands::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_robot_goes_to_the_end_and_back() {
        let (mut shuttle, mut pose) =
            Shuttle::start([Point::new(3.0, 1.0), Point::new(9.0, 1.0)], &mut Stream::new(3, "shuttle"));
        let (mut least, mut most) = (pose.x_m, pose.x_m);
        for _ in 0..1200 {
            let commands = shuttle.commands(pose);
            let (sin, cos) = pose.heading_rad.sin_cos();
            pose = Pose::new(
                pose.x_m + 0.05 * commands.translation_mps * cos,
                pose.y_m + 0.05 * commands.translation_mps * sin,
                pose.heading_rad + 0.05 * commands.rotation_radps,
            );
            (least, most) = (least.min(pose.x_m), most.max(pose.x_m));
            assert!((pose.y_m - 1.0).abs() < BESIDE_M + 0.1);
        }
        assert!((2.8..3.1).contains(&least) && (8.9..9.2).contains(&most), "{least} {most}");
    }
}
