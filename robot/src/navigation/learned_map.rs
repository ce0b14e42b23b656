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

use super::obstacle_memory::{direction_rad, laser_bearing_rad};
use crate::geometry::{Point, Pose, distance_m, wrap_angle_rad};
use crate::localization::SONARS;
use crate::occupancy::{Cell, OccupancyGrid};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// How fine a map is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Grain {
    /// 10 cm: sonars are not sharper.
    #[default]
    Sonar,
    /// 3.5 cm: a gap hardly wider than the robot leaves less air than a cell of 5 cm.
    Laser,
}

impl Grain {
    /// Edge of a cell.
    pub fn cell_m(self) -> f64 {
        match self {
            Grain::Sonar => 0.1,
            Grain::Laser => 0.035,
        }
    }

    /// How far from the middle of an obstacle cell its surface may be: all of the cell may be filled
    /// where an echo came from an arc, but a beam ends at a surface.
    fn surface_m(self) -> f64 {
        match self {
            Grain::Sonar => self.cell_m() / 2.0,
            Grain::Laser => 0.0,
        }
    }
}

/// Cells along the edge of a tile.
const TILE: i64 = 32;

/// Parts of a nat in which log-odds are kept.
const PARTS: f64 = 8.0;

/// Log-odds of a cell nothing has been seen of. Never those of one that has been.
const UNSEEN: i8 = i8::MIN;

/// Log-odds are kept within these bounds, so that what goes away is seen to be gone.
const LEAST: i8 = -40;
const MOST: i8 = 48;

/// A scan counts after so much motion or time: a robot that stands hears the same again, right or
/// wrong.
const VIEW_M: f64 = 0.1;
const VIEW_RAD: f64 = 0.087;
const VIEW_S: f64 = 1.0;

/// Sonars say something about cells up to here: beyond, arcs are as wide as doors.
const SONAR_REACH_M: f64 = 3.0;
/// So far silence means free; farther it is more often a wall that threw the sound away.
const SILENCE_REACH_M: f64 = 1.5;

/// Log-odds of an unseen cell where an echo is to be explained.
const UNSEEN_NATS: f64 = -1.5;
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

/// Where the robot is nothing else is: the cells within its radius, and what that says.
const BODY_M: f64 = 0.2;
const BODY_NATS: f64 = -4.0;
/// What a touch says.
const FELT_NATS: f64 = 4.0;

/// How sure it takes to be to call a cell an obstacle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Evidence {
    /// More than against it.
    Likely,
    /// Much more: an echo or two will not do.
    Certain,
}

impl Evidence {
    fn threshold(self) -> i8 {
        match self {
            Evidence::Likely => 4,
            Evidence::Certain => 24,
        }
    }
}

/// What the beams of a scan do in a cell; of several the most telling counts.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Beam {
    Misses,
    Passes,
    Ends,
}

type Tile = [[i8; TILE as usize]; TILE as usize];

/// The evidence, in tiles that forks share as long as they agree.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LearnedMap {
    grain: Grain,
    /// Tile (i, j) begins at cell (32 i, 32 j), which begins at the origin of `odom` for i = j = 0.
    tiles: BTreeMap<(i32, i32), Arc<Tile>>,
    seen_cells: u64,
    now_s: f64,
    /// From where and when the last scan that counted was taken.
    view: Option<(Pose, f64)>,
}

/// A cell of the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct At {
    column: i64,
    row: i64,
}

impl At {
    fn around(point_in_odom: Point, cell_m: f64) -> Self {
        let cell = |value_m: f64| libm::floor(value_m / cell_m) as i64;
        Self { column: cell(point_in_odom.x), row: cell(point_in_odom.y) }
    }

    fn centre(self, cell_m: f64) -> Point {
        Point::new((self.column as f64 + 0.5) * cell_m, (self.row as f64 + 0.5) * cell_m)
    }

    fn tile(self) -> (i32, i32) {
        (self.column.div_euclid(TILE) as i32, self.row.div_euclid(TILE) as i32)
    }

    fn in_tile(self) -> (usize, usize) {
        (self.row.rem_euclid(TILE) as usize, self.column.rem_euclid(TILE) as usize)
    }
}

impl LearnedMap {
    /// A map of which nothing has been seen.
    pub fn new(grain: Grain) -> Self {
        Self { grain, ..Self::default() }
    }

    /// How fine it is.
    pub fn grain(&self) -> Grain {
        self.grain
    }

    /// Edge of a cell.
    pub fn cell_m(&self) -> f64 {
        self.grain.cell_m()
    }

    /// The radius for a planner, which takes cells to be filled, of a robot that may come as near to
    /// surfaces as `robot_radius_m`.
    pub fn planning_radius_m(&self, robot_radius_m: f64) -> f64 {
        robot_radius_m + self.grain.surface_m() - self.cell_m() / 2.0
    }

    fn around(&self, point_in_odom: Point) -> At {
        At::around(point_in_odom, self.cell_m())
    }

    /// Takes a scan in, if the robot looks from a new place or some time has passed. The readings are
    /// those of [`super::NavigationInput`].
    pub fn observe(
        &mut self,
        odometry_in_odom: Pose,
        sonar_m: Option<&[f32; SONARS]>,
        laser_m: Option<&[f32]>,
        sonar_max_range_m: f64,
        step_s: f64,
    ) {
        self.now_s += step_s;
        if !self.is_new_view(odometry_in_odom) {
            return;
        }
        self.view = Some((odometry_in_odom, self.now_s));
        for at in disc(odometry_in_odom.point(), BODY_M, self.cell_m()) {
            self.add(at, BODY_NATS);
        }
        if let Some(sonar_m) = sonar_m {
            self.hear(odometry_in_odom, sonar_m, sonar_max_range_m);
        }
        if let Some(laser_m) = laser_m {
            self.scan(odometry_in_odom, laser_m);
        }
    }

    /// Takes in that the robot touches something: it drives forward only, so that is at the front.
    pub fn feel(&mut self, odometry_in_odom: Pose, robot_radius_m: f64) {
        let touched = odometry_in_odom.transform(Point::new(robot_radius_m + self.cell_m() / 2.0, 0.0));
        self.add(self.around(touched), FELT_NATS);
    }

    /// Halves what is known near a point: it holds the robot up, and may be wrong.
    pub fn doubt_around(&mut self, point_in_odom: Point, reach_m: f64) {
        for at in disc(point_in_odom, reach_m, self.cell_m()) {
            let nats = self.nats(at);
            if nats > 0.0 {
                self.add(at, -nats / 2.0);
            }
        }
    }

    /// How many cells have been seen so far.
    pub fn seen_cells(&self) -> u64 {
        self.seen_cells
    }

    /// Whether an obstacle is believed to be so near to a point.
    pub fn is_obstructed(&self, point_in_odom: Point, reach_m: f64, evidence: Evidence) -> bool {
        disc(point_in_odom, reach_m, self.cell_m()).any(|at| self.log_odds(at) >= evidence.threshold())
    }

    /// The map around these points and all that has been seen, with `margin_m` to spare, but nothing
    /// farther than `most_m` from the first. What has not been seen is free.
    pub fn grid(&self, points_in_odom: &[Point], margin_m: f64, most_m: f64, evidence: Evidence) -> OccupancyGrid {
        let first = points_in_odom.first().map_or(Point::origin(), |&first| first);
        let shift = |by_m: f64| self.around(Point::new(first.x + by_m, first.y + by_m));
        let (least, most) = (shift(-most_m), shift(most_m));
        let corners = self.tiles.keys().flat_map(|&(i, j)| {
            let (column, row) = (i64::from(i) * TILE, i64::from(j) * TILE);
            [At { column, row }, At { column: column + TILE, row: row + TILE }]
        });
        let margin = libm::ceil(margin_m / self.cell_m()) as i64;
        let wanted = points_in_odom.iter().map(|&point| self.around(point)).flat_map(|at| {
            let apart = |by: i64| At { column: at.column.saturating_add(by), row: at.row.saturating_add(by) };
            [apart(-margin), apart(margin)]
        });
        let (mut low, mut high) = (shift(0.0), shift(0.0));
        for at in wanted.chain(corners) {
            low = At { column: low.column.min(at.column), row: low.row.min(at.row) };
            high = At { column: high.column.max(at.column), row: high.row.max(at.row) };
        }
        low = At { column: low.column.max(least.column), row: low.row.max(least.row) };
        high = At { column: high.column.min(most.column), row: high.row.min(most.row) };
        self.window(low, high, evidence)
    }

    fn window(&self, low: At, high: At, evidence: Evidence) -> OccupancyGrid {
        let cell_m = self.cell_m();
        let origin = Point::new(low.column as f64 * cell_m, low.row as f64 * cell_m);
        let (columns, rows) = ((high.column - low.column + 1) as usize, (high.row - low.row + 1) as usize);
        let mut grid = OccupancyGrid::filled(origin, cell_m, columns, rows, Cell::Free);
        for (&(i, j), tile) in &self.tiles {
            for (y, line) in tile.iter().enumerate() {
                for (x, &log_odds) in line.iter().enumerate() {
                    let column = i64::from(i) * TILE + x as i64 - low.column;
                    let row = i64::from(j) * TILE + y as i64 - low.row;
                    let inside = column >= 0 && row >= 0 && column < columns as i64 && row < rows as i64;
                    if inside && log_odds >= evidence.threshold() {
                        grid.set(column as usize, row as usize, Cell::Occupied);
                    }
                }
            }
        }
        grid
    }

    /// Bytes of tiles that an earlier map does not share.
    pub fn bytes_apart(&self, earlier: &Self) -> usize {
        let is_new = |(key, tile): &(&(i32, i32), &Arc<Tile>)| {
            earlier.tiles.get(*key).is_none_or(|known| !Arc::ptr_eq(known, tile))
        };
        self.tiles.iter().filter(is_new).count() * size_of::<Tile>()
    }

    fn is_new_view(&self, odometry_in_odom: Pose) -> bool {
        let Some((from_in_odom, at_s)) = self.view else { return true };
        let turned_rad = wrap_angle_rad(odometry_in_odom.heading_rad - from_in_odom.heading_rad).abs();
        odometry_in_odom.distance_m(from_in_odom) >= VIEW_M || turned_rad >= VIEW_RAD || self.now_s - at_s >= VIEW_S
    }

    /// The cones tile the full turn, so that each cell is in one of them.
    fn hear(&mut self, odometry_in_odom: Pose, sonar_m: &[f32; SONARS], max_range_m: f64) {
        let (here, cell_m) = (odometry_in_odom.point(), self.cell_m());
        let arc_m = ARC_CELLS * cell_m;
        let mut arcs: [Vec<At>; SONARS] = std::array::from_fn(|_| Vec::new());
        for at in disc(here, SONAR_REACH_M, self.cell_m()) {
            let centre = at.centre(cell_m);
            let bearing_rad = libm::atan2(centre.y - here.y, centre.x - here.x) - odometry_in_odom.heading_rad;
            let sonar = libm::round(bearing_rad / direction_rad(1)) as i64;
            let sonar = sonar.rem_euclid(SONARS as i64) as usize;
            let reading_m = f64::from(sonar_m[sonar]);
            let beyond_m = reading_m - distance_m(here, centre);
            if reading_m >= max_range_m {
                if distance_m(here, centre) < SILENCE_REACH_M {
                    self.add(at, SILENT_NATS);
                }
            } else if beyond_m > arc_m {
                self.add(at, HEARD_BEYOND_NATS);
            } else if beyond_m >= -arc_m {
                arcs[sonar].push(at);
            }
        }
        arcs.iter().for_each(|arc| self.explain(arc));
    }

    /// An echo from an arc: each cell is as likely its origin as the others are not.
    fn explain(&mut self, arc: &[At]) {
        let nats: Vec<f64> = arc.iter().map(|&at| self.nats(at)).collect();
        let free: Vec<f64> = nats.iter().map(|&nats| 1.0 / (1.0 + libm::exp(nats))).collect();
        let all_free: f64 = free.iter().product();
        for (&at, &is_free) in arc.iter().zip(&free) {
            let others = 1.0 - all_free / is_free;
            self.add(at, -libm::log(FALSE_ECHO + (1.0 - FALSE_ECHO) * others));
        }
    }

    /// Every cell is changed once by a scan, for an end if a beam ends there.
    fn scan(&mut self, odometry_in_odom: Pose, laser_m: &[f32]) {
        let (here, cell_m) = (odometry_in_odom.point(), self.cell_m());
        let middle = self.around(here);
        let reach = libm::ceil(LASER_REACH_M / cell_m) as i64 + 1;
        let side = 2 * reach + 1;
        let mut beams = vec![Beam::Misses; (side * side) as usize];
        let index = |at: At| ((at.row - middle.row + reach) * side + at.column - middle.column + reach) as usize;
        for (beam, &reading_m) in laser_m.iter().enumerate() {
            let bearing_rad = odometry_in_odom.heading_rad + laser_bearing_rad(laser_m, beam);
            let (sin, cos) = libm::sincos(bearing_rad);
            let reading_m = f64::from(reading_m);
            if reading_m.is_nan() || reading_m < 0.0 {
                continue;
            }
            let along = |way_m: f64| At::around(Point::new(here.x + cos * way_m, here.y + sin * way_m), cell_m);
            let is_end = reading_m < LASER_REACH_M;
            let free = libm::floor((reading_m.min(LASER_REACH_M) - cell_m) / cell_m).max(0.0) as i64;
            for step in 0..=free {
                let at = along(step as f64 * cell_m);
                let beam = &mut beams[index(at)];
                *beam = (*beam).max(Beam::Passes);
            }
            if is_end {
                let at = along(reading_m);
                beams[index(at)] = Beam::Ends;
            }
        }
        for (row, line) in (-reach..).zip(beams.chunks_exact(side as usize)) {
            for (column, beam) in (-reach..).zip(line) {
                let change = match beam {
                    Beam::Misses => continue,
                    Beam::Passes => SEEN_THROUGH_NATS,
                    Beam::Ends => SEEN_NATS,
                };
                let (column, row) = (middle.column.saturating_add(column), middle.row.saturating_add(row));
                self.add(At { column, row }, change);
            }
        }
    }

    fn log_odds(&self, at: At) -> i8 {
        let (row, column) = at.in_tile();
        self.tiles.get(&at.tile()).map_or(UNSEEN, |tile| tile[row][column])
    }

    fn nats(&self, at: At) -> f64 {
        match self.log_odds(at) {
            UNSEEN => UNSEEN_NATS,
            parts => f64::from(parts) / PARTS,
        }
    }

    fn add(&mut self, at: At, nats: f64) {
        let tile = self.tiles.entry(at.tile()).or_insert_with(|| Arc::new([[UNSEEN; TILE as usize]; TILE as usize]));
        let (row, column) = at.in_tile();
        let before = tile[row][column];
        let from = if before == UNSEEN { UNSEEN_NATS * PARTS } else { f64::from(before) };
        let after = libm::round(from + nats * PARTS).clamp(f64::from(LEAST), f64::from(MOST)) as i8;
        if after != before {
            Arc::make_mut(tile)[row][column] = after;
        }
        self.seen_cells += u64::from(before == UNSEEN);
    }
}

/// Half the depth of an arc, in cells: every ray of the cone meets one of its cells.
const ARC_CELLS: f64 = 0.7;

/// The cells whose centres are so near to a point, in row order.
fn disc(point_in_odom: Point, reach_m: f64, cell_m: f64) -> impl Iterator<Item = At> {
    let middle = At::around(point_in_odom, cell_m);
    let reach = libm::ceil(reach_m / cell_m) as i64;
    (-reach..=reach)
        .flat_map(move |row| (-reach..=reach).map(move |column| (column, row)))
        .map(move |(column, row)| At {
            column: middle.column.saturating_add(column),
            row: middle.row.saturating_add(row),
        })
        .filter(move |at| (at.centre(cell_m) - point_in_odom).norm_squared() <= reach_m * reach_m)
}
