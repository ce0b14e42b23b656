//! Feature detection: what a robot that drives along a hallway passes on both sides, by its sonars and, if there
//! is a camera, by markers (Gutierrez-Osuna and Luo, "Feature Detection").
//!
//! Read in this order: `parameters`; `contour` (what the sonars of a side heard along the way); `openings` and
//! `indentations` (the two monitor flags); `hidden` (what stands before the wall); `hallway_end`; `merging` (sonar and vision, Table 1); `score` (how
//! right the percepts of a drive were).

mod contour;
mod hallway_end;
mod hidden;
mod indentations;
mod merging;
mod openings;
mod parameters;
pub mod score;

#[cfg(test)]
mod tests;

use crate::beside::{axes_in_odom, side_readings};
use crate::feature::{Feature, HiddenWall, Percept, Side};
use crate::registration::HallwayAxis;
#[cfg(test)]
use crate::registration::Registration;
pub use contour::ContourPoint;
use contour::WallReference;
use hallway_end::EndMonitor;
pub(crate) use hallway_end::wall_ahead_m;
pub(crate) use hidden::HIDES_BESIDE_M;
use hidden::HiddenMonitor;
use indentations::IndentationMonitor;
pub(crate) use openings::opening_of_width;
use openings::{Found, OpeningMonitor};
use parameters::PARAMETERS;
use rpl_robot::geometry::{Point, Pose};
use rpl_robot::sensors::SonarScan;
use serde::{Deserialize, Serialize};

/// The state of feature detection in a hallway. A plain value.
///
/// Places are metres along the axis from where it was started. They are added up from the odometry, each bit of
/// the way in the direction of the axis as it was known then: a better axis moves nothing that was found
/// before.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FeatureDetection {
    last_in_odom: Pose,
    along_m: f64,
    /// To the left of the line on which it was started.
    left_m: f64,
    /// The farthest it has been: what is heard on the way back adds nothing.
    farthest_m: f64,
    sides: [SideMonitor; 2],
    end: EndMonitor,
    count: u64,
}

/// One side.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct SideMonitor {
    /// How far the wall is to the side of the line on which the detection was started.
    wall_aside_m: Option<f64>,
    reference: WallReference,
    kept: Vec<ContourPoint>,
    openings: OpeningMonitor,
    indentations: IndentationMonitor,
    hidden: HiddenMonitor,
    /// The parts of the wall that percepts tell of, as far as they matter.
    told_m: Vec<(f64, f64)>,
}

impl FeatureDetection {
    /// Begins where the robot is.
    pub fn start(axis: &HallwayAxis, odometry_in_odom: Pose) -> Self {
        let side = |side| SideMonitor {
            wall_aside_m: axis.wall_distance_m(odometry_in_odom, side),
            reference: WallReference::default(),
            kept: Vec::new(),
            openings: OpeningMonitor::default(),
            indentations: IndentationMonitor::default(),
            hidden: HiddenMonitor::default(),
            told_m: Vec::new(),
        };
        Self {
            last_in_odom: odometry_in_odom,
            along_m: 0.0,
            left_m: 0.0,
            farthest_m: f64::NEG_INFINITY,
            sides: Side::ALL.map(side),
            end: EndMonitor::default(),
            count: 0,
        }
    }

    /// Takes in what the sonars hear, and where the camera has seen markers; `None` without one. Answers the
    /// features that have been passed since, in the order of their ends. Cost: about 50 µs, a millisecond beside an indentation.
    pub fn take_in(
        &mut self,
        axis: &HallwayAxis,
        odometry_in_odom: Pose,
        scan: SonarScan<'_>,
        markers_in_odom: Option<&[Point]>,
    ) -> Vec<Percept> {
        let (along, left) = axes_in_odom(axis.heading_in_odom_rad);
        let way = odometry_in_odom.point() - self.last_in_odom.point();
        self.last_in_odom = odometry_in_odom;
        self.along_m += way.dot(&along);
        self.left_m += way.dot(&left);
        if self.along_m < self.farthest_m + PARAMETERS.scan_m {
            return Vec::new();
        }
        self.farthest_m = self.along_m;
        let heading_rad = odometry_in_odom.heading_rad - axis.heading_in_odom_rad;
        self.end.take_in(self.along_m, self.left_m, heading_rad, scan, self.walls_left_m());
        let mut found: Vec<(Side, Found)> = Vec::new();
        for side in Side::ALL {
            let (along_m, aside_m) = (self.along_m, side.sign() * self.left_m);
            let monitor = &mut self.sides[side as usize];
            let wall_m = axis.wall_distance_m(odometry_in_odom, side);
            monitor.wall_aside_m = wall_m.map(|wall_m| aside_m + wall_m).or(monitor.reference.aside_m);
            found.extend(monitor.take_in(along_m, aside_m, heading_rad, side, scan).into_iter().map(|one| (side, one)));
        }
        self.percepts(found, axis, markers_in_odom)
    }

    /// The robot stops here and will not pass what it is beside, as at the hallway's end: what is known of that.
    /// Where the hallway ends, if it does here, ends what is open up to there.
    pub fn finish(
        &mut self,
        axis: &HallwayAxis,
        end_m: Option<f64>,
        markers_in_odom: Option<&[Point]>,
    ) -> Vec<Percept> {
        let along_m = self.along_m;
        let mut found = Vec::new();
        for side in Side::ALL {
            let closed = self.sides[side as usize].close(along_m, end_m);
            found.extend(closed.into_iter().map(|one| (side, one)));
        }
        self.percepts(found, axis, markers_in_odom)
    }

    /// Where the walls are, to the left of the line on which the detection was started.
    fn walls_left_m(&self) -> [Option<f64>; 2] {
        Side::ALL.map(|side| self.sides[side as usize].wall_aside_m.map(|aside_m| side.sign() * aside_m))
    }

    /// Merges with vision and numbers what is left.
    fn percepts(
        &mut self,
        mut found: Vec<(Side, Found)>,
        axis: &HallwayAxis,
        markers_in_odom: Option<&[Point]>,
    ) -> Vec<Percept> {
        let in_odom = markers_in_odom.unwrap_or_default().iter();
        let markers: Vec<Point> = in_odom.map(|&marker| self.in_hallway(axis, marker)).collect();
        let markers_m =
            Side::ALL.map(|side| merging::markers_beside(&markers, side, self.sides[side as usize].wall_aside_m));
        for side in Side::ALL {
            let door = self.sides[side as usize].door_of_marker(self.along_m, &markers_m[side as usize]);
            found.extend(door.map(|door| (side, door)));
        }
        found.sort_by(|(_, a), (_, b)| a.to_m.total_cmp(&b.to_m));
        let numbered = (self.count..).zip(found).map(|(number, (side, found))| {
            let (seen, marked) = merging::merged(&found, &markers_m[side as usize]);
            let Found { from_m, to_m, depth_m, .. } = found;
            Percept { number, side, seen, from_m, to_m, depth_m, marked }
        });
        let percepts: Vec<Percept> = numbered.collect();
        self.count += percepts.len() as u64;
        percepts
    }

    /// A point of `odom`, along the axis and to the left of the line on which the detection was started.
    fn in_hallway(&self, axis: &HallwayAxis, point_in_odom: Point) -> Point {
        let (along, left) = axes_in_odom(axis.heading_in_odom_rad);
        let from_robot = point_in_odom - self.last_in_odom.point();
        Point::new(self.along_m + from_robot.dot(&along), self.left_m + from_robot.dot(&left))
    }

    /// Where the robot is along the axis.
    pub fn along_m(&self) -> f64 {
        self.along_m
    }

    /// How many percepts there have been.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Where the hallway ends, along the axis, once its end was heard.
    pub fn hallway_end_m(&self) -> Option<f64> {
        self.end.end_m()
    }

    /// What was heard ahead was no end of the hallway.
    pub fn forget_end(&mut self) {
        self.end = EndMonitor::default();
    }

    /// The parts of both sides before which something stands.
    pub fn hidden(&self) -> Vec<HiddenWall> {
        Side::ALL.into_iter().flat_map(|side| self.sides[side as usize].hidden.walls(side)).collect()
    }

    /// The contour line of a side over the last metres, and what the transducers beside the nearest heard.
    pub fn contour(&self, side: Side) -> &[ContourPoint] {
        &self.sides[side as usize].kept
    }
}

impl SideMonitor {
    /// Takes in a scan; answers what has been passed.
    fn take_in(&mut self, along_m: f64, aside_m: f64, heading_rad: f64, side: Side, scan: SonarScan<'_>) -> Vec<Found> {
        let readings: Vec<_> = side_readings(scan, heading_rad, side, PARAMETERS.widest_rad).collect();
        let Some(nearest) = readings.iter().min_by(|a, b| a.off_rad().total_cmp(&b.off_rad())).copied() else {
            return Vec::new();
        };
        let heard_aside_m = aside_m + nearest.apex_aside_m + nearest.perpendicular_m();
        if heard_aside_m.is_finite() {
            self.reference.take_in(along_m, heard_aside_m);
        }
        let Some(wall_aside_m) = self.wall_aside_m else { return Vec::new() };
        let mut found = self.looked_at_anew(wall_aside_m);
        self.kept.retain(|point| along_m - point.robot_along_m <= PARAMETERS.kept_m);
        let point = |reading| ContourPoint {
            robot_along_m: along_m,
            robot_aside_m: aside_m,
            reading,
            is_nearest: reading == nearest,
            wall_aside_m,
        };
        self.kept.extend(readings.into_iter().map(point));
        let nearest = point(nearest);
        self.hidden.take_in(&nearest);
        let opening = if nearest.is_of_opening() { self.openings.take_in(&nearest, &self.kept) } else { None };
        if let Some(opening) = opening {
            self.tell(opening, &mut found);
        }
        if let Some(indentation) = self.indentations.take_in(along_m, &self.kept, &self.taken_m()) {
            self.tell(indentation, &mut found);
        }
        found
    }

    /// The wall turns out to be elsewhere than was believed, as where a box stood at the start: what is kept is
    /// looked at with the wall where it is.
    fn looked_at_anew(&mut self, wall_aside_m: f64) -> Vec<Found> {
        let mut found = Vec::new();
        let is_elsewhere = |point: &ContourPoint| (point.wall_aside_m - wall_aside_m).abs() > PARAMETERS.obstacle_m;
        if self.kept.last().is_some_and(is_elsewhere) {
            self.kept.iter_mut().for_each(|point| point.wall_aside_m = wall_aside_m);
            self.openings = self.openings.begun_anew();
            for index in 0..self.kept.len() {
                let point = self.kept[index];
                if point.is_of_opening()
                    && let Some(opening) = self.openings.take_in(&point, &self.kept[..=index])
                {
                    self.tell(opening, &mut found);
                }
            }
        }
        found
    }

    /// Nothing comes any more: whatever is under way ends at the hallway's end, if one was heard.
    fn close(&mut self, along_m: f64, end_m: Option<f64>) -> Vec<Found> {
        let mut found = Vec::new();
        if let Some(opening) = self.openings.close(end_m, &self.kept) {
            self.tell(opening, &mut found);
        }
        if let Some(indentation) = self.indentations.close(along_m, end_m, &self.kept, &self.taken_m()) {
            self.tell(indentation, &mut found);
        }
        found
    }

    /// The door of a marker that was passed without a find.
    fn door_of_marker(&mut self, along_m: f64, markers_m: &[f64]) -> Option<Found> {
        let door = merging::door_of_marker(markers_m, along_m, &self.kept, &self.taken_m())?;
        let mut found = Vec::new();
        self.tell(door, &mut found);
        found.pop()
    }

    /// What overlaps with what was told of is the rest of it.
    fn tell(&mut self, one: Found, found: &mut Vec<Found>) {
        let overlap_m = |told: &(f64, f64)| one.to_m.min(told.1) - one.from_m.max(told.0);
        if self.told_m.iter().any(|told| overlap_m(told) > PARAMETERS.grain_m.max((one.to_m - one.from_m) / 2.0)) {
            return;
        }
        self.told_m.push((one.from_m, one.to_m));
        if self.told_m.len() > MOST_TOLD {
            self.told_m.remove(0);
        }
        if one.seen == Feature::ClosedDoor {
            self.indentations.pass(one.to_m);
        }
        found.push(one);
    }

    /// The parts of the wall that are told of, or being passed.
    fn taken_m(&self) -> Vec<(f64, f64)> {
        self.told_m.iter().copied().chain(self.openings.passing_m()).collect()
    }
}

/// How many of the parts of a wall told of last can overlap with what is still kept.
const MOST_TOLD: usize = 8;
