//! The proportional derivative compensator of the pan axis, which keeps the camera at an angle while the
//! robot under it turns (Gutierrez-Osuna and Luo, "Vision").

use crate::description::Camera;
use crate::geometry::wrap_angle_rad;
use serde::{Deserialize, Serialize};

/// Speed for each radian that the camera is off: it is there after about three tenths of a second.
const PROPORTIONAL_PER_S: f64 = 8.0;

/// The share of the speed at which the error changes that is added, to stop in time and to lead where the robot turns.
const DERIVATIVE: f64 = 0.35;

/// What it remembers from step to step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PanControl {
    /// How far the camera was off in the step before; none at first.
    off_rad: Option<f64>,
}

impl PanControl {
    /// The speed of the pan unit that turns the camera to an angle from straight ahead, or as near to it as
    /// it gets. `pan_rad` is where it is, `step_s` the time from step to step.
    pub fn speed_radps(&mut self, camera: &Camera, wanted_rad: f64, pan_rad: f64, step_s: f64) -> f64 {
        let range_rad = camera.pan_range_rad;
        let off_rad = wrap_angle_rad(wanted_rad).clamp(-range_rad, range_rad) - pan_rad;
        let change_radps = self.off_rad.map_or(0.0, |before_rad| (off_rad - before_rad) / step_s);
        self.off_rad = Some(off_rad);
        let speed_radps = PROPORTIONAL_PER_S * off_rad + DERIVATIVE * change_radps;
        speed_radps.clamp(-camera.max_pan_radps, camera.max_pan_radps)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::RobotDescription;
    use crate::simulator::Pan;

    const STEP_S: f64 = 0.05;

    fn camera() -> Camera {
        RobotDescription::builtin("b21-camera").and_then(|robot| robot.camera).expect("it has one")
    }

    /// Where the pan unit is after each step while the robot turns, and where it was wanted.
    fn turned(wanted_rad: impl Fn(f64) -> f64, steps: usize) -> Vec<(f64, f64)> {
        let (camera, mut control, mut pan) = (camera(), PanControl::default(), Pan::default());
        let mut step = |number: usize| {
            let wanted_rad = wanted_rad(number as f64 * STEP_S);
            let speed_radps = control.speed_radps(&camera, wanted_rad, pan.angle_rad, STEP_S);
            pan.step(&camera, speed_radps, STEP_S);
            (wanted_rad, pan.angle_rad)
        };
        (0..steps).map(&mut step).collect()
    }

    #[test]
    fn the_camera_comes_to_an_angle_and_stays_there() {
        for wanted_rad in [0.1, -0.8, 1.5] {
            let way = turned(|_| wanted_rad, 60);
            let overshoot = way.iter().map(|(wanted_rad, pan_rad)| pan_rad / wanted_rad - 1.0).fold(0.0, f64::max);
            assert!(overshoot < 0.15, "{wanted_rad}: {overshoot}");
            assert!(way[30..].iter().all(|(wanted_rad, pan_rad)| (wanted_rad - pan_rad).abs() < 0.02), "{way:?}");
        }
    }

    #[test]
    fn the_camera_stays_on_a_side_while_the_robot_steers_around_something() {
        // The robot turns to and fro by 40° within four seconds: the fastest at 1.1 rad/s.
        let swerve = |time_s: f64| 0.7 - 0.7 * libm::sin(1.57 * time_s);
        let off_rad = turned(swerve, 160)[20..].iter().map(|(wanted, pan)| (wanted - pan).abs()).fold(0.0, f64::max);
        assert!(off_rad < 0.2, "{off_rad}");
    }

    #[test]
    fn an_angle_beyond_the_range_is_gone_to_as_near_as_can_be() {
        let way = turned(|_| 3.1, 80);
        assert!((way[79].1 - camera().pan_range_rad).abs() < 0.01, "{:?}", way[79]);
    }
}
