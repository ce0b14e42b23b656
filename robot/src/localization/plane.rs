//! One plane of the belief: all cells of equal heading.

use super::grid::BeliefGrid;
use super::kernel::{self, Extent};
use super::model::LocalizationModel;
use super::saved_cells;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Pending noise is applied once it reaches this variance, in cells².
const BLUR_AT: f64 = 0.04;

/// Largest variance one pass of the three-point blur adds without overshooting.
const BLUR_MOST: f64 = 0.5;

/// Whether a plane takes part in updates (Beetz et al. §2.1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Activity {
    /// It is moved and weighed.
    Active,
    /// All its cells are below θ: only its terms change.
    ///
    /// # Deviation
    /// The paper keeps the factor α_π alone and brings a part back when α_π > 1. Mixing adds the
    /// same amount to every cell, which stays exact as the second term; the plane comes back when
    /// its largest cell reaches θ, which for a floor of 0 is the paper's rule.
    Inactive,
}

/// The cells of one heading. Clones share the cells until one of them is written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plane {
    /// `[row][column]`, padded to whole blocks; empty for a plane with factor 0.
    #[serde(with = "saved_cells")]
    pub(super) cells: Arc<Vec<f32>>,
    /// Whether it takes part in updates.
    pub(super) activity: Activity,
    /// A cell is worth `factor · stored + floor`: the normalization that the next pass over the
    /// cells brings in; for an inactive plane α_π, all normalizations since it was deactivated.
    pub(super) factor: f64,
    /// What mixing has added to each admissible cell, as above.
    pub(super) floor: f64,
    /// Where cells really are, relative to their middles, in cells along x and y: motion that is
    /// not yet applied, at most half a cell.
    pub(super) offset_cells: [f64; 2],
    /// Variance of motion that is not yet applied, along x and y.
    ///
    /// # Deviation
    /// The paper keeps the motion a_π of an inactive part and applies it when the part comes back. Here every plane
    /// is moved alike at every step, also one without cells: what is not yet applied depends on the way of the robot
    /// alone, and not on when a plane fell asleep, was forgotten and woke.
    pub(super) variance_cells: [f64; 2],
    /// Sum of the stored cells.
    pub(super) stored_mass: f64,
    /// Largest stored cell.
    pub(super) stored_peak: f32,
}

impl Plane {
    /// An active plane of these cells.
    pub(super) fn active(cells: Arc<Vec<f32>>) -> Self {
        let extent = kernel::extent(&cells);
        Self {
            cells,
            activity: Activity::Active,
            factor: 1.0,
            floor: 0.0,
            offset_cells: [0.0; 2],
            variance_cells: [0.0; 2],
            stored_mass: extent.mass,
            stored_peak: extent.peak,
        }
    }

    /// Whether the plane takes part in updates.
    pub fn is_active(&self) -> bool {
        self.activity == Activity::Active
    }

    /// The stored cells, `[row][column]`; planes of a fork are the same allocation until written.
    pub fn shared_cells(&self) -> &Arc<Vec<f32>> {
        &self.cells
    }

    /// Factor and floor by which stored cells are read.
    pub(super) fn terms(&self) -> [f32; 2] {
        [self.factor as f32, self.floor as f32]
    }

    /// Probability of one admissible cell.
    pub(super) fn value(&self, cell: usize) -> f64 {
        self.factor * self.cells.get(cell).copied().map_or(0.0, f64::from) + self.floor
    }

    /// Probability of the cells around the points of a lattice, `[row][column]`, whose columns and rows
    /// are given in fractions of a cell; of the likeliest cell beside one that cannot be stood in: at a
    /// wall a point may be free whose coarse cell is not.
    pub(super) fn densities(&self, model: &LocalizationModel, columns: &[f64], rows: &[f64]) -> Vec<f64> {
        let grid = &model.grid;
        let nearest = |places: &[f64], axis: usize| -> Vec<i64> {
            places.iter().map(|place| libm::round(place - self.offset_cells[axis]) as i64).collect()
        };
        let at = |column: i64, row: i64| -> f64 {
            let inside = (0..grid.columns as i64).contains(&column) && (0..grid.rows as i64).contains(&row);
            if !inside || !model.is_admissible(column as usize, row as usize) {
                return 0.0;
            }
            self.value(row as usize * grid.columns + column as usize)
        };
        let columns = nearest(columns, 0);
        let mut densities = Vec::with_capacity(columns.len() * rows.len());
        for row in nearest(rows, 1) {
            densities.extend(columns.iter().map(|&column| {
                let here = at(column, row);
                let beside = || [at(column + 1, row), at(column - 1, row), at(column, row + 1), at(column, row - 1)];
                if here > 0.0 { here } else { beside().into_iter().fold(0.0, f64::max) }
            }));
        }
        densities
    }

    /// Probability of the whole plane.
    pub(super) fn mass(&self, model: &LocalizationModel) -> f64 {
        self.factor * self.stored_mass + self.floor * model.admissible_cells as f64
    }

    /// Largest probability of a cell.
    pub(super) fn peak(&self) -> f64 {
        self.factor * f64::from(self.stored_peak) + self.floor
    }

    /// Where a cell's middle really is, in fractions of a cell.
    pub(super) fn position_cells(&self, grid: &BeliefGrid, cell: usize) -> (f64, f64) {
        let (column, row) = (cell % grid.columns, cell / grid.columns);
        (column as f64 + self.offset_cells[0], row as f64 + self.offset_cells[1])
    }

    /// Brings motion into the cells, if there are any: whole cells of the offset, and noise once there is enough.
    pub(super) fn apply_motion(&mut self, grid: &BeliefGrid) {
        let has_cells = !self.cells.is_empty();
        let whole = self.offset_cells.map(libm::round);
        if whole != [0.0; 2] {
            if has_cells {
                kernel::shift(self.cells_mut(), grid.columns, grid.rows, whole[0] as i64, whole[1] as i64);
            }
            self.offset_cells[0] -= whole[0];
            self.offset_cells[1] -= whole[1];
        }
        while self.variance_cells[0].max(self.variance_cells[1]) >= BLUR_AT {
            let [x, y] = self.variance_cells.map(|variance| variance.min(BLUR_MOST));
            if has_cells {
                kernel::blur(self.cells_mut(), grid.columns, grid.rows, (x / 2.0) as f32, (y / 2.0) as f32);
            }
            self.variance_cells[0] -= x;
            self.variance_cells[1] -= y;
        }
    }

    /// Takes in that the cells were read by the terms and weighed.
    pub(super) fn weighed(&mut self, extent: Extent) {
        (self.factor, self.floor) = (1.0, 0.0);
        (self.stored_mass, self.stored_peak) = (extent.mass, extent.peak);
    }

    /// The cells, copied first if a fork shares them.
    pub(super) fn cells_mut(&mut self) -> &mut Vec<f32> {
        Arc::make_mut(&mut self.cells)
    }

    /// Applies factor and floor to the cells and updates the plane from now on.
    pub(super) fn activate(&mut self, model: &LocalizationModel) {
        if self.is_active() {
            return;
        }
        self.activity = Activity::Active;
        if self.cells.is_empty() {
            self.cells = Arc::new(vec![0.0; model.grid.plane_len()]);
        }
        let terms = self.terms();
        kernel::apply_terms(self.cells_mut(), &model.admissible, terms);
        *self = Self {
            offset_cells: self.offset_cells,
            variance_cells: self.variance_cells,
            ..Self::active(std::mem::take(&mut self.cells))
        };
    }

    /// Drops stored cells that no longer matter beside the floor.
    pub(super) fn forget_if_negligible(&mut self) {
        if self.floor > 0.0 && self.factor * f64::from(self.stored_peak) < 1e-3 * self.floor {
            self.factor = 0.0;
            self.cells = Arc::default();
            self.stored_mass = 0.0;
            self.stored_peak = 0.0;
        }
    }
}
