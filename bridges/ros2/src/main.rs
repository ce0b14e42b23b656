//! A robot that speaks ROS 2, as a host for missions: `rpl run PLAN --world W --robot R --host ADDRESS`.
//!
//! The bridge is one more server of the host protocol (`docs/hosts.md`). It takes part in ROS 2 by itself
//! and needs no installation of it. Read `conversion`, `track`, `topic`, `velocity` and `ros_host`.

mod conversion;
#[cfg(test)]
mod loopback;
mod ros_host;
#[cfg(test)]
mod strangers;
mod teller;
mod topic;
mod track;
mod velocity;

use anyhow::{Context, Result, anyhow, bail};
use clap::Parser;
use ros_host::{NUMBER, RosHost, TopicNames};
use rpl_link::tcp_server::{Notice, PATIENCE, Service, serve};
use rpl_protocol::token::Token;
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::Pose;
use std::fs::File;
use std::io::Read;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;
use teller::Teller;
use velocity::Choice;

/// The largest number of a domain whose ports there are.
const LAST_DOMAIN: i64 = 232;

/// Bytes of a robot file or of one with a token, at most.
const MOST_BYTES: u64 = 64 << 10;

/// How often it is looked whether the topics have spoken.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Somebody wants the bridge to end.
static IS_STOPPED: AtomicBool = AtomicBool::new(false);

/// Serve a robot with ROS 2 to a mission (`rpl run --host`)
#[derive(Parser, Debug)]
#[command(version)]
struct Arguments {
    /// Robot: a built-in name or a .toml file, which describes its sensors
    #[arg(long, value_name = "R")]
    robot: String,
    /// Address where missions connect; with port 0 the system chooses one, and the first line says which
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:7300")]
    listen: String,
    /// Domain of ROS 2
    #[arg(long, value_name = "N", env = "ROS_DOMAIN_ID", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=LAST_DOMAIN))]
    domain: u16,
    /// The robot is at the start that the world names (default: the mission has to find its position)
    #[arg(long)]
    start_known: bool,
    /// Topic of the odometry (nav_msgs/Odometry)
    #[arg(long, value_name = "TOPIC", default_value = "/odom")]
    odometry: String,
    /// Topic of the laser scans (sensor_msgs/LaserScan)
    #[arg(long, value_name = "TOPIC", default_value = "/scan")]
    scan: String,
    /// Topic of each sonar (sensor_msgs/Range); {} is replaced by its number, from 0 on
    #[arg(long, value_name = "TOPIC", default_value = "/sonar_{}")]
    sonar: String,
    /// Topic of the bumper (std_msgs/Bool)
    #[arg(long, value_name = "TOPIC", default_value = "/bumper")]
    bumper: String,
    /// Topic of the battery (sensor_msgs/BatteryState)
    #[arg(long, value_name = "TOPIC", default_value = "/battery_state")]
    battery: String,
    /// Release the robot if a mission gives no commands for this many seconds
    #[arg(long, value_name = "SECONDS", default_value_t = PATIENCE.as_secs(), value_parser = clap::value_parser!(u64).range(1..=86_400))]
    patience: u64,
    /// File with the token that missions must know, one line of at least 16 characters
    #[arg(long, value_name = "FILE")]
    token_file: Option<PathBuf>,
    /// Topic of the commanded velocity (geometry_msgs/Twist or geometry_msgs/TwistStamped)
    #[arg(long, value_name = "TOPIC", default_value = "/cmd_vel")]
    velocity: String,
    /// Message of the commanded velocity
    #[arg(long, value_name = "KIND", value_enum, default_value_t = Choice::Auto)]
    twist: Choice,
    /// Distance of the laser ahead of the middle of the robot, in metres
    #[arg(long, value_name = "M", default_value_t = 0.0, value_parser = finite, allow_negative_numbers = true)]
    laser_x: f64,
    /// Distance of the laser to the left of the middle of the robot, in metres
    #[arg(long, value_name = "M", default_value_t = 0.0, value_parser = finite, allow_negative_numbers = true)]
    laser_y: f64,
    /// Direction of the laser's zero, in degrees counter-clockwise from ahead
    #[arg(long, value_name = "DEG", default_value_t = 0.0, value_parser = finite, allow_negative_numbers = true)]
    laser_heading: f64,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    ctrlc::set_handler(|| IS_STOPPED.store(true, Ordering::Relaxed)).context("cannot hear Ctrl-C")?;
    let is_stopped = || IS_STOPPED.load(Ordering::Relaxed);
    let robot = robot_named(&arguments.robot)?;
    let cannot_listen = || format!("cannot listen at `{}`", arguments.listen);
    let listener = TcpListener::bind(&arguments.listen).with_context(cannot_listen)?;
    let topics = topic::Topics::join(arguments.domain, "rpl_bridge")?;
    let (names, laser_in_base) = (names(arguments, &robot)?, laser_in_base(arguments));
    let teller = Teller::new(|sentence| eprintln!("{sentence}"));
    let mut host = RosHost::new(robot.clone(), topics, &names, arguments.twist, laser_in_base, teller)?;
    if robot.gripper.is_some() {
        eprintln!("the robot `{}` has a gripper, and the bridge moves none: it stays open", robot.name);
    }
    wait_for_topics(&mut host, &is_stopped)?;
    println!("listening at {}", listener.local_addr().with_context(cannot_listen)?);
    let service = Service {
        robot: robot.name.clone(),
        period_us: robot.step_us,
        factor: 1.0,
        until_us: None,
        once: false,
        start_known: arguments.start_known,
        patience: Duration::from_secs(arguments.patience),
        token: arguments.token_file.as_deref().map(token).transpose()?,
    };
    let record =
        serve(&mut host, listener, service, &is_stopped, &mut |notice| tell(&notice)).with_context(cannot_listen)?;
    record.lost.map_or(Ok(()), |lost| Err(anyhow!(lost.0)))
}

/// Returns when all that a percept needs has come once, or the bridge is to end.
fn wait_for_topics(host: &mut RosHost, is_stopped: &dyn Fn() -> bool) -> Result<()> {
    let mut told = Vec::new();
    while !is_stopped() {
        let awaited = host.awaited().map_err(|lost| anyhow!(lost.0))?;
        if awaited.is_empty() {
            return Ok(());
        }
        if awaited != told {
            eprintln!("waiting for {}", awaited.join(", "));
            told = awaited.into_iter().map(String::from).collect();
        }
        thread::sleep(LOOK_EVERY);
    }
    Ok(())
}

fn names(arguments: &Arguments, robot: &RobotDescription) -> Result<TopicNames> {
    if robot.sonar.is_some() && !arguments.sonar.contains(NUMBER) {
        bail!("`--sonar {}` has no place for the number of a sonar; write {NUMBER} there", arguments.sonar);
    }
    Ok(TopicNames {
        odometry: arguments.odometry.clone(),
        scan: arguments.scan.clone(),
        sonar: arguments.sonar.clone(),
        bumper: arguments.bumper.clone(),
        battery: arguments.battery.clone(),
        velocity: arguments.velocity.clone(),
    })
}

fn laser_in_base(arguments: &Arguments) -> Pose {
    Pose::new(arguments.laser_x, arguments.laser_y, arguments.laser_heading.to_radians())
}

fn robot_named(name: &str) -> Result<Arc<RobotDescription>> {
    if let Some(robot) = RobotDescription::builtin(name) {
        return Ok(robot);
    }
    if !Path::new(name).exists() {
        let known: Vec<&str> = RobotDescription::builtin_names().collect();
        bail!("no robot is called `{name}`; there are {}, and files that end in .toml", known.join(", "));
    }
    let text = text_of(Path::new(name)).with_context(|| format!("cannot read the robot `{name}`"))?;
    RobotDescription::parse(&text, name)
        .map(Arc::new)
        .map_err(|error| anyhow!("the robot `{name}` has faults\n{error}"))
}

fn token(file: &Path) -> Result<Token> {
    let cannot = || format!("the token file `{}` is of no use", file.to_string_lossy());
    let text = text_of(file).with_context(cannot)?;
    Token::new(&text).map_err(|why| anyhow!("the token {why}")).with_context(cannot)
}

/// A file that is short by its nature.
fn text_of(file: &Path) -> Result<String> {
    let mut text = String::new();
    File::open(file)?.take(MOST_BYTES + 1).read_to_string(&mut text)?;
    if text.len() as u64 > MOST_BYTES {
        bail!("it has more than {MOST_BYTES} bytes");
    }
    Ok(text)
}

fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) | Err(_) => Err("a number is expected, such as 0.1 or -32".to_string()),
    }
}

fn tell(notice: &Notice) {
    match notice {
        Notice::Came(who) => eprintln!("{who} has the robot"),
        Notice::Went(why) => eprintln!("the mission is gone: {why}"),
        Notice::Refused(why) => eprintln!("refused: {why}"),
        Notice::RefusedMore(count) => eprintln!("refused: {count} more"),
        Notice::Halted(halt) => eprintln!("motors off: {halt:?}"),
        // Nobody looks at the world of a real robot.
        Notice::Happened(_) => {}
    }
}
