//! The bridge between a mission and a robot that speaks ROS 2: our simulator, as a node of its own.

use crate::ros_host::{NUMBER, RosHost, TopicNames};
use crate::teller::Teller;
use crate::topic::Topics;
use crate::velocity::Choice;
use rpl_link::tcp_server::{PATIENCE, Service, ServiceRecord, serve};
use rpl_protocol::host::{CommandsMessage, FromHost, MissionHello, PROTOCOL, PerceptMessage, ToHost, read, written};
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::Pose;
use rpl_robot::simulator::{Commands, SimulatorModel, SimulatorSettings};
use rpl_robot::world::World;
use rpl_ros_messages::messages::{BatteryState, Bool, LaserScan, Odometry, Range, Twist};
use std::io::{BufRead, BufReader, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// What does not come within this time never comes.
const DEADLINE: Duration = Duration::from_secs(30);

const DOMAIN: u16 = 77;

const SONARS: usize = 8;

/// A small robot with a laser, and with sonars besides.
fn robot() -> Arc<RobotDescription> {
    let robot = RobotDescription::builtin("turtlebot").expect("a built-in robot");
    let sonar = RobotDescription::builtin("pioneer-front").expect("a built-in robot").sonar.clone();
    Arc::new(RobotDescription { bumper: true, sonar, ..RobotDescription::clone(&robot).without_errors() })
}

/// Names that no other run of this test has.
fn names() -> TopicNames {
    let name = |topic: &str| format!("/rpl_test{}/{topic}", std::process::id());
    TopicNames {
        odometry: name("odom"),
        scan: name("scan"),
        sonar: name("sonar_{}"),
        bumper: name("bumper"),
        battery: name("battery_state"),
        velocity: name("cmd_vel"),
    }
}

/// What the test and the simulated robot know of each other.
#[derive(Default)]
struct Contact {
    is_pressed: AtomicBool,
    told: Mutex<Option<Twist>>,
}

/// Drives as it is told, and says what it perceives, until the other end of the channel is gone.
fn drive(contact: &Contact, ends: &Receiver<()>) {
    let (robot, names) = (robot(), names());
    let mut topics = Topics::join(DOMAIN, "robot").expect("a network");
    let mut velocity = topics.hear_newest::<Twist>(&names.velocity, "geometry_msgs/Twist").expect("a topic");
    let mut odometry = topics.say(&names.odometry, "nav_msgs/Odometry").expect("a topic");
    let mut scan = topics.say(&names.scan, "sensor_msgs/LaserScan").expect("a topic");
    let mut bumper = topics.say(&names.bumper, "std_msgs/Bool").expect("a topic");
    let mut battery = topics.say(&names.battery, "sensor_msgs/BatteryState").expect("a topic");
    let sonar = |number: usize| names.sonar.replace(NUMBER, &number.to_string());
    let mut sonar = |number| topics.say(&sonar(number), "sensor_msgs/Range").expect("a topic");
    let mut sonars: Vec<_> = (0..SONARS).map(&mut sonar).collect();
    let world = Arc::new(World::builtin("dept").expect("a built-in world"));
    let model = SimulatorModel::new(world, SimulatorSettings::of(RobotDescription::clone(&robot)));
    let (mut state, mut commands) = (model.start(1), Commands { sonars_on: true, ..Commands::default() });
    while ends.recv_timeout(Duration::from_millis(20)) == Err(RecvTimeoutError::Timeout) {
        if let Some(told) = velocity.take().expect("twists").pop() {
            (commands.translation_mps, commands.rotation_radps) = (told.linear.x, told.angular.z);
            *contact.told.lock().expect("a twist") = Some(told);
        }
        let percept = model.step(&mut state, &commands);
        let Pose { x_m, y_m, heading_rad } = percept.odometry_in_odom;
        let mut moved = Odometry::default();
        // It was switched on elsewhere.
        (moved.pose.pose.position.x, moved.pose.pose.position.y) = (x_m + 5.0, y_m - 3.0);
        (moved.pose.pose.orientation.z, moved.pose.pose.orientation.w) = (heading_rad / 2.0).sin_cos();
        (moved.twist.twist.linear.x, moved.twist.twist.angular.z) = (percept.translation_mps, percept.rotation_radps);
        odometry.say(moved).expect("odometry");
        let laser = robot.laser.expect("it has a laser").scanner;
        let seen = LaserScan {
            angle_min: laser.direction_rad(0) as f32,
            angle_max: laser.direction_rad(laser.readings - 1) as f32,
            angle_increment: laser.resolution_deg.to_radians() as f32,
            range_min: 0.05,
            range_max: laser.range_m as f32,
            ranges: percept.laser_m.expect("readings"),
            ..LaserScan::default()
        };
        scan.say(seen).expect("a scan");
        let sonar_m = percept.sonar_m.expect("readings");
        for (sonar, range) in sonars.iter_mut().zip(sonar_m) {
            sonar.say(Range { min_range: 0.02, max_range: 8.0, range, ..Range::default() }).expect("a range");
        }
        battery.say(BatteryState { percentage: 0.5, ..BatteryState::default() }).expect("a battery");
        bumper.say(Bool { data: contact.is_pressed.load(Ordering::Relaxed) }).expect("a bumper");
    }
}

/// The bridge, in a thread of its own, and where it listens.
fn bridge() -> (SocketAddr, JoinHandle<ServiceRecord>) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address");
    let serving = thread::spawn(move || {
        let topics = Topics::join(DOMAIN, "bridge").expect("a network");
        let teller = Teller::new(|_| {});
        let mut host = RosHost::new(robot(), topics, &names(), Choice::Auto, Pose::default(), teller).expect("topics");
        let began = Instant::now();
        while !host.awaited().expect("a robot").is_empty() {
            assert!(began.elapsed() < DEADLINE, "the robot says nothing: {:?}", host.awaited());
            thread::park_timeout(Duration::from_millis(20));
        }
        let robot = robot();
        let (name, period_us) = (robot.name.clone(), robot.step_us);
        let service = Service {
            robot: name,
            period_us,
            factor: 1.0,
            until_us: None,
            once: false,
            start_known: false,
            patience: PATIENCE,
            token: None,
        };
        serve(&mut host, listener, service, &|| false, &mut |_| {}).expect("a listener")
    });
    (address, serving)
}

/// A mission that wants to drive ahead.
struct Mission {
    stream: TcpStream,
    reading: BufReader<TcpStream>,
    /// The number of the next percept.
    next: u64,
}

impl Mission {
    fn connect(address: SocketAddr) -> Self {
        let stream = TcpStream::connect(address).expect("the bridge listens");
        stream.set_read_timeout(Some(DEADLINE)).expect("a socket");
        let reading = BufReader::new(stream.try_clone().expect("a socket"));
        let mut mission = Self { stream, reading, next: 0 };
        let (rpl, robot) = ("test".to_string(), robot().name.clone());
        let hello = MissionHello { protocol: PROTOCOL, rpl, robot, mission: None, token: None };
        mission.say(&ToHost::Hello(hello));
        let FromHost::Hello(hello) = mission.hear() else { panic!("the bridge greets") };
        assert!(!hello.start_known && hello.period_us == 50_000, "{hello:?}");
        mission
    }

    fn say(&mut self, message: &ToHost) {
        self.stream.write_all(written(message).as_bytes()).expect("the bridge hears");
    }

    fn hear(&mut self) -> FromHost {
        let mut line = String::new();
        self.reading.read_line(&mut line).expect("the bridge speaks");
        read(&line).unwrap_or_else(|why| panic!("{why}: {line}"))
    }

    /// Drives ahead until a percept is as asked.
    fn drive_until(&mut self, what: &str, asked: impl Fn(&PerceptMessage) -> bool) -> PerceptMessage {
        let began = Instant::now();
        let commands = Commands { translation_mps: 9.0, sonars_on: true, ..Commands::default() };
        loop {
            self.say(&ToHost::Commands(CommandsMessage::new(self.next, &commands)));
            let FromHost::Percept(percept) = self.hear() else { panic!("the bridge says goodbye") };
            self.next = percept.number + 1;
            if asked(&percept) {
                return *percept;
            }
            assert!(began.elapsed() < DEADLINE, "never: {what}; {percept:?}");
        }
    }
}

#[test]
fn a_mission_drives_a_robot_that_speaks_ros() {
    let contact = Arc::new(Contact::default());
    let (ending, ends) = channel();
    let driving = thread::spawn({
        let contact = contact.clone();
        move || drive(&contact, &ends)
    });
    let (address, serving) = bridge();
    let mut mission = Mission::connect(address);

    let first = mission.drive_until("the first percept", |_| true);
    assert_eq!((first.number, first.odometry_in_odom.x_m, first.odometry_in_odom.y_m), (0, 0.0, 0.0));
    let seen_m = first.laser_m.expect("a laser");
    assert_eq!(seen_m.len(), 360);
    assert!(seen_m.iter().any(|range_m| *range_m < 3.4), "the walls of a hallway");
    let heard_m = first.sonar_m.expect("sonars");
    assert_eq!(heard_m.len(), SONARS);
    assert!(heard_m.iter().all(|range_m| *range_m > 0.1 && *range_m <= 8.0), "{heard_m:?}");
    mission.drive_until("the battery", |percept| percept.battery == 0.5);

    mission.drive_until("it drives", |percept| percept.odometry_in_odom.x_m > 0.1);
    let told = contact.told.lock().expect("a twist").clone().expect("it was told something");
    assert_eq!(told.linear.x, 0.22, "no faster than it can");

    contact.is_pressed.store(true, Ordering::Relaxed);
    mission.drive_until("the bumper", |percept| percept.bumped);
    mission.drive_until("it stands", |percept| percept.translation_mps == 0.0);
    contact.is_pressed.store(false, Ordering::Relaxed);
    mission.drive_until("it drives again", |percept| !percept.bumped && percept.translation_mps > 0.2);

    // The line is cut.
    drop(mission);
    let began = Instant::now();
    while contact.told.lock().expect("a twist").as_ref() != Some(&Twist::default()) {
        assert!(began.elapsed() < DEADLINE, "it was never told to stand");
        thread::yield_now();
    }

    // The robot is switched off.
    drop(ending);
    driving.join().expect("a robot");
    let record = serving.join().expect("a bridge");
    assert!(record.halts.bumps >= 1 && record.halts.closed_lines == 1, "{:?}", record.halts);
    let lost = record.lost.expect("it is lost").0;
    assert!(lost.contains("/odom` has said nothing for 1.0 s"), "{lost}");
}
