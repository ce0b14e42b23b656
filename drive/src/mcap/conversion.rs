//! From what the robot has to messages, in the frames of REP 103 and REP 105: x ahead, y to the left, `map`, `odom`,
//! `base_link`.

use rpl_mission::sight::PositionBelief;
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::{Point, Pose, Velocity, wrap_angle_rad};
use rpl_robot::localization::Maximum;
use rpl_robot::occupancy::{Cell, OccupancyGrid};
use rpl_robot::sensors::{LaserScanner, SonarArray};
use rpl_robot::simulator::Percept;
use rpl_ros_messages::messages as ros;

/// The map, and where the robot is in it.
pub const MAP: &str = "map";
/// Dead reckoning from the start.
pub const ODOM: &str = "odom";
/// The middle of the robot.
pub const BASE: &str = "base_link";

/// The least probability of a square metre that a belief tells apart from none, and the most, in powers of ten.
const LEAST_POWER: f64 = -4.0;
const MOST_POWER: f64 = 2.0;

/// A time of the run; 0 is its start.
pub fn time(time_us: u64) -> ros::Time {
    ros::Time { sec: (time_us / 1_000_000) as i32, nanosec: (time_us % 1_000_000) as u32 * 1000 }
}

/// When, and in which frame.
pub fn header(time_us: u64, frame: &str) -> ros::Header {
    ros::Header { stamp: time(time_us), frame_id: frame.to_string() }
}

fn turn(heading_rad: f64) -> ros::Quaternion {
    let (sin, cos) = (heading_rad / 2.0).sin_cos();
    ros::Quaternion { x: 0.0, y: 0.0, z: sin, w: cos }
}

/// A pose in the plane.
pub fn pose(pose: Pose) -> ros::Pose {
    let position = ros::Point { x: pose.x_m, y: pose.y_m, z: 0.0 };
    ros::Pose { position, orientation: turn(pose.heading_rad) }
}

/// A velocity of the robot.
pub fn twist(velocity: Velocity) -> ros::Twist {
    ros::Twist {
        linear: ros::Vector3 { x: velocity.translation_mps, ..ros::Vector3::default() },
        angular: ros::Vector3 { z: velocity.rotation_radps, ..ros::Vector3::default() },
    }
}

/// A frame in its parent.
pub fn transform(time_us: u64, parent: &str, child: &str, child_in_parent: Pose) -> ros::TransformStamped {
    let translation = ros::Vector3 { x: child_in_parent.x_m, y: child_in_parent.y_m, z: 0.0 };
    ros::TransformStamped {
        header: header(time_us, parent),
        child_frame_id: child.to_string(),
        transform: ros::Transform { translation, rotation: turn(child_in_parent.heading_rad) },
    }
}

/// What dead reckoning says.
pub fn odometry(time_us: u64, percept: &Percept) -> ros::Odometry {
    let Percept { odometry_in_odom, translation_mps, rotation_radps, .. } = *percept;
    ros::Odometry {
        header: header(time_us, ODOM),
        child_frame_id: BASE.to_string(),
        pose: ros::PoseWithCovariance { pose: pose(odometry_in_odom), ..ros::PoseWithCovariance::default() },
        twist: ros::TwistWithCovariance {
            twist: twist(Velocity { translation_mps, rotation_radps }),
            ..ros::TwistWithCovariance::default()
        },
    }
}

/// How far apart the likely poses are from a pose: squares of x, y and heading, and their products.
pub fn covariance(likely: &[Maximum], pose_in_map: Pose) -> ros::Covariance {
    let mut covariance = ros::Covariance::default();
    let total: f64 = likely.iter().map(|state| state.mass).sum();
    if total <= 0.0 {
        return covariance;
    }
    // In the order of ROS: x, y, z, about x, about y, about z.
    const AXES: [usize; 3] = [0, 1, 5];
    for state in likely {
        let at = state.pose_in_map;
        let heading_rad = wrap_angle_rad(at.heading_rad - pose_in_map.heading_rad);
        let off = [at.x_m - pose_in_map.x_m, at.y_m - pose_in_map.y_m, heading_rad];
        for (row, one) in AXES.into_iter().zip(off) {
            for (column, other) in AXES.into_iter().zip(off) {
                covariance[row][column] += state.mass / total * one * other;
            }
        }
    }
    covariance
}

/// A scan of the laser in the middle of the robot; what came back from nowhere is infinite, after REP 117.
pub fn laser_scan(time_us: u64, every_us: u64, scanner: &LaserScanner, ranges_m: &[f32]) -> ros::LaserScan {
    let range_m = scanner.range_m as f32;
    let last = scanner.readings.saturating_sub(1);
    ros::LaserScan {
        header: header(time_us, BASE),
        angle_min: scanner.direction_rad(0) as f32,
        angle_max: scanner.direction_rad(last) as f32,
        angle_increment: scanner.resolution_deg.to_radians() as f32,
        time_increment: 0.0,
        scan_time: every_us as f32 / 1e6,
        range_min: 0.0,
        range_max: range_m,
        ranges: ranges_m.iter().map(|&reading_m| echo(reading_m, range_m)).collect(),
        intensities: Vec::new(),
    }
}

fn echo(reading_m: f32, range_m: f32) -> f32 {
    if reading_m < range_m { reading_m } else { f32::INFINITY }
}

/// The frame of a sonar.
pub fn sonar_frame(sonar: usize) -> String {
    format!("sonar_{sonar}")
}

/// Where the sonars sit.
pub fn sonar_frames(sonars: &SonarArray) -> Vec<ros::TransformStamped> {
    let mounts = sonars.mounts.iter().enumerate();
    let frame = |(sonar, mount): (usize, &rpl_robot::sensors::SonarMount)| {
        let at = Pose::new(mount.at_in_base.x, mount.at_in_base.y, mount.heading_rad);
        transform(0, BASE, &sonar_frame(sonar), at)
    };
    mounts.map(frame).collect()
}

/// What a sonar heard.
pub fn range(time_us: u64, sonars: &SonarArray, sonar: usize, reading_m: f32) -> ros::Range {
    let range_m = sonars.range_m as f32;
    ros::Range {
        header: header(time_us, &sonar_frame(sonar)),
        radiation_type: 0,
        field_of_view: sonars.cone_rad as f32,
        min_range: 0.0,
        max_range: range_m,
        range: echo(reading_m, range_m),
    }
}

/// The sonars of a robot, as its description has them.
pub fn sonars(robot: &RobotDescription) -> Option<SonarArray> {
    robot.sonar.as_ref().map(|sonar| SonarArray::new(&sonar.layout, sonar.cone_rad, sonar.range_m))
}

fn meta(resolution_m: f64, columns: usize, cells: usize, origin_in_map: Point) -> ros::MapMetaData {
    ros::MapMetaData {
        map_load_time: ros::Time::default(),
        resolution: resolution_m as f32,
        width: columns as u32,
        height: (cells / columns.max(1)) as u32,
        origin: pose(Pose::new(origin_in_map.x, origin_in_map.y, 0.0)),
    }
}

/// A map: 100 is occupied, 0 free, −1 not known.
pub fn map(grid: &OccupancyGrid) -> ros::OccupancyGrid {
    let cell = |cell: &Cell| match cell {
        Cell::Occupied => 100,
        Cell::Free => 0,
        Cell::Unknown => -1,
    };
    ros::OccupancyGrid {
        header: header(0, MAP),
        info: meta(grid.resolution_m, grid.columns, grid.cells.len(), grid.origin_in_frame),
        data: grid.cells.iter().map(cell).collect(),
    }
}

/// A belief on a scale of powers of ten: 0 is a probability of 0.0001 per square metre and less, 100 is 100 and more.
pub fn belief(time_us: u64, belief: &PositionBelief) -> ros::OccupancyGrid {
    let cell_m2 = belief.resolution_m * belief.resolution_m;
    let least = libm::exp10(LEAST_POWER) * cell_m2;
    // Nearly all cells are below the scale, and a logarithm takes a while.
    let cell = |&probability: &f64| match probability > least {
        true => {
            let power = libm::log10(probability / cell_m2);
            libm::round(100.0 * (power - LEAST_POWER) / (MOST_POWER - LEAST_POWER)).min(100.0) as i8
        }
        false => 0,
    };
    ros::OccupancyGrid {
        header: header(time_us, MAP),
        info: meta(belief.resolution_m, belief.columns, belief.cells.len(), belief.origin_in_map),
        data: belief.cells.iter().map(cell).collect(),
    }
}

/// Target points in the order in which they are to be reached.
pub fn path(time_us: u64, poses_in_map: &[Pose]) -> ros::Path {
    let stamped = |at: &Pose| ros::PoseStamped { header: header(time_us, MAP), pose: pose(*at) };
    ros::Path { header: header(time_us, MAP), poses: poses_in_map.iter().map(stamped).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_belief_of_one_percent_in_a_square_metre_is_in_the_middle_of_the_scale() {
        let belief = PositionBelief {
            resolution_m: 1.0,
            origin_in_map: Point::origin(),
            columns: 2,
            cells: vec![0.0, 0.0001, 0.01, 0.9],
        };
        let grid = super::belief(0, &belief);
        assert_eq!((grid.info.width, grid.info.height), (2, 2));
        assert_eq!(grid.data, [0, 0, 33, 66]);
    }

    #[test]
    fn a_covariance_is_that_of_the_likely_poses() {
        let state = |x_m: f64, heading_rad: f64| Maximum { pose_in_map: Pose::new(x_m, 0.0, heading_rad), mass: 0.4 };
        let at = Pose::new(1.0, 0.0, 3.1);
        let covariance = covariance(&[state(0.0, 3.1), state(2.0, -3.1)], at);
        assert!((covariance[0][0] - 1.0).abs() < 1e-12);
        let turned_rad = std::f64::consts::TAU - 6.2;
        assert!((covariance[5][5] - turned_rad * turned_rad / 2.0).abs() < 1e-12, "the short way round");
        assert!((covariance[0][5] - turned_rad / 2.0).abs() < 1e-12 && covariance[1][1] == 0.0);
    }
}
