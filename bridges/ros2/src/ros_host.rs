//! A robot that speaks ROS 2, as a host.

use crate::conversion::{Motion, Scan, motion, sonar_m, twist};
use rpl_ros_messages::messages::{BatteryState, Bool, LaserScan, Odometry, Range, Twist};
use crate::topic::{Heard, Said, Topics};
use anyhow::Result;
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::Pose;
use rpl_robot::office::{Host, HostLost, Report};
use rpl_robot::sensors::{FailedSensors, RangeSensors, Signals, SonarLayout};
use rpl_robot::simulator::{Commands, GripperMotion, GripperStatus, Percept};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

/// How often a robot is told to stand that nobody commands any more, and the time between: what is said
/// once may be lost when the process ends.
const FAREWELL: (u32, Duration) = (6, Duration::from_millis(50));

/// Where the number of a sonar stands in the name of its topic.
pub const NUMBER: &str = "{}";

/// The names of the topics.
#[derive(Clone, Debug)]
pub struct TopicNames {
    /// `nav_msgs/Odometry`.
    pub odometry: String,
    /// `sensor_msgs/LaserScan`.
    pub scan: String,
    /// `sensor_msgs/Range`, with [`NUMBER`] in it.
    pub sonar: String,
    /// `std_msgs/Bool`.
    pub bumper: String,
    /// `sensor_msgs/BatteryState`.
    pub battery: String,
    /// `geometry_msgs/Twist`.
    pub velocity: String,
}

/// A laser that is heard.
struct Laser {
    heard: Heard<LaserScan>,
    in_base: Pose,
    scan: Option<Scan>,
}

/// A sonar that is heard.
struct SonarHeard {
    heard: Heard<Range>,
    /// How far it sits before the place from which its description measures.
    ahead_m: f64,
    reading_m: f32,
}

/// A robot that speaks ROS 2. Dropped, it has been told to stand.
pub struct RosHost {
    robot: Arc<RobotDescription>,
    sensors: RangeSensors,
    odometry: Heard<Odometry>,
    laser: Option<Laser>,
    sonars: Vec<SonarHeard>,
    bumper: Option<Heard<Bool>>,
    battery: Option<Heard<BatteryState>>,
    velocity: Said<Twist>,
    motion: Option<Motion>,
    /// Where odometry was when it was first asked for.
    began_in_odom: Option<Pose>,
    is_bumped: bool,
    charge: f64,
    time_us: u64,
}

impl RosHost {
    /// Opens the topics of all that a robot has. Nothing moves yet.
    ///
    /// # Errors
    /// A name is none of ROS.
    pub fn new(
        robot: Arc<RobotDescription>,
        topics: &mut Topics,
        names: &TopicNames,
        laser_in_base: Pose,
    ) -> Result<Self> {
        let sensors = robot.range_sensors();
        // A ring is measured from the middle of the robot, and a real one sits on the rim.
        let ahead_m = match robot.sonar.as_ref().map(|sonar| &sonar.layout) {
            Some(SonarLayout::Ring(_)) => robot.radius_m,
            Some(SonarLayout::Mounts(_)) | None => 0.0,
        };
        let count = sensors.sonars.as_ref().map_or(0, |sonars| sonars.mounts.len());
        let mut sonar = |number: usize| {
            let topic = names.sonar.replace(NUMBER, &number.to_string());
            Ok(SonarHeard { heard: topics.hear_newest(&topic, "sensor_msgs/Range")?, ahead_m, reading_m: 0.0 })
        };
        let sonars = (0..count).map(&mut sonar).collect::<Result<_>>()?;
        let laser = match sensors.laser {
            Some(_) => Some(topics.hear_newest(&names.scan, "sensor_msgs/LaserScan")?),
            None => None,
        };
        Ok(Self {
            odometry: topics.hear_newest(&names.odometry, "nav_msgs/Odometry")?,
            laser: laser.map(|heard| Laser { heard, in_base: laser_in_base, scan: None }),
            sonars,
            bumper: robot.bumper.then(|| topics.hear_each(&names.bumper, "std_msgs/Bool")).transpose()?,
            battery: robot
                .battery
                .map(|_| topics.hear_newest(&names.battery, "sensor_msgs/BatteryState"))
                .transpose()?,
            velocity: topics.say(&names.velocity, "geometry_msgs/Twist")?,
            robot,
            sensors,
            motion: None,
            began_in_odom: None,
            is_bumped: false,
            charge: 1.0,
            time_us: 0,
        })
    }

    /// The topics without which there is no percept, and which have said nothing yet.
    ///
    /// # Errors
    /// What came is not what the robot's description says.
    pub fn awaited(&mut self) -> Result<Vec<&str>, HostLost> {
        self.listen()?;
        let needed = std::iter::once((self.motion.is_some(), self.odometry.topic.as_str()));
        // A scan before the first odometry is nowhere.
        let needed = needed.chain(self.laser.iter().map(|laser| (laser.scan.is_some(), laser.heard.topic.as_str())));
        let needed =
            needed.chain(self.sonars.iter().map(|sonar| (sonar.heard.has_spoken(), sonar.heard.topic.as_str())));
        Ok(needed.filter(|(has_spoken, _)| !has_spoken).map(|(_, topic)| topic).collect())
    }

    /// Takes in what has come; whether the bumper was pressed meanwhile.
    fn listen(&mut self) -> Result<bool, HostLost> {
        if let Some(message) = self.odometry.take().map_err(HostLost)?.pop() {
            self.motion = Some(motion(&message).map_err(|why| HostLost(self.odometry.fault(&why)))?);
        }
        self.look()?;
        for sonar in &mut self.sonars {
            let (message, described) = (sonar.heard.take().map_err(HostLost)?.pop(), &self.sensors.sonars);
            if let Some((message, described)) = message.zip(described.as_ref()) {
                let reading_m = sonar_m(&message, sonar.ahead_m, described.range_m);
                sonar.reading_m = reading_m.map_err(|why| HostLost(sonar.heard.fault(&why)))?;
            }
        }
        if let Some(heard) = &mut self.battery
            && let Some(BatteryState { percentage, .. }) = heard.take().map_err(HostLost)?.pop()
            && percentage.is_finite()
        {
            self.charge = f64::from(percentage).clamp(0.0, 1.0);
        }
        let pressed = self.bumper.as_mut().map_or(Ok(Vec::new()), Heard::take).map_err(HostLost)?;
        let was_pressed = pressed.iter().any(|message| message.data);
        self.is_bumped = pressed.last().map_or(self.is_bumped, |message| message.data);
        Ok(was_pressed || self.is_bumped)
    }

    /// Takes in the newest scan, at the place where the robot is now.
    fn look(&mut self) -> Result<(), HostLost> {
        let (Some(laser), Some(scanner)) = (&mut self.laser, &self.sensors.laser) else { return Ok(()) };
        let message = laser.heard.take().map_err(HostLost)?.pop();
        if let Some((message, motion)) = message.zip(self.motion) {
            let laser_in_odom = motion.base_in_odom.compose(laser.in_base);
            let scan = Scan::new(&message, laser_in_odom, laser.in_base, scanner);
            laser.scan = Some(scan.map_err(|why| HostLost(laser.heard.fault(&why)))?);
        }
        Ok(())
    }

    /// All without which nobody may drive have spoken lately.
    fn are_alive(&self, now: Instant) -> Result<(), String> {
        self.odometry.is_alive(now)?;
        self.laser.iter().try_for_each(|laser| laser.heard.is_alive(now))?;
        self.sonars.iter().try_for_each(|sonar| sonar.heard.is_alive(now))
    }

    fn percept(&mut self, was_pressed: bool, sonars_on: bool) -> Result<Percept, HostLost> {
        self.are_alive(Instant::now()).map_err(HostLost)?;
        let Some(Motion { base_in_odom, velocity }) = self.motion else {
            return Err(HostLost(self.odometry.fault("has said nothing yet")));
        };
        let began_in_odom = *self.began_in_odom.get_or_insert(base_in_odom);
        let scan = self.laser.as_ref().and_then(|laser| laser.scan.as_ref());
        let laser_m = scan.zip(self.sensors.laser.as_ref()).map(|(scan, laser)| scan.readings_m(base_in_odom, laser));
        let sonar_m =
            (sonars_on && !self.sonars.is_empty()).then(|| self.sonars.iter().map(|sonar| sonar.reading_m).collect());
        self.time_us += self.robot.step_us;
        Ok(Percept {
            time_us: self.time_us,
            odometry_in_odom: base_in_odom.relative_to(began_in_odom),
            translation_mps: velocity.translation_mps,
            rotation_radps: velocity.rotation_radps,
            sonar_m,
            laser_m,
            camera: None,
            failed: FailedSensors::default(),
            bumped: was_pressed,
            gripper: GripperStatus { motion: GripperMotion::Open, holding: None },
            battery: self.charge,
            messages: Vec::new(),
            others: Signals::new(),
        })
    }
}

impl Host for RosHost {
    /// The wheels are told, and what was heard last is perceived.
    fn step(&mut self, commands: &Commands, _: &mut Vec<Report>) -> Result<Percept, HostLost> {
        self.velocity.say(twist(commands, &self.robot.motors)).map_err(HostLost)?;
        let was_pressed = self.listen()?;
        self.percept(was_pressed, commands.sonars_on)
    }
}

impl Drop for RosHost {
    /// Whatever the reason, the robot does not drive on.
    fn drop(&mut self) {
        for _ in 0..FAREWELL.0 {
            // Nobody is left who could be told that it was in vain.
            self.velocity.say(Twist::default()).ok();
            thread::sleep(FAREWELL.1);
        }
    }
}
