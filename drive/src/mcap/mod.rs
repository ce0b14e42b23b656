//! Recordings of runs that ROS tools read: MCAP, ROS 2 profile, messages as CDR; events and log are texts of JSON in
//! `std_msgs/String`, since readers of ROS refuse files with channels of another encoding.
//!
//! The recording is an onlooker of the driver, like the trace: it reads the robot after each step and changes nothing.
//!
//! Read `conversion` (from a robot to messages), then `recording` (which of them are written when), then `channels`
//! (the file).

mod channels;
mod conversion;
mod recording;

pub use recording::McapRecording;
