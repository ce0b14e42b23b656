//! The belief and its two updates.

use super::grid::{Place, State};
use super::ground::{Cells, GroundTile};
use super::kernel::LIFT;
use super::model::LocalizationModel;
use super::motion::Surroundings;
use super::parameters::Spread;
use super::plane::Plane;
use super::scan::Weighing;
use super::sensor::BinnedScan;
use super::tile::Tile;
use super::weigh::{Stored, weigh_planes};
use crate::geometry::{Pose, wrap_angle_rad};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// With less than this (of [`LIFT`]), motion has left nothing.
const LEAST_EVIDENCE: f64 = 1e-15;

/// P(l) over all states: one plane per heading, each in tiles. Its mass is 1 after every operation but
/// [`Belief::advance`], which a normalizing one must follow.
///
/// A tile sleeps while all its cells are below θ (Beetz et al. §2.1); all cells that sleep are worth the same. It
/// wakes when motion or noise brings a cell of it above θ, and all wake when what sleeps comes to be worth θ, unless
/// a coarse belief watches over this one, which looks at what sleeps.
///
/// # Deviation
/// The paper keeps the cells of a part that sleeps, with a factor α_π for all normalizations since, and brings it back
/// when α_π > 1. Below θ, cells differ by little from what mixing adds to each; so what falls asleep is put together
/// with all that sleeps, and memory and time follow what may be true instead of the size of the map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Belief {
    /// Plane `k` has heading `(k + heading_offset) · angle_step`.
    pub(super) planes: Vec<Plane>,
    /// A cell that is awake is worth `factor · stored + floor`: the normalization that the next pass over the cells
    /// brings in, and what mixing has added to each cell that can be stood in.
    pub(super) factor: f64,
    /// See above.
    pub(super) floor: f64,
    /// Probability of each cell that sleeps.
    pub(super) asleep: f64,
    /// θ of Beetz et al. Eq. (3), as a probability.
    pub(super) threshold: f64,
    /// Rotation that is not yet applied, in angle steps, at most one half.
    pub(super) heading_offset: f64,
    /// Variance of the rotation that is not yet applied, in squared angle steps.
    pub(super) heading_variance: f64,
}

impl Belief {
    /// Every admissible state alike.
    pub fn uniform(model: &LocalizationModel) -> Self {
        let mut belief = Self::asleep(model);
        belief.asleep = model.prior();
        belief.wake_what_must(model);
        belief
    }

    /// Nothing is awake, and what sleeps is worth nothing.
    pub(super) fn asleep(model: &LocalizationModel) -> Self {
        Self {
            planes: vec![Plane::default(); model.grid.headings],
            factor: 1.0,
            floor: 0.0,
            asleep: 0.0,
            threshold: model.threshold(),
            heading_offset: 0.0,
            heading_variance: 0.0,
        }
    }

    /// A normal distribution around a pose; the uniform one if nothing around it is admissible.
    pub fn around(model: &LocalizationModel, pose_in_map: Pose, spread: Spread) -> Self {
        let grid = &model.grid;
        let (x, y) = grid.fractional(pose_in_map.point());
        // Cells are laid through the pose itself, so that a belief without spread is exact.
        let offset_cells = [x - libm::round(x), y - libm::round(y)];
        let heading_steps = pose_in_map.heading_rad / grid.angle_step_rad();
        let sigma = (spread.position_m / grid.cell_m).max(1e-3);
        let heading_sigma = (spread.heading_rad / grid.angle_step_rad()).max(1e-3);
        let nearest = grid.heading_at(pose_in_map.heading_rad) as i64;
        let along_headings: Vec<f64> = (0..grid.headings as i64)
            .map(|heading| {
                let half = grid.headings as i64 / 2;
                let away = (heading - nearest + half).rem_euclid(grid.headings as i64) - half;
                normal(away as f64 / heading_sigma)
            })
            .collect();
        let along = |count: usize, middle: f64| -> Vec<f64> {
            (0..count).map(|i| normal((i as f64 - middle) / sigma)).collect()
        };
        let (along_x, along_y) = (along(grid.columns, libm::round(x)), along(grid.rows, libm::round(y)));
        let at = |tile: u32, cell: usize| {
            let [column, row] = grid.column_and_row(Place { tile: tile as usize, cell });
            along_x[column as usize] * along_y[row as usize]
        };
        // The same in all planes, but for a factor.
        let tiles = model.ground.tiles().map(|(number, ground)| {
            let mut cells = ground.admissible;
            ground.free().for_each(|cell| cells[cell] = at(number, cell) as f32);
            Tile::new(number, cells)
        });
        let tiles: Vec<Tile> = tiles.collect();
        let total = tiles.iter().map(|tile| tile.mass).sum::<f64>() * along_headings.iter().sum::<f64>();
        if total <= 0.0 {
            return Self::uniform(model);
        }
        let mut belief = Self::asleep(model);
        for (plane, share) in belief.planes.iter_mut().zip(along_headings) {
            let factor = share / total;
            let awake = tiles.iter().filter(|tile| f64::from(tile.peak) * factor >= model.threshold());
            let scaled = |tile: &Tile| Tile::new(tile.number, tile.cells.map(|cell| (f64::from(cell) * factor) as f32));
            *plane = Plane { offset_cells, ..Plane::of(awake.map(scaled).collect()) };
        }
        belief.heading_offset = heading_steps - libm::round(heading_steps);
        belief.sense(model, &[]);
        belief
    }

    /// Half of this belief and half of another one, cell by cell: places are exact to half a cell.
    pub fn merged(&self, model: &LocalizationModel, other: &Self) -> Self {
        let mut merged = Self::asleep(model);
        for (heading, plane) in merged.planes.iter_mut().enumerate() {
            plane.tiles = self.tiles_with(model, other, heading, 0.5);
        }
        merged.asleep = 0.5 * (self.asleep + other.asleep);
        merged.sense(model, &[]);
        merged
    }

    /// The tiles of a plane of this belief with a share of another one, cell by cell.
    pub(super) fn tiles_with(
        &self,
        model: &LocalizationModel,
        other: &Self,
        heading: usize,
        share: f32,
    ) -> Arc<Vec<Tile>> {
        let held = [self, other].map(|belief| belief.planes[heading].tiles.iter().map(|tile| tile.number));
        let mut numbers: Vec<u32> = held.into_iter().flatten().collect();
        numbers.sort_unstable();
        numbers.dedup();
        let both = |number: u32| {
            let ground = model.ground.tile(number)?;
            let [own, others] = [self, other].map(|belief| belief.values(heading, number, ground));
            let cell = |cell: usize| (1.0 - share) * own[cell] + share * others[cell];
            Some(Tile::new(number, std::array::from_fn(cell)))
        };
        Arc::new(numbers.into_iter().filter_map(both).collect())
    }

    /// The planes, by heading.
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// All tiles that are awake, plane by plane.
    pub(super) fn tiles(&self) -> impl Iterator<Item = &Tile> {
        self.planes.iter().flat_map(|plane| plane.tiles.iter())
    }

    /// Bytes of all tiles.
    pub(super) fn bytes(&self) -> usize {
        self.tiles().count() * size_of::<Cells>()
    }

    /// Bytes of tiles that an earlier belief does not share.
    pub(super) fn bytes_apart(&self, earlier: &Self) -> usize {
        let pairs = self.planes.iter().zip(&earlier.planes);
        let apart = pairs.map(|(plane, earlier)| plane.tiles.len() - plane.shared_tiles(earlier));
        apart.sum::<usize>() * size_of::<Cells>()
    }

    /// Planes that take part in updates.
    pub fn active_planes(&self) -> usize {
        self.planes.iter().filter(|plane| plane.is_active()).count()
    }

    /// Factor and floor by which cells that are awake are read.
    pub(super) fn terms(&self) -> [f32; 2] {
        [self.factor as f32, self.floor as f32]
    }

    /// Probability of a cell that is awake and can be stood in.
    pub(super) fn value(&self, stored: f32) -> f64 {
        self.factor * f64::from(stored) + self.floor
    }

    /// Probability of the cells of a tile that can be stood in.
    pub(super) fn mass_of(&self, model: &LocalizationModel, tile: &Tile) -> f64 {
        self.factor * tile.mass + self.floor * model.ground.tile(tile.number).map_or(0.0, |ground| ground.cells as f64)
    }

    /// Probabilities of the cells of a tile of a plane, awake or not; 0 where nobody can stand.
    pub(super) fn values(&self, heading: usize, number: u32, ground: &GroundTile) -> Cells {
        match self.planes[heading].tile(number) {
            Some(tile) => std::array::from_fn(|cell| self.value(tile.cells[cell]) as f32 * ground.admissible[cell]),
            None => ground.filled(self.asleep as f32),
        }
    }

    /// The sum of the belief, 1 but for rounding. Reads what the last update summed.
    pub fn mass(&self, model: &LocalizationModel) -> f64 {
        let awake: f64 = self.tiles().map(|tile| self.mass_of(model, tile)).sum();
        awake + self.mass_asleep(model)
    }

    /// Heading of a plane, with the rotation not yet applied.
    pub fn heading_rad(&self, model: &LocalizationModel, heading: usize) -> f64 {
        wrap_angle_rad((heading as f64 + self.heading_offset) * model.grid.angle_step_rad())
    }

    /// Probability of one state; 0 where the robot cannot stand.
    pub fn probability(&self, model: &LocalizationModel, state: State) -> f64 {
        self.probability_at(model, state.heading, [state.column as i64, state.row as i64])
    }

    /// The same of a cell that may be beyond the grid.
    pub(super) fn probability_at(&self, model: &LocalizationModel, heading: usize, [column, row]: [i64; 2]) -> f64 {
        let grid = &model.grid;
        if !(0..grid.columns as i64).contains(&column) || !(0..grid.rows as i64).contains(&row) {
            return 0.0;
        }
        let place = grid.place(column as usize, row as usize);
        if !model.ground.is_free(place) {
            return 0.0;
        }
        self.planes[heading].stored(place).map_or(self.asleep, |stored| self.value(stored))
    }

    /// What lies around the tiles that are awake.
    pub(super) fn surroundings<'m>(&self, model: &'m LocalizationModel) -> Surroundings<'m> {
        let stored = |value: f64| ((value - self.floor) / self.factor) as f32;
        Surroundings {
            grid: &model.grid,
            ground: &model.ground,
            instructions: model.instructions,
            quiet: stored(self.asleep),
            loud: stored(self.threshold),
        }
    }

    /// Eq. (2), selectively by Eqs. (3) and (4), and normalizes: takes in a scan of each sensor of the
    /// model, one after the other. Missing readings and scans count for nothing. Tells how much better than on the
    /// average over all states the scans fit: the logarithm of their evidence by their average weight.
    ///
    /// # Deviation
    /// After the scans a share of the uniform distribution is mixed in.
    pub(super) fn sense(&mut self, model: &LocalizationModel, scans: &[BinnedScan]) -> f64 {
        self.sense_weighed(model, scans, model.parameters.mixing, |_| Weighing::USUAL)
    }

    /// The same with the scan of each sensor weighed in a way of its own, and another share of the uniform distribution.
    pub(super) fn sense_weighed(
        &mut self,
        model: &LocalizationModel,
        scans: &[BinnedScan],
        mixed: f64,
        weighing: impl Fn(usize) -> Weighing,
    ) -> f64 {
        let readings = |scan: &BinnedScan| -> Vec<(usize, u8)> {
            scan.iter().enumerate().filter_map(|(beam, bin)| bin.map(|bin| (beam, bin))).collect()
        };
        let sensors = 0..model.sensors.len();
        let mut heard: Vec<(usize, Vec<(usize, u8)>)> = sensors.zip(scans.iter().map(readings)).collect();
        heard.retain(|(_, readings)| !readings.is_empty());
        let Some((last, readings)) = heard.pop() else {
            return self.sense_scan(model, 0, &[], Weighing::USUAL, 0.0);
        };
        let mut fit = 0.0;
        for (sensor, readings) in heard {
            fit += self.sense_scan(model, sensor, &readings, weighing(sensor), 0.0);
        }
        fit + self.sense_scan(model, last, &readings, weighing(last), mixed)
    }

    /// Eq. (2) for the readings of one sensor; `mixed` is the share of the uniform distribution.
    fn sense_scan(
        &mut self,
        model: &LocalizationModel,
        sensor: usize,
        readings: &[(usize, u8)],
        weighing: Weighing,
        mixed: f64,
    ) -> f64 {
        let average = if readings.is_empty() { 1.0 } else { model.average_weight(sensor, readings, weighing) };
        let stored = Stored { terms: self.terms(), average, threshold: self.threshold };
        weigh_planes(&mut self.planes, model, &model.sensors[sensor], readings, weighing, stored);
        self.weighed(model, average, f64::from(LIFT), mixed)
    }

    /// Takes in that all tiles were weighed and are stored `lift` times as large, and normalizes; what sleeps is
    /// multiplied by the average weight. Tells the logarithm of the evidence by the average weight.
    pub(super) fn weighed(&mut self, model: &LocalizationModel, average: f64, lift: f64, mixed: f64) -> f64 {
        (self.factor, self.floor) = (1.0, 0.0);
        self.asleep *= average * lift;
        let awake: f64 = self.tiles().map(|tile| tile.mass).sum();
        let evidence = awake + self.mass_asleep(model);
        if evidence > LEAST_EVIDENCE {
            self.normalize(model, evidence, mixed);
            libm::log(evidence / (average * lift))
        } else {
            *self = Self::uniform(model);
            0.0
        }
    }

    /// Eq. (2) for a scan of each sensor in metres, every finite reading of it.
    pub fn sense_ranges(&mut self, model: &LocalizationModel, scans_m: &[Option<&[f32]>]) {
        self.sense(model, &model.binned(scans_m));
    }

    /// Mixes a share of the uniform distribution into the belief.
    pub fn mix(&mut self, model: &LocalizationModel, share: f64) {
        if share >= 1.0 {
            // A factor of 0 could not be taken out again when a neighbour is blended in.
            *self = Self::uniform(model);
            return;
        }
        self.sense_scan(model, 0, &[], Weighing::USUAL, share);
    }

    /// Divides by the evidence, mixes, and lets tiles fall asleep or wake up.
    fn normalize(&mut self, model: &LocalizationModel, evidence: f64, mixed: f64) {
        let scale = (1.0 - mixed) / evidence;
        let add = mixed * model.prior();
        self.factor *= scale;
        self.floor = self.floor * scale + add;
        self.asleep = self.asleep * scale + add;
        self.wake_what_must(model);
        self.put_to_sleep(model);
    }

    /// How many states are worth at least a bound.
    pub(super) fn states_above(&self, bound: f64) -> usize {
        let above = |cell: &&f32| self.value(**cell) >= bound;
        let tiles = self.tiles().filter(|tile| self.value(tile.peak) >= bound);
        tiles.map(|tile| tile.cells.iter().filter(above).count()).sum()
    }
}

fn normal(sigmas: f64) -> f64 {
    libm::exp(-0.5 * sigmas * sigmas)
}
