//! The messages, field by field as in their `.msg` files. What a later release has added behind the last field is left
//! unread.

use crate::definition::messages;
use serde::{Deserialize, Serialize};

/// A covariance of six: on the wire 36 numbers, row by row.
pub type Covariance = [[f64; 6]; 6];

messages! {
    /// `builtin_interfaces/Time`.
    builtin_interfaces/Time {
        /// Seconds since 1970.
        sec: i32,
        /// Nanoseconds after these.
        nanosec: u32,
    }

    /// `std_msgs/Header`.
    std_msgs/Header {
        /// When it was measured.
        stamp: Time,
        /// In which frame.
        frame_id: String,
    }

    /// Metres along three axes, or metres or radians a second.
    geometry_msgs/Vector3 {
        /// Ahead.
        x: f64,
        /// To the left.
        y: f64,
        /// Up.
        z: f64,
    }

    /// `geometry_msgs/Quaternion`.
    geometry_msgs/Quaternion {
        /// Of the vector.
        x: f64,
        /// Of the vector.
        y: f64,
        /// Of the vector.
        z: f64,
        /// The scalar.
        w: f64,
    }

    /// `geometry_msgs/Pose`.
    geometry_msgs/Pose {
        /// Metres.
        position: Point,
        /// From the frame of the body.
        orientation: Quaternion,
    }

    /// `geometry_msgs/Twist`.
    geometry_msgs/Twist {
        /// Metres a second.
        linear: Vector3,
        /// Radians a second.
        angular: Vector3,
    }

    /// A twist at a time.
    geometry_msgs/TwistStamped {
        /// When, and of which frame.
        header: Header,
        /// The twist.
        twist: Twist,
    }

    /// `geometry_msgs/PoseWithCovariance`.
    geometry_msgs/PoseWithCovariance {
        /// The pose.
        pose: Pose,
        /// How sure it is.
        covariance: Covariance,
    }

    /// `geometry_msgs/TwistWithCovariance`.
    geometry_msgs/TwistWithCovariance {
        /// The velocity.
        twist: Twist,
        /// How sure it is.
        covariance: Covariance,
    }

    /// `nav_msgs/Odometry`.
    nav_msgs/Odometry {
        /// When, and in which frame the pose is.
        header: Header,
        /// In which frame the velocity is.
        child_frame_id: String,
        /// Where dead reckoning says the robot is.
        pose: PoseWithCovariance,
        /// How it moves.
        twist: TwistWithCovariance,
    }

    /// `sensor_msgs/LaserScan`.
    sensor_msgs/LaserScan {
        /// When, and in which frame.
        header: Header,
        /// Direction of the first reading, radians.
        angle_min: f32,
        /// Direction of the last.
        angle_max: f32,
        /// From one to the next; negative when they go clockwise.
        angle_increment: f32,
        /// Seconds from one to the next.
        time_increment: f32,
        /// Seconds from scan to scan.
        scan_time: f32,
        /// Metres; what is less was not measured.
        range_min: f32,
        /// Metres; what is more was not measured.
        range_max: f32,
        /// Metres.
        ranges: Vec<f32>,
        /// In units of the device.
        intensities: Vec<f32>,
    }

    /// `sensor_msgs/Range`.
    sensor_msgs/Range {
        /// When, and in which frame.
        header: Header,
        /// 0 for ultrasound, 1 for infrared.
        radiation_type: u8,
        /// Opening of the cone, radians.
        field_of_view: f32,
        /// Metres; what is less was not measured.
        min_range: f32,
        /// Metres; what is more was not measured.
        max_range: f32,
        /// Metres from the sensor.
        range: f32,
    }

    /// `std_msgs/Bool`.
    std_msgs/Bool {
        /// Yes or no.
        data: bool,
    }

    /// A point.
    geometry_msgs/Point {
        /// Ahead.
        x: f64,
        /// To the left.
        y: f64,
        /// Up.
        z: f64,
    }

    /// A pose at a time.
    geometry_msgs/PoseStamped {
        /// When, and in which frame.
        header: Header,
        /// The pose.
        pose: Pose,
    }

    /// A pose at a time, and how sure it is.
    geometry_msgs/PoseWithCovarianceStamped {
        /// When, and in which frame.
        header: Header,
        /// The pose.
        pose: PoseWithCovariance,
    }

    /// From a frame to another.
    geometry_msgs/Transform {
        /// Where the other is.
        translation: Vector3,
        /// How it is turned.
        rotation: Quaternion,
    }

    /// The same at a time.
    geometry_msgs/TransformStamped {
        /// When, and in which frame.
        header: Header,
        /// Which frame is there.
        child_frame_id: String,
        /// Where.
        transform: Transform,
    }

    /// Some frames.
    tf2_msgs/TFMessage {
        /// Each in its parent.
        transforms: Vec<TransformStamped>,
    }

    /// What a grid is like.
    nav_msgs/MapMetaData {
        /// When it was made.
        map_load_time: Time,
        /// Metres of a cell.
        resolution: f32,
        /// Cells along x.
        width: u32,
        /// Cells along y.
        height: u32,
        /// The lower left corner of cell (0, 0).
        origin: Pose,
    }

    /// A grid, row by row: 0 to 100, and −1 for what is not known.
    nav_msgs/OccupancyGrid {
        /// When, and in which frame.
        header: Header,
        /// What it is like.
        info: MapMetaData,
        /// The cells.
        data: Vec<i8>,
    }

    /// A way.
    nav_msgs/Path {
        /// When, and in which frame.
        header: Header,
        /// Its poses.
        poses: Vec<PoseStamped>,
    }

    /// A number.
    std_msgs/Float64 {
        /// The number.
        data: f64,
    }
}

/// `sensor_msgs/BatteryState`, up to the last field that is used here.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BatteryState {
    /// When.
    pub header: Header,
    /// Volts.
    pub voltage: f32,
    /// Degrees Celsius.
    pub temperature: f32,
    /// Amperes, negative when it empties.
    pub current: f32,
    /// Ampere hours.
    pub charge: f32,
    /// Ampere hours when it was last full.
    pub capacity: f32,
    /// Ampere hours when it was new.
    pub design_capacity: f32,
    /// From 0 to 1; not a number when nobody measures it.
    pub percentage: f32,
}

#[cfg(test)]
mod tests {
    use super::*;
    use byteorder::LittleEndian;
    use cdr_encoding::{from_bytes, to_vec};

    /// Bytes as `rclcpp` writes them (CDR, little-endian): numbers begin at multiples of their size, a text
    /// has its length with a zero at its end.
    struct Bytes(Vec<u8>);

    impl Bytes {
        fn put(mut self, bytes: &[u8]) -> Self {
            self.0.resize(self.0.len().next_multiple_of(bytes.len()), 0);
            self.0.extend_from_slice(bytes);
            self
        }

        fn int(self, value: u32) -> Self {
            self.put(&value.to_le_bytes())
        }

        fn float(self, value: f32) -> Self {
            self.put(&value.to_le_bytes())
        }

        fn double(self, value: f64) -> Self {
            self.put(&value.to_le_bytes())
        }

        fn text(self, text: &str) -> Self {
            let mut bytes = self.int(text.len() as u32 + 1);
            bytes.0.extend_from_slice(text.as_bytes());
            bytes.0.push(0);
            bytes
        }

        fn header(frame: &str) -> Self {
            Self(Vec::new()).int(7).int(9).text(frame)
        }
    }

    #[test]
    fn odometry_is_read_from_its_36_numbers_without_a_length() {
        let mut bytes = Bytes::header("odom").text("base_link");
        bytes = [1.0, 2.0, 0.0, 0.0, 0.0, 0.6, 0.8].into_iter().fold(bytes, Bytes::double);
        bytes = (0..36).map(f64::from).fold(bytes, Bytes::double);
        bytes = [0.3, 0.0, 0.0, 0.0, 0.0, -0.2].into_iter().fold(bytes, Bytes::double);
        bytes = [0.0; 36].into_iter().fold(bytes, Bytes::double);
        let (read, used) = from_bytes::<Odometry, LittleEndian>(&bytes.0).expect("an Odometry");
        assert_eq!((read.header.frame_id.as_str(), read.child_frame_id.as_str()), ("odom", "base_link"));
        assert_eq!((read.pose.pose.position.y, read.pose.pose.orientation.w), (2.0, 0.8));
        assert_eq!((read.pose.covariance[5][5], read.twist.twist.angular.z), (35.0, -0.2));
        assert_eq!(used, bytes.0.len());
    }

    #[test]
    fn a_scan_and_a_range_are_read_and_what_a_later_release_adds_is_left() {
        let mut bytes = Bytes::header("base_scan");
        bytes = [-1.0, 1.0, 0.5, 0.0, 0.2, 0.1, 3.5].into_iter().fold(bytes, Bytes::float);
        bytes = [1.0, 2.0, 3.0, f32::INFINITY, 0.0].into_iter().fold(bytes.int(5), Bytes::float);
        let scan = from_bytes::<LaserScan, LittleEndian>(&bytes.int(0).0).expect("a LaserScan").0;
        assert_eq!((scan.angle_increment, scan.range_max), (0.5, 3.5));
        assert_eq!(scan.ranges, [1.0, 2.0, 3.0, f32::INFINITY, 0.0]);
        let range = Bytes::header("sonar").put(&[0]).float(0.5).float(0.2).float(4.0).float(1.5);
        // `variance`, since Jazzy.
        let range = from_bytes::<Range, LittleEndian>(&range.float(0.01).0).expect("a Range").0;
        assert_eq!((range.max_range, range.range), (4.0, 1.5));
    }

    #[test]
    fn a_battery_is_read_as_far_as_it_is_used() {
        let mut bytes = Bytes::header("");
        bytes = [12.0, 20.0, -1.0, 2.0, 4.0, 4.0, 0.5].into_iter().fold(bytes, Bytes::float);
        bytes = bytes.put(&[2]).put(&[1]).put(&[3]).put(&[1]).int(0).int(0).text("").text("x");
        let battery = from_bytes::<BatteryState, LittleEndian>(&bytes.0).expect("a BatteryState").0;
        assert_eq!((battery.voltage, battery.percentage), (12.0, 0.5));
    }

    #[test]
    fn a_twist_is_six_numbers() {
        let twist = Twist {
            linear: Vector3 { x: 0.5, ..Vector3::default() },
            angular: Vector3 { z: -1.0, ..Vector3::default() },
        };
        let bytes = [0.5, 0.0, 0.0, 0.0, 0.0, -1.0].into_iter().fold(Bytes(Vec::new()), Bytes::double);
        assert_eq!(to_vec::<Twist, LittleEndian>(&twist).expect("bytes"), bytes.0);
    }

    #[test]
    fn a_stamped_twist_is_a_header_and_then_six_numbers() {
        let twist = Twist {
            linear: Vector3 { x: 0.5, ..Vector3::default() },
            angular: Vector3 { z: -1.0, ..Vector3::default() },
        };
        let header = Header { stamp: Time { sec: 7, nanosec: 9 }, frame_id: "base_link".to_string() };
        let bytes = [0.5, 0.0, 0.0, 0.0, 0.0, -1.0].into_iter().fold(Bytes::header("base_link"), Bytes::double);
        let message = TwistStamped { header, twist };
        assert_eq!(to_vec::<TwistStamped, LittleEndian>(&message).expect("bytes"), bytes.0);
    }

    #[test]
    fn the_text_of_a_message_names_its_fields_and_the_messages_in_it_once() {
        let text = <Odometry as crate::Message>::definition();
        assert!(text.starts_with("std_msgs/Header header\nstring child_frame_id\n"), "{text}");
        assert_eq!(text.matches("float64[36] covariance\n").count(), 2);
        assert_eq!(text.matches("MSG: geometry_msgs/Vector3\n").count(), 1);
        assert!(text.contains("MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"), "{text}");
    }

    #[test]
    fn a_grid_is_the_same_after_its_bytes() {
        let grid = OccupancyGrid { data: vec![-1, 0, 100], ..OccupancyGrid::default() };
        let bytes = crate::cdr(&grid);
        assert_eq!(bytes[..4], [0, 1, 0, 0]);
        assert_eq!(bytes[bytes.len() - 7..], [3, 0, 0, 0, 0xff, 0, 100]);
        assert_eq!(crate::from_cdr(&bytes), Some(grid.clone()));
        // What fills up the last word is counted in the options.
        let filled = [&[0, 1, 0, 1], &bytes[4..], &[0]].concat();
        assert_eq!(crate::from_cdr(&filled), Some(grid));
        assert_eq!(crate::from_cdr::<OccupancyGrid>(&[&[0, 0, 0, 0], &bytes[4..]].concat()), None);
    }
}
