//! The experimenter's hands and eyes: what no plan of the robot may use.

use super::gripper::{ItemPlace, ItemState};
use super::model::SimulatorModel;
use super::state::{Contacts, SimulatorState};
use super::walker::PERSON_RADIUS_M;
use crate::geometry::{Point, Pose, Vector, distance_m};
use crate::world::{Object, Outline, Rect, SolidOrigin, UnknownName, is_same_name};
use rpl_lang::symbol::fold_name;

/// Why the experimenter cannot do that.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OracleError {
    /// The robot would stand in something.
    #[error("the robot cannot stand at ({x_m:.2}, {y_m:.2}): {what} is in the way")]
    Occupied {
        /// Where.
        x_m: f64,
        /// Where.
        y_m: f64,
        /// What stands there.
        what: String,
    },
    /// The thing would stand in the robot or a person.
    #[error("{what} cannot be put where {whom} stands")]
    InTheWay {
        /// A door or an object.
        what: String,
        /// "the robot" or "a person".
        whom: &'static str,
    },
    /// There is no object of this name.
    #[error("there is no object `{0}`")]
    NoObject(String),
    /// An object of this name is already there.
    #[error("there is an object `{0}` already")]
    SameName(String),
    /// There is no room or door of this name.
    #[error(transparent)]
    Unknown(#[from] UnknownName),
}

impl SimulatorState {
    /// Where the robot really is.
    pub fn true_pose(&self) -> Pose {
        self.robot_in_map
    }

    /// Turns the robot by hand: its odometry does not notice.
    pub fn rotate(&mut self, angle_rad: f64) {
        let Pose { x_m, y_m, heading_rad } = self.robot_in_map;
        self.robot_in_map = Pose::new(x_m, y_m, heading_rad + angle_rad);
    }

    /// Makes the sonars fail for a time from now.
    pub fn drop_sonars(&mut self, seconds: f64) {
        let until_us = self.time_us.saturating_add((seconds.max(0.0) * 1e6) as u64);
        self.sonars_fail_until_us = self.sonars_fail_until_us.max(until_us);
    }

    /// Holds the wheels for a time from now, as the brakes do when the emergency stop is pressed.
    pub fn hold_wheels(&mut self, seconds: f64) {
        let until_us = self.time_us.saturating_add((seconds.max(0.0) * 1e6) as u64);
        self.wheels_held_until_us = self.wheels_held_until_us.max(until_us);
    }

    /// Fills the battery up to a share of its capacity, or empties it down to that.
    pub fn set_battery(&mut self, charge: f64) {
        self.battery = charge.clamp(0.0, 1.0);
    }

    /// Sends the robot a message, word by word.
    pub fn send_message(&mut self, words: Vec<String>) {
        self.messages.push(words);
    }

    /// Touches so far.
    pub fn contacts(&self) -> Contacts {
        self.contacts
    }

    /// Way the robot has driven.
    pub fn distance_driven_m(&self) -> f64 {
        self.distance_driven_m
    }

    /// Puts a thing somewhere, also one that is elsewhere or held so far.
    pub fn place_item(&mut self, name: &str, point_in_map: Point) {
        let name = fold_name(name);
        self.gripper.items.retain(|item| item.name != name);
        self.gripper.items.push(ItemState { name: name.into_owned(), at: ItemPlace::Point(point_in_map), put_down: 0 });
    }
}

impl SimulatorModel {
    /// Puts the robot somewhere else, standing still: its odometry does not notice.
    ///
    /// # Errors
    /// The robot would stand in something; the state is unchanged.
    pub fn teleport(&self, state: &mut SimulatorState, robot_in_map: Pose) -> Result<(), OracleError> {
        if let Some(what) = self.in_the_way(state, robot_in_map.point(), self.robot().radius_m) {
            return Err(OracleError::Occupied { x_m: robot_in_map.x_m, y_m: robot_in_map.y_m, what });
        }
        state.robot_in_map = Pose::new(robot_in_map.x_m, robot_in_map.y_m, robot_in_map.heading_rad);
        state.translation_mps = 0.0;
        state.rotation_radps = 0.0;
        state.touching = false;
        Ok(())
    }

    /// What a disc at a point would touch, if anything.
    pub fn in_the_way(&self, state: &SimulatorState, point_in_map: Point, radius_m: f64) -> Option<String> {
        let Rect { min, max } = self.world.bounds();
        let reach = Vector::new(radius_m, radius_m);
        let inside = Rect { min: min + reach, max: max - reach }.contains(point_in_map);
        if !inside {
            return Some("the edge of the world".to_owned());
        }
        let touches = |outline: &Outline| outline.distance_m(point_in_map) < radius_m;
        let solid = self.solids.iter().find(|solid| state.is_there(solid.origin) && touches(&solid.outline));
        let fixed = solid.map(|solid| match solid.origin {
            SolidOrigin::Wall => "a wall".to_owned(),
            SolidOrigin::Door(index) => format!("the door of `{}`", self.world.doors[index].room),
            SolidOrigin::Object(index) => format!("`{}`", self.world.objects[index].name),
        });
        let added = || {
            let object = state.objects_added.iter().find(|object| touches(&object.outline()));
            object.map(|object| format!("`{}`", object.name))
        };
        let person = || {
            let near = |at: Point| distance_m(at, point_in_map) < radius_m + PERSON_RADIUS_M;
            state.people.iter().any(|person| near(person.at_in_map)).then(|| "a person".to_owned())
        };
        fixed.or_else(added).or_else(person)
    }

    /// The share of the readings of all range sensors that a person stands in, from 0 to 1; 0 without such sensors.
    pub fn blocked_share(&self, state: &SimulatorState) -> f64 {
        let ranges_m = |state: &SimulatorState| -> Vec<f64> {
            let sonars = self.sensors.sonars.as_ref();
            let echoes = sonars.map_or_else(Vec::new, |sonars| self.sonar_echoes(sonars, state, state.robot_in_map));
            let sonars_m = echoes.into_iter().map(|echo| echo.range_m);
            sonars_m.chain(self.laser_ranges(state, state.robot_in_map)).collect()
        };
        let among_people_m = ranges_m(state);
        let alone_m = ranges_m(&SimulatorState { people: Vec::new(), ..state.clone() });
        let blocked = among_people_m.iter().zip(&alone_m).filter(|(among_m, alone_m)| among_m < alone_m).count();
        blocked as f64 / among_people_m.len().max(1) as f64
    }

    /// Opens all doors of a room.
    ///
    /// # Errors
    /// The room has no door.
    pub fn open_door(&self, state: &mut SimulatorState, room: &str) -> Result<(), OracleError> {
        self.world.door_of(room)?;
        for (open, door) in state.doors_open.iter_mut().zip(&self.world.doors) {
            *open |= is_same_name(&door.room, room);
        }
        Ok(())
    }

    /// Closes all doors of a room.
    ///
    /// # Errors
    /// The room has no door, or somebody stands in one; the state is unchanged.
    pub fn close_door(&self, state: &mut SimulatorState, room: &str) -> Result<(), OracleError> {
        self.world.door_of(room)?;
        let doors = || self.world.doors.iter().enumerate().filter(|(_, door)| is_same_name(&door.room, room));
        for (_, door) in doors() {
            let outline = Outline::of_rect(door.leaf());
            self.nobody_in(state, &outline, || format!("the door of `{room}`"))?;
        }
        for (index, door) in doors() {
            state.doors_open[index] = false;
            self.notice_sudden(state, &Outline::of_rect(door.leaf()));
        }
        Ok(())
    }

    /// Remembers if a body that is there now is so near before the moving robot that it cannot stop
    /// in time.
    fn notice_sudden(&self, state: &mut SimulatorState, outline: &Outline) {
        const SUDDEN_US: u64 = 1_000_000;
        let gap_m = outline.distance_m(state.robot_in_map.point()) - self.robot().radius_m;
        if gap_m <= self.stopping_m(state) {
            state.sudden_until_us = state.time_us + SUDDEN_US;
        }
    }

    /// Puts an object into the world.
    ///
    /// # Errors
    /// Somebody stands there, or an object of this name is there; the state is unchanged.
    pub fn add_object(&self, state: &mut SimulatorState, object: Object) -> Result<(), OracleError> {
        let in_file = self.world.objects.iter().zip(&state.objects_removed);
        let mut names = in_file.filter(|(_, removed)| !**removed).map(|(object, _)| object).chain(&state.objects_added);
        if names.any(|there| is_same_name(&there.name, &object.name)) {
            return Err(OracleError::SameName(object.name));
        }
        self.nobody_in(state, &object.outline(), || format!("`{}`", object.name))?;
        self.notice_sudden(state, &object.outline());
        state.objects_added.push(object);
        Ok(())
    }

    /// Takes all objects of a name away, those of the world file and added ones.
    ///
    /// # Errors
    /// There is none; the state is unchanged.
    pub fn remove_object(&self, state: &mut SimulatorState, name: &str) -> Result<(), OracleError> {
        let added_before = state.objects_added.len();
        state.objects_added.retain(|object| !is_same_name(&object.name, name));
        let mut found = state.objects_added.len() < added_before;
        for (removed, object) in state.objects_removed.iter_mut().zip(&self.world.objects) {
            if is_same_name(&object.name, name) && !*removed {
                *removed = true;
                found = true;
            }
        }
        found.then_some(()).ok_or_else(|| OracleError::NoObject(name.to_owned()))
    }

    fn nobody_in(
        &self,
        state: &SimulatorState,
        outline: &Outline,
        what: impl Fn() -> String,
    ) -> Result<(), OracleError> {
        if outline.distance_m(state.robot_in_map.point()) < self.robot().radius_m {
            return Err(OracleError::InTheWay { what: what(), whom: "the robot" });
        }
        if state.people.iter().any(|person| outline.distance_m(person.at_in_map) < PERSON_RADIUS_M) {
            return Err(OracleError::InTheWay { what: what(), whom: "a person" });
        }
        Ok(())
    }
}
