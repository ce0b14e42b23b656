//! What others want to know of a belief: its mode, its maxima, its entropy, its picture.

use super::belief::Belief;
use super::kernel;
use super::model::LocalizationModel;
use super::plane::Plane;
use crate::geometry::{Point, Pose, wrap_angle_rad};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Poses nearer than this, and than [`NEAR_RAD`], count as one: for the certainty, and for maxima.
const NEAR_M: f64 = 0.5;

/// See [`NEAR_M`].
const NEAR_RAD: f64 = 15.0 / 180.0 * std::f64::consts::PI;

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
    fn pose(&self, model: &LocalizationModel, heading: usize, cell: usize) -> Pose {
        let (column, row) = self.planes[heading].position_cells(&model.grid, cell);
        let origin = model.grid.origin_in_map;
        Pose::new(
            origin.x + column * model.grid.cell_m,
            origin.y + row * model.grid.cell_m,
            self.heading_rad(model, heading),
        )
    }

    /// The most probable state, refined, with the mass around it.
    pub fn mode(&self, model: &LocalizationModel) -> Maximum {
        let highest = (0..self.planes.len())
            .filter(|&heading| self.planes[heading].is_active())
            .reduce(|best, next| if self.planes[next].peak() > self.planes[best].peak() { next } else { best });
        let heading = highest.unwrap_or(0);
        let cells = &self.planes[heading].cells;
        let peak = kernel::extent(cells).peak;
        let cell = cells.iter().position(|&value| value == peak).unwrap_or(0);
        self.refined(model, self.pose(model, heading, cell))
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
                    let cell = r * grid.columns + c;
                    let (x, y) = (c as f64 + dx - column, r as f64 + dy - row);
                    if x * x + y * y <= reach * reach + 1e-9 && model.admissible[cell] > 0.0 {
                        let at = Point::new(pose.x_m + x * grid.cell_m, pose.y_m + y * grid.cell_m);
                        visit(at, away_rad, plane.value(cell));
                    }
                }
            }
        }
    }

    /// The local maxima with at least `min_mass`, the heaviest first, at most `max_count`, no two
    /// within 0.5 m and 15° of each other. O(active states), a few milliseconds for all of them.
    pub fn maxima(&self, model: &LocalizationModel, max_count: usize, min_mass: f64) -> Vec<Maximum> {
        let peak = self.planes.iter().map(Plane::peak).fold(0.0, f64::max);
        let cutoff = peak * MAXIMUM_SHARE;
        let mut summits: Vec<(f64, usize, usize)> = (0..self.planes.len())
            .into_par_iter()
            .flat_map_iter(|heading| self.summits(model, heading, cutoff))
            .collect();
        summits.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut kept: Vec<(Pose, Maximum)> = Vec::new();
        for (_, heading, cell) in summits {
            if kept.len() >= 4 * max_count {
                break;
            }
            let pose = self.pose(model, heading, cell);
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
    /// counts as a maximum of its own. O(active states · log).
    pub fn likely_states(&self, model: &LocalizationModel, share: f64) -> Vec<Maximum> {
        let mut states: Vec<Maximum> = Vec::new();
        for (heading, plane) in self.planes.iter().enumerate().filter(|(_, plane)| plane.is_active()) {
            for cell in (0..model.grid.cells()).filter(|&cell| model.admissible[cell] > 0.0) {
                states.push(Maximum { pose_in_map: self.pose(model, heading, cell), mass: plane.value(cell) });
            }
        }
        states.sort_by(|a, b| b.mass.total_cmp(&a.mass));
        let mut held = 0.0;
        let kept = states.iter().take_while(|state| {
            let is_needed = held < share;
            held += state.mass;
            is_needed
        });
        let kept = kept.count();
        states.truncate(kept);
        states
    }

    /// Cells of an active plane above the cutoff that no neighbour exceeds, with their values.
    fn summits(&self, model: &LocalizationModel, heading: usize, cutoff: f64) -> Vec<(f64, usize, usize)> {
        let plane = &self.planes[heading];
        if !plane.is_active() || plane.peak() < cutoff {
            return Vec::new();
        }
        let count = self.planes.len();
        let (before, after) = (&self.planes[(heading + count - 1) % count], &self.planes[(heading + 1) % count]);
        let columns = model.grid.columns;
        let mut summits = Vec::new();
        for (cell, &value) in plane.cells.iter().enumerate() {
            let probability = plane.value(cell);
            if probability <= cutoff {
                continue;
            }
            // A plateau has one summit: its first cell.
            let earlier = [1, columns - 1, columns, columns + 1]
                .iter()
                .all(|&back| cell < back || plane.cells[cell - back] < value);
            let later = [1, columns - 1, columns, columns + 1]
                .iter()
                .all(|&on| plane.cells.get(cell + on).is_none_or(|&next| next <= value));
            if earlier && later && before.value(cell) < probability && after.value(cell) <= probability {
                summits.push((probability, heading, cell));
            }
        }
        summits
    }

    /// −Σ P ln P, in nats.
    pub fn entropy(&self, model: &LocalizationModel) -> f64 {
        let parts: Vec<f64> = self
            .planes
            .par_iter()
            .map(|plane| {
                if plane.factor * plane.stored_mass < 1e-3 * plane.floor {
                    model.admissible_cells as f64 * entropy_term(plane.floor)
                } else {
                    model.instructions.entropy(&plane.cells, &model.admissible, plane.terms())
                }
            })
            .collect();
        parts.iter().sum()
    }

    /// Probability of each cell of (x, y) over all headings, `[row][column]`.
    pub fn xy(&self, model: &LocalizationModel) -> Vec<f64> {
        let mut mass = vec![0.0; model.grid.cells()];
        for plane in &self.planes {
            for (cell, (sum, &admissible)) in mass.iter_mut().zip(model.admissible.iter()).enumerate() {
                if admissible > 0.0 {
                    *sum += plane.value(cell);
                }
            }
        }
        mass
    }
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
