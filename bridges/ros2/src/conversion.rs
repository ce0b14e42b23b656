//! From the messages of ROS 2 to what a robot perceives, and from its commands to a message.

use rpl_robot::description::Motors;
use rpl_robot::geometry::{Point, Pose, Transform, Velocity, wrap_angle_rad};
use rpl_robot::sensors::LaserScanner;
use rpl_robot::simulator::Commands;
use rpl_ros_messages::messages::{LaserScan, Odometry, Range, Twist, Vector3};
use std::f64::consts::TAU;

/// A robot that is measured to be slower than this stands: an estimate of a velocity is hardly ever 0, and
/// what the bumper has stopped waits until the robot stands.
const STANDING: Velocity = Velocity { translation_mps: 0.005, rotation_radps: 0.01 };

/// How much less than its description says a sensor may reach: numbers of 32 bits do not say 3.5 exactly.
const REACH_SLACK_M: f64 = 1e-3;

/// What odometry says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Where the robot is, in the frame of the odometry.
    pub base_in_odom: Pose,
    /// How it moves.
    pub velocity: Velocity,
}

/// The first field of an odometry that is used and not finite.
pub fn not_finite(message: &Odometry) -> Option<&'static str> {
    let (pose, twist) = (&message.pose.pose, &message.twist.twist);
    let (position, turn) = (&pose.position, &pose.orientation);
    let used = [
        ("pose.pose.position.x", position.x),
        ("pose.pose.position.y", position.y),
        ("pose.pose.orientation.x", turn.x),
        ("pose.pose.orientation.y", turn.y),
        ("pose.pose.orientation.z", turn.z),
        ("pose.pose.orientation.w", turn.w),
        ("twist.twist.linear.x", twist.linear.x),
        ("twist.twist.angular.z", twist.angular.z),
    ];
    used.into_iter().find(|(_, number)| !number.is_finite()).map(|(field, _)| field)
}

/// The plane of an odometry: heading is the turn about the vertical.
///
/// # Errors
/// One clause that says what is no pose or no velocity.
pub fn motion(message: &Odometry) -> Result<Motion, String> {
    let (pose, twist) = (&message.pose.pose, &message.twist.twist);
    let (position, turn) = (&pose.position, &pose.orientation);
    if let Some(field) = not_finite(message) {
        return Err(format!("has a `{field}` that is not finite"));
    }
    let length = [turn.x, turn.y, turn.z, turn.w].map(|part| part * part).iter().sum::<f64>();
    if (length - 1.0).abs() > 0.1 {
        return Err("has an `orientation` that is no rotation".to_string());
    }
    let sin = 2.0 * (turn.w * turn.z + turn.x * turn.y);
    let cos = 1.0 - 2.0 * (turn.y * turn.y + turn.z * turn.z);
    let at_rest = |speed: f64, standing: f64| if speed.abs() < standing { 0.0 } else { speed };
    Ok(Motion {
        base_in_odom: Pose::new(position.x, position.y, sin.atan2(cos)),
        velocity: Velocity {
            translation_mps: at_rest(twist.linear.x, STANDING.translation_mps),
            rotation_radps: at_rest(twist.angular.z, STANDING.rotation_radps),
        },
    })
}

/// What a reading between limits says, after REP 117: the distance of an echo, or none. Minus infinity is
/// too near to be measured; what is beside the limits or no number was not measured, and drivers say so
/// where nothing came back.
fn echo_m(reading_m: f32, least_m: f32, most_m: f32) -> Option<f64> {
    if reading_m == f32::NEG_INFINITY {
        return Some(f64::from(least_m.max(0.0)));
    }
    (reading_m > 0.0 && (least_m..=most_m).contains(&reading_m)).then_some(f64::from(reading_m))
}

/// The sensor reaches as far as the description says: else silence would say that there is nothing where
/// it never looks.
fn reaches(most_m: f64, described_m: f64) -> Result<(), String> {
    if most_m >= described_m - REACH_SLACK_M {
        return Ok(());
    }
    Err(format!("reaches {most_m:.2} m, and the robot's description says {described_m:.2} m"))
}

/// The reading of a sonar that sits `ahead_m` before the place from which its description measures.
///
/// # Errors
/// One clause that says how it is another sonar than the description's.
pub fn sonar_m(message: &Range, ahead_m: f64, range_m: f64) -> Result<f32, String> {
    reaches(f64::from(message.max_range) + ahead_m, range_m)?;
    let echo_m = echo_m(message.range, message.min_range, message.max_range);
    Ok(echo_m.map_or(range_m, |echo_m| (echo_m + ahead_m).min(range_m)) as f32)
}

/// A scan whose rays end somewhere in the frame of the odometry, so that it can be seen from where the
/// robot is a little later.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// Where each ray ends; with an echo or without.
    ends_in_odom: Vec<(Point, bool)>,
}

impl Scan {
    /// A scan of a laser in a robot.
    ///
    /// # Errors
    /// One clause that says how it is another laser than the description's.
    pub fn new(
        message: &LaserScan,
        laser_in_odom: Pose,
        laser_in_base: Pose,
        scanner: &LaserScanner,
    ) -> Result<Self, String> {
        covers(message, laser_in_base, scanner)?;
        reaches(f64::from(message.range_max), scanner.range_m)?;
        let in_odom = Transform::new(laser_in_odom);
        let end = |(ray, &reading_m): (usize, &f32)| {
            let direction_rad = f64::from(message.angle_min) + ray as f64 * f64::from(message.angle_increment);
            let echo_m = echo_m(reading_m, message.range_min, message.range_max);
            let (sin, cos) = direction_rad.sin_cos();
            let length_m = echo_m.unwrap_or(scanner.range_m);
            (in_odom.apply(Point::new(length_m * cos, length_m * sin)), echo_m.is_some())
        };
        Ok(Self { ends_in_odom: message.ranges.iter().enumerate().map(end).collect() })
    }

    /// The readings of the description's laser in the middle of a robot: each that of the ray whose end is
    /// nearest to its direction. Cost: n log n.
    pub fn readings_m(&self, base_in_odom: Pose, scanner: &LaserScanner) -> Vec<f32> {
        let in_base = Transform::new(base_in_odom.inverse());
        let seen = |&(end_in_odom, is_echo): &(Point, bool)| {
            let end = in_base.apply(end_in_odom);
            let distance_m = end.x.hypot(end.y);
            (end.y.atan2(end.x), if is_echo { distance_m.min(scanner.range_m) } else { scanner.range_m })
        };
        let mut rays: Vec<(f64, f64)> = self.ends_in_odom.iter().map(seen).collect();
        rays.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.total_cmp(&other.1)));
        (0..scanner.readings).map(|reading| nearest_m(&rays, scanner.direction_rad(reading)) as f32).collect()
    }
}

/// The distance of the ray nearest to a direction; rays are sorted by theirs, and there is one at least.
fn nearest_m(rays: &[(f64, f64)], direction_rad: f64) -> f64 {
    let direction_rad = wrap_angle_rad(direction_rad);
    let behind = rays.partition_point(|ray| ray.0 < direction_rad);
    let neighbours = [rays[(behind + rays.len() - 1) % rays.len()], rays[behind % rays.len()]];
    let off_rad = |ray: (f64, f64)| wrap_angle_rad(ray.0 - direction_rad).abs();
    let [before, after] = neighbours;
    if off_rad(before) < off_rad(after) { before.1 } else { after.1 }
}

/// The scan looks wherever the description's laser does.
fn covers(message: &LaserScan, laser_in_base: Pose, scanner: &LaserScanner) -> Result<(), String> {
    let (first_rad, step_rad) = (f64::from(message.angle_min), f64::from(message.angle_increment));
    if message.ranges.is_empty() || !first_rad.is_finite() || !step_rad.is_finite() || step_rad == 0.0 {
        return Err("has a scan without readings or without directions".to_string());
    }
    let last_rad = first_rad + (message.ranges.len() - 1) as f64 * step_rad;
    let (from_rad, to_rad) = (first_rad.min(last_rad), first_rad.max(last_rad));
    let slack_rad = step_rad.abs().max(scanner.resolution_deg.to_radians());
    let is_seen = |reading: usize| {
        let since_rad = (scanner.direction_rad(reading) - laser_in_base.heading_rad - from_rad).rem_euclid(TAU);
        since_rad <= to_rad - from_rad + slack_rad || since_rad >= TAU - slack_rad
    };
    match (0..scanner.readings).find(|&reading| !is_seen(reading)) {
        None => Ok(()),
        Some(blind) => Err(format!(
            "looks from {:.0}° to {:.0}° of its own, and the laser of the robot's description at {:.0}° of the robot",
            from_rad.to_degrees(),
            to_rad.to_degrees(),
            scanner.direction_rad(blind).to_degrees()
        )),
    }
}

/// What the wheels are told: no more than the robot can do, and nothing when its motors are off.
pub fn twist(commands: &Commands, motors: &Motors) -> Twist {
    if commands.motors_off {
        return Twist::default();
    }
    let within = |speed: f64, most: f64| if speed.is_finite() { speed.clamp(-most, most) } else { 0.0 };
    let ahead = within(commands.translation_mps, motors.max_translation_mps);
    let turning = within(commands.rotation_radps, motors.max_rotation_radps);
    Twist { linear: Vector3 { x: ahead, ..Vector3::default() }, angular: Vector3 { z: turning, ..Vector3::default() } }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_ros_messages::messages::Quaternion;
    use std::f64::consts::{FRAC_PI_2, PI};

    const FRONT: LaserScanner = LaserScanner { readings: 181, resolution_deg: 1.0, range_m: 8.0 };

    fn turned(heading_rad: f64, roll_rad: f64) -> Quaternion {
        let ((z, w), (x, v)) = ((heading_rad / 2.0).sin_cos(), (roll_rad / 2.0).sin_cos());
        // The turn about the vertical after that about the axis ahead.
        Quaternion { x: w * x, y: z * x, z: z * v, w: w * v }
    }

    fn odometry(orientation: Quaternion, ahead: f64) -> Odometry {
        let mut message = Odometry::default();
        (message.pose.pose.position.x, message.pose.pose.orientation) = (2.0, orientation);
        message.twist.twist.linear.x = ahead;
        message
    }

    #[test]
    fn heading_is_the_turn_about_the_vertical() {
        for heading_rad in [0.0, 0.3, FRAC_PI_2, -2.0, PI] {
            for roll_rad in [0.0, 0.1] {
                let found = motion(&odometry(turned(heading_rad, roll_rad), 0.3)).expect("a motion");
                assert!(wrap_angle_rad(found.base_in_odom.heading_rad - heading_rad).abs() < 1e-12, "{found:?}");
                assert_eq!((found.base_in_odom.x_m, found.velocity.translation_mps), (2.0, 0.3));
            }
        }
    }

    #[test]
    fn a_robot_that_hardly_moves_stands() {
        let found = motion(&odometry(turned(0.0, 0.0), -0.004)).expect("a motion");
        assert_eq!(found.velocity, Velocity::default());
    }

    #[test]
    fn what_is_no_pose_is_refused() {
        let none = motion(&odometry(Quaternion::default(), 0.0)).expect_err("all zeros");
        assert!(none.contains("no rotation"), "{none}");
        let endless = motion(&odometry(turned(0.0, 0.0), f64::NAN)).expect_err("not a number");
        assert!(endless.contains("`twist.twist.linear.x` that is not finite"), "{endless}");
    }

    /// What a laser at a place sees of a wall two metres ahead of the middle of the robot, and nothing else.
    fn wall_ahead(laser_in_base: Pose, from_deg: f64, step_deg: f64, count: usize) -> LaserScan {
        let ray = |ray: usize| {
            let direction_rad = (from_deg + ray as f64 * step_deg).to_radians();
            let cos = (direction_rad + laser_in_base.heading_rad).cos();
            let range_m = if cos > 0.0 { (2.0 - laser_in_base.x_m) / cos } else { f64::INFINITY };
            if range_m < 8.0 { range_m as f32 } else { f32::INFINITY }
        };
        LaserScan {
            angle_min: from_deg.to_radians() as f32,
            angle_max: (from_deg + (count - 1) as f64 * step_deg).to_radians() as f32,
            angle_increment: step_deg.to_radians() as f32,
            range_min: 0.1,
            range_max: 8.0,
            ranges: (0..count).map(ray).collect(),
            ..LaserScan::default()
        }
    }

    fn assert_wall(readings_m: &[f32], distance_m: f64, off_deg: f64) {
        assert_eq!(readings_m.len(), FRONT.readings);
        for (reading, &found_m) in readings_m.iter().enumerate() {
            let direction_rad = FRONT.direction_rad(reading);
            // Beside the wall's last ray lies the first without an echo.
            if direction_rad.abs() > 70_f64.to_radians() {
                continue;
            }
            let [one, other] = [-off_deg, off_deg].map(|off| distance_m / (direction_rad + off.to_radians()).cos());
            let (least, most) = (one.min(other).min(distance_m / direction_rad.cos()), one.max(other));
            let found_m = f64::from(found_m);
            assert!(found_m > least - 1e-3 && found_m < most + 1e-3, "{reading}: {found_m} not in {least}..{most}");
        }
        assert_eq!((readings_m[0], readings_m[180]), (8.0, 8.0), "nothing to either side");
    }

    #[test]
    fn scans_of_any_resolution_order_and_mount_are_the_same_wall() {
        let ahead = Pose::default();
        let cases = [
            (ahead, -90.0, 1.0, 181, 0.01),
            (ahead, -135.0, 0.25, 1081, 0.13),
            (ahead, -90.0, 2.0, 91, 1.01),
            (ahead, 90.0, -0.5, 361, 0.26),
            (ahead, 0.0, 1.0, 360, 0.01),
            (Pose::new(0.0, 0.0, PI), 0.0, 1.0, 360, 0.01),
            (Pose::new(0.2, 0.0, 0.0), -180.0, 0.5, 720, 0.3),
        ];
        for (laser_in_base, from_deg, step_deg, count, off_deg) in cases {
            let message = wall_ahead(laser_in_base, from_deg, step_deg, count);
            let scan = Scan::new(&message, laser_in_base, laser_in_base, &FRONT).expect("a scan");
            assert_wall(&scan.readings_m(Pose::default(), &FRONT), 2.0, off_deg);
        }
    }

    #[test]
    fn a_scan_is_seen_from_where_the_robot_is_now() {
        let began_in_odom = Pose::new(1.0, 1.0, 0.0);
        let message = wall_ahead(Pose::default(), -180.0, 0.25, 1440);
        let scan = Scan::new(&message, began_in_odom, Pose::default(), &FRONT).expect("a scan");
        assert_wall(&scan.readings_m(Pose::new(1.5, 1.0, 0.0), &FRONT), 1.5, 0.6);
        let turned_m = scan.readings_m(Pose::new(1.0, 1.0, 0.5), &FRONT);
        let at = FRONT.reading_at(-0.5).round() as usize;
        assert!((f64::from(turned_m[at]) - 2.0).abs() < 0.01, "the wall is to the right now: {}", turned_m[at]);
    }

    #[test]
    fn another_laser_than_the_descriptions_is_refused() {
        let front = wall_ahead(Pose::default(), -45.0, 1.0, 91);
        let narrow = Scan::new(&front, Pose::default(), Pose::default(), &FRONT).expect_err("half of it is missing");
        assert!(narrow.contains("looks from -45° to 45°"), "{narrow}");
        let short = LaserScan { range_max: 3.5, ..wall_ahead(Pose::default(), -90.0, 1.0, 181) };
        let short = Scan::new(&short, Pose::default(), Pose::default(), &FRONT).expect_err("it sees less far");
        assert!(short.contains("reaches 3.50 m") && short.contains("8.00 m"), "{short}");
        let empty = Scan::new(&LaserScan::default(), Pose::default(), Pose::default(), &FRONT).expect_err("nothing");
        assert!(empty.contains("without readings"), "{empty}");
    }

    #[test]
    fn a_sonar_on_the_rim_is_measured_from_the_middle() {
        let heard = |range: f32| {
            let message = Range { min_range: 0.15, max_range: 5.0, range, ..Range::default() };
            sonar_m(&message, 0.25, 5.0).expect("a sonar")
        };
        assert_eq!([1.0, 4.9].map(heard), [1.25, 5.0], "no farther than it reaches");
        assert_eq!([f32::INFINITY, f32::NAN, 0.0, 0.1].map(heard), [5.0; 4], "nothing was measured");
        assert_eq!(heard(f32::NEG_INFINITY), 0.4, "too near to be measured");
    }

    #[test]
    fn wheels_are_told_no_more_than_they_can_and_nothing_when_the_motors_are_off() {
        let motors = rpl_robot::description::RobotDescription::papers().motors;
        let wanted = Commands { translation_mps: -99.0, rotation_radps: 0.2, ..Commands::default() };
        let told = twist(&wanted, &motors);
        assert_eq!((told.linear.x, told.angular.z), (-motors.max_translation_mps, 0.2));
        assert_eq!(twist(&Commands { motors_off: true, ..wanted }, &motors), Twist::default());
    }
}
