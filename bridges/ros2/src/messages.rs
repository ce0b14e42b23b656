//! The messages of ROS 2 that the bridge hears and says, field by field as in their `.msg` files. What a
//! later release has added behind the last field is left unread.

use serde::{Deserialize, Serialize};

/// `builtin_interfaces/Time`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Time {
    /// Seconds since 1970.
    pub sec: i32,
    /// Nanoseconds after these.
    pub nanosec: u32,
}

/// `std_msgs/Header`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// When it was measured.
    pub stamp: Time,
    /// In which frame.
    pub frame_id: String,
}

/// `geometry_msgs/Vector3` and `geometry_msgs/Point`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Vector3 {
    /// Ahead.
    pub x: f64,
    /// To the left.
    pub y: f64,
    /// Up.
    pub z: f64,
}

/// `geometry_msgs/Quaternion`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    /// Of the vector.
    pub x: f64,
    /// Of the vector.
    pub y: f64,
    /// Of the vector.
    pub z: f64,
    /// The scalar.
    pub w: f64,
}

/// `geometry_msgs/Pose`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose3 {
    /// Metres.
    pub position: Vector3,
    /// From the frame of the body.
    pub orientation: Quaternion,
}

/// `geometry_msgs/Twist`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// Metres a second.
    pub linear: Vector3,
    /// Radians a second.
    pub angular: Vector3,
}

/// A covariance of six: on the wire 36 numbers, row by row.
pub type Covariance = [[f64; 6]; 6];

/// `geometry_msgs/PoseWithCovariance`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseWithCovariance {
    /// The pose.
    pub pose: Pose3,
    /// How sure it is.
    pub covariance: Covariance,
}

/// `geometry_msgs/TwistWithCovariance`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TwistWithCovariance {
    /// The velocity.
    pub twist: Twist,
    /// How sure it is.
    pub covariance: Covariance,
}

/// `nav_msgs/Odometry`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Odometry {
    /// When, and in which frame the pose is.
    pub header: Header,
    /// In which frame the velocity is.
    pub child_frame_id: String,
    /// Where dead reckoning says the robot is.
    pub pose: PoseWithCovariance,
    /// How it moves.
    pub twist: TwistWithCovariance,
}

/// `sensor_msgs/LaserScan`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LaserScan {
    /// When, and in which frame.
    pub header: Header,
    /// Direction of the first reading, radians.
    pub angle_min: f32,
    /// Direction of the last.
    pub angle_max: f32,
    /// From one to the next; negative when they go clockwise.
    pub angle_increment: f32,
    /// Seconds from one to the next.
    pub time_increment: f32,
    /// Seconds from scan to scan.
    pub scan_time: f32,
    /// Metres; what is less was not measured.
    pub range_min: f32,
    /// Metres; what is more was not measured.
    pub range_max: f32,
    /// Metres.
    pub ranges: Vec<f32>,
    /// In units of the device.
    pub intensities: Vec<f32>,
}

/// `sensor_msgs/Range`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Range {
    /// When, and in which frame.
    pub header: Header,
    /// 0 for ultrasound, 1 for infrared.
    pub radiation_type: u8,
    /// Opening of the cone, radians.
    pub field_of_view: f32,
    /// Metres; what is less was not measured.
    pub min_range: f32,
    /// Metres; what is more was not measured.
    pub max_range: f32,
    /// Metres from the sensor.
    pub range: f32,
}

/// `std_msgs/Bool`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bool {
    /// Yes or no.
    pub data: bool,
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
}
