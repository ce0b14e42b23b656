//! A recorded drive from MCAP: scans, odometry and corrected poses by the types of their messages, each at the time in
//! its header.

use super::mcap_messages::{self, Channel};
use super::topics::{Kind, Topic, Topics, Wanted};
use anyhow::{Result, anyhow, bail};
use rpl_lang::visible::shortened;
use rpl_robot::geometry::Pose;
use rpl_robot::recording::{Rays, Recording, ScanGeometry, StampedDrive, StampedScan, Track};
use rpl_ros_messages::from_cdr;
use rpl_ros_messages::messages::{self as ros, LaserScan, Odometry, PoseStamped, PoseWithCovarianceStamped};
use std::collections::BTreeMap;

/// A drive, and what is to be told of how it was read.
pub struct McapDrive {
    /// The drive.
    pub recording: Recording,
    /// Which topics were taken, and what was left out.
    pub notes: Vec<String>,
}

/// A message and its times, in nanoseconds.
struct Heard<M> {
    stamp_ns: i64,
    log_ns: u64,
    message: M,
}

/// What has been heard on a topic.
#[derive(Default)]
struct OnTopic {
    scans: Vec<Heard<LaserScan>>,
    poses: Vec<Heard<Pose>>,
    /// Messages that are not what their channel says.
    unreadable: usize,
}

/// Recordings of one drive, one or several files.
#[derive(Default)]
pub struct McapReader {
    topics: BTreeMap<Topic, OnTopic>,
    /// Topics with what could be taken, but not as ROS 2 writes it, and how it is written.
    other_encodings: BTreeMap<String, String>,
    is_cut: bool,
}

impl McapReader {
    /// Takes in a file.
    ///
    /// # Errors
    /// It is damaged, or packed by something unknown.
    pub fn read(&mut self, bytes: &[u8]) -> Result<()> {
        let (topics, other) = (&mut self.topics, &mut self.other_encodings);
        let is_whole = mcap_messages::each(bytes, |channel: &Channel, log_ns, body| {
            let Some(kind) = Kind::of(&channel.kind) else {
                // ROS 1 names types without `/msg`.
                if Kind::of(&channel.kind.replacen('/', "/msg/", 1)).is_some() {
                    other.entry(channel.topic.clone()).or_insert_with(|| channel.encoding.clone());
                }
                return;
            };
            if channel.encoding == "cdr" {
                topics.entry((channel.topic.clone(), kind)).or_default().hear(kind, log_ns, body);
            } else {
                other.entry(channel.topic.clone()).or_insert_with(|| channel.encoding.clone());
            }
        })?;
        self.is_cut |= !is_whole;
        Ok(())
    }

    /// The drive; the laser is mounted there.
    ///
    /// # Errors
    /// A topic is missing, or several fit; messages are not what their channel says; scans differ in their rays; no
    /// scan has poses; the robot never moves.
    pub fn drive(mut self, wanted: Wanted<'_>, laser_in_base: Pose) -> Result<McapDrive> {
        let all: Vec<Topic> = self.topics.keys().cloned().collect();
        let chosen = Topics::choose(&all, wanted).map_err(|error| match self.other_encodings.iter().next() {
            Some((topic, encoding)) => anyhow!(
                "{error}; `{}` is written as `{}`, and `cdr` of ROS 2 is read: a bag of ROS 1 is converted by `pip \
                 install rosbags && rosbags-convert --src FILE.bag --dst FOLDER --dst-storage mcap`",
                shortened(topic),
                shortened(encoding)
            ),
            None => error,
        })?;
        let mut take = |topic: &Topic| {
            let heard = self.topics.remove(topic).unwrap_or_default();
            if heard.unreadable == 0 {
                return Ok(heard);
            }
            let (name, kind) = topic;
            Err(anyhow!("`{}` has {} messages that are no {}", shortened(name), heard.unreadable, kind.name()))
        };
        let (scans, odom, truth) = (take(&chosen.scan)?.scans, take(&chosen.odom)?.poses, take(&chosen.truth)?.poses);
        let said = |(name, kind): &Topic, count: usize| format!("`{}` ({}, {count})", shortened(name), kind.name());
        let taken = format!(
            "taken: scans of {}, odometry of {}, corrected poses of {}",
            said(&chosen.scan, scans.len()),
            said(&chosen.odom, odom.len()),
            said(&chosen.truth, truth.len())
        );
        let count = scans.len();
        let recording = paired(scans, odom, truth, laser_in_base)?;
        let mut notes = vec![taken];
        let left_out = count - recording.scans.len();
        if left_out > 0 {
            let what = "were taken before or after the odometry or the corrected poses, and are left out";
            notes.push(format!("{left_out} of {count} scans {what}"));
        }
        if self.is_cut {
            let advice = "`mcap recover FILE -o whole.mcap` writes one that other programs read";
            notes.push(format!("the recording was not written to its end; what is whole in it is read ({advice})"));
        }
        Ok(McapDrive { recording, notes })
    }
}

impl OnTopic {
    fn hear(&mut self, kind: Kind, log_ns: u64, body: &[u8]) {
        let pose = |header: ros::Header, pose: &ros::Pose| Heard {
            stamp_ns: stamp_ns(&header),
            log_ns,
            message: planar(pose),
        };
        let heard = match kind {
            Kind::LaserScan => {
                let Some(mut message) = from_cdr::<LaserScan>(body) else {
                    self.unreadable += 1;
                    return;
                };
                // As long as the readings, and not needed.
                message.intensities = Vec::new();
                self.scans.push(Heard { stamp_ns: stamp_ns(&message.header), log_ns, message });
                return;
            }
            Kind::Odometry => from_cdr::<Odometry>(body).map(|message| pose(message.header, &message.pose.pose)),
            Kind::PoseStamped => from_cdr::<PoseStamped>(body).map(|message| pose(message.header, &message.pose)),
            Kind::PoseWithCovarianceStamped => {
                let message = from_cdr::<PoseWithCovarianceStamped>(body);
                message.map(|message| pose(message.header, &message.pose.pose))
            }
        };
        match heard {
            Some(heard) if is_finite(heard.message) => self.poses.push(heard),
            // Trackers say so that they see nothing.
            Some(_) => {}
            None => self.unreadable += 1,
        }
    }
}

fn stamp_ns(header: &ros::Header) -> i64 {
    i64::from(header.stamp.sec) * 1_000_000_000 + i64::from(header.stamp.nanosec)
}

fn is_finite(pose: Pose) -> bool {
    [pose.x_m, pose.y_m, pose.heading_rad].into_iter().all(f64::is_finite)
}

fn planar(pose: &ros::Pose) -> Pose {
    let (at, turn) = (&pose.position, &pose.orientation);
    let sin = 2.0 * (turn.w * turn.z + turn.x * turn.y);
    let cos = 1.0 - 2.0 * (turn.y * turn.y + turn.z * turn.z);
    Pose::new(at.x, at.y, sin.atan2(cos))
}

/// Whether messages were never stamped: drivers leave out what they do not know.
fn is_unstamped<M>(heard: &[Heard<M>]) -> bool {
    heard.len() > 1 && heard.iter().all(|message| message.stamp_ns == 0)
}

fn paired(
    scans: Vec<Heard<LaserScan>>,
    odom: Vec<Heard<Pose>>,
    truth: Vec<Heard<Pose>>,
    laser_in_base: Pose,
) -> Result<Recording> {
    // One clock for all three: without stamps that of the recorder.
    let by_recorder = is_unstamped(&scans) || is_unstamped(&odom) || is_unstamped(&truth);
    let stamp_s = |stamp_ns: i64, log_ns: u64| if by_recorder { log_ns as f64 / 1e9 } else { stamp_ns as f64 / 1e9 };
    let track = |heard: Vec<Heard<Pose>>| {
        Track::new(heard.iter().map(|pose| (stamp_s(pose.stamp_ns, pose.log_ns), pose.message)).collect())
    };
    let mut first: Option<(ScanGeometry, Option<f64>, f32)> = None;
    let mut stamped = Vec::with_capacity(scans.len());
    for (index, Heard { stamp_ns, log_ns, message }) in scans.into_iter().enumerate() {
        let number = index + 1;
        let rays = Rays {
            first_rad: f64::from(message.angle_min),
            last_rad: f64::from(message.angle_max),
            step_rad: f64::from(message.angle_increment),
            range_min_m: message.range_min,
            range_max_m: message.range_max,
            ranges_m: &message.ranges,
        };
        let Some(own) = rays.geometry() else {
            if message.ranges.is_empty() {
                continue;
            }
            bail!(
                "scan {number} does not say where its rays point: its `angle_increment` is {}",
                message.angle_increment
            );
        };
        let (geometry, _, no_echo_m) = *first.get_or_insert((own, rays.range_m(), rays.no_echo_m()));
        let Some(ranges_m) = rays.on(&geometry, no_echo_m) else {
            bail!(
                "scan {number} has {} rays from {:.1}° to {:.1}° where the first one has {} from {:.1}° to {:.1}°; a log \
                 has one laser",
                own.readings,
                own.first_rad.to_degrees(),
                own.bearing_rad(own.readings - 1).to_degrees(),
                geometry.readings,
                geometry.first_rad.to_degrees(),
                geometry.bearing_rad(geometry.readings - 1).to_degrees()
            );
        };
        stamped.push(StampedScan { number, stamp_s: stamp_s(stamp_ns, log_ns), ranges_m });
    }
    let Some((geometry, range_m, _)) = first else { bail!("all its scans are empty") };
    let drive =
        StampedDrive { geometry, range_m, scans: stamped, base_in_odom: track(odom), base_in_map: track(truth) };
    Ok(drive.paired(laser_in_base)?)
}
