//! Markers: what the camera looks for while marker-detection is active.

use crate::markers::{Gaze, MarkerDetection, MarkerEye};
use rpl_robot::geometry::Point;
use rpl_robot::office::{Moment, Start};
use rpl_robot::simulator::CameraCommand;
use rpl_robot::vision::FloorMark;
use rpl_robot::world::MarkerColour;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use serde::{Deserialize, Serialize};

/// How large the markers beside doors are, unless it is said.
const SIZE_M: f64 = 0.3;

/// The markers that are looked for, and those that were found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Seeing {
    colour: MarkerColour,
    size_m: f64,
    /// All around, or on both sides of the hallway.
    around: bool,
    detection: MarkerDetection,
    /// Whether there are such markers here: one was seen for sure.
    has_found: bool,
    /// What one looks like: follows from colour and size, and is no part of a saved state.
    #[serde(skip)]
    mark: Option<FloorMark>,
}

impl Seeing {
    /// Begins to look, or goes on with what was found.
    ///
    /// # Errors
    /// The robot has no camera, or an argument is wrong.
    pub fn start(start: &Start<'_>, before: Option<Self>) -> Result<Self, Raise> {
        let robot = &start.model.settings.robot;
        if robot.camera.is_none() {
            let message = format!("the robot `{}` has no camera; `rpl robots` lists robots that have one", robot.name);
            return Err(Raise::new("behaviour-failure", message));
        }
        let around = start.argument("around").is_some_and(Value::is_true);
        let size_m = start.argument("size").and_then(Value::as_f64).unwrap_or(SIZE_M);
        let colour = match start.argument("colour") {
            Some(Value::Symbol(symbol)) => colour_named(start.machine.symbols.name(symbol))?,
            None | Some(Value::Nil) => MarkerColour::ALL[0],
            Some(_) => {
                return Err(Raise::type_error("`:colour` takes the name of a colour, such as `:colour 'orange`"));
            }
        };
        let kept = before.filter(|before| before.colour == colour && before.size_m == size_m);
        let has_found = kept.as_ref().is_some_and(Self::has_found);
        let detection = kept.map_or_else(MarkerDetection::default, |before| before.detection);
        Ok(Self { colour, size_m, around, detection, has_found, mark: Some(FloorMark::marker(colour, size_m)) })
    }

    /// Takes back what is no part of a saved state.
    pub fn resume(&mut self) {
        self.mark = Some(FloorMark::marker(self.colour, self.size_m));
    }

    /// What the camera is to do.
    pub fn command(&self) -> CameraCommand {
        self.detection.command()
    }

    /// Takes in what the camera told.
    pub fn take_in(&mut self, now: &Moment<'_>, axis_in_odom_rad: Option<f64>) {
        let camera = now.model.settings.robot.camera.as_ref();
        let (Some(camera), Some(mark), Some(reading)) = (camera, &self.mark, &now.percept.camera) else { return };
        let eye = MarkerEye { camera, mark, step_s: now.model.limits.step_s };
        let gaze = if self.around { Gaze::Around } else { Gaze::Both };
        self.detection.take_in(&eye, gaze, axis_in_odom_rad, now.percept.odometry_in_odom, reading);
        self.has_found |= self.detection.markers().next().is_some();
    }

    /// Whether there are such markers here, though those that were seen may be far behind by now.
    pub fn has_found(&self) -> bool {
        self.has_found
    }

    /// The robot was turned by hand: in the frame of the odometry the markers are elsewhere now.
    pub fn forget_places(&mut self) {
        self.detection = MarkerDetection::default();
    }

    /// Where the markers are that are sure.
    pub fn markers_in_odom(&self) -> Vec<Point> {
        self.detection.markers().map(|marker| marker.at_in_odom).collect()
    }
}

fn colour_named(name: &str) -> Result<MarkerColour, Raise> {
    let known = MarkerColour::ALL.into_iter().find(|colour| colour.name() == name);
    known.ok_or_else(|| {
        let names = MarkerColour::ALL.map(MarkerColour::name).join(", ");
        Raise::type_error(format!("markers are not `{name}`; their colours are {names}"))
    })
}
