//! What a mission and a host in another process say to each other, one JSON object a line.
//!
//! The mission greets ([`ToHost::Hello`]), the host greets ([`FromHost::Hello`]); the first commands begin
//! the mission. From then on the host says what the robot perceives once a period, and the mission what the
//! robot is to do as soon as it has decided. Either says `bye` before it goes, with a reason if there is one.

use crate::json_fault::unreadable;
use crate::token::Token;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use rpl_lang::visible::{clause, shortened};
use rpl_robot::geometry::Pose;
use rpl_robot::sensors::{CameraImage, CameraReading, CameraView, FailedSensors, RangeSensors, Signal, Signals};
use rpl_robot::simulator::{CameraCommand, Commands, GripperCommand, GripperMotion, GripperStatus, Percept};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The version of the messages.
pub const PROTOCOL: u32 = 2;

/// Bytes of a line, at most; a longer one is a fault of whoever sent it.
pub const LONGEST_LINE: usize = 1 << 20;

/// A host that hears nothing for this time stops the motors, by the clock on the wall.
pub const SILENCE_US: u64 = 300_000;

/// What a mission says to a host.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(tag = "type", rename_all = "lowercase")]
pub enum ToHost {
    /// The first message.
    Hello(MissionHello),
    /// What the robot is to do from now on.
    Commands(CommandsMessage),
    /// The last message.
    Bye(Bye),
}

/// What a host says to a mission.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(tag = "type", rename_all = "lowercase")]
pub enum FromHost {
    /// The first message, an answer to the mission's.
    Hello(HostHello),
    /// What the robot perceives, once a period.
    Percept(Box<PerceptMessage>),
    /// The last message.
    Bye(Bye),
}

/// How a mission greets.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MissionHello {
    /// The version of the messages it speaks: 2.
    pub protocol: u32,
    /// The version of the program.
    pub rpl: String,
    /// The robot it is for.
    pub robot: String,
    /// What it is called, for whoever finds the robot in use: a plan, by the name of its file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mission: Option<String>,
    /// What a host that has a token wants to be told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub token: Option<Token>,
}

/// How a host greets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct HostHello {
    /// The version of the messages it speaks: 2.
    pub protocol: u32,
    /// The robot that it moves.
    pub robot: String,
    /// Time of the robot between two percepts.
    pub period_us: u64,
    /// Seconds of the robot for each second on the wall; a real robot has 1.
    pub factor: f64,
    /// Whether the robot stands where the world says it starts. If not, the mission begins without knowing
    /// where it is.
    pub start_known: bool,
}

/// What the robot is to do until other commands come.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CommandsMessage {
    /// The number of the percept that the decision waits for: it has taken in those before, as far as they came. The
    /// same number again is the same decision, repeated as a sign of life.
    pub number: u64,
    /// Wanted speed ahead, negative backwards.
    pub translation_mps: f64,
    /// Wanted turning speed, counter-clockwise.
    pub rotation_radps: f64,
    /// Whether the sonars fire.
    pub sonars_on: bool,
    /// What the gripper is to begin, if anything.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gripper: Option<GripperOrder>,
    /// What the camera is to do; it is off without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraOrder>,
    /// What actuators of other kinds are told, by their names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub others: SignalMessages,
}

/// What the gripper is to begin.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum GripperOrder {
    /// Take the thing of this name.
    Grasp(String),
    /// Let go.
    Release,
}

/// What a camera that is on is to do.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CameraOrder {
    /// Wanted turning speed of its pan unit, counter-clockwise.
    pub pan_radps: f64,
}

/// What the robot perceives at the end of a period.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PerceptMessage {
    /// Counts the percepts of the mission from 0.
    pub number: u64,
    /// Time of the robot since the mission began.
    pub time_us: u64,
    /// The number of the newest commands that had taken effect; none before the first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub commands: Option<u64>,
    /// Where dead reckoning says the robot is; where the mission began is the origin.
    pub odometry_in_odom: PoseMessage,
    /// Speed ahead, from the wheels.
    pub translation_mps: f64,
    /// Turning speed, from the wheels.
    pub rotation_radps: f64,
    /// Of each sonar, the distance from its mount, which of a ring is the middle of the robot; the maximum
    /// range where there was no echo.
    /// None if there are no sonars, or they are off or have failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sonar_m: Option<Vec<f32>>,
    /// The same of each reading of the laser, from right to left. None if there is no laser, or it has failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub laser_m: Option<Vec<f32>>,
    /// What the camera tells. None if there is no camera, or it is off.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraMessage>,
    /// Sensors that have failed. Of all others that the robot has and that are on something is expected.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub failed: Vec<SensorMessage>,
    /// Whether something presses against the body.
    pub bumped: bool,
    /// How the gripper stands.
    pub gripper: GripperMotionMessage,
    /// The thing in it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub holding: Option<String>,
    /// Charge of the battery, from 0 to 1.
    pub battery: f64,
    /// What people have sent since the last percept, word by word.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub messages: Vec<Vec<String>>,
    /// What sensors of other kinds perceive, by their names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub others: SignalMessages,
}

/// What a camera that is on tells.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CameraMessage {
    /// Where it is turned to, counter-clockwise from straight ahead.
    pub pan_rad: f64,
    /// The newest image, if there is one since the last percept: red, green and blue of each pixel, a byte
    /// each, the top row first, in Base64. It is as wide and high as the file of the robot says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub image: Option<String>,
}

/// What a robot may have to sense with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum SensorMessage {
    /// All sonars.
    Sonars,
    /// The laser range finder.
    Laser,
    /// The camera.
    Camera,
}

/// What a sensor perceives or an actuator is told, by its name, that rpl knows nothing else of.
pub type SignalMessages = BTreeMap<String, SignalMessage>;

/// The value of such a signal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(untagged)]
pub enum SignalMessage {
    /// Yes or no.
    Truth(bool),
    /// A number.
    Number(f64),
    /// A text.
    Text(String),
    /// Signals, one after the other.
    List(Vec<SignalMessage>),
}

/// Position and heading in the plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PoseMessage {
    /// Metres.
    pub x_m: f64,
    /// Metres.
    pub y_m: f64,
    /// Counter-clockwise from the x axis.
    pub heading_rad: f64,
}

/// How a gripper stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum GripperMotionMessage {
    /// Open and at rest; also of a robot without one.
    Open,
    /// Closing or opening.
    Moving,
    /// Closed.
    Closed,
}

/// A farewell.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Bye {
    /// One clause that says why, if it is not because all is done.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// What a mission heard at a turn: a percept, and how it came.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HostAnswer {
    /// The percept.
    pub percept: PerceptMessage,
    /// By how much it came late, if that is more than a period.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub late_s: Option<f64>,
    /// Percepts before it that never came.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub missing: u64,
    /// How long the decision before it took, if that is more than a period.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decided_in_s: Option<f64>,
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}

impl Bye {
    /// That somebody says this, as a clause about them.
    pub fn told(&self) -> String {
        match &self.reason {
            Some(reason) => format!("says goodbye: {}", clause(reason)),
            None => "says goodbye".to_string(),
        }
    }
}

impl MissionHello {
    /// Why a host of this robot cannot serve the mission, as a clause about it, if it cannot.
    pub fn unfit(&self, robot: &str, token: Option<&Token>) -> Option<String> {
        if self.protocol != PROTOCOL {
            return Some(format!("speaks version {} of the messages, and this host {PROTOCOL}", self.protocol));
        }
        // Whoever has no token learns nothing of what is here.
        match (token, &self.token) {
            (Some(token), Some(said)) if token.is(said) => {}
            (Some(_), Some(_)) => return Some("has another token than this host".to_string()),
            (Some(_), None) => {
                return Some("has no token, and this host wants one: `--token-file FILE`".to_string());
            }
            (None, _) => {}
        }
        let is_for = || format!("is for the robot `{}`, and this host moves `{robot}`", shortened(&self.robot));
        (self.robot != robot).then(is_for)
    }
}

impl CommandsMessage {
    /// The commands of a robot, as the decision of a number.
    pub fn new(number: u64, commands: &Commands) -> Self {
        // JSON has no other numbers, and a robot stands still for them.
        let finite = |speed: f64| if speed.is_finite() { speed } else { 0.0 };
        Self {
            number,
            translation_mps: finite(commands.translation_mps),
            rotation_radps: finite(commands.rotation_radps),
            sonars_on: commands.sonars_on,
            gripper: match &commands.gripper {
                GripperCommand::None => None,
                GripperCommand::Grasp(item) => Some(GripperOrder::Grasp(item.clone())),
                GripperCommand::Release => Some(GripperOrder::Release),
            },
            camera: commands.camera.map(|camera| CameraOrder { pan_radps: finite(camera.pan_radps) }),
            others: messages_of(&commands.others),
        }
    }

    /// What the robot is to do.
    pub fn commands(&self) -> Commands {
        Commands {
            translation_mps: self.translation_mps,
            rotation_radps: self.rotation_radps,
            sonars_on: self.sonars_on,
            gripper: match &self.gripper {
                None => GripperCommand::None,
                Some(GripperOrder::Grasp(item)) => GripperCommand::Grasp(item.clone()),
                Some(GripperOrder::Release) => GripperCommand::Release,
            },
            camera: self.camera.map(|camera| CameraCommand { pan_radps: camera.pan_radps }),
            others: signals_of(&self.others),
            ..Commands::default()
        }
    }
}

impl PerceptMessage {
    /// What a robot perceived, as the percept of a number.
    pub fn new(number: u64, commands: Option<u64>, percept: &Percept) -> Self {
        let Pose { x_m, y_m, heading_rad } = percept.odometry_in_odom;
        Self {
            number,
            time_us: percept.time_us,
            commands,
            odometry_in_odom: PoseMessage { x_m, y_m, heading_rad },
            translation_mps: percept.translation_mps,
            rotation_radps: percept.rotation_radps,
            sonar_m: percept.sonar_m.as_ref().map(|readings| readings.to_vec()),
            laser_m: percept.laser_m.clone(),
            camera: percept.camera.as_ref().map(|reading| CameraMessage {
                pan_rad: reading.pan_rad,
                image: reading.image.as_ref().map(|image| BASE64_STANDARD.encode(&image.rgb)),
            }),
            failed: failed_messages(percept.failed),
            bumped: percept.bumped,
            gripper: match percept.gripper.motion {
                GripperMotion::Open => GripperMotionMessage::Open,
                GripperMotion::Moving => GripperMotionMessage::Moving,
                GripperMotion::Closed => GripperMotionMessage::Closed,
            },
            holding: percept.gripper.holding.clone(),
            battery: percept.battery,
            messages: percept.messages.clone(),
            others: messages_of(&percept.others),
        }
    }

    /// The percept of a robot with these range sensors and this camera.
    ///
    /// # Errors
    /// One clause that says what no robot of this kind can have perceived.
    pub fn percept(&self, sensors: &RangeSensors, camera: Option<&CameraView>) -> Result<Percept, String> {
        let PoseMessage { x_m, y_m, heading_rad } = self.odometry_in_odom;
        let numbers = [
            ("odometry_in_odom.x_m", x_m),
            ("odometry_in_odom.y_m", y_m),
            ("odometry_in_odom.heading_rad", heading_rad),
            ("translation_mps", self.translation_mps),
            ("rotation_radps", self.rotation_radps),
        ];
        // What is out of all proportion would be infinite a few sums later.
        if let Some((name, value)) = numbers.into_iter().find(|(_, value)| value.abs() > MOST) {
            return Err(format!("`{name}` is {value}, and at most {MOST} makes sense"));
        }
        if !(0.0..=1.0).contains(&self.battery) {
            return Err(format!("`battery` is {}, and 0 to 1 is expected", self.battery));
        }
        let sonars = sensors.sonars.as_ref().map_or(0, |sonars| sonars.mounts.len());
        let sonar_m = self.sonar_m.as_deref().map(|readings| ranges("sonar_m", readings, sonars)).transpose()?;
        let readings = sensors.laser.map_or(0, |laser| laser.readings);
        let laser_m = self.laser_m.as_deref().map(|found| laser_ranges(found, readings)).transpose()?;
        let camera = self.camera.as_ref().map(|told| told.reading(camera)).transpose()?;
        let motion = match self.gripper {
            GripperMotionMessage::Open => GripperMotion::Open,
            GripperMotionMessage::Moving => GripperMotion::Moving,
            GripperMotionMessage::Closed => GripperMotion::Closed,
        };
        Ok(Percept {
            time_us: self.time_us,
            odometry_in_odom: Pose::new(x_m, y_m, heading_rad),
            translation_mps: self.translation_mps,
            rotation_radps: self.rotation_radps,
            sonar_m: sonar_m.map(<[f32]>::to_vec),
            laser_m: laser_m.map(<[f32]>::to_vec),
            camera,
            failed: FailedSensors {
                sonars: self.failed.contains(&SensorMessage::Sonars),
                laser: self.failed.contains(&SensorMessage::Laser),
                camera: self.failed.contains(&SensorMessage::Camera),
            },
            bumped: self.bumped,
            gripper: GripperStatus { motion, holding: self.holding.clone() },
            battery: self.battery,
            messages: self.messages.clone(),
            others: signals_of(&self.others),
        })
    }
}

impl CameraMessage {
    fn reading(&self, view: Option<&CameraView>) -> Result<CameraReading, String> {
        let Some(view) = view else { return Err("`camera` is there, and the robot has none".to_string()) };
        if self.pan_rad.abs() > std::f64::consts::PI {
            return Err(format!("`camera.pan_rad` is {}, and a pan unit turns by half a turn at most", self.pan_rad));
        }
        let image = self.image.as_deref().map(|text| image(text, view)).transpose()?;
        Ok(CameraReading { pan_rad: self.pan_rad, image })
    }
}

fn image(text: &str, view: &CameraView) -> Result<CameraImage, String> {
    let rgb = BASE64_STANDARD.decode(text).map_err(|error| format!("`camera.image` is no Base64: {error}"))?;
    let CameraView { columns, rows, .. } = *view;
    if rgb.len() != 3 * columns * rows {
        let expected = 3 * columns * rows;
        return Err(format!(
            "`camera.image` has {} bytes, and {expected} are expected, 3 for each of {columns} by {rows} pixels",
            rgb.len()
        ));
    }
    Ok(CameraImage { columns, rgb })
}

fn failed_messages(failed: FailedSensors) -> Vec<SensorMessage> {
    let FailedSensors { sonars, laser, camera } = failed;
    let all = [(SensorMessage::Sonars, sonars), (SensorMessage::Laser, laser), (SensorMessage::Camera, camera)];
    all.into_iter().filter(|(_, has_failed)| *has_failed).map(|(sensor, _)| sensor).collect()
}

fn messages_of(signals: &Signals) -> SignalMessages {
    fn message(signal: &Signal) -> SignalMessage {
        match signal {
            Signal::Truth(truth) => SignalMessage::Truth(*truth),
            Signal::Number(number) => SignalMessage::Number(if number.is_finite() { *number } else { 0.0 }),
            Signal::Text(text) => SignalMessage::Text(text.clone()),
            Signal::List(items) => SignalMessage::List(items.iter().map(message).collect()),
        }
    }
    signals.iter().map(|(name, signal)| (name.clone(), message(signal))).collect()
}

fn signals_of(messages: &SignalMessages) -> Signals {
    fn signal(message: &SignalMessage) -> Signal {
        match message {
            SignalMessage::Truth(truth) => Signal::Truth(*truth),
            SignalMessage::Number(number) => Signal::Number(*number),
            SignalMessage::Text(text) => Signal::Text(text.clone()),
            SignalMessage::List(items) => Signal::List(items.iter().map(signal).collect()),
        }
    }
    messages.iter().map(|(name, message)| (name.clone(), signal(message))).collect()
}

/// Metres, metres a second or radians that no robot comes to.
const MOST: f64 = 1e6;

/// A laser's readings. None is at the robot's middle: drivers say so where there was no echo.
fn laser_ranges(readings: &[f32], expected: usize) -> Result<&[f32], String> {
    let readings = ranges("laser_m", readings, expected)?;
    match readings.iter().position(|&reading| reading == 0.0) {
        Some(at) => Err(format!("`laser_m[{at}]` is 0; a reading without an echo is the range of the laser")),
        None => Ok(readings),
    }
}

fn ranges<'a>(name: &str, readings: &'a [f32], expected: usize) -> Result<&'a [f32], String> {
    if readings.len() != expected {
        return Err(format!("`{name}` has {} readings, and {expected} are expected", readings.len()));
    }
    match readings.iter().position(|reading| !(0.0..=MOST as f32).contains(reading)) {
        Some(at) => Err(format!("`{name}[{at}]` is {}, and no distance", readings[at])),
        None => Ok(readings),
    }
}

/// A message of one line.
///
/// # Errors
/// One clause that says what is wrong with it.
pub fn read<'t, M: Deserialize<'t>>(line: &'t str) -> Result<M, String> {
    serde_json::from_str(line).map_err(|error| unreadable(line, &error))
}

/// A message as a line, with its end.
pub fn written(message: &impl Serialize) -> String {
    match serde_json::to_string(message) {
        Ok(text) => text + "\n",
        Err(error) => unreachable!("every message can be written: {error}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_robot::description::RobotDescription;
    use rpl_robot::simulator::{SimulatorModel, SimulatorSettings};
    use rpl_robot::world::World;
    use std::sync::Arc;

    /// What a robot with a camera perceives while that is on, with an image.
    fn seen() -> (Arc<RobotDescription>, Percept) {
        let robot = RobotDescription::builtin("b21-camera").expect("built in");
        let world = World::builtin("test-room").expect("built in");
        let model = SimulatorModel::new(Arc::new(world), SimulatorSettings::of(robot.clone()));
        let camera = Some(CameraCommand { pan_radps: 1.0 });
        let commands = Commands { camera, sonars_on: true, ..Commands::default() };
        let mut state = model.start(1);
        let mut percepts = std::iter::from_fn(|| Some(model.step(&mut state, &commands))).take(10);
        let has_image = |percept: &Percept| percept.camera.as_ref().is_some_and(|camera| camera.image.is_some());
        (robot, percepts.find(has_image).expect("an image"))
    }

    fn taken(message: &PerceptMessage, robot: &RobotDescription) -> Result<Percept, String> {
        message.percept(&robot.range_sensors(), robot.camera.map(|camera| camera.view).as_ref())
    }

    #[test]
    fn an_image_is_the_same_after_it_was_said() {
        let (robot, percept) = seen();
        let line = written(&PerceptMessage::new(3, Some(2), &percept));
        assert!(line.len() < 20_000, "{}", line.len());
        assert_eq!(taken(&read(&line).expect("a message"), &robot), Ok(percept));
    }

    #[test]
    fn what_no_camera_can_have_told_is_refused_in_words() {
        let (robot, percept) = seen();
        let message = PerceptMessage::new(3, Some(2), &percept);
        let camera = |pan_rad, image: &str| PerceptMessage {
            camera: Some(CameraMessage { pan_rad, image: Some(image.to_string()) }),
            ..message.clone()
        };
        let why = |message: &PerceptMessage| taken(message, &robot).expect_err("it cannot be");
        assert_eq!(
            why(&camera(0.0, "AAAA")),
            "`camera.image` has 3 bytes, and 14400 are expected, 3 for each of 80 by 60 pixels"
        );
        assert!(
            why(&camera(0.0, "AA*A")).starts_with("`camera.image` is no Base64: "),
            "{}",
            why(&camera(0.0, "AA*A"))
        );
        assert!(why(&camera(9.0, "")).contains("`camera.pan_rad` is 9"));
        let blind = RobotDescription::papers();
        assert_eq!(taken(&message, &blind), Err("`camera` is there, and the robot has none".to_string()));
    }

    #[test]
    fn a_camera_is_told_to_turn_and_otherwise_nothing() {
        let looking = Commands { camera: Some(CameraCommand { pan_radps: -0.5 }), ..Commands::default() };
        let line = written(&CommandsMessage::new(1, &looking));
        assert!(line.contains("\"camera\":{\"pan_radps\":-0.5}"), "{line}");
        assert_eq!(read::<CommandsMessage>(&line).map(|message| message.commands()), Ok(looking));
        assert!(!written(&CommandsMessage::new(1, &Commands::default())).contains("camera"));
    }
}
