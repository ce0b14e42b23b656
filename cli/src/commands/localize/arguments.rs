//! The arguments of `rpl localize`.

use super::topics::Wanted;
use clap::ValueHint;
use clap_complete::engine::ArgValueCompleter;
use rpl_lang::visible::visible;
use rpl_robot::geometry::Pose;
use rpl_robot::recording::{FirstReading, LaserMount, TrialStart};
use rpl_shell::arguments::completion;
use rpl_shell::arguments::numbers::{number, positive};
use rpl_shell::files::shown::Shown;
use std::path::PathBuf;

/// Windows, if nobody says how many.
pub const WINDOWS: usize = 20;

/// Localize the robot in a recorded drive, and report how well
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Map of the ROS map_server: its YAML file, or a folder with a map.yaml
    #[arg(long, value_name = "MAP", add = ArgValueCompleter::new(completion::maps), required_unless_present = "world")]
    pub map: Option<PathBuf>,
    /// World whose map it is, instead of a map: for recordings of `rpl run --mcap`
    #[arg(long, value_name = "W", add = ArgValueCompleter::new(completion::worlds), conflicts_with = "map")]
    pub world: Option<String>,
    /// CARMEN log with FLASER or ROBOTLASER1 messages and corrected poses, or an MCAP recording with scans, odometry
    /// and corrected poses; either also packed. Or a folder with MCAP, as `ros2 bag record` makes it
    #[arg(long, value_name = "LOG", value_hint = ValueHint::AnyPath)]
    pub log: PathBuf,
    /// Topic of the scans in an MCAP recording (default: the only LaserScan, or /scan)
    #[arg(long, value_name = "TOPIC")]
    pub scan: Option<String>,
    /// Topic of the odometry in an MCAP recording (default: the only Odometry, or /odom)
    #[arg(long, value_name = "TOPIC")]
    pub odom: Option<String>,
    /// Topic of the corrected poses in an MCAP recording: PoseStamped, PoseWithCovarianceStamped or Odometry (default:
    /// /ground_truth, /amcl_pose, /pose, or the only one)
    #[arg(long, value_name = "TOPIC")]
    pub truth: Option<String>,
    /// Number of beams used of each scan, equally spaced
    #[arg(long, value_name = "N", default_value_t = 24)]
    pub beams: usize,
    /// Number of windows, with starts spread over the drive (default: 20; with --from-truth one, the
    /// whole drive)
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub windows: Option<u32>,
    /// Length of a window, in metres
    #[arg(long, value_name = "M", default_value_t = 25.0, value_parser = positive)]
    pub window_length: f64,
    /// Start of the first window, as a share of the distance to the second one; use other windows for
    /// tuning than for reporting
    #[arg(long, value_name = "SHARE", default_value_t = 0.5, value_parser = share)]
    pub phase: f64,
    /// Run the windows N times, each time with starts shifted by an N-th of the distance between two starts, from
    /// --phase on; windows of different phases overlap
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub phases: u32,
    /// Start each window without knowledge of the pose (default)
    #[arg(long, conflicts_with = "from_truth")]
    pub uniform: bool,
    /// Start at the corrected pose, to measure how well a position is tracked
    #[arg(long)]
    pub from_truth: bool,
    /// Localize by single scans: compare N scans, evenly spread over the drive, with the whole map (default: 200)
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "200",
        value_parser = clap::value_parser!(u32).range(1..=1_000_000),
        conflicts_with_all = ["windows", "phases", "phase", "window_length", "from_truth", "uniform", "fit", "figures"])]
    pub once: Option<u32>,
    /// Field of view of the laser of FLASER messages, in degrees
    #[arg(long, value_name = "DEG", default_value_t = 180.0, value_parser = angle)]
    pub field_of_view: f64,
    /// Side of the first reading of a FLASER message
    #[arg(long, value_name = "END", value_enum, default_value_t = End::Right)]
    pub first_reading: End,
    /// Place of the laser on the robot: metres to the front and to the left, degrees to the left
    #[arg(long, value_name = "X,Y,DEG", default_value = "0,0,0", value_parser = mount, allow_hyphen_values = true)]
    pub mount: Pose,
    /// File with the parameters of the filter, from --fit
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub parameters: Option<PathBuf>,
    /// Fit the sensor and odometry models to the drive and write the parameters to this file
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with_all = ["figures", "json", "from_truth", "uniform"])]
    pub fit: Option<PathBuf>,
    /// Draw map and paths, the errors over the way, and the calibration of the certainty into this folder
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub figures: Option<PathBuf>,
    /// Print the results as one JSON object
    #[arg(long)]
    pub json: bool,
    /// Memory limit for tables and belief, in GiB
    #[arg(long, value_name = "GIB", default_value_t = 4.0, value_parser = positive)]
    pub memory: f64,
}

/// An end of a scan.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// On the right
    Right,
    /// On the left
    Left,
}

impl Arguments {
    /// What is known at the start of a window.
    pub fn start(&self) -> TrialStart {
        if self.from_truth { TrialStart::FromTruth } else { TrialStart::Uniform }
    }

    /// The phases of the windows, from --phase on and around.
    pub fn all_phases(&self) -> Vec<f64> {
        let around = |turn: u32| {
            let phase = (self.phase + f64::from(turn) / f64::from(self.phases)).fract();
            // As people write it.
            (phase * 1e9).round() / 1e9
        };
        (0..self.phases).map(around).collect()
    }

    /// What the user has said of the topics of a recording.
    pub fn topics(&self) -> Wanted<'_> {
        Wanted { scan: self.scan.as_deref(), odom: self.odom.as_deref(), truth: self.truth.as_deref() }
    }

    /// The map, or the world that has it, as it was named.
    pub fn map_name(&self) -> String {
        let world = || visible(self.world.as_deref().unwrap_or_default()).into_owned();
        self.map.as_ref().map_or_else(world, |map| map.shown())
    }

    /// What a log does not say about its laser.
    pub fn laser(&self) -> LaserMount {
        let first = match self.first_reading {
            End::Right => FirstReading::Right,
            End::Left => FirstReading::Left,
        };
        LaserMount { field_of_view_rad: self.field_of_view.to_radians(), first, laser_in_base: self.mount }
    }
}

fn share(text: &str) -> Result<f64, String> {
    let within = |value: &f64| (0.0..1.0).contains(value);
    number(text)
        .and_then(|value| if within(&value) { Ok(value) } else { Err("it must be from 0 to below 1".to_string()) })
}

fn angle(text: &str) -> Result<f64, String> {
    let fits = |value: &f64| *value > 0.0 && *value <= 360.0;
    number(text)
        .and_then(|value| if fits(&value) { Ok(value) } else { Err("it must be above 0 and at most 360".to_string()) })
}

fn mount(text: &str) -> Result<Pose, String> {
    let numbers: Vec<f64> = text.split(',').map(number).collect::<Result<_, _>>()?;
    match numbers[..] {
        [x_m, y_m, heading_deg] => Ok(Pose::new(x_m, y_m, heading_deg.to_radians())),
        _ => Err("write three numbers, like `0.2,0,0`".to_string()),
    }
}
