//! Landmarks: what the camera looks for while `landmark-localization` is active, and what comes of it.

use crate::control::CaseDrive;
use crate::landmarks::{LandmarkEye, LandmarkFix, LocalizingTarget, Recognized, SeenSheet, Track, recognize};
use rpl_robot::geometry::{Point, Pose, distance_m, wrap_angle_rad};
use rpl_robot::localization::LandmarkSighting;
use rpl_robot::office::{Moment, OfficeModel, Position, PositionBy, Raise};
use rpl_robot::simulator::CameraCommand;
use rpl_robot::vision::WallMark;
use rpl_robot::world::Landmark;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A robot that goes by its odometry localizes by landmarks no farther than this ...
const NEAR_M: f64 = 3.0;

/// ... once it has driven this far since the last time, and farther to do so by the same landmark again.
const APART_M: f64 = 2.0;
const AGAIN_M: f64 = 8.0;

/// A sheet is the one that the robot localizes by within this of where it was.
const SAME_M: f64 = 1.0;

/// The number of images after which a landmark that is not expected is believed.
const SURE_IMAGES: u32 = 3;

/// A landmark at which the estimate jumps farther than this was not expected.
const JUMP_M: f64 = 1.0;

/// What is known of landmarks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Looking {
    track: Track,
    /// What landmarks of the world look like: looked up when it is first needed.
    #[serde(skip)]
    marks: Option<Arc<[WallMark]>>,
    /// The landmark that the sheet in view is taken for.
    in_view: Option<usize>,
    /// The way driven, and how long it was at the last try to localize, and by which landmark that was.
    driven_m: f64,
    tried: Option<(usize, f64)>,
    last_in_odom: Option<Pose>,
    /// In how many images in a row no landmark was expected where one was seen.
    unexpected_images: u32,
    /// The sheet whose like was not expected, and made the route be given up.
    unexpected_in_odom: Option<Point>,
    /// Whether the landmark that the robot localizes by was not expected.
    is_surprised: bool,
}

/// Whether, in this world and with these settings, a robot looks for landmarks.
///
/// # Errors
/// Why it does not.
pub(super) fn can_look(model: &OfficeModel) -> Result<(), Raise> {
    let fault = |message: String| Err(Raise::new("behaviour-failure", message));
    let robot = &model.settings.robot;
    if robot.camera.is_none() {
        return fault(format!("the robot `{}` has no camera; `rpl robots` lists robots that have one", robot.name));
    }
    if model.map.is_none() {
        return fault("the robot has no map that says where landmarks are; run the plan without `--map none`".into());
    }
    if model.settings.position_by == PositionBy::GridWithoutLandmarks {
        return fault("the robot is set to go by its range sensors alone".into());
    }
    if model.world.landmarks.is_empty() {
        let world = &model.world.name;
        return fault(format!("the world `{world}` has no landmarks: add [[landmark]] with a name and a pose to it"));
    }
    Ok(())
}

impl Looking {
    /// What the camera is to do.
    pub fn command(&self) -> CameraCommand {
        self.track.command()
    }

    /// The landmark in view.
    pub fn in_view<'m>(&self, model: &'m OfficeModel) -> Option<&'m Landmark> {
        self.in_view.and_then(|number| model.world.landmarks.get(number))
    }

    /// Nothing is looked at any more.
    pub fn end(&mut self) {
        self.in_view = None;
    }

    fn marks(&mut self, landmarks: &[Landmark]) -> Arc<[WallMark]> {
        let of_all = || {
            let mut marks: Vec<WallMark> = Vec::new();
            for landmark in landmarks {
                if !marks.iter().any(|mark| mark.is_of(landmark)) {
                    marks.push(WallMark::of(landmark));
                }
            }
            marks.into()
        };
        self.marks.get_or_insert_with(of_all).clone()
    }

    /// One step: turns the camera, tells the belief what was seen, and has the control localize where it is time to.
    /// Whether a landmark was seen that makes the route worth nothing.
    pub fn take_in(
        &mut self,
        now: &Moment<'_>,
        position: &mut Position,
        drive: &mut CaseDrive,
        is_driving: bool,
    ) -> bool {
        let camera = now.model.settings.robot.camera.as_ref();
        let (Some(camera), Some(map), Some(reading)) = (camera, &now.model.map, &now.percept.camera) else {
            return false;
        };
        let robot_in_odom = now.percept.odometry_in_odom;
        self.driven_m += self.last_in_odom.replace(robot_in_odom).map_or(0.0, |last| last.distance_m(robot_in_odom));
        let landmarks = &now.model.world.landmarks;
        let marks = self.marks(landmarks);
        let target_in_odom = drive.is_localizing().then(|| drive.localizing.target().map(|target| target.at_in_odom));
        let target_in_odom = target_in_odom.flatten();
        let eye = LandmarkEye { camera, marks: &marks, step_s: now.model.limits.step_s };
        let sheets = self.track.take_in(&eye, robot_in_odom, reading, target_in_odom);
        if reading.image.is_none() {
            return false;
        }
        if let Some(seen) = target_in_odom.and_then(|target| same(&sheets, robot_in_odom, target)) {
            drive.localizing.see(robot_in_odom, seen);
        }
        let before_in_map = position.estimate(Some(map)).pose_in_map;
        position.see_landmarks(map, &sightings(&sheets, &marks, landmarks));
        let recognized = sheets.iter().find_map(|sheet| {
            Some((sheet, recognize(landmarks, &marks[sheet.mark], sheet.at_in_base, before_in_map)?))
        });
        self.in_view = recognized.map(|(_, recognized)| recognized.number());
        let Some((sheet, recognized)) = recognized else { return false };
        if now.model.settings.position_by == PositionBy::Landmarks {
            if is_driving && self.is_due(recognized.number(), sheet) {
                self.begin(drive, landmarks, sheet, recognized, [before_in_map, robot_in_odom]);
            }
            return false;
        }
        let has_jumped = position.estimate(Some(map)).pose_in_map.distance_m(before_in_map) > JUMP_M;
        self.is_unexpected(recognized, robot_in_odom.transform(sheet.at_in_base), has_jumped)
    }

    /// Whether it is time to localize by a landmark.
    fn is_due(&self, landmark: usize, sheet: &SeenSheet) -> bool {
        let since_m = |at_m: f64| self.driven_m - at_m;
        let is_apart = |(tried, at_m): (usize, f64)| since_m(at_m) > if tried == landmark { AGAIN_M } else { APART_M };
        sheet.at_in_base.coords.norm() < NEAR_M && self.tried.is_none_or(is_apart)
    }

    fn begin(
        &mut self,
        drive: &mut CaseDrive,
        landmarks: &[Landmark],
        sheet: &SeenSheet,
        recognized: Recognized,
        [estimated_in_map, robot_in_odom]: [Pose; 2],
    ) {
        let facing_in_map_rad = landmarks[recognized.number()].pose_in_map.heading_rad;
        let turned_rad = robot_in_odom.heading_rad - estimated_in_map.heading_rad;
        let target = LocalizingTarget {
            landmark: recognized.number(),
            at_in_odom: robot_in_odom.transform(sheet.at_in_base),
            facing_in_odom_rad: wrap_angle_rad(facing_in_map_rad + turned_rad),
        };
        if drive.begin_localizing(target) {
            self.tried = Some((recognized.number(), self.driven_m));
            self.is_surprised = matches!(recognized, Recognized::Unexpected(_));
        }
    }

    /// The robot has measured where it is. Whether the landmark was not expected.
    pub fn localized(&mut self, model: &OfficeModel, position: &mut Position, fix: &LandmarkFix) -> bool {
        if let (Some(map), Some(landmark)) = (&model.map, model.world.landmarks.get(fix.landmark)) {
            position.tell_by_landmark(map, fix.pose_in_map(landmark));
        }
        self.tried = Some((fix.landmark, self.driven_m));
        std::mem::take(&mut self.is_surprised)
    }

    /// Whether a route is worth nothing by what was seen: the estimate has jumped, or a landmark is where none is
    /// expected, image after image. The same sheet says so once.
    fn is_unexpected(&mut self, recognized: Recognized, seen_in_odom: Point, has_jumped: bool) -> bool {
        match recognized {
            Recognized::Expected(_) => self.unexpected_images = 0,
            Recognized::Unexpected(_) => self.unexpected_images += 1,
        }
        let is_known = self.unexpected_in_odom.is_some_and(|told| distance_m(told, seen_in_odom) < SAME_M);
        let is_sure = has_jumped || self.unexpected_images >= SURE_IMAGES;
        if is_known || !is_sure {
            return false;
        }
        self.unexpected_images = 0;
        self.unexpected_in_odom = Some(seen_in_odom);
        true
    }
}

/// Where the sheet nearest to a place was seen, if that is the same.
fn same(sheets: &[SeenSheet], robot_in_odom: Pose, at_in_odom: Point) -> Option<Point> {
    let off_m = |sheet: &&SeenSheet| distance_m(robot_in_odom.transform(sheet.at_in_base), at_in_odom);
    let near = sheets.iter().filter(|sheet| off_m(sheet) < SAME_M);
    near.min_by(|a, b| off_m(a).total_cmp(&off_m(b))).map(|sheet| sheet.at_in_base)
}

/// What the belief is told: each sheet may be any of the landmarks that look like it.
fn sightings(sheets: &[SeenSheet], marks: &[WallMark], landmarks: &[Landmark]) -> Vec<LandmarkSighting> {
    let sighting = |sheet: &SeenSheet| {
        let alike = landmarks.iter().filter(|landmark| marks[sheet.mark].is_of(landmark));
        LandmarkSighting {
            at_in_base: sheet.at_in_base,
            candidates_in_map: alike.map(|landmark| landmark.pose_in_map).collect(),
        }
    };
    sheets.iter().map(sighting).collect()
}
