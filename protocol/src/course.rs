//! The course of a robot by what its host says: what of a percept cannot be, by the percepts before it and by the
//! robot's description.
//!
//! What cannot be is told and counts for nothing; a host that says it again and again, or says nothing of a
//! sensor that its robot has, is lost.

use crate::host::PerceptMessage;
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::{Pose, wrap_angle_rad};
use rpl_robot::office::Report;
use rpl_robot::sensors::FailedSensors;
use rpl_robot::simulator::{Commands, Percept};
use serde::{Deserialize, Serialize};

/// Percepts in a row that say what cannot be, at most.
const MOST_ASTRAY: u32 = 20;

/// The longest time for which a sensor that is on and has not failed may tell nothing.
const MOST_SILENT_US: u64 = 1_000_000;

/// The most of its own periods for which a camera may give no image.
const MOST_IMAGES_MISSING: u64 = 3;

/// The factor by which the robot may be faster than its description says: it goes down a ramp, and wheels are worn.
const FASTER: f64 = 1.25;

/// The most periods for which odometry that is told with a delay may make up at once.
const PERIODS_AT_ONCE: f64 = 4.0;

/// What wheels may seem to do when they stand: of a motion in metres, and of one in radians.
const TREMBLE: [f64; 2] = [0.01, 0.01];

/// A leap of time explains no more motion than that of this time.
const LONGEST_GAP_US: u64 = 10_000_000;

/// What was perceived so far, as far as the next percept is judged by it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Course {
    /// The number of the next percept, if none is missing.
    pub next: u64,
    /// The time that the host gave its last percept; none before the first.
    time_us: Option<u64>,
    /// Where the odometry of the host was then, as the host counts it.
    robot_in_host_odom: Pose,
    /// Where that odometry began, in that of the run.
    host_odom_in_odom: Pose,
    /// So far, in metres and in radians, the odometry may go at once.
    credit: [f64; 2],
    /// Percepts in a row that said what cannot be.
    astray: u32,
    /// What sonars, laser, camera and its images have told, of those that are on.
    sensors: [Option<Silence>; 4],
    /// Which of them have told anything since the host began.
    have_told: [bool; 4],
    /// What has failed.
    failed: FailedSensors,
}

/// A sensor that is on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Silence {
    /// The number of the commands that have switched it on.
    commands: u64,
    /// For how long it has been on by all that was commanded.
    on_us: u64,
    /// For how long it has been on by what the host says has taken effect, and told nothing.
    silent_us: u64,
}

/// What became of a percept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Astray {
    /// Its time cannot be.
    pub is_time: bool,
    /// Its motion cannot be.
    pub is_motion: bool,
}

impl Course {
    /// The course of a host that begins now, with a robot that is here in the odometry of the run.
    pub fn new(robot_in_odom: Pose) -> Self {
        Self {
            next: 0,
            time_us: None,
            robot_in_host_odom: Pose::default(),
            host_odom_in_odom: robot_in_odom,
            // Before the first percept the robot may have done whatever it can.
            credit: [f64::MAX; 2],
            astray: 0,
            sensors: [None; 4],
            have_told: [false; 4],
            failed: FailedSensors::default(),
        }
    }

    /// Takes in what the host has said and the robot is to have perceived, after these commands: what cannot be is
    /// taken out of the percept and reported, and its odometry becomes that of the run.
    ///
    /// # Errors
    /// One clause that says why a host that says this is lost.
    pub fn take(
        &mut self,
        message: &PerceptMessage,
        percept: &mut Percept,
        commands: &Commands,
        robot: &RobotDescription,
        reports: &mut Vec<Report>,
    ) -> Result<Astray, String> {
        self.look_at_sensors(message.commands, percept, commands, robot, reports)?;
        let periods = message.number.saturating_sub(self.next).saturating_add(1);
        let expected_us = periods.saturating_mul(robot.step_us);
        self.next = message.number.saturating_add(1);
        let (passed_us, is_time) = self.time(message.time_us, expected_us, robot.step_us, reports);
        let is_stale = passed_us == 0;
        let is_motion = self.motion(percept, passed_us, is_stale, robot, reports);
        if is_stale {
            // What was measured at no time of its own was measured before, or nobody knows when.
            (percept.sonar_m, percept.laser_m) = (None, None);
            if let Some(camera) = &mut percept.camera {
                camera.image = None;
            }
        }
        self.astray = if is_time || is_motion { self.astray + 1 } else { 0 };
        if self.astray >= MOST_ASTRAY {
            let what = if is_motion { "the robot cannot have moved so" } else { "time cannot go so" };
            return Err(format!("in {MOST_ASTRAY} percepts one after the other {what}"));
        }
        Ok(Astray { is_time, is_motion })
    }

    /// How much time has passed since the last percept, as far as that can be: none if time goes back or stands; and
    /// whether it is astray.
    fn time(&mut self, time_us: u64, expected_us: u64, period_us: u64, reports: &mut Vec<Report>) -> (u64, bool) {
        // Only from the second percept on it is known when the last one was.
        let Some(last_us) = self.time_us else {
            self.time_us = Some(time_us);
            return (expected_us.min(LONGEST_GAP_US), false);
        };
        let passed_us = time_us.saturating_sub(last_us);
        let is_astray = passed_us == 0 || passed_us.abs_diff(expected_us) > period_us.saturating_mul(2);
        if is_astray {
            let by_s = (time_us as f64 - last_us as f64 - expected_us as f64) / 1e6;
            reports.push(Report::TimeAstray { by_s });
        }
        // Time that has gone back goes on from there: a host that was restarted is not astray for ever.
        self.time_us = Some(time_us);
        let longest_us = expected_us.saturating_add(LONGEST_GAP_US).min(2 * LONGEST_GAP_US);
        (if passed_us == 0 { 0 } else { passed_us.max(expected_us).min(longest_us) }, is_astray)
    }

    /// Odometry as the run counts it; whether it has leapt, or the wheels are too fast.
    fn motion(
        &mut self,
        percept: &mut Percept,
        passed_us: u64,
        is_stale: bool,
        robot: &RobotDescription,
        reports: &mut Vec<Report>,
    ) -> bool {
        let fastest = [robot.motors.max_translation_mps, robot.motors.max_rotation_radps].map(|most| most * FASTER);
        let passed_s = passed_us as f64 / 1e6;
        let at_once_s = passed_s + PERIODS_AT_ONCE * robot.step_us as f64 / 1e6;
        for axis in 0..2 {
            let most = fastest[axis] * at_once_s + TREMBLE[axis];
            self.credit[axis] = (self.credit[axis] + fastest[axis] * passed_s + TREMBLE[axis]).min(most);
        }
        let told = percept.odometry_in_odom;
        let distance_m = self.robot_in_host_odom.distance_m(told);
        let angle_rad = wrap_angle_rad(told.heading_rad - self.robot_in_host_odom.heading_rad);
        let has_leapt = distance_m > self.credit[0] || angle_rad.abs() > self.credit[1];
        if has_leapt {
            reports.push(Report::OdometryLeapt { distance_m, angle_rad });
        }
        if has_leapt || is_stale {
            let robot_in_odom = self.robot_in_odom();
            self.host_odom_in_odom = robot_in_odom.compose(told.inverse());
        } else {
            self.credit[0] -= distance_m;
            self.credit[1] -= angle_rad.abs();
        }
        self.robot_in_host_odom = told;
        percept.odometry_in_odom = self.robot_in_odom();
        let wheels = [percept.translation_mps, percept.rotation_radps];
        let are_too_fast = wheels.iter().zip(fastest).any(|(wheel, most)| wheel.abs() > most);
        if are_too_fast {
            let [translation_mps, rotation_radps] = wheels;
            reports.push(Report::WheelsTooFast { translation_mps, rotation_radps });
            percept.translation_mps = translation_mps.clamp(-fastest[0], fastest[0]);
            percept.rotation_radps = rotation_radps.clamp(-fastest[1], fastest[1]);
        }
        has_leapt || are_too_fast
    }

    /// Where the robot is, in the odometry of the run.
    pub fn robot_in_odom(&self) -> Pose {
        self.host_odom_in_odom.compose(self.robot_in_host_odom)
    }

    /// Whether a sensor that shows what is in the way is on and has told nothing yet: a robot that has never seen what
    /// it is to see does not drive. Sonars that are switched off and on again may be late.
    pub fn is_blind(&self) -> bool {
        let mut of_ranges = self.sensors.iter().zip(self.have_told).take(2);
        of_ranges.any(|(sensor, has_told)| sensor.is_some_and(|sensor| sensor.silent_us > 0) && !has_told)
    }

    /// What is on and has not failed tells something, or has not been silent for long. Commands that have not taken
    /// effect yet switch nothing on, unless that takes too long.
    fn look_at_sensors(
        &mut self,
        in_effect: Option<u64>,
        percept: &Percept,
        commands: &Commands,
        robot: &RobotDescription,
        reports: &mut Vec<Report>,
    ) -> Result<(), String> {
        let failed = percept.failed;
        for ((sensor, had_failed), (_, has_failed)) in self.failed.by_name().into_iter().zip(failed.by_name()) {
            let sensor = sensor.to_string();
            match (had_failed, has_failed) {
                (false, true) => reports.push(Report::SensorFailed { sensor }),
                (true, false) => reports.push(Report::SensorWorks { sensor }),
                (true, true) | (false, false) => {}
            }
        }
        self.failed = failed;
        let sees = commands.camera.is_some() && robot.camera.is_some() && !failed.camera;
        let has_image = percept.camera.as_ref().is_some_and(|camera| camera.image.is_some());
        let image_us = robot.camera.map_or(0, |camera| camera.period_us.saturating_mul(MOST_IMAGES_MISSING));
        let sensors = [
            ("sonar_m", robot.sonar.is_some() && commands.sonars_on && !failed.sonars, percept.sonar_m.is_some(), 0),
            ("laser_m", robot.laser.is_some() && !failed.laser, percept.laser_m.is_some(), 0),
            ("camera", sees, percept.camera.is_some(), 0),
            ("camera.image", sees, has_image, image_us),
        ];
        let kept = self.sensors.iter_mut().zip(&mut self.have_told);
        for ((name, is_on, tells, its_us), (sensor, has_told)) in sensors.into_iter().zip(kept) {
            if !is_on {
                *sensor = None;
                continue;
            }
            let silence = sensor.get_or_insert(Silence { commands: self.next, ..Silence::default() });
            silence.on_us = silence.on_us.saturating_add(robot.step_us);
            let is_in_effect = in_effect >= Some(silence.commands) || silence.on_us > LONGEST_GAP_US;
            silence.silent_us = match is_in_effect && !tells {
                true => silence.silent_us.saturating_add(robot.step_us),
                false => 0,
            };
            *has_told |= tells;
            if silence.silent_us > MOST_SILENT_US.max(its_us) {
                return Err(format!(
                    "`{name}` has been missing for {:.1} s, and the robot `{}` has it: a sensor that has failed is named \
                     in `failed`",
                    silence.silent_us as f64 / 1e6,
                    robot.name
                ));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::host::{GripperMotionMessage, PoseMessage, SensorMessage};
    use rpl_robot::office::ReportKind;
    use rpl_robot::simulator::{CameraCommand, SimulatorModel, SimulatorSettings};
    use rpl_robot::world::World;
    use std::collections::BTreeMap;
    use std::sync::Arc;

    const PERIOD_US: u64 = 50_000;

    /// A percept of a robot that has sonars, in the middle of nothing.
    fn message(number: u64, time_us: u64, x_m: f64) -> PerceptMessage {
        PerceptMessage {
            number,
            time_us,
            commands: Some(number),
            odometry_in_odom: PoseMessage { x_m, y_m: 0.0, heading_rad: 0.0 },
            translation_mps: 0.0,
            rotation_radps: 0.0,
            sonar_m: Some(vec![5.0; 24]),
            laser_m: None,
            camera: None,
            failed: Vec::new(),
            bumped: false,
            gripper: GripperMotionMessage::Open,
            holding: None,
            battery: 1.0,
            messages: Vec::new(),
            others: BTreeMap::new(),
        }
    }

    /// A robot by what its host says, and what was reported of it.
    struct Heard {
        robot: Arc<RobotDescription>,
        course: Course,
        commands: Commands,
        reports: Vec<Report>,
    }

    impl Heard {
        fn of(robot: &str) -> Self {
            let robot = RobotDescription::builtin(robot).expect("built in");
            let commands = Commands { sonars_on: true, ..Commands::default() };
            Self { robot, course: Course::new(Pose::default()), commands, reports: Vec::new() }
        }

        fn take(&mut self, message: &PerceptMessage) -> Result<Percept, String> {
            let view = self.robot.camera.map(|camera| camera.view);
            let mut percept = message.percept(&self.robot.range_sensors(), view.as_ref())?;
            self.course.take(message, &mut percept, &self.commands, &self.robot, &mut self.reports)?;
            Ok(percept)
        }

        /// Where the robot is ahead of where it began.
        fn x_m(&mut self, number: u64, time_us: u64, x_m: f64) -> f64 {
            self.take(&message(number, time_us, x_m)).expect("it may be").odometry_in_odom.x_m
        }

        fn kinds(&mut self) -> Vec<ReportKind> {
            std::mem::take(&mut self.reports).iter().map(Report::kind).collect()
        }
    }

    #[test]
    fn what_our_simulator_perceives_at_full_speed_is_all_possible() {
        let robot = RobotDescription::builtin("b21").expect("built in");
        let world = World::builtin("dept").expect("built in");
        let model = SimulatorModel::new(Arc::new(world), SimulatorSettings::of(robot));
        let mut heard = Heard::of("b21");
        let mut state = model.start(1);
        for number in 0..600 {
            let turning = if number % 100 < 50 { 9.0 } else { -9.0 };
            heard.commands =
                Commands { translation_mps: 9.0, rotation_radps: turning, sonars_on: true, ..Commands::default() };
            let percept = model.step(&mut state, &heard.commands);
            let taken = heard.take(&PerceptMessage::new(number, None, &percept)).expect("it was perceived");
            assert!(taken.odometry_in_odom.distance_m(percept.odometry_in_odom) < 1e-9);
        }
        assert!(heard.reports.is_empty(), "{:?}", heard.reports);
    }

    #[test]
    fn a_leap_of_odometry_is_told_and_is_no_motion() {
        let mut heard = Heard::of("b21");
        assert!((heard.x_m(0, PERIOD_US, 0.04) - 0.04).abs() < 1e-9);
        assert!((heard.x_m(1, 2 * PERIOD_US, 5.04) - 0.04).abs() < 1e-9);
        let [Report::OdometryLeapt { distance_m, angle_rad }] = heard.reports[..] else {
            panic!("{:?}", heard.reports)
        };
        assert!((distance_m - 5.0).abs() < 1e-9 && angle_rad == 0.0, "{distance_m} {angle_rad}");
        assert!((heard.x_m(2, 3 * PERIOD_US, 5.08) - 0.08).abs() < 1e-9, "and then it goes on from there");
        let turned = PerceptMessage {
            odometry_in_odom: PoseMessage { x_m: 5.08, y_m: 0.0, heading_rad: 2.0 },
            ..message(3, 4 * PERIOD_US, 0.0)
        };
        let pose = heard.take(&turned).expect("it may be").odometry_in_odom;
        assert!((pose.x_m - 0.08).abs() < 1e-9 && pose.heading_rad.abs() < 1e-9, "{pose:?}");
        assert_eq!(heard.kinds(), [ReportKind::OdometryLeapt, ReportKind::OdometryLeapt]);
    }

    #[test]
    fn a_robot_is_not_for_long_faster_than_it_can_drive() {
        let mut heard = Heard::of("b21");
        let most_mps = heard.robot.motors.max_translation_mps;
        // Twice as fast as it can: each step could be one that makes up for a delay.
        for number in 0..200 {
            let Ok(percept) = heard.take(&message(number, (number + 1) * PERIOD_US, 0.1 * most_mps * number as f64))
            else {
                break;
            };
            let came_m = percept.odometry_in_odom.x_m;
            let driven_s = (number + 1) as f64 * 0.05;
            assert!(came_m <= 1.5 * most_mps * (driven_s + 0.2) + 0.1, "{came_m} m in {driven_s} s");
        }
        assert!(heard.kinds().contains(&ReportKind::OdometryLeapt));
        // What comes late and at once is no leap.
        let mut heard = Heard::of("b21");
        for number in 0..100 {
            let told_m = 0.05 * most_mps * (number / 3 * 3) as f64;
            assert!((heard.x_m(number, (number + 1) * PERIOD_US, told_m) - told_m).abs() < 1e-9);
        }
        assert!(heard.reports.is_empty(), "{:?}", heard.reports);
    }

    #[test]
    fn time_that_goes_back_stands_or_leaps_is_told_and_what_was_measured_then_is_not_taken_again() {
        let mut heard = Heard::of("b21");
        heard.x_m(0, PERIOD_US, 0.0);
        for (number, time_us, by_s) in [(1, PERIOD_US, -0.05), (2, 10_000, -0.09), (3, 10_060_000, 10.0)] {
            let taken = heard.take(&message(number, time_us, 0.01 * number as f64)).expect("it may be");
            let [Report::TimeAstray { by_s: told_s }] = heard.reports[..] else { panic!("{:?}", heard.reports) };
            assert!((told_s - by_s).abs() < 1e-9, "{told_s}");
            assert_eq!(taken.sonar_m.is_some(), by_s > 0.0);
            heard.reports.clear();
        }
        assert!(heard.x_m(4, 10_110_000, 0.04) < 0.03, "what time does not explain is no motion");
        assert!(heard.reports.is_empty(), "it goes on from there");
        assert!(heard.x_m(5, 10_210_000, 0.05) > 0.0, "a period more is nothing");
        assert!(heard.reports.is_empty(), "{:?}", heard.reports);
    }

    #[test]
    fn a_host_that_is_always_astray_is_lost() {
        for (period_us, step_m, expected) in [(0, 0.0, "time cannot go so"), (PERIOD_US, 9.0, "cannot have moved so")] {
            let mut heard = Heard::of("b21");
            let lost = (0..100).find_map(|number: u64| {
                heard.take(&message(number, (number + 1) * period_us, step_m * number as f64)).err().zip(Some(number))
            });
            let (why, number) = lost.expect("it is lost");
            assert!(why.contains(expected) && (19..22).contains(&number), "{number}: {why}");
        }
    }

    #[test]
    fn wheels_are_no_faster_than_the_robot_can_drive() {
        let mut heard = Heard::of("b21");
        let fast = PerceptMessage { translation_mps: -50.0, ..message(0, PERIOD_US, 0.0) };
        let taken = heard.take(&fast).expect("it may be");
        assert_eq!(taken.translation_mps, -FASTER * heard.robot.motors.max_translation_mps);
        assert_eq!(heard.kinds(), [ReportKind::WheelsTooFast]);
    }

    #[test]
    fn a_sensor_that_the_robot_has_tells_something_or_is_said_to_have_failed_or_the_host_is_lost() {
        let camera = Some(CameraCommand { pan_radps: 0.0 });
        let without = |message: PerceptMessage| PerceptMessage { sonar_m: None, ..message };
        for (robot, camera, missing, failed) in [
            ("b21", None, "`sonar_m`", SensorMessage::Sonars),
            ("b21-laser", None, "`laser_m`", SensorMessage::Laser),
            ("b21-camera", camera, "`camera`", SensorMessage::Camera),
        ] {
            let lost_at = |failed: &[SensorMessage]| {
                let mut heard = Heard::of(robot);
                heard.commands = Commands { sonars_on: missing == "`sonar_m`", camera, ..heard.commands };
                let lost = (0..100).find_map(|number| {
                    let said = PerceptMessage {
                        failed: failed.to_vec(),
                        ..without(message(number, (number + 1) * PERIOD_US, 0.0))
                    };
                    heard.take(&said).err().zip(Some(number))
                });
                (lost, heard.kinds())
            };
            let (lost, _) = lost_at(&[]);
            let (why, number) = lost.unwrap_or_else(|| panic!("{robot} is blind"));
            assert!(why.contains(missing) && why.contains(&format!("`{robot}` has it")), "{why}");
            assert_eq!(number, 20, "after a second");
            assert_eq!(lost_at(&[failed]), (None, vec![ReportKind::SensorFailed]));
        }
    }

    #[test]
    fn a_robot_is_blind_until_its_sensor_has_told_something_once() {
        let mut heard = Heard::of("b21");
        let silent = |number: u64| PerceptMessage { sonar_m: None, ..message(number, (number + 1) * PERIOD_US, 0.0) };
        assert!(!heard.course.is_blind(), "nothing is missing yet");
        for number in 0..3 {
            heard.take(&silent(number)).expect("it may be late");
            assert!(heard.course.is_blind());
        }
        heard.x_m(3, 4 * PERIOD_US, 0.0);
        assert!(!heard.course.is_blind());
        heard.take(&silent(4)).expect("a scan may be missing");
        assert!(!heard.course.is_blind(), "what is in the way is known");
        heard.commands.sonars_on = false;
        heard.take(&silent(5)).expect("they are off");
        heard.commands.sonars_on = true;
        heard.take(&silent(6)).expect("they may be late");
        assert!(!heard.course.is_blind(), "they have told something before");
    }

    #[test]
    fn sonars_that_were_switched_on_by_commands_under_way_may_be_silent_and_not_for_ever() {
        let lost_at = |lag: u64, tells_before: bool| {
            let mut heard = Heard::of("b21");
            (0_u64..1_000).find(|&number| {
                heard.commands.sonars_on = number >= 100;
                let commands = number.checked_sub(lag);
                let said = PerceptMessage { commands, ..message(number, (number + 1) * PERIOD_US, 0.0) };
                let sonar_m = said.sonar_m.clone().filter(|_| tells_before && commands < Some(100));
                heard.take(&PerceptMessage { sonar_m, ..said }).is_err()
            })
        };
        assert_eq!(lost_at(0, true), Some(120), "a second after they were switched on");
        assert_eq!(lost_at(40, true), Some(160), "a second after that took effect");
        assert_eq!(lost_at(40, false), Some(160), "the same, of sonars that are off until then");
        assert_eq!(lost_at(2_000, false), Some(320), "commands that never take effect are no excuse");
    }
}
