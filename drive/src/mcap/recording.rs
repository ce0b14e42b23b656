//! Which messages of a run are written when.

use super::channels::{McapFile, Topic};
use super::conversion as of;
use crate::events::LineKind;
use crate::onlooker::{Happened, Onlooker};
use anyhow::{Context, Result};
use rpl_mission::robot::Robot;
use rpl_robot::geometry::Pose;
use rpl_robot::office::OfficeModel;
use rpl_robot::planning::Target;
use rpl_robot::sensors::SonarArray;
use rpl_ros_messages::messages as ros;
use rpl_ros_messages::text::String as Text;
use serde_json::json;
use std::fs::File;
use std::sync::Arc;

/// How often the findings of the sensors are written.
const SENSED_EVERY_US: u64 = 200_000;

/// How often the estimate is written: to ask the filter for it costs more than a step.
const ESTIMATE_EVERY_US: u64 = 1_000_000;

/// How often the belief and its spread are written: they are large, and cost some milliseconds.
const BELIEF_EVERY_US: u64 = 5_000_000;

/// The likely poses have this share of the belief together.
const LIKELY_SHARE: f64 = 0.95;

/// An MCAP recording of a run.
pub struct McapRecording {
    file: McapFile,
    log: Topic,
    events: Topic,
    robot: Option<RobotTopics>,
}

/// What is written of a robot, and what was.
struct RobotTopics {
    sonars: Option<SonarArray>,
    tf: Topic,
    odom: Topic,
    scan: Option<Topic>,
    ranges: Option<Topic>,
    cmd_vel: Topic,
    pose: Topic,
    certainty: Topic,
    belief: Topic,
    plan: Topic,
    truth: Topic,
    /// The percept that was written last.
    seen_us: Option<u64>,
    /// When what is written next.
    sensed_due_us: u64,
    estimate_due_us: u64,
    belief_due_us: u64,
    /// As of the last estimate.
    odom_in_map: Pose,
    covariance: ros::Covariance,
    targets: Vec<Pose>,
}

impl McapRecording {
    /// A recording of a run that has not begun, with the map and the frames of the sensors.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn begin(file: File, office: Option<&Arc<OfficeModel>>) -> Result<Self> {
        let mut file = McapFile::begin(file)?;
        let log = file.json_topic("/log", &log_schema())?;
        let events = file.json_topic("/events", &event_schema())?;
        let robot = office.map(|office| RobotTopics::begin(&mut file, office)).transpose()?;
        Ok(Self { file, log, events, robot })
    }
}

impl Onlooker for McapRecording {
    /// What the plan logged, and the events as the trace has them.
    fn happened(&mut self, happened: &Happened<'_>, _: &mut Robot) -> Result<()> {
        let now_us = happened.now_us;
        for told in happened.told.iter().filter(|told| told.kind == LineKind::Log) {
            let line = json!({ "time_s": now_us as f64 / 1e6, "text": told.text }).to_string();
            self.file.write(&mut self.log, now_us, &Text { data: line })?;
        }
        for event in happened.events {
            self.file.write(&mut self.events, event.time_us, &Text { data: crate::trace::line(event) })?;
        }
        Ok(())
    }

    fn stepped(&mut self, now_us: u64, robot: &mut Robot) -> Result<()> {
        match &mut self.robot {
            Some(topics) => topics.look(&mut self.file, robot, now_us),
            None => Ok(()),
        }
    }

    /// The index of the file.
    fn ends(&mut self) -> Result<()> {
        self.file.finish().context("the MCAP file cannot be written")
    }
}

impl RobotTopics {
    fn begin(file: &mut McapFile, office: &OfficeModel) -> Result<Self> {
        let robot = &office.settings.robot;
        let sonars = of::sonars(robot);
        if let Some(map) = &office.map {
            let mut topic = file.topic::<ros::OccupancyGrid>("/map", true)?;
            file.write(&mut topic, 0, &of::map(&office.world.map(map.localization.grid.cell_m)))?;
        }
        let mut fixed = file.topic::<ros::TFMessage>("/tf_static", true)?;
        let transforms = sonars.as_ref().map_or(Vec::new(), of::sonar_frames);
        file.write(&mut fixed, 0, &ros::TFMessage { transforms })?;
        Ok(Self {
            tf: file.topic::<ros::TFMessage>("/tf", false)?,
            odom: file.topic::<ros::Odometry>("/odom", false)?,
            scan: robot.laser.as_ref().map(|_| file.topic::<ros::LaserScan>("/scan", false)).transpose()?,
            ranges: sonars.as_ref().map(|_| file.topic::<ros::Range>("/sonars", false)).transpose()?,
            cmd_vel: file.topic::<ros::Twist>("/cmd_vel", false)?,
            pose: file.topic::<ros::PoseWithCovarianceStamped>("/pose", false)?,
            certainty: file.topic::<ros::Float64>("/certainty", false)?,
            belief: file.topic::<ros::OccupancyGrid>("/belief", false)?,
            plan: file.topic::<ros::Path>("/plan", false)?,
            truth: file.topic::<ros::PoseStamped>("/ground_truth", false)?,
            sonars,
            seen_us: None,
            sensed_due_us: 0,
            estimate_due_us: 0,
            belief_due_us: 0,
            odom_in_map: Pose::default(),
            covariance: ros::Covariance::default(),
            targets: Vec::new(),
        })
    }

    fn look(&mut self, file: &mut McapFile, robot: &mut Robot, time_us: u64) -> Result<()> {
        let percept_us = robot.percept().map(|percept| percept.time_us);
        // Not every instant is a step of the robot.
        if percept_us == self.seen_us || time_us < self.sensed_due_us {
            return Ok(());
        }
        self.seen_us = percept_us;
        self.sensed_due_us = time_us + SENSED_EVERY_US;
        self.write_sensed(file, robot, time_us)?;
        if time_us >= self.estimate_due_us {
            self.estimate_due_us = time_us + ESTIMATE_EVERY_US;
            self.write_estimate(file, robot, time_us)?;
        }
        self.write_frames(file, robot, time_us)?;
        self.write_targets(file, robot, time_us)
    }

    fn write_sensed(&mut self, file: &mut McapFile, robot: &Robot, time_us: u64) -> Result<()> {
        let (Some(percept), Some(model)) = (robot.percept(), robot.model()) else { return Ok(()) };
        let description = &model.settings.robot;
        file.write(&mut self.odom, time_us, &of::odometry(time_us, percept))?;
        if let Some(wanted) = robot.drive_request() {
            file.write(&mut self.cmd_vel, time_us, &of::twist(wanted))?;
        }
        if let (Some(topic), Some(laser), Some(ranges_m)) = (&mut self.scan, &description.laser, &percept.laser_m) {
            let scan = of::laser_scan(time_us, SENSED_EVERY_US, &laser.scanner, ranges_m);
            file.write(topic, time_us, &scan)?;
        }
        if let (Some(topic), Some(sonars), Some(ranges_m)) = (&mut self.ranges, &self.sonars, &percept.sonar_m) {
            for (sonar, &range_m) in ranges_m.iter().enumerate() {
                file.write(topic, time_us, &of::range(time_us, sonars, sonar, range_m))?;
            }
        }
        Ok(())
    }

    fn write_estimate(&mut self, file: &mut McapFile, robot: &Robot, time_us: u64) -> Result<()> {
        let (Some(sight), Some(percept)) = (robot.sight(), robot.percept()) else { return Ok(()) };
        let estimate = sight.estimate_in_map;
        if time_us >= self.belief_due_us
            && let Some(belief) = robot.belief()
        {
            self.belief_due_us = time_us + BELIEF_EVERY_US;
            file.write(&mut self.belief, time_us, &of::belief(time_us, &belief))?;
            self.covariance = of::covariance(&robot.likely_states(LIKELY_SHARE), estimate);
        }
        self.odom_in_map = estimate.compose(percept.odometry_in_odom.inverse());
        let pose = ros::PoseWithCovariance { pose: of::pose(estimate), covariance: self.covariance };
        let stamped = ros::PoseWithCovarianceStamped { header: of::header(time_us, of::MAP), pose };
        file.write(&mut self.pose, time_us, &stamped)?;
        file.write(&mut self.certainty, time_us, &ros::Float64 { data: sight.certainty })
    }

    /// Where the robot is by dead reckoning from the last estimate, and where it really is.
    fn write_frames(&mut self, file: &mut McapFile, robot: &Robot, time_us: u64) -> Result<()> {
        let Some(percept) = robot.percept() else { return Ok(()) };
        let transforms = vec![
            of::transform(time_us, of::MAP, of::ODOM, self.odom_in_map),
            of::transform(time_us, of::ODOM, of::BASE, percept.odometry_in_odom),
        ];
        file.write(&mut self.tf, time_us, &ros::TFMessage { transforms })?;
        if let Some(truth) = robot.true_pose_in_map() {
            let stamped = ros::PoseStamped { header: of::header(time_us, of::MAP), pose: of::pose(truth) };
            file.write(&mut self.truth, time_us, &stamped)?;
        }
        Ok(())
    }

    /// The target points of navigation, when they change.
    fn write_targets(&mut self, file: &mut McapFile, robot: &mut Robot, time_us: u64) -> Result<()> {
        // A heading that does not matter is 0.
        let pose = |target: &Target| {
            let at = target.point_in_frame;
            Pose::new(at.x, at.y, target.heading_rad.unwrap_or(0.0))
        };
        let navigating = robot.navigation();
        let targets: Vec<Pose> =
            navigating.map_or_else(Vec::new, |navigating| navigating.targets_in_map().iter().map(pose).collect());
        if targets == self.targets {
            return Ok(());
        }
        file.write(&mut self.plan, time_us, &of::path(time_us, &targets))?;
        self.targets = targets;
        Ok(())
    }
}

fn log_schema() -> serde_json::Value {
    json!({
        "title": "rpl.Log",
        "description": "What a plan logged",
        "type": "object",
        "properties": { "time_s": { "type": "number" }, "text": { "type": "string" } },
        "required": ["time_s", "text"],
    })
}

fn event_schema() -> serde_json::Value {
    json!({
        "title": "rpl.Event",
        "description": "What happened to tasks, valves, fluents and the robot: a line of the trace",
        "type": "object",
        "properties": { "time_s": { "type": "number" }, "kind": { "type": "string" } },
        "required": ["time_s", "kind"],
    })
}
