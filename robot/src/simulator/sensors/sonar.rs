//! From the nearest surfaces to what the sonars report.

use super::Commands;
use crate::sensors::SONARS;
use crate::simulator::model::SimulatorModel;
use crate::simulator::state::SimulatorState;
use crate::simulator::sweep::Echo;
use rpl_random::Stream;

impl SimulatorModel {
    /// One firing of the ring; none if it is off or has failed.
    pub(super) fn fire_sonars(
        &self,
        state: &SimulatorState,
        commands: &Commands,
        stream: &mut Stream,
    ) -> Option<[f32; SONARS]> {
        if !commands.sonars_on || state.time_us < state.sonars_fail_until_us {
            return None;
        }
        let echoes = self.sonar_echoes(state, state.robot_in_map);
        let incidence_limit_cos = libm::cos(self.settings.specular_angle_rad);
        let pose_hash = self.specular_hash(state);
        let mut readings = [0.0; SONARS];
        for (sonar, (reading, echo)) in readings.iter_mut().zip(&echoes).enumerate() {
            let draws = Draws::new(pose_hash, sonar);
            *reading = self.sonar_reading(stream, echo, incidence_limit_cos, draws) as f32;
        }
        Some(readings)
    }

    fn sonar_reading(&self, stream: &mut Stream, echo: &Echo, incidence_limit_cos: f64, mut miss: Draws) -> f64 {
        let settings = &self.settings;
        let (nearest_m, farthest_m) = (settings.robot_radius_m, settings.sonar_max_range_m);
        let event = stream.uniform();
        if event < settings.dropout_probability {
            return farthest_m;
        }
        if event < settings.dropout_probability + settings.crosstalk_probability {
            return stream.uniform_in(nearest_m, echo.range_m.min(farthest_m).max(nearest_m));
        }
        if echo.range_m > farthest_m {
            return farthest_m;
        }
        let miss_probability = if echo.corner {
            settings.edge_miss_probability
        } else if echo.incidence_cos < incidence_limit_cos {
            settings.specular_miss_probability
        } else {
            0.0
        };
        let mut range_m = echo.range_m;
        if miss.uniform() < miss_probability {
            if miss.uniform() < settings.specular_silence_probability {
                return farthest_m;
            }
            range_m += (farthest_m - range_m) * miss.uniform();
        }
        let sigma_m = settings.sonar_noise_m + settings.sonar_noise_per_m * range_m;
        (range_m + sigma_m * stream.normal()).clamp(nearest_m, farthest_m)
    }

    /// One number for all poses close enough to hit the same walls in the same way.
    fn specular_hash(&self, state: &SimulatorState) -> u64 {
        let settings = &self.settings;
        let pose = state.robot_in_map;
        let patch = |value: f64, size: f64| libm::floor(value / size) as i64 as u64;
        [
            patch(pose.x_m, settings.specular_coherence_m),
            patch(pose.y_m, settings.specular_coherence_m),
            patch(pose.heading_rad, settings.specular_coherence_rad),
        ]
        .into_iter()
        .fold(mix(state.specular_seed), |hash, part| mix(hash ^ part))
    }
}

/// Numbers that depend on nothing but where the robot is.
#[derive(Clone, Copy)]
struct Draws(u64);

impl Draws {
    fn new(pose_hash: u64, sonar: usize) -> Self {
        Self(mix(pose_hash ^ sonar as u64))
    }

    fn uniform(&mut self) -> f64 {
        self.0 = mix(self.0);
        (self.0 >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }
}

/// The finalizer of SplitMix64: every bit of the input changes every bit of the output.
fn mix(value: u64) -> u64 {
    let value = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    value ^ (value >> 31)
}
