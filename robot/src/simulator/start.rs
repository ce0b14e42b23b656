//! How a world begins, and which states are of it.

use super::gripper::Gripper;
use super::model::SimulatorModel;
use super::odometry::OdometryBias;
use super::pan::Pan;
use super::percept::SensorStreams;
use super::state::{Contacts, SimulatorState, Streams};
use crate::geometry::Pose;
use rpl_random::Stream;

impl SimulatorModel {
    /// The world as its file says, with the robot at its start.
    pub fn start(&self, seed: u64) -> SimulatorState {
        let mut odometry = Stream::new(seed, "odometry");
        let odometry_bias = OdometryBias::draw(&self.robot().odometry, &mut odometry);
        let mut people = Stream::new(seed, "people");
        SimulatorState {
            time_us: 0,
            robot_in_map: self.world.start_in_map,
            translation_mps: 0.0,
            rotation_radps: 0.0,
            odometry_in_odom: Pose::default(),
            odometry_bias,
            doors_open: self.world.doors.iter().map(|door| door.open).collect(),
            objects_removed: vec![false; self.world.objects.len()],
            objects_added: Vec::new(),
            people: self.people_at_start(&mut people),
            gripper: Gripper::open_among(&self.world.items),
            pan: Pan::default(),
            battery: 1.0,
            messages: Vec::new(),
            messages_given: 0,
            sonars_fail_until_us: 0,
            wheels_held_until_us: 0,
            sudden_until_us: 0,
            stepped_before: None,
            touching: false,
            contacts: Contacts::default(),
            distance_driven_m: 0.0,
            streams: Streams {
                sensors: SensorStreams::new(seed),
                odometry,
                gripper: Stream::new(seed, "gripper"),
                people,
            },
            place_seed: seed,
        }
    }

    /// Whether a state belongs to a world like this one. A state that does not must not be stepped;
    /// a saved one may be older than its world file.
    pub fn fits(&self, state: &SimulatorState) -> bool {
        state.doors_open.len() == self.world.doors.len()
            && state.objects_removed.len() == self.world.objects.len()
            && self.fits_people(&state.people)
    }
}
