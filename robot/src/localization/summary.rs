//! What others want to know of a belief: its mode, its maxima, its entropy, its picture.

use super::belief::Belief;
use super::grid::{Place, TILE_EDGE};
use super::model::LocalizationModel;
use super::plane::Plane;
use super::tile::Tile;
use crate::geometry::{Point, Pose, wrap_angle_rad};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Poses nearer than this, and than [`NEAR_RAD`], count as one: for the certainty, and for maxima.
pub(super) const NEAR_M: f64 = 0.5;

/// See [`NEAR_M`].
pub(super) const NEAR_RAD: f64 = 15.0 / 180.0 * std::f64::consts::PI;

/// The neighbourhood a maximum is refined in.
const REFINE_M: f64 = 0.35;
const REFINE_RAD: f64 = 8.0 / 180.0 * std::f64::consts::PI;

/// Cells below this share of the largest one start no maximum.
const MAXIMUM_SHARE: f64 = 1e-3;

/// A local maximum of the belief.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Maximum {
    /// The pose, refined below the cell size.
    pub pose_in_map: Pose,
    /// Probability within 0.5 m and 15° of it.
    pub mass: f64,
}

impl Maximum {
    /// Whether this maximum, carried on by a motion, is at a pose.
    pub fn is_near(&self, pose_in_map: Pose, motion: Pose) -> bool {
        near(self.pose_in_map.compose(motion), pose_in_map)
    }
}

/// Whether two poses count as one.
fn near(a: Pose, b: Pose) -> bool {
    a.distance_m(b) <= NEAR_M && libm::fabs(wrap_angle_rad(a.heading_rad - b.heading_rad)) <= NEAR_RAD
}

impl Belief {
    /// The pose of a cell's middle, with motion not yet applied.
    fn pose(&self, model: &LocalizationModel, heading: usize, place: Place) -> Pose {
        let (column, row) = self.planes[heading].position_cells(&model.grid, place);
        let origin = model.grid.origin_in_map;
        Pose::new(
            origin.x + column * model.grid.cell_m,
            origin.y + row * model.grid.cell_m,
            self.heading_rad(model, heading),
        )
    }

    /// The most probable state, refined, with the mass around it.
    pub fn mode(&self, model: &LocalizationModel) -> Maximum {
        let numbered = self.planes.iter().enumerate();
        let tiles = numbered.flat_map(|(heading, plane)| plane.tiles.iter().map(move |tile| (heading, tile)));
        let highest = tiles.reduce(|best, next| if next.1.peak > best.1.peak { next } else { best });
        let (heading, number, cell) = match highest {
            Some((heading, tile)) => {
                let cell = tile.cells.iter().position(|&value| value == tile.peak);
                (heading, tile.number, cell)
            }
            // Where everything sleeps, any state will do.
            None => {
                let first = model.ground.tiles().next();
                first.map_or((0, 0, None), |(number, ground)| (0, number, ground.free().next()))
            }
        };
        let place = Place { tile: number as usize, cell: cell.unwrap_or(0) };
        self.refined(model, self.pose(model, heading, place))
    }

    /// The maximum around a pose: its neighbourhood's mean, and the mass near that.
    fn refined(&self, model: &LocalizationModel, around: Pose) -> Maximum {
        let mut pose = around;
        for _ in 0..2 {
            let (mut mass, mut x, mut y, mut turn) = (0.0, 0.0, 0.0, 0.0);
            self.visit_near(model, pose, REFINE_M, REFINE_RAD, |at, away_rad, value| {
                mass += value;
                x += value * (at.x - pose.x_m);
                y += value * (at.y - pose.y_m);
                turn += value * away_rad;
            });
            if mass > 0.0 {
                pose = Pose::new(pose.x_m + x / mass, pose.y_m + y / mass, pose.heading_rad + turn / mass);
            }
        }
        Maximum { pose_in_map: pose, mass: self.mass_near(model, pose) }
    }

    /// Probability within 0.5 m and 15° of a pose.
    pub fn mass_near(&self, model: &LocalizationModel, pose_in_map: Pose) -> f64 {
        self.mass_within(model, pose_in_map, NEAR_M, NEAR_RAD)
    }

    /// Probability within a distance and an angle of a pose.
    pub(super) fn mass_within(
        &self,
        model: &LocalizationModel,
        pose_in_map: Pose,
        radius_m: f64,
        angle_rad: f64,
    ) -> f64 {
        let mut mass = 0.0;
        self.visit_near(model, pose_in_map, radius_m, angle_rad, |_, _, value| mass += value);
        mass
    }

    /// The same of what is awake, however wide. O(states that are awake).
    pub(super) fn awake_within(&self, model: &LocalizationModel, pose: Pose, radius_m: f64, angle_rad: f64) -> f64 {
        let grid = &model.grid;
        let (column, row) = grid.fractional(pose.point());
        let reach = radius_m / grid.cell_m;
        let of_plane = |(heading, plane): (usize, &Plane)| -> f64 {
            let away_rad = wrap_angle_rad(self.heading_rad(model, heading) - pose.heading_rad);
            if libm::fabs(away_rad) > angle_rad + 1e-9 {
                return 0.0;
            }
            let [dx, dy] = plane.offset_cells;
            let of_tile = |tile: &Tile| -> f64 {
                let Some(ground) = model.ground.tile(tile.number) else { return 0.0 };
                let [first_column, first_row] = grid.column_and_row(Place { tile: tile.number as usize, cell: 0 });
                let is_near = |cell: &usize| {
                    let x = (first_column + (cell % TILE_EDGE) as i64) as f64 + dx - column;
                    let y = (first_row + (cell / TILE_EDGE) as i64) as f64 + dy - row;
                    x * x + y * y <= reach * reach + 1e-9
                };
                ground.free().filter(is_near).map(|cell| self.value(tile.cells[cell])).sum()
            };
            plane.tiles.iter().map(of_tile).sum()
        };
        self.planes.iter().enumerate().map(of_plane).sum()
    }

    /// Calls `visit` with position, heading relative to the pose's, and probability of every
    /// admissible state within a radius and an angle.
    fn visit_near(
        &self,
        model: &LocalizationModel,
        pose: Pose,
        radius_m: f64,
        angle_rad: f64,
        mut visit: impl FnMut(Point, f64, f64),
    ) {
        let grid = &model.grid;
        let (column, row) = grid.fractional(pose.point());
        for (heading, plane) in self.planes.iter().enumerate() {
            let away_rad = wrap_angle_rad(self.heading_rad(model, heading) - pose.heading_rad);
            if libm::fabs(away_rad) > angle_rad + 1e-9 {
                continue;
            }
            let [dx, dy] = plane.offset_cells;
            let reach = radius_m / grid.cell_m;
            for r in clip(row - dy, reach, grid.rows) {
                for c in clip(column - dx, reach, grid.columns) {
                    let (x, y) = (c as f64 + dx - column, r as f64 + dy - row);
                    if x * x + y * y <= reach * reach + 1e-9 && model.is_admissible(c, r) {
                        let at = Point::new(pose.x_m + x * grid.cell_m, pose.y_m + y * grid.cell_m);
                        visit(at, away_rad, self.probability_at(model, heading, [c as i64, r as i64]));
                    }
                }
            }
        }
    }

    /// The local maxima with at least `min_mass`, the heaviest first, at most `max_count`, no two
    /// within 0.5 m and 15° of each other. O(states that are awake), a few milliseconds for all of them.
    pub fn maxima(&self, model: &LocalizationModel, max_count: usize, min_mass: f64) -> Vec<Maximum> {
        let peak = self.tiles().map(|tile| self.value(tile.peak)).fold(0.0, f64::max);
        let cutoff = peak * MAXIMUM_SHARE;
        let mut summits: Vec<Summit> = (0..self.planes.len())
            .into_par_iter()
            .flat_map_iter(|heading| self.summits(model, heading, cutoff))
            .collect();
        summits.sort_by(|a, b| {
            let order = |summit: &Summit| (summit.heading, summit.row, summit.column);
            b.probability.total_cmp(&a.probability).then(order(a).cmp(&order(b)))
        });
        let mut kept: Vec<(Pose, Maximum)> = Vec::new();
        for Summit { heading, column, row, .. } in summits {
            if kept.len() >= 4 * max_count {
                break;
            }
            let pose = self.pose(model, heading, model.grid.place(column, row));
            if kept.iter().any(|(other, maximum)| near(*other, pose) || near(maximum.pose_in_map, pose)) {
                continue;
            }
            let maximum = self.refined(model, pose);
            if kept.iter().all(|(_, other)| !near(other.pose_in_map, maximum.pose_in_map)) {
                kept.push((pose, maximum));
            }
        }
        let mut maxima: Vec<Maximum> =
            kept.into_iter().map(|(_, maximum)| maximum).filter(|maximum| maximum.mass >= min_mass).collect();
        maxima.sort_by(|a, b| b.mass.total_cmp(&a.mass));
        maxima.truncate(max_count);
        maxima
    }

    /// The likeliest states that together hold a share of the belief, the likeliest first; a state
    /// counts as a maximum of its own. Those that sleep are none of them. O(states that are awake + n log n) for the
    /// n that are not far below the likeliest; more only where the share needs them.
    pub fn likely_states(&self, model: &LocalizationModel, share: f64) -> Vec<Maximum> {
        /// Of the likeliest state; what is below is looked at if what is above does not hold enough.
        const FAR_BELOW: f64 = 1e-3;
        let mut cutoff = self.tiles().map(|tile| self.value(tile.peak)).fold(0.0, f64::max);
        loop {
            cutoff = if cutoff * FAR_BELOW > self.asleep { cutoff * FAR_BELOW } else { 0.0 };
            let mut states = self.states_from(model, cutoff);
            states.sort_by(|a, b| b.1.total_cmp(&a.1));
            let mut held = 0.0;
            let kept = states.iter().take_while(|state| {
                let is_needed = held < share;
                held += state.1;
                is_needed
            });
            let kept = kept.count();
            if held >= share || cutoff == 0.0 {
                let maximum = |&((heading, place), mass): &((usize, Place), f64)| Maximum {
                    pose_in_map: self.pose(model, heading, place),
                    mass,
                };
                return states[..kept].iter().map(maximum).collect();
            }
        }
    }

    /// The states of tiles that are awake with at least this probability, each with heading and place, in their order.
    fn states_from(&self, model: &LocalizationModel, cutoff: f64) -> Vec<((usize, Place), f64)> {
        let mut states = Vec::new();
        for (heading, plane) in self.planes.iter().enumerate() {
            for tile in plane.tiles.iter().filter(|tile| self.value(tile.peak) >= cutoff) {
                let Some(ground) = model.ground.tile(tile.number) else { continue };
                let place = |cell: usize| (heading, Place { tile: tile.number as usize, cell });
                let likely = ground.free().map(|cell| (place(cell), self.value(tile.cells[cell])));
                states.extend(likely.filter(|state| state.1 >= cutoff));
            }
        }
        states
    }

    /// Cells of a plane that are awake and above the cutoff, and that no neighbour exceeds.
    fn summits(&self, model: &LocalizationModel, heading: usize, cutoff: f64) -> Vec<Summit> {
        let mut summits = Vec::new();
        let may_have = |tile: &&Tile| self.value(tile.peak) > cutoff;
        for tile in self.planes[heading].tiles.iter().filter(may_have) {
            let Some(ground) = model.ground.tile(tile.number) else { continue };
            for cell in ground.free().filter(|&cell| self.value(tile.cells[cell]) > cutoff) {
                let state = model.grid.state(heading, tile.number, cell);
                let probability = self.value(tile.cells[cell]);
                if self.is_summit(model, heading, [state.column as i64, state.row as i64], probability) {
                    summits.push(Summit { probability, heading, column: state.column, row: state.row });
                }
            }
        }
        summits
    }

    /// Whether no neighbour of a state exceeds it. A plateau has one summit: its first cell.
    fn is_summit(&self, model: &LocalizationModel, heading: usize, [column, row]: [i64; 2], probability: f64) -> bool {
        let count = self.planes.len();
        let at = |heading: usize, by: [i64; 2]| self.probability_at(model, heading, [column + by[0], row + by[1]]);
        let mut earlier = [[-1, 0], [1, -1], [0, -1], [-1, -1]].into_iter();
        let mut later = [[1, 0], [-1, 1], [0, 1], [1, 1]].into_iter();
        earlier.all(|by| at(heading, by) < probability)
            && later.all(|by| at(heading, by) <= probability)
            && at((heading + count - 1) % count, [0, 0]) < probability
            && at((heading + 1) % count, [0, 0]) <= probability
    }

    /// −Σ P ln P, in nats.
    pub fn entropy(&self, model: &LocalizationModel) -> f64 {
        let of_tile = |tile: &Tile| {
            let ground = model.ground.tile(tile.number)?;
            Some(model.instructions.entropy(&tile.cells, &ground.admissible, self.terms()))
        };
        let of_plane = |plane: &Plane| plane.tiles.iter().filter_map(of_tile).sum();
        let awake: Vec<f64> = self.planes.par_iter().map(of_plane).collect();
        awake.iter().sum::<f64>() + self.cells_asleep(model) as f64 * entropy_term(self.asleep)
    }

    /// Probability of each cell of (x, y) over all headings, `[row][column]`. O(cells of a plane, and those that are
    /// awake).
    pub fn xy(&self, model: &LocalizationModel) -> Vec<f64> {
        let mut mass = vec![0.0; model.grid.cells()];
        let mut awake = vec![0; model.grid.tiles()];
        self.tiles().for_each(|tile| awake[tile.number as usize] += 1);
        let mut add = |number: u32, value: &dyn Fn(usize) -> f64| {
            let Some(ground) = model.ground.tile(number) else { return };
            for cell in ground.free() {
                let state = model.grid.state(0, number, cell);
                mass[state.row * model.grid.columns + state.column] += value(cell);
            }
        };
        for &number in model.ground.numbers() {
            let asleep = self.asleep * (self.planes.len() - awake[number as usize]) as f64;
            add(number, &|_| asleep);
        }
        for tile in self.tiles() {
            add(tile.number, &|cell| self.value(tile.cells[cell]));
        }
        mass
    }
}

/// A state that no neighbour exceeds.
struct Summit {
    probability: f64,
    heading: usize,
    column: usize,
    row: usize,
}

/// Indices within `reach` of `middle`, on the grid.
fn clip(middle: f64, reach: f64, count: usize) -> std::ops::Range<usize> {
    let first = libm::ceil(middle - reach - 1e-9).max(0.0) as usize;
    let end = (libm::floor(middle + reach + 1e-9) + 1.0).clamp(0.0, count as f64) as usize;
    first.min(end)..end
}

fn entropy_term(probability: f64) -> f64 {
    if probability > 0.0 { -probability * libm::log(probability) } else { 0.0 }
}
