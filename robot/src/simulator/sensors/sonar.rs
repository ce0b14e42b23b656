//! From the nearest surfaces to what the sonars report.

use crate::description::Sonar;
use crate::simulator::commands::Commands;
use crate::simulator::echo::Echo;
use crate::simulator::model::SimulatorModel;
use crate::simulator::place_draws::PlaceDraws;
use crate::simulator::state::SimulatorState;
use rpl_random::Stream;

impl SimulatorModel {
    /// Whether there are sonars that have failed.
    pub(in crate::simulator) fn have_sonars_failed(&self, state: &SimulatorState) -> bool {
        self.sensors.sonars.is_some() && state.time_us < state.sonars_fail_until_us
    }

    /// One firing of all sonars; none if there are none, or they are off or have failed.
    pub(super) fn fire_sonars(
        &self,
        state: &SimulatorState,
        commands: &Commands,
        stream: &mut Stream,
    ) -> Option<Vec<f32>> {
        let (sonar, sonars) = self.robot().sonar.as_ref().zip(self.sensors.sonars.as_ref())?;
        if !commands.sonars_on || self.have_sonars_failed(state) {
            return None;
        }
        let echoes = self.sonar_echoes(sonars, state, state.robot_in_map);
        let incidence_limit_cos = libm::cos(sonar.specular_angle_rad);
        let here = specular_draws(sonar, state);
        let heard = echoes.iter().zip(&self.sonar_rims_m).enumerate().map(|(number, (echo, &rim_m))| {
            let miss = here.of(number as u64);
            Hearing { sonar, rim_m, incidence_limit_cos, miss }.reading_m(stream, echo) as f32
        });
        Some(heard.collect())
    }
}

/// What one sonar makes of its echo.
struct Hearing<'r> {
    sonar: &'r Sonar,
    rim_m: f64,
    incidence_limit_cos: f64,
    miss: PlaceDraws,
}

impl Hearing<'_> {
    fn reading_m(self, stream: &mut Stream, echo: &Echo) -> f64 {
        let Self { sonar, rim_m: nearest_m, incidence_limit_cos, mut miss } = self;
        let farthest_m = sonar.range_m;
        let event = stream.uniform();
        if event < sonar.dropout_probability {
            return farthest_m;
        }
        if event < sonar.dropout_probability + sonar.crosstalk_probability {
            return stream.uniform_in(nearest_m, echo.range_m.min(farthest_m).max(nearest_m));
        }
        if echo.range_m > farthest_m {
            return farthest_m;
        }
        let miss_probability = if echo.corner {
            sonar.edge_miss_probability
        } else if echo.incidence_cos < incidence_limit_cos {
            sonar.specular_miss_probability
        } else {
            0.0
        };
        let mut range_m = echo.range_m;
        if miss.uniform() < miss_probability {
            if miss.uniform() < sonar.specular_silence_probability {
                return farthest_m;
            }
            range_m += (farthest_m - range_m) * miss.uniform();
        }
        let sigma_m = sonar.noise_m + sonar.noise_per_m * range_m;
        (range_m + sigma_m * stream.normal()).clamp(nearest_m, farthest_m)
    }
}

/// One number for all poses close enough to hit the same walls in the same way.
fn specular_draws(sonar: &Sonar, state: &SimulatorState) -> PlaceDraws {
    let pose = state.robot_in_map;
    PlaceDraws::new(state.place_seed)
        .at(pose.x_m, sonar.specular_coherence_m)
        .at(pose.y_m, sonar.specular_coherence_m)
        .at(pose.heading_rad, sonar.specular_coherence_rad)
}
