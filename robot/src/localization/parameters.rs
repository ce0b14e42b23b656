//! What can be set about the filter.

use serde::{Deserialize, Serialize};

/// Sonars around the robot; sonar `i` points `i · 15°` to the left of straight ahead.
pub const SONARS: usize = 24;

/// Everything that can be set about the filter.
///
/// # Deviation
/// The defaults depart from the papers in six ways, each switchable, because the literal
/// equations lose a robot turned by hand: 24 overlapping cones of one scan are not independent
/// evidence, so a scan is *tempered*; an update waits for some motion, so that a standing robot
/// does not count the same evidence again; a little of the uniform distribution is *mixed* in, so
/// that no hypothesis is beyond recall; and readings clearly shorter than expected are *gated*,
/// because they are usually people and furniture outside the map; θ is lower; and a turn
/// by hand is watched for.
/// [`LocalizationParameters::literal`] has none of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LocalizationParameters {
    /// Edge of a belief cell.
    pub cell_m: f64,
    /// Whole degrees between two headings; must divide 360.
    pub angle_step_deg: u32,
    /// Whether the grid is centred on the world, so that mirror poses fall on mirror cells; else it
    /// is laid from the corner of the map.
    pub centred: bool,
    /// Positions nearer than this to anything occupied carry no mass: the robot is a disc.
    pub clearance_m: f64,
    /// The sonar model.
    pub sensor: SensorParameters,
    /// The error model of the odometry.
    pub odometry: OdometryError,
    /// Exponent of a scan's likelihood; 1 takes the beams as independent.
    pub tempering: f64,
    /// Share of the uniform distribution mixed in after an update; 0 is none.
    pub mixing: f64,
    /// Readings to leave out; none leaves out none.
    pub gating: Option<Gating>,
    /// The watch for a robot that was turned by hand; none does not watch.
    pub turn_watch: Option<TurnWatch>,
    /// θ of Beetz et al. Eqs. (3)–(4) as a share of the prior probability of a cell; 0 updates
    /// every cell every time. With the papers' 1 %, one of two mirror poses can lose the edge of its
    /// peak before the other does and then falls behind; well above `mixing`, or nothing ever sleeps.
    pub activity_threshold: f64,
    /// An update is due after this distance ...
    pub update_distance_m: f64,
    /// ... or after turning by this much.
    pub update_angle_rad: f64,
    /// A robot at rest updates after so many observations ...
    pub standing_observations: u32,
    /// ... but at most so many times, until it moves or sees something new.
    pub standing_updates: u32,
}

impl Default for LocalizationParameters {
    fn default() -> Self {
        Self {
            cell_m: 0.15,
            angle_step_deg: 2,
            centred: true,
            clearance_m: 0.15,
            sensor: SensorParameters::default(),
            odometry: OdometryError::default(),
            tempering: 0.15,
            mixing: 5e-4,
            gating: Some(Gating::default()),
            turn_watch: Some(TurnWatch::default()),
            activity_threshold: 0.003,
            update_distance_m: 0.15,
            update_angle_rad: 10f64.to_radians(),
            standing_observations: 20,
            standing_updates: 5,
        }
    }
}

impl LocalizationParameters {
    /// The equations as printed: every scan counts in full, at every step, and nothing is mixed in.
    pub fn literal() -> Self {
        Self {
            tempering: 1.0,
            mixing: 0.0,
            gating: None,
            turn_watch: None,
            activity_threshold: 0.01,
            update_distance_m: 0.0,
            update_angle_rad: 0.0,
            ..Self::default()
        }
    }

    /// A coarse grid (30 cm, 6°) for tests and for saving often.
    pub fn coarse() -> Self {
        Self { cell_m: 0.3, angle_step_deg: 6, ..Self::default() }
    }
}

/// P(s | o) of one sonar: a mixture of a Gaussian around the expected distance, a uniform and a
/// geometric density (Fox, Burgard, Thrun §3.2), and the echo that never comes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorParameters {
    /// Readings at or beyond this are "no echo".
    pub max_range_m: f64,
    /// Readings are measured from this far in front of the robot's middle.
    pub mount_radius_m: f64,
    /// Full opening angle of the cone; the nearest surface in it is expected.
    pub cone_deg: u32,
    /// Standard deviation of the Gaussian, which must cover half a belief cell.
    pub sigma_m: f64,
    /// What the standard deviation grows by per metre of distance.
    pub sigma_per_m: f64,
    /// Weight of the Gaussian.
    pub hit: f64,
    /// Weight of the uniform density.
    pub uniform: f64,
    /// Weight of the geometric density: something unmapped stands before the expected surface.
    pub short: f64,
    /// Mean distance of what is unmapped.
    pub short_mean_m: f64,
    /// Weight of "no echo": the surface turned the sound away.
    pub missed: f64,
}

impl Default for SensorParameters {
    fn default() -> Self {
        Self {
            max_range_m: 5.0,
            mount_radius_m: 0.0,
            cone_deg: 15,
            sigma_m: 0.12,
            sigma_per_m: 0.02,
            hit: 0.55,
            uniform: 0.08,
            short: 0.12,
            short_mean_m: 2.0,
            missed: 0.25,
        }
    }
}

/// How far odometry strays: variances grow in proportion to the way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OdometryError {
    /// Standard deviation along the heading after one metre.
    pub forward_m: f64,
    /// Standard deviation across the heading after one metre.
    pub sideward_m: f64,
    /// Standard deviation of the heading after one metre.
    pub turn_per_metre_rad: f64,
    /// Standard deviation of the heading after turning by one radian.
    pub turn_per_radian_rad: f64,
}

impl Default for OdometryError {
    fn default() -> Self {
        Self {
            forward_m: 0.06,
            sideward_m: 0.03,
            turn_per_metre_rad: 1.5f64.to_radians(),
            turn_per_radian_rad: 3f64.to_radians(),
        }
    }
}

/// Which readings to leave out: those clearly shorter than the estimated pose explains, as long
/// as they are few. Many short readings speak against the pose and not for furniture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gating {
    /// By how much a reading must fall short.
    pub margin_m: f64,
    /// More short readings than this are all kept.
    pub max_readings: usize,
    /// Below this certainty nothing is left out.
    pub min_certainty: f64,
}

impl Default for Gating {
    fn default() -> Self {
        Self { margin_m: 0.4, max_readings: 4, min_certainty: 0.5 }
    }
}

/// Watches whether scans fit another heading at the estimated place better than the estimated one.
///
/// # Deviation
/// Selective computation notices a lost pose only once scans fit worse than they would on average
/// anywhere, which at some places takes metres. Being turned by hand is the likeliest way to get
/// lost on the spot, and its alternatives are few: the tempered log-likelihood ratio of the best
/// other heading is summed up (a CUSUM test), and at a limit the belief is mixed with the uniform one,
/// so that the full update decides. The test by itself moves no mass to any pose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TurnWatch {
    /// Other headings are at least this far off.
    pub away_rad: f64,
    /// Taken off the sum at each scan, in nats: the best of many headings fits well by chance.
    pub drift: f64,
    /// The sum that counts as turned, in nats.
    pub limit: f64,
    /// Share of the uniform distribution mixed in then.
    pub mixing: f64,
}

impl Default for TurnWatch {
    fn default() -> Self {
        Self { away_rad: 20f64.to_radians(), drift: 0.5, limit: 3.0, mixing: 0.02 }
    }
}

/// Standard deviations of a belief around a known pose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// In x and in y.
    pub position_m: f64,
    /// In the heading.
    pub heading_rad: f64,
}

impl Default for Spread {
    fn default() -> Self {
        Self { position_m: 0.15, heading_rad: 3f64.to_radians() }
    }
}
