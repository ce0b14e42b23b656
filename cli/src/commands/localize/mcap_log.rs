//! A recorded drive from an MCAP file: each scan on `/scan` with what `/odom` last said, and with the corrected pose that
//! `/ground_truth`, or without it `/pose`, last said.

use anyhow::{Context, Result, bail};
use mcap::MessageStream;
use rpl_robot::geometry::Pose;
use rpl_robot::recording::{Recording, Scan, ScanGeometry};
use rpl_ros_messages::messages::{self as ros, LaserScan, Odometry, PoseStamped, PoseWithCovarianceStamped};
use rpl_ros_messages::{Message, from_cdr};
use serde::de::DeserializeOwned;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// How the file begins.
const MAGIC: &[u8] = b"\x89MCAP";

/// A longer recording is refused: it is read as a whole. An hour of a robot with a laser takes a fifth of that.
pub const MOST_BYTES: u64 = 2 << 30;

/// Whether this is such a file.
pub fn is_mcap(path: &Path) -> bool {
    let mut head = [0; MAGIC.len()];
    path.is_file() && File::open(path).and_then(|mut file| file.read_exact(&mut head)).is_ok() && head == MAGIC
}

/// What was last heard, while scans are gathered.
#[derive(Default)]
struct Gathered {
    in_odom: Option<Pose>,
    estimate_in_map: Option<Pose>,
    truth_in_map: Option<Pose>,
    geometry: Option<ScanGeometry>,
    scans: Vec<Scan>,
}

/// Reads a drive; the laser is mounted there.
///
/// # Errors
/// The file is damaged; there are no scans, or no poses before them; scans differ in their rays; the robot never moves.
pub fn read(bytes: &[u8], laser_in_base: Pose) -> Result<Recording> {
    let mut gathered = Gathered::default();
    let has_truth = topics(bytes)?.iter().any(|topic| topic == "/ground_truth");
    for message in MessageStream::new(bytes)? {
        let message = message?;
        let body = &message.data;
        match message.channel.topic.as_str() {
            "/odom" => gathered.in_odom = Some(planar(&decoded::<Odometry>(body, "/odom")?.pose.pose)),
            "/pose" => {
                let pose = decoded::<PoseWithCovarianceStamped>(body, "/pose")?.pose.pose;
                gathered.estimate_in_map = Some(planar(&pose));
            }
            "/ground_truth" => {
                gathered.truth_in_map = Some(planar(&decoded::<PoseStamped>(body, "/ground_truth")?.pose))
            }
            "/scan" => gathered.add(&decoded(body, "/scan")?, has_truth, laser_in_base)?,
            _ => {}
        }
    }
    let Some(geometry) = gathered.geometry else {
        bail!(
            "it has no scans with poses: messages on `/scan`, and before them on `/odom` and `/ground_truth` or `/pose`"
        );
    };
    Ok(Recording::new(geometry, gathered.scans)?)
}

fn topics(bytes: &[u8]) -> Result<Vec<String>> {
    let summary = mcap::Summary::read(bytes)?.context("it ends before its index: it was not written to its end")?;
    Ok(summary.channels.values().map(|channel| channel.topic.clone()).collect())
}

fn decoded<M: Message + DeserializeOwned>(bytes: &[u8], topic: &str) -> Result<M> {
    from_cdr(bytes).with_context(|| format!("`{topic}` has a message that is no {}", M::NAME))
}

fn planar(pose: &ros::Pose) -> Pose {
    let (at, turn) = (&pose.position, &pose.orientation);
    let sin = 2.0 * (turn.w * turn.z + turn.x * turn.y);
    let cos = 1.0 - 2.0 * (turn.y * turn.y + turn.z * turn.z);
    Pose::new(at.x, at.y, sin.atan2(cos))
}

impl Gathered {
    fn add(&mut self, scan: &LaserScan, has_truth: bool, laser_in_base: Pose) -> Result<()> {
        let in_map = if has_truth { self.truth_in_map } else { self.estimate_in_map };
        // Scans before the first poses belong nowhere.
        let (Some(base_in_odom), Some(base_in_map)) = (self.in_odom, in_map) else { return Ok(()) };
        let geometry = ScanGeometry {
            readings: scan.ranges.len(),
            first_rad: f64::from(scan.angle_min),
            step_rad: f64::from(scan.angle_increment),
        };
        if *self.geometry.get_or_insert(geometry) != geometry {
            bail!("`/scan` has scans whose rays point elsewhere than those of the first one; a log has one laser");
        }
        let heard = |&range_m: &f32| if range_m.is_finite() && range_m >= 0.0 { range_m } else { scan.range_max };
        self.scans.push(Scan {
            line: self.scans.len() + 1,
            ranges_m: scan.ranges.iter().map(heard).collect(),
            laser_in_map: base_in_map.compose(laser_in_base),
            laser_in_odom: base_in_odom.compose(laser_in_base),
        });
        Ok(())
    }
}
