//! The camera: an image by casting a ray for each pixel.
//!
//! What stands reaches above the image, whatever it is: a camera looks over nothing. Farther off than
//! [`SIGHT_M`] nothing is drawn.

use crate::geometry::{Point, Pose, Transform, Vector};
use crate::sensors::{CameraImage, CameraReading, Rgb};
use crate::simulator::appearance::{Appearance, Colour, Light};
use crate::simulator::commands::Commands;
use crate::simulator::echo::cross;
use crate::simulator::eye::{Eye, Line, SIGHT_M};
use crate::simulator::model::SimulatorModel;
use crate::simulator::state::SimulatorState;
use crate::simulator::surface::Body;
use crate::world::{Landmark, Marker};
use rpl_random::Stream;

/// What a ray of the fan meets first.
#[derive(Clone, Copy)]
struct Hit {
    range_m: f64,
    body: Option<Body>,
}

impl SimulatorModel {
    /// Where the camera is turned to, and an image if it is time for one.
    pub(super) fn see(
        &self,
        state: &SimulatorState,
        commands: &Commands,
        stream: &mut Stream,
    ) -> Option<CameraReading> {
        let eye = self.eye.as_ref()?;
        commands.camera?;
        let is_time = state.time_us % eye.camera.period_us < self.robot().step_us;
        let image = is_time.then(|| self.take_image(eye, state, stream));
        Some(CameraReading { pan_rad: state.pan.angle_rad, image })
    }

    /// An image from where the robot is. Cost: for 80 by 60 pixels about a third of a millisecond.
    fn take_image(&self, eye: &Eye, state: &SimulatorState, stream: &mut Stream) -> CameraImage {
        let camera_in_map = state.robot_in_map.compose(Pose::new(0.0, 0.0, state.pan.angle_rad));
        let mut hits = vec![Hit { range_m: SIGHT_M, body: None }; eye.fan.scanner.readings];
        self.for_each_visible(
            state,
            camera_in_map,
            |_| true,
            |form, body| {
                eye.fan.lay(form, &mut hits, |hit, range_m| {
                    if range_m < hit.range_m {
                        *hit = Hit { range_m, body: Some(body) };
                    }
                });
            },
        );
        let appearance = Appearance::new(state.place_seed);
        let scene = Scene {
            height_m: eye.camera.view.height_m,
            to_map: Transform::new(camera_in_map),
            light: appearance.light(camera_in_map.point(), SIGHT_M),
            appearance,
            markers: self.markers_around(camera_in_map.point()),
            sheets: self.landmarks_facing(camera_in_map),
            hits,
        };
        let noise = eye.camera.noise;
        let rgb = eye.lines.iter().flat_map(|line| exposed(scene.colour(line), noise, stream)).collect();
        CameraImage { columns: eye.camera.view.columns, rgb }
    }

    fn markers_around(&self, at_in_map: Point) -> Vec<&Marker> {
        let near = |marker: &&Marker| {
            (marker.at - at_in_map).norm_squared() < (SIGHT_M + marker.size_m) * (SIGHT_M + marker.size_m)
        };
        self.world.markers.iter().filter(near).collect()
    }

    /// The landmarks near enough whose fronts look to the camera.
    fn landmarks_facing(&self, camera_in_map: Pose) -> Vec<Sheet<'_>> {
        let map_in_camera = camera_in_map.inverse();
        let near = |landmark: &&Landmark| {
            let at = landmark.pose_in_map.point() - camera_in_map.point();
            at.norm_squared() < (SIGHT_M + landmark.width_m) * (SIGHT_M + landmark.width_m)
        };
        let sheets = self.world.landmarks.iter().filter(near).map(|landmark| Sheet::new(landmark, map_in_camera));
        sheets.filter(|sheet| sheet.before_m > 0.0).collect()
    }
}

/// A landmark as the camera has it, in `pan`.
struct Sheet<'m> {
    landmark: &'m Landmark,
    middle: Vector,
    /// Of unit length.
    facing: Vector,
    /// How far the camera is before its plane.
    before_m: f64,
}

/// What is met so little before a sheet is the wall that it hangs on.
const ON_WALL_M: f64 = 0.05;

impl<'m> Sheet<'m> {
    fn new(landmark: &'m Landmark, map_in_camera: Pose) -> Self {
        let in_pan = map_in_camera.compose(landmark.pose_in_map);
        let (sin, cos) = libm::sincos(in_pan.heading_rad);
        let (middle, facing) = (in_pan.point().coords, Vector::new(cos, sin));
        Self { landmark, middle, facing, before_m: -facing.dot(&middle) }
    }

    /// How far off the sheet is along a line of sight that ends at `ends_m`, if the sheet is in it.
    fn range_m(&self, line: &Line, camera_m: f64, ends_m: f64) -> Option<f64> {
        let towards = -self.facing.dot(&line.direction);
        if towards <= 0.0 {
            return None;
        }
        let range_m = self.before_m / towards;
        let aside_m = cross(self.facing, line.direction * range_m - self.middle);
        let over_bottom_m = camera_m - line.drop_per_m * range_m - self.landmark.bottom_m;
        let is_on = range_m <= ends_m + ON_WALL_M
            && aside_m.abs() <= self.landmark.width_m / 2.0
            && (0.0..=self.landmark.height_m).contains(&over_bottom_m);
        is_on.then_some(range_m)
    }
}

/// What is around a camera.
struct Scene<'m> {
    height_m: f64,
    to_map: Transform,
    appearance: Appearance,
    light: Light,
    markers: Vec<&'m Marker>,
    sheets: Vec<Sheet<'m>>,
    /// What each ray of the fan meets.
    hits: Vec<Hit>,
}

impl Scene<'_> {
    /// What is at the end of a line of sight, in the light there.
    fn colour(&self, line: &Line) -> Colour {
        let hit = self.hits[line.ray];
        let floor_m = if line.drop_per_m > 0.0 { self.height_m / line.drop_per_m } else { f64::INFINITY };
        let sheet = self.sheets.iter().find_map(|sheet| {
            let range_m = sheet.range_m(line, self.height_m, hit.range_m.min(floor_m))?;
            Some((range_m, Appearance::of_marker(sheet.landmark.colour)))
        });
        let (range_m, colour) = match (sheet, hit.body) {
            (Some(found), _) => found,
            _ if floor_m < hit.range_m => (floor_m, self.floor(self.at(line, floor_m))),
            (None, Some(body)) => {
                let height_m = self.height_m - line.drop_per_m * hit.range_m;
                (hit.range_m, self.appearance.of_body(body, height_m))
            }
            (None, None) => (SIGHT_M, Appearance::of_haze()),
        };
        let light = self.light.at(self.at(line, range_m));
        std::array::from_fn(|part| colour[part] * light[part])
    }

    fn at(&self, line: &Line, range_m: f64) -> Point {
        self.to_map.apply(Point::from(line.direction * range_m))
    }

    fn floor(&self, at_in_map: Point) -> Colour {
        let is_on = |marker: &&&Marker| (at_in_map - marker.at).amax() <= marker.size_m / 2.0;
        match self.markers.iter().find(is_on) {
            Some(marker) => Appearance::of_marker(marker.colour),
            None => self.appearance.of_floor(at_in_map),
        }
    }
}

/// The standard deviation of the sum of two bytes left to chance.
const TWO_BYTES: f64 = 104.51;

/// What a pixel makes of a colour: noise, and nothing brighter than white. The noise is the sum of two even
/// spreads, of one draw for all three values: a sum of more would cost more than the image.
fn exposed(colour: Colour, noise: f64, stream: &mut Stream) -> Rgb {
    let chance = if noise > 0.0 { (stream.uniform() * (1u64 << 48) as f64) as u64 } else { 0 };
    std::array::from_fn(|part| {
        let bytes = [chance >> (16 * part), chance >> (16 * part + 8)].map(|byte| (byte & 255) as f64);
        let strayed = if noise > 0.0 { noise * (bytes[0] + bytes[1] - 255.0) / TWO_BYTES } else { 0.0 };
        libm::round(255.0 * (colour[part] + strayed)).clamp(0.0, 255.0) as u8
    })
}
