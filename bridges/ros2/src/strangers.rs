//! Robots as others build them: nodes that listen to another message, to another topic or to none, whose scans come
//! late, whose clocks are not this machine's, and whose numbers are none.

use crate::ros_host::{RosHost, TopicNames};
use crate::teller::Teller;
use crate::topic::{Heard, Said, Topics};
use crate::track::{machine_ns, stamp, stamp_ns};
use crate::velocity::Choice;
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::{Pose, wrap_angle_rad};
use rpl_robot::office::Host;
use rpl_robot::sensors::LaserScanner;
use rpl_robot::simulator::{Commands, Percept};
use rpl_ros_messages::messages::{LaserScan, Odometry, Time, Twist, TwistStamped};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

/// What does not come within this time never comes.
const DEADLINE: Duration = Duration::from_secs(30);

/// Between two messages of odometry.
const TICK: Duration = Duration::from_millis(20);

/// Between two scans, and between two steps of the bridge.
const SCAN_TICKS: u32 = 5;
const STEP_TICKS: u32 = 2;

const SECOND_NS: i64 = 1_000_000_000;

const TURNING_RADPS: f64 = 0.8;

fn robot() -> Arc<RobotDescription> {
    RobotDescription::builtin("turtlebot").expect("a built-in robot")
}

fn scanner() -> LaserScanner {
    robot().laser.expect("it has a laser").scanner
}

/// A post stands one metre from the robot, where odometry has its zero, and a wall three metres all around.
fn scan(heading_rad: f64, stamp: Time) -> LaserScan {
    let laser = scanner();
    let range_m = |reading: usize| {
        let is_post = wrap_angle_rad(laser.direction_rad(reading) + heading_rad).abs() < 10_f64.to_radians();
        if is_post { 1.0 } else { 3.0 }
    };
    let mut scan = LaserScan {
        angle_min: laser.direction_rad(0) as f32,
        angle_max: laser.direction_rad(laser.readings - 1) as f32,
        angle_increment: laser.resolution_deg.to_radians() as f32,
        range_min: 0.05,
        range_max: laser.range_m as f32,
        ranges: (0..laser.readings).map(range_m).collect(),
        ..LaserScan::default()
    };
    scan.header.stamp = stamp;
    scan
}

/// By how much the post is not where it stands, in degrees.
fn off_deg(percept: &Percept) -> f64 {
    let laser = scanner();
    let seen = percept.laser_m.as_ref().expect("a scan").iter().enumerate().filter(|(_, range_m)| **range_m < 2.0);
    let (sin, cos) = seen.fold((0.0, 0.0), |(sum_sin, sum_cos), (reading, _)| {
        let (sin, cos) = laser.direction_rad(reading).sin_cos();
        (sum_sin + sin, sum_cos + cos)
    });
    wrap_angle_rad(f64::atan2(sin, cos) + percept.odometry_in_odom.heading_rad).to_degrees().abs()
}

/// A robot, with what is wrong with it.
struct Stranger {
    topics: Topics,
    names: TopicNames,
    odometry: Said<Odometry>,
    scans: Said<LaserScan>,
    /// Scans come so much later.
    late: Duration,
    /// What its clocks say; the time is that of this machine.
    odometry_stamp: fn(i64) -> Time,
    scan_stamp: fn(i64) -> Time,
    /// What it does to each message of odometry, which it counts.
    spoil: fn(u32, &mut Odometry),
    turning_since: Option<Instant>,
    on_the_way: VecDeque<(Instant, LaserScan)>,
    ticks: u32,
}

impl Stranger {
    fn new(domain: u16) -> Self {
        let name = |topic: &str| format!("/rpl_stranger{}/{topic}", std::process::id());
        let names = TopicNames {
            odometry: name("odom"),
            scan: name("scan"),
            sonar: name("sonar_{}"),
            bumper: name("bumper"),
            battery: name("battery_state"),
            velocity: name("cmd_vel"),
        };
        let mut topics = Topics::join(domain, "stranger").expect("a network");
        Self {
            odometry: topics.say(&names.odometry, "nav_msgs/Odometry").expect("a topic"),
            scans: topics.say(&names.scan, "sensor_msgs/LaserScan").expect("a topic"),
            topics,
            names,
            late: Duration::ZERO,
            odometry_stamp: stamp,
            scan_stamp: stamp,
            spoil: |_, _| {},
            turning_since: None,
            on_the_way: VecDeque::new(),
            ticks: 0,
        }
    }

    fn hear<M: 'static>(&mut self, topic: &str, kind: &str) -> Heard<M> {
        self.topics.hear_newest(topic, kind).expect("a topic")
    }

    /// One message of odometry, and a scan if it is time.
    fn tick(&mut self) {
        let (now, now_ns) = (Instant::now(), machine_ns());
        let heading_rad = self.turning_since.map_or(0.0, |since| TURNING_RADPS * (now - since).as_secs_f64());
        let mut moved = Odometry::default();
        (moved.pose.pose.orientation.z, moved.pose.pose.orientation.w) = (heading_rad / 2.0).sin_cos();
        moved.header.stamp = (self.odometry_stamp)(now_ns);
        (self.spoil)(self.ticks, &mut moved);
        self.odometry.say(moved).expect("odometry");
        if self.ticks.is_multiple_of(SCAN_TICKS) {
            self.on_the_way.push_back((now + self.late, scan(heading_rad, (self.scan_stamp)(now_ns))));
        }
        while self.on_the_way.front().is_some_and(|(due, _)| *due <= now)
            && let Some((_, scan)) = self.on_the_way.pop_front()
        {
            self.scans.say(scan).expect("a scan");
        }
        self.ticks += 1;
        thread::sleep(TICK);
    }
}

/// A bridge to a stranger, and what it has told.
struct Bridge {
    host: RosHost,
    told: Arc<Mutex<Vec<String>>>,
}

impl Bridge {
    fn to(stranger: &mut Stranger, domain: u16) -> Self {
        let told = Arc::new(Mutex::new(Vec::new()));
        let teller = Teller::new({
            let told = told.clone();
            move |sentence| told.lock().expect("sentences").push(sentence.to_string())
        });
        let topics = Topics::join(domain, "bridge").expect("a network");
        let names = stranger.names.clone();
        let mut host = RosHost::new(robot(), topics, &names, Choice::Auto, Pose::default(), teller).expect("topics");
        let began = Instant::now();
        while !host.awaited().expect("a robot").is_empty() {
            assert!(began.elapsed() < DEADLINE, "the robot says nothing: {:?}", host.awaited());
            stranger.tick();
        }
        Self { host, told }
    }

    fn told(&self, part: &str) -> usize {
        self.told.lock().expect("sentences").iter().filter(|sentence| sentence.contains(part)).count()
    }

    /// Both go on for a time, and each percept is looked at.
    fn go_on(&mut self, stranger: &mut Stranger, time: Duration, mut look: impl FnMut(&Percept)) {
        let commands = Commands { translation_mps: 0.1, ..Commands::default() };
        let began = Instant::now();
        while began.elapsed() < time {
            (0..STEP_TICKS).for_each(|_| stranger.tick());
            look(&self.host.step(&commands, &mut Vec::new()).expect("a percept"));
        }
    }

    /// Both go on until something has come.
    fn go_on_until<T>(&mut self, stranger: &mut Stranger, what: &str, mut come: impl FnMut(&Self) -> Option<T>) -> T {
        let began = Instant::now();
        loop {
            if let Some(found) = come(self) {
                return found;
            }
            assert!(began.elapsed() < DEADLINE, "never: {what}; {:?}", self.told);
            self.go_on(stranger, TICK, |_| {});
        }
    }
}

#[test]
fn a_base_hears_the_message_that_it_listens_to_with_a_stamp_of_its_clock() {
    const DOMAIN: u16 = 78;
    let mut stranger = Stranger::new(DOMAIN);
    let topic = stranger.names.velocity.clone();
    let mut stamped: Heard<TwistStamped> = stranger.hear(&topic, "geometry_msgs/TwistStamped");
    let mut bridge = Bridge::to(&mut stranger, DOMAIN);
    let told = bridge.go_on_until(&mut stranger, "a stamped twist", |_| stamped.take().expect("twists").pop());
    assert_eq!((told.twist.linear.x, told.header.frame_id.as_str()), (0.1, "base_link"));
    let age_ns = machine_ns() - stamp_ns(&told.header.stamp).expect("a stamp");
    assert!(age_ns.abs() < SECOND_NS, "{age_ns}");

    // A base that counts from when it was switched on.
    stranger.odometry_stamp = |now_ns| stamp(now_ns - 1_700_000_000 * SECOND_NS);
    bridge.go_on_until(&mut stranger, "a stamp of the base's clock", |_| {
        let told = stamped.take().expect("twists").pop()?;
        let age_ns = machine_ns() - 1_700_000_000 * SECOND_NS - stamp_ns(&told.header.stamp)?;
        (age_ns.abs() < SECOND_NS).then_some(())
    });

    // It is changed for another.
    drop(stamped);
    bridge.go_on_until(&mut stranger, "that it has left", |bridge| (bridge.told("has left") > 0).then_some(()));
    // Another node: in one, messages of a topic outlive those who heard them.
    let mut other = Topics::join(DOMAIN, "other").expect("a network");
    let mut plain = other.hear_newest::<Twist>(&topic, "geometry_msgs/Twist").expect("a topic");
    let told = bridge.go_on_until(&mut stranger, "a twist", |_| plain.take().expect("twists").pop());
    assert_eq!(told.linear.x, 0.1);
}

#[test]
fn that_nobody_listens_is_told_with_who_listens_elsewhere() {
    const DOMAIN: u16 = 79;
    let mut stranger = Stranger::new(DOMAIN);
    let topic = stranger.names.velocity.clone();
    let elsewhere = topic.replace("cmd_vel", "diff_drive_controller/cmd_vel");
    let _elsewhere: Heard<TwistStamped> = stranger.hear(&elsewhere, "geometry_msgs/TwistStamped");
    let mut bridge = Bridge::to(&mut stranger, DOMAIN);
    bridge.go_on(&mut stranger, Duration::from_secs(3), |_| {});
    assert_eq!(bridge.told("nobody listens"), 0, "it is too early: {:?}", bridge.told);
    bridge.go_on(&mut stranger, Duration::from_secs(5), |_| {});
    let nobody = format!(
        "nobody listens to `{topic}`; `{elsewhere}` has a subscriber of TwistStamped: `--velocity {elsewhere}`"
    );
    assert_eq!((bridge.told("nobody listens"), bridge.told(&nobody)), (1, 1), "{:?}", bridge.told);

    let mut heard: Heard<Twist> = stranger.hear(&topic, "geometry_msgs/Twist");
    bridge.go_on_until(&mut stranger, "a twist", |_| heard.take().expect("twists").pop());
    drop(heard);
    bridge.go_on_until(&mut stranger, "that it has left", |bridge| (bridge.told("has left") > 0).then_some(()));
    let left = format!("the last subscriber of `{topic}` has left: nobody listens");
    assert_eq!((bridge.told("nobody listens"), bridge.told(&left)), (2, 1), "{:?}", bridge.told);
}

#[test]
fn two_messages_at_one_topic_are_told_once_and_one_is_spoken() {
    const DOMAIN: u16 = 86;
    let mut stranger = Stranger::new(DOMAIN);
    let topic = stranger.names.velocity.clone();
    let mut plain: Heard<Twist> = stranger.hear(&topic, "geometry_msgs/Twist");
    let mut bridge = Bridge::to(&mut stranger, DOMAIN);
    bridge.go_on_until(&mut stranger, "a twist", |_| plain.take().expect("twists").pop());
    let mut other = Topics::join(DOMAIN, "other").expect("a network");
    let _stamped = other.hear_newest::<TwistStamped>(&topic, "geometry_msgs/TwistStamped").expect("a topic");
    let both = format!("`{topic}` has subscribers of Twist and of TwistStamped, and Twist is spoken");
    bridge.go_on_until(&mut stranger, "that there are two", |bridge| (bridge.told(&both) > 0).then_some(()));
    plain.take().expect("twists");
    bridge.go_on(&mut stranger, Duration::from_secs(1), |_| {});
    let told = plain.take().expect("twists").pop().expect("it still hears");
    assert_eq!((told.linear.x, bridge.told(&both)), (0.1, 1), "{:?}", bridge.told);
}

/// A robot turns, and its scans come late: by how many degrees the post is not where it stands, at 95 %.
fn off_deg_of(domain: u16, odometry_stamp: fn(i64) -> Time, scan_stamp: fn(i64) -> Time) -> (f64, Bridge) {
    let mut stranger = Stranger::new(domain);
    (stranger.odometry_stamp, stranger.scan_stamp) = (odometry_stamp, scan_stamp);
    stranger.late = Duration::from_millis(300);
    let mut bridge = Bridge::to(&mut stranger, domain);
    // Its odometry begins as it stands.
    bridge.go_on(&mut stranger, Duration::from_secs(1), |_| {});
    stranger.turning_since = Some(Instant::now());
    bridge.go_on(&mut stranger, Duration::from_secs(1), |_| {});
    let mut off = Vec::new();
    bridge.go_on(&mut stranger, Duration::from_secs(3), |percept| off.push(off_deg(percept)));
    off.sort_by(f64::total_cmp);
    (off[off.len() * 95 / 100], bridge)
}

#[test]
fn scans_that_come_late_belong_to_where_they_were_taken() {
    let (off_deg, bridge) = off_deg_of(80, stamp, stamp);
    assert!(off_deg < 2.0, "{off_deg}");
    assert_eq!((bridge.told("stamped"), bridge.told("as they arrive")), (0, 0), "{:?}", bridge.told);
}

#[test]
fn another_clock_of_the_robot_is_told_once_and_its_stamps_agree() {
    let simulated = |now_ns: i64| stamp(now_ns - 1_700_000_000 * SECOND_NS);
    let (off_deg, bridge) = off_deg_of(81, simulated, simulated);
    assert!(off_deg < 2.0, "{off_deg}");
    let clock = bridge.told(" s behind the clock of this machine");
    assert_eq!((clock, bridge.told("as they arrive")), (1, 0), "{:?}", bridge.told);
}

#[test]
fn scans_of_another_clock_are_paired_as_they_arrive_and_that_is_told_once() {
    let (off_deg, bridge) = off_deg_of(82, stamp, |now_ns| stamp(now_ns + 3600 * SECOND_NS));
    assert!(off_deg > 8.0, "0.3 s late at 0.8 rad/s: {off_deg}");
    assert_eq!(bridge.told(" s ahead of odometry"), 1, "{:?}", bridge.told);
    assert_eq!(bridge.told("as they arrive"), 1, "{:?}", bridge.told);
}

#[test]
fn scans_without_stamps_are_paired_as_they_arrive_and_that_is_told_once() {
    let (off_deg, bridge) = off_deg_of(83, stamp, |_| Time::default());
    assert!(off_deg > 8.0, "0.3 s late at 0.8 rad/s: {off_deg}");
    assert_eq!(bridge.told("scans or odometry have no stamps"), 1, "{:?}", bridge.told);
}

#[test]
fn scans_do_not_wait_long_for_odometry_that_is_behind() {
    let behind = |now_ns: i64| stamp(now_ns - 8 * SECOND_NS / 10);
    let (off_deg, bridge) = off_deg_of(85, behind, stamp);
    assert!(off_deg > 8.0, "paired as they arrive: {off_deg}");
    assert_eq!(bridge.told("odometry is more than 0.3 s behind the scans"), 1, "{:?}", bridge.told);
}

#[test]
fn odometry_that_is_not_finite_is_dropped_and_its_field_told_and_nothing_else_is_silence() {
    const DOMAIN: u16 = 84;
    let mut stranger = Stranger::new(DOMAIN);
    stranger.spoil = |tick, message| match tick % 4 {
        0 => message.twist.twist.linear.x = f64::NAN,
        1 => message.pose.pose.position.y = f64::INFINITY,
        _ => {}
    };
    let mut bridge = Bridge::to(&mut stranger, DOMAIN);
    bridge.go_on(&mut stranger, Duration::from_secs(2), |percept| {
        let pose = percept.odometry_in_odom;
        assert_eq!((percept.translation_mps, pose.x_m, pose.y_m), (0.0, 0.0, 0.0), "{percept:?}");
    });
    for field in ["twist.twist.linear.x", "pose.pose.position.y"] {
        let told = bridge.told(&format!("odom` has a `{field}` that is not finite: such messages are dropped"));
        assert_eq!(told, 1, "{:?}", bridge.told);
    }

    stranger.spoil = |_, message| message.twist.twist.angular.z = f64::NEG_INFINITY;
    let began = Instant::now();
    let lost = loop {
        assert!(began.elapsed() < DEADLINE, "it is never lost");
        stranger.tick();
        if let Err(lost) = bridge.host.step(&Commands::default(), &mut Vec::new()) {
            break lost.0;
        }
    };
    assert!(lost.contains("odom` has said nothing of use for 1.0 s"), "{lost}");
}
