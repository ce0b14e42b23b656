//! What the sensors have seen since the start, as a map in `odom`: for each cell the log-odds that
//! something stands there.
//!
//! A sonar's echo comes from somewhere on an arc. The model is that of Konolige 1997, "Improved
//! Occupancy Grids for Map Building": it counts for a cell only as far as no other cell of the arc
//! explains it.
//!
//! # Deviation
//! Konolige keeps the poses a cell was seen from to recognize walls that throw the sound away. Here
//! silence counts little, and what is heard or not from nearly the same place counts once.

use super::log_odds::{Confidence, GridCell, LogOdds};
use crate::geometry::{Point, Pose, Transform, wrap_angle_rad};
use crate::occupancy::OccupancyGrid;
use crate::sensors::{LaserScan, RangeSensor, SonarScan};
use serde::{Deserialize, Serialize};

/// A scan counts after this motion or time: a robot that stands hears the same again, right or
/// wrong.
const VIEW_M: f64 = 0.1;
const VIEW_RAD: f64 = 0.087;
const VIEW_S: f64 = 1.0;

/// Sonars say something about cells up to here: beyond, arcs are as wide as doors.
const SONAR_REACH_M: f64 = 3.0;
/// So far silence means free; farther it is more often a wall that threw the sound away.
const SILENCE_REACH_M: f64 = 1.5;

/// An echo without anything on the arc.
const FALSE_ECHO: f64 = 0.05;
/// What a sonar that hears something beyond says of a cell, in nats: it misses a third of what is
/// there.
const HEARD_BEYOND_NATS: f64 = -0.6;
/// What silence says of it.
const SILENT_NATS: f64 = -0.25;

/// What a laser beam says of a cell it goes through, and of the one it ends in.
const SEEN_THROUGH_NATS: f64 = -0.7;
const SEEN_NATS: f64 = 1.5;
/// Laser beams are followed so far.
const LASER_REACH_M: f64 = 6.0;

/// Half the depth of an arc, in cells: every ray of the cone meets one of its cells.
const ARC_CELLS: f64 = 0.7;

/// Where the robot is nothing else is: the cells within its radius, but no farther, and what that says.
const BODY_M: f64 = 0.2;
const BODY_NATS: f64 = -4.0;
/// What a touch says.
const FELT_NATS: f64 = 4.0;

/// What the beams of a scan do in a cell; of several the most telling counts.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum BeamMark {
    Misses,
    Passes,
    Ends,
}

/// What has been seen, as sharply as the sharpest sensor sees it. Forks share it as long as they agree.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LearnedMap {
    log_odds: LogOdds,
    now_s: f64,
    /// From where and when the last scan that counted was taken.
    view: Option<(Pose, f64)>,
}

impl LearnedMap {
    /// A map of which nothing has been seen.
    pub fn new(sharpest: RangeSensor) -> Self {
        Self { log_odds: LogOdds::new(sharpest), ..Self::default() }
    }

    /// The sensor it is as fine as.
    pub fn sharpest(&self) -> RangeSensor {
        self.log_odds.sensor
    }

    /// Edge of a cell.
    pub fn cell_m(&self) -> f64 {
        self.log_odds.cell_m()
    }

    /// The radius for a planner, which takes cells to be filled, of a robot that may come as near to
    /// surfaces as `robot_radius_m`.
    pub fn planning_radius_m(&self, robot_radius_m: f64) -> f64 {
        robot_radius_m + self.surface_m() - self.cell_m() / 2.0
    }

    /// How far from the middle of an obstacle cell its surface may be: all of the cell may be filled
    /// where an echo came from an arc, but a beam ends at a surface.
    fn surface_m(&self) -> f64 {
        match self.sharpest() {
            RangeSensor::Sonar => self.cell_m() / 2.0,
            RangeSensor::Laser => 0.0,
        }
    }

    /// Takes a scan in, if a robot of this radius looks from a new place or some time has passed.
    pub fn observe(
        &mut self,
        odometry_in_odom: Pose,
        sonar: Option<SonarScan<'_>>,
        laser: Option<LaserScan<'_>>,
        robot_radius_m: f64,
        step_s: f64,
    ) {
        self.now_s += step_s;
        if !self.is_new_view(odometry_in_odom) {
            return;
        }
        self.view = Some((odometry_in_odom, self.now_s));
        for at in self.log_odds.disc(odometry_in_odom.point(), BODY_M.min(robot_radius_m)) {
            self.log_odds.add(at, BODY_NATS);
        }
        if let Some(scan) = sonar {
            self.hear(odometry_in_odom, scan);
        }
        if let Some(scan) = laser {
            self.scan(odometry_in_odom, scan);
        }
    }

    /// Takes in that the robot touches something: it drives forward only, so that is at the front.
    pub fn feel(&mut self, odometry_in_odom: Pose, robot_radius_m: f64) {
        let touched = odometry_in_odom.transform(Point::new(robot_radius_m + self.cell_m() / 2.0, 0.0));
        self.log_odds.add(self.log_odds.around(touched), FELT_NATS);
    }

    /// Forgets what was seen near a point.
    pub fn forget_around(&mut self, point_in_odom: Point, reach_m: f64) {
        for at in self.log_odds.disc(point_in_odom, reach_m) {
            let nats = self.log_odds.nats(at);
            self.log_odds.add(at, -nats);
        }
    }

    /// Halves what is known near a point: it holds the robot up, and may be wrong.
    pub fn doubt_around(&mut self, point_in_odom: Point, reach_m: f64) {
        for at in self.log_odds.disc(point_in_odom, reach_m) {
            let nats = self.log_odds.nats(at);
            if nats > 0.0 {
                self.log_odds.add(at, -nats / 2.0);
            }
        }
    }

    /// How many cells have been seen so far.
    pub fn seen_cells(&self) -> u64 {
        self.log_odds.seen_cells()
    }

    /// Whether an obstacle is believed to be so near to a point.
    pub fn is_obstructed(&self, point_in_odom: Point, reach_m: f64, confidence: Confidence) -> bool {
        self.log_odds.disc(point_in_odom, reach_m).any(|at| self.log_odds.is_obstacle(at, confidence))
    }

    /// The map around these points and all that has been seen, with `margin_m` to spare, but nothing
    /// farther than `most_m` from the first. What has not been seen is free. Lies in `odom`.
    pub fn grid(&self, points_in_odom: &[Point], margin_m: f64, most_m: f64, confidence: Confidence) -> OccupancyGrid {
        self.log_odds.grid(points_in_odom, margin_m, most_m, confidence)
    }

    /// Bytes of evidence that an earlier map does not share.
    pub fn bytes_apart(&self, earlier: &Self) -> usize {
        self.log_odds.bytes_apart(&earlier.log_odds)
    }

    fn is_new_view(&self, odometry_in_odom: Pose) -> bool {
        let Some((from_in_odom, at_s)) = self.view else { return true };
        let turned_rad = wrap_angle_rad(odometry_in_odom.heading_rad - from_in_odom.heading_rad).abs();
        odometry_in_odom.distance_m(from_in_odom) >= VIEW_M || turned_rad >= VIEW_RAD || self.now_s - at_s >= VIEW_S
    }

    /// Every sonar has a say of the cells in its cone.
    fn hear(&mut self, odometry_in_odom: Pose, scan: SonarScan<'_>) {
        let SonarScan { sonars, ranges_m } = scan;
        let cell_m = self.cell_m();
        let arc_m = ARC_CELLS * cell_m;
        let odom_in_base = Transform::new(odometry_in_odom.inverse());
        let mut arcs: Vec<Vec<GridCell>> = vec![Vec::new(); ranges_m.len()];
        for at in self.log_odds.disc(odometry_in_odom.point(), SONAR_REACH_M) {
            for (sonar, off) in sonars.hearing(odom_in_base.apply(at.centre(cell_m))) {
                let (reading_m, away_m) = (f64::from(ranges_m[sonar]), libm::hypot(off.x, off.y));
                let beyond_m = reading_m - away_m;
                if reading_m >= sonars.range_m {
                    if away_m < SILENCE_REACH_M {
                        self.log_odds.add(at, SILENT_NATS);
                    }
                } else if beyond_m > arc_m {
                    self.log_odds.add(at, HEARD_BEYOND_NATS);
                } else if beyond_m >= -arc_m {
                    arcs[sonar].push(at);
                }
            }
        }
        arcs.iter().for_each(|arc| self.explain(arc));
    }

    /// An echo from an arc: each cell is as likely its origin as the others are not.
    fn explain(&mut self, arc: &[GridCell]) {
        let nats: Vec<f64> = arc.iter().map(|&at| self.log_odds.nats(at)).collect();
        let free: Vec<f64> = nats.iter().map(|&nats| 1.0 / (1.0 + libm::exp(nats))).collect();
        let all_free: f64 = free.iter().product();
        for (&at, &is_free) in arc.iter().zip(&free) {
            let others = 1.0 - all_free / is_free;
            self.log_odds.add(at, -libm::log(FALSE_ECHO + (1.0 - FALSE_ECHO) * others));
        }
    }

    /// Every cell is changed once by a scan, for an end if a beam ends there.
    fn scan(&mut self, odometry_in_odom: Pose, scan: LaserScan<'_>) {
        let reach_m = scan.laser.range_m.min(LASER_REACH_M);
        let (here, cell_m) = (odometry_in_odom.point(), self.cell_m());
        let middle = self.log_odds.around(here);
        let reach = libm::ceil(reach_m / cell_m) as i64 + 1;
        let side = 2 * reach + 1;
        let mut beams = vec![BeamMark::Misses; (side * side) as usize];
        let index = |at: GridCell| ((at.row - middle.row + reach) * side + at.column - middle.column + reach) as usize;
        for (beam, &reading_m) in scan.ranges_m.iter().enumerate() {
            let bearing_rad = odometry_in_odom.heading_rad + scan.laser.direction_rad(beam);
            let (sin, cos) = libm::sincos(bearing_rad);
            let reading_m = f64::from(reading_m);
            if reading_m.is_nan() || reading_m < 0.0 {
                continue;
            }
            let along = |way_m: f64| GridCell::around(Point::new(here.x + cos * way_m, here.y + sin * way_m), cell_m);
            let is_end = reading_m < reach_m;
            let free = libm::floor((reading_m.min(reach_m) - cell_m) / cell_m).max(0.0) as i64;
            for step in 0..=free {
                let at = along(step as f64 * cell_m);
                let beam = &mut beams[index(at)];
                *beam = (*beam).max(BeamMark::Passes);
            }
            if is_end {
                let at = along(reading_m);
                beams[index(at)] = BeamMark::Ends;
            }
        }
        for (row, line) in (-reach..).zip(beams.chunks_exact(side as usize)) {
            for (column, beam) in (-reach..).zip(line) {
                let change = match beam {
                    BeamMark::Misses => continue,
                    BeamMark::Passes => SEEN_THROUGH_NATS,
                    BeamMark::Ends => SEEN_NATS,
                };
                let (column, row) = (middle.column.saturating_add(column), middle.row.saturating_add(row));
                self.log_odds.add(GridCell { column, row }, change);
            }
        }
    }
}
