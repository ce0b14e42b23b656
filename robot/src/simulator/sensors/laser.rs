//! The laser range finder.

use crate::geometry::Pose;
use crate::simulator::commands::Commands;
use crate::simulator::model::SimulatorModel;
use crate::simulator::state::SimulatorState;
use rpl_random::Stream;

impl SimulatorModel {
    /// One scan; none if the robot has no laser.
    pub(super) fn scan_laser(&self, state: &SimulatorState, _: &Commands, stream: &mut Stream) -> Option<Vec<f32>> {
        let laser = self.robot().laser?;
        let most_m = laser.scanner.range_m;
        let ranges_m = self.laser_ranges(state, state.robot_in_map);
        let readings = ranges_m.into_iter().map(|range_m| {
            if stream.chance(laser.dropout_probability) || range_m >= most_m {
                return most_m as f32;
            }
            (range_m + laser.noise_m * stream.normal()).clamp(0.0, most_m) as f32
        });
        Some(readings.collect())
    }

    /// Distance to the first surface that the robot's laser sees along each reading, at most its range: no
    /// noise. Nothing without a laser.
    pub fn laser_ranges(&self, state: &SimulatorState, robot_in_map: Pose) -> Vec<f64> {
        let Some(fan) = &self.laser_fan else { return Vec::new() };
        let mut ranges_m = vec![fan.scanner.range_m; fan.scanner.readings];
        self.for_each_visible(
            state,
            robot_in_map,
            |seen_by| seen_by.laser,
            |form, _| {
                fan.lay(form, &mut ranges_m, |range_m, hit_m| *range_m = range_m.min(hit_m));
            },
        );
        ranges_m
    }
}
