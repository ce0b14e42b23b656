//! A robot that speaks ROS 2, as a host.

use crate::conversion::{Motion, Scan, motion, not_finite, sonar_m, twist};
use crate::teller::Teller;
use crate::topic::{Heard, Topics};
use crate::track::{Place, SAME_CLOCK, Track, machine_ns, nanoseconds, stamp, stamp_ns};
use crate::velocity::{Choice, Motors, Velocity};
use anyhow::Result;
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::Pose;
use rpl_robot::office::{Host, HostLost, Report};
use rpl_robot::sensors::{FailedSensors, RangeSensors, Signals, SonarLayout};
use rpl_robot::simulator::{Commands, GripperMotion, GripperStatus, Percept};
use rpl_ros_messages::messages::{BatteryState, Bool, LaserScan, Odometry, Range, Time, Twist};
use std::collections::VecDeque;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

/// How often a robot is told to stand that nobody commands any more, and the time between: what is said
/// once may be lost when the process ends.
const FAREWELL: (u32, Duration) = (6, Duration::from_millis(50));

/// A scan waits no longer for the odometry of its time.
const MOST_WAITED: Duration = Duration::from_millis(300);

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
    /// `geometry_msgs/Twist` or `geometry_msgs/TwistStamped`.
    pub velocity: String,
}

/// A laser that is heard.
struct Laser {
    heard: Heard<LaserScan>,
    in_base: Pose,
    /// What has come before the odometry of its time, the newest last.
    waiting: VecDeque<(LaserScan, Instant)>,
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
    velocity: Velocity,
    teller: Teller,
    motion: Option<Motion>,
    track: Track,
    /// Where odometry was when it was first asked for.
    began_in_odom: Option<Pose>,
    is_bumped: bool,
    charge: f64,
    time_us: u64,
    // Behind all that are open.
    topics: Topics,
}

impl RosHost {
    /// Opens the topics of all that a robot has. Nothing moves yet. What its user should know is told.
    ///
    /// # Errors
    /// A name is none of ROS.
    pub fn new(
        robot: Arc<RobotDescription>,
        mut topics: Topics,
        names: &TopicNames,
        choice: Choice,
        laser_in_base: Pose,
        teller: Teller,
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
            odometry: topics.hear_each(&names.odometry, "nav_msgs/Odometry")?,
            laser: laser.map(|heard| Laser { heard, in_base: laser_in_base, waiting: VecDeque::new(), scan: None }),
            sonars,
            bumper: robot.bumper.then(|| topics.hear_each(&names.bumper, "std_msgs/Bool")).transpose()?,
            battery: robot
                .battery
                .map(|_| topics.hear_newest(&names.battery, "sensor_msgs/BatteryState"))
                .transpose()?,
            velocity: Velocity::new(&mut topics, &names.velocity, choice)?,
            teller,
            robot,
            sensors,
            motion: None,
            track: Track::default(),
            began_in_odom: None,
            is_bumped: false,
            charge: 1.0,
            time_us: 0,
            topics,
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
        let now = Instant::now();
        self.hear_odometry(now)?;
        self.look(now)?;
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

    /// Takes in where the robot is and was.
    fn hear_odometry(&mut self, now: Instant) -> Result<(), HostLost> {
        let (teller, topic) = (&mut self.teller, self.odometry.topic.clone());
        let is_of_use = |message: &Odometry| {
            let fault = not_finite(message);
            if let Some(field) = fault {
                teller.once(field, || {
                    format!("the topic `{topic}` has a `{field}` that is not finite: such messages are dropped")
                });
            }
            fault.is_none()
        };
        for message in self.odometry.take_if(is_of_use).map_err(HostLost)? {
            let heard = motion(&message).map_err(|why| HostLost(self.odometry.fault(&why)))?;
            self.motion = Some(heard);
            if let Some(stamp_ns) = stamp_ns(&message.header.stamp) {
                self.track.add(stamp_ns, heard.base_in_odom, now);
            }
        }
        if let Some(ahead_ns) = self.track.clock_ns(now).map(|clock_ns| clock_ns - machine_ns())
            && ahead_ns.abs() > nanoseconds(SAME_CLOCK)
        {
            let what =
                || self.odometry.fault(&format!("is stamped {} the clock of this machine", by_how_much(ahead_ns)));
            self.teller.once("clock of the odometry", what);
        }
        Ok(())
    }

    /// Takes in the newest scan whose place is known: where the robot was at the time of its stamp. A stamp of another
    /// clock says nothing, and then it is where the robot is as the scan comes.
    fn look(&mut self, now: Instant) -> Result<(), HostLost> {
        let (Some(laser), Some(scanner)) = (&mut self.laser, &self.sensors.laser) else { return Ok(()) };
        laser.waiting.extend(laser.heard.take().map_err(HostLost)?.into_iter().map(|message| (message, now)));
        // A scan before the first odometry is nowhere.
        let Some(motion) = self.motion else {
            laser.waiting.clear();
            return Ok(());
        };
        let mut tell = |subject: &'static str, why: &str| {
            self.teller.once(subject, || {
                let (laser, odometry) = (&laser.heard.topic, &self.odometry.topic);
                format!("{why}: scans at `{laser}` are paired with `{odometry}` as they arrive")
            });
        };
        let mut placed = None;
        for at in (0..laser.waiting.len()).rev() {
            let (message, came) = &laser.waiting[at];
            let place = match stamp_ns(&message.header.stamp) {
                Some(stamp_ns) => self.track.at(stamp_ns, now),
                None => Place::NoClock,
            };
            let base_in_odom = match place {
                Place::Known(base_in_odom) => Some(base_in_odom),
                Place::NotYet if now.saturating_duration_since(*came) < MOST_WAITED => continue,
                Place::NotYet => {
                    tell("odometry is late", "odometry is more than 0.3 s behind the scans");
                    Some(motion.base_in_odom)
                }
                Place::Forgotten => None,
                Place::OtherClock(ahead_ns) => {
                    tell("clock of the scans", &format!("scans are stamped {} odometry", by_how_much(ahead_ns)));
                    Some(motion.base_in_odom)
                }
                Place::NoClock => {
                    tell("no stamps", "scans or odometry have no stamps");
                    Some(motion.base_in_odom)
                }
            };
            placed = base_in_odom.map(|base_in_odom| (message.clone(), base_in_odom));
            laser.waiting.drain(..=at);
            break;
        }
        if let Some((message, base_in_odom)) = placed {
            let scan = Scan::new(&message, base_in_odom.compose(laser.in_base), laser.in_base, scanner);
            laser.scan = Some(scan.map_err(|why| HostLost(laser.heard.fault(&why)))?);
        }
        Ok(())
    }

    /// The time of the robot as it is best known: that of its odometry, if it is another clock's than this machine's;
    /// else the later of both, because a base does not obey what is old.
    fn stamp(&self, now: Instant) -> Time {
        let machine_ns = machine_ns();
        stamp(match self.track.clock_ns(now) {
            None => machine_ns,
            Some(clock_ns) if (clock_ns - machine_ns).abs() > nanoseconds(SAME_CLOCK) => clock_ns,
            Some(clock_ns) => clock_ns.max(machine_ns),
        })
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

/// How far a clock is from another, before the name of that.
fn by_how_much(ahead_ns: i64) -> String {
    let way = if ahead_ns > 0 { "ahead of" } else { "behind" };
    format!("{:.1} s {way}", ahead_ns.unsigned_abs() as f64 / 1e9)
}

impl Host for RosHost {
    /// The wheels are told, and what was heard last is perceived.
    fn step(&mut self, commands: &Commands, _: &mut Vec<Report>) -> Result<Percept, HostLost> {
        let (now, twist) = (Instant::now(), twist(commands, &self.robot.motors));
        let told = match () {
            () if commands.motors_off => Motors::Off,
            () if twist == Twist::default() => Motors::Stand,
            () => Motors::Drive,
        };
        let attended = self.velocity.attend(&mut self.topics, now, told, &mut self.teller);
        attended.map_err(|error| HostLost(format!("{error:#}")))?;
        self.velocity.say(twist, self.stamp(now)).map_err(HostLost)?;
        let was_pressed = self.listen()?;
        self.percept(was_pressed, commands.sonars_on)
    }
}

impl Drop for RosHost {
    /// Whatever the reason, the robot does not drive on.
    fn drop(&mut self) {
        for _ in 0..FAREWELL.0 {
            // Nobody is left who could be told that it was in vain.
            self.velocity.say(Twist::default(), self.stamp(Instant::now())).ok();
            thread::sleep(FAREWELL.1);
        }
    }
}
