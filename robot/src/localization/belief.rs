//! The belief and its two updates.

use super::grid::{BeliefGrid, Place, State, TILE_EDGE};
use super::ground::{Cells, GroundTile};
use super::kernel::LIFT;
use super::model::LocalizationModel;
use super::motion::{Share, Spare, Surroundings};
use super::parameters::{OdometryError, Spread};
use super::plane::Plane;
use super::scan::Weighing;
use super::sensor::BinnedScan;
use super::tile::Tile;
use super::weigh::{Stored, TILES_FOR_THREADS, weigh_planes};
use crate::geometry::{Pose, wrap_angle_rad};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Noise of the heading is applied once it reaches this variance, in squared angle steps.
const HEADING_BLUR_AT: f64 = 0.1;

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
    threshold: f64,
    /// Rotation that is not yet applied, in angle steps, at most one half.
    pub(super) heading_offset: f64,
    /// Variance of the rotation that is not yet applied, in squared angle steps.
    heading_variance: f64,
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
    fn asleep(model: &LocalizationModel) -> Self {
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

    /// The belief of another grid over the same map: every state takes the density of the state of
    /// the other grid it lies in.
    pub(super) fn resampled(model: &LocalizationModel, other: &Self, other_model: &LocalizationModel) -> Self {
        let grid = &model.grid;
        // What a state of the other grid is worth in this one.
        let ratio = model.prior() / other_model.prior();
        let resampled = |heading: usize| -> Plane {
            let tiles = model.ground.tiles().filter_map(|(number, ground)| {
                let cells = other.density(other_model, heading, grid, number, model.threshold() / ratio)?;
                let tile =
                    Tile::new(number, std::array::from_fn(|cell| cells[cell] * ratio as f32 * ground.admissible[cell]));
                (f64::from(tile.peak) >= model.threshold()).then_some(tile)
            });
            Plane::of(tiles.collect())
        };
        // The other grid may have fewer headings: each of its planes is resampled once.
        let sources: Vec<Plane> = (0..other.planes.len()).into_par_iter().map(resampled).collect();
        let mut belief = Self::asleep(model);
        for (heading, plane) in belief.planes.iter_mut().enumerate() {
            *plane = sources[other.plane_at(other_model, grid.angle_step_rad() * heading as f64)].clone();
        }
        belief.asleep = ratio * other.mean_below(other_model, model.threshold() / ratio);
        belief.sense(model, &[]);
        belief
    }

    /// Probabilities of the states that the cells of a tile of another grid lie in: of the likeliest beside one that
    /// cannot be stood in, because at a wall a point may be free whose coarse cell is not. None if all are below a
    /// bound.
    fn density(
        &self,
        model: &LocalizationModel,
        heading: usize,
        grid: &BeliefGrid,
        number: u32,
        bound: f64,
    ) -> Option<Cells> {
        let offset = self.planes[heading].offset_cells;
        let corner = Place { tile: number as usize, cell: 0 };
        let [column, row] = grid.column_and_row(corner);
        let nearest = |along: i64, axis: usize| -> i64 {
            let at = grid.origin_in_map[axis] + along as f64 * grid.cell_m - model.grid.origin_in_map[axis];
            libm::round(at / model.grid.cell_m - offset[axis]) as i64
        };
        let columns: [i64; TILE_EDGE] = std::array::from_fn(|at| nearest(column + at as i64, 0));
        let rows: [i64; TILE_EDGE] = std::array::from_fn(|at| nearest(row + at as i64, 1));
        let [columns_around, rows_around] = [&columns, &rows].map(|places| places[0] - 1..=places[TILE_EDGE - 1] + 1);
        if self.highest_within(model, heading, columns_around, rows_around) < bound {
            return None;
        }
        let at = |column: i64, row: i64| self.probability_at(model, heading, [column, row]);
        let likeliest = |column: i64, row: i64| {
            let here = at(column, row);
            let beside = || [at(column + 1, row), at(column - 1, row), at(column, row + 1), at(column, row - 1)];
            if here > 0.0 { here } else { beside().into_iter().fold(0.0, f64::max) }
        };
        Some(std::array::from_fn(|cell| likeliest(columns[cell % TILE_EDGE], rows[cell / TILE_EDGE]) as f32))
    }

    /// The average probability of the states that are below a bound; 0 if none is.
    fn mean_below(&self, model: &LocalizationModel, bound: f64) -> f64 {
        let (mut mass, mut cells) = (0.0, 0_usize);
        let mut add = |value: f64, count: usize| {
            if value < bound {
                mass += value * count as f64;
                cells += count;
            }
        };
        add(self.asleep, self.cells_asleep(model));
        for tile in self.tiles() {
            let free = model.ground.tile(tile.number).into_iter().flat_map(GroundTile::free);
            free.for_each(|cell| add(self.value(tile.cells[cell]), 1));
        }
        mass / cells.max(1) as f64
    }

    /// At least the probability of the likeliest state in the tiles of a plane that some columns and rows meet.
    fn highest_within(
        &self,
        model: &LocalizationModel,
        heading: usize,
        columns: RangeInclusive<i64>,
        rows: RangeInclusive<i64>,
    ) -> f64 {
        let met = |tile: &&Tile| model.grid.meets(tile.number, &columns, &rows);
        let peaks = self.planes[heading].tiles.iter().filter(met).map(|tile| self.value(tile.peak));
        peaks.fold(self.asleep, f64::max)
    }

    /// The plane whose heading is nearest.
    fn plane_at(&self, model: &LocalizationModel, heading_rad: f64) -> usize {
        let steps = libm::round(heading_rad / model.grid.angle_step_rad() - self.heading_offset) as i64;
        steps.rem_euclid(model.grid.headings as i64) as usize
    }

    /// The planes, by heading.
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// All tiles that are awake, plane by plane.
    pub(super) fn tiles(&self) -> impl Iterator<Item = &Tile> {
        self.planes.iter().flat_map(|plane| plane.tiles.iter())
    }

    /// How many states are asleep.
    pub(super) fn cells_asleep(&self, model: &LocalizationModel) -> usize {
        let awake = self.tiles().filter_map(|tile| model.ground.tile(tile.number)).map(|ground| ground.cells);
        (model.ground.cells() * self.planes.len()).saturating_sub(awake.sum())
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

    /// Eq. (1) for a motion measured in the frame of the robot before it, by odometry that errs so.
    ///
    /// # Deviation
    /// A motion moves planes by whole cells and headings by whole steps; the rest is kept beside
    /// each plane as the true place of its cells, and noise is kept until it amounts to something.
    /// Interpolating at each step instead would blur by up to a quarter of a squared cell, far
    /// more than odometry errs. What moves into walls is lost until the next normalization. What
    /// mixing has added, the same everywhere, stays.
    pub fn advance(&mut self, model: &LocalizationModel, motion: Pose, error: &OdometryError) {
        let grid = &model.grid;
        let [forward, sideward, heading] = error.variances(motion);
        let [forward, sideward] = [forward, sideward].map(|variance| variance / (grid.cell_m * grid.cell_m));
        let headings: Vec<f64> = (0..grid.headings).map(|heading| self.heading_rad(model, heading)).collect();
        let around = self.surroundings(model);
        update_planes(&mut self.planes, |heading, plane, spare| {
            let (sin, cos) = libm::sincos(headings[heading]);
            plane.offset_cells[0] += (cos * motion.x_m - sin * motion.y_m) / grid.cell_m;
            plane.offset_cells[1] += (sin * motion.x_m + cos * motion.y_m) / grid.cell_m;
            plane.variance_cells[0] += cos * cos * forward + sin * sin * sideward;
            plane.variance_cells[1] += sin * sin * forward + cos * cos * sideward;
            around.apply_motion(plane, spare);
        });
        self.rotate(model, motion.heading_rad);
        self.heading_variance += heading / (grid.angle_step_rad() * grid.angle_step_rad());
        while self.heading_variance >= HEADING_BLUR_AT {
            let variance = self.heading_variance.min(0.5);
            self.heading_variance -= variance;
            self.blur_headings(model, variance / 2.0);
        }
    }

    /// Turns every hypothesis alike: planes change places.
    fn rotate(&mut self, model: &LocalizationModel, turn_rad: f64) {
        self.heading_offset += turn_rad / model.grid.angle_step_rad();
        let whole = libm::round(self.heading_offset);
        self.heading_offset -= whole;
        self.planes.rotate_right((whole as i64).rem_euclid(model.grid.headings as i64) as usize);
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

    /// Spreads every plane by `[g, 1 − 2g, g]` over its neighbours in heading, aligned by where their cells really are.
    fn blur_headings(&mut self, model: &LocalizationModel, spread: f64) {
        let around = self.surroundings(model);
        let count = self.planes.len();
        // Stretches of planes, each between the planes before and after it as they were.
        let length =
            if is_for_threads(&self.planes) { count.div_ceil(2 * rayon::current_num_threads()) } else { count };
        let ends = (0..count).step_by(length).map(|first| {
            let next = (first + length).min(count) % count;
            [&self.planes[(first + count - 1) % count], &self.planes[next]].map(Plane::clone)
        });
        let ends: Vec<[Plane; 2]> = ends.collect();
        let blur = |(planes, [before, after]): (&mut [Plane], [Plane; 2])| {
            blur_stretch(&around, planes, before, &after, spread as f32);
        };
        if length < count {
            self.planes.par_chunks_mut(length).zip(ends).for_each(blur);
        } else {
            self.planes.chunks_mut(length).zip(ends).for_each(blur);
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

    /// Changes θ, a probability, from that of the model it was made for; what is to sleep or to wake by it does when the
    /// belief is next updated by a scan or mixed. With 0 nothing sleeps.
    pub fn sleep_below(&mut self, threshold: f64) {
        self.threshold = threshold;
    }

    /// Whether what sleeps is worth θ, and is to be looked at somehow.
    pub(super) fn is_adrift(&self, model: &LocalizationModel) -> bool {
        model.sleeps() && self.asleep >= self.threshold
    }

    /// Brings back every tile in which somebody can stand, if what sleeps is worth θ and nobody else looks at it.
    fn wake_what_must(&mut self, model: &LocalizationModel) {
        if self.asleep < self.threshold || model.watch.is_some() && model.sleeps() {
            return;
        }
        let quiet = self.surroundings(model).quiet;
        let missing = |plane: &Plane| plane.tiles.len() < model.ground.numbers().len();
        if !self.planes.iter().any(missing) {
            return;
        }
        let fresh: Vec<Tile> =
            model.ground.tiles().map(|(number, ground)| Tile::new(number, ground.filled(quiet))).collect();
        for plane in self.planes.iter_mut().filter(|plane| missing(plane)) {
            let tiles = fresh.iter().map(|fresh| plane.tile(fresh.number).unwrap_or(fresh).clone());
            plane.tiles = Arc::new(tiles.collect());
        }
    }

    /// Brings back the tiles within a distance and an angle of a pose, if what sleeps is worth θ.
    pub(super) fn wake_near(&mut self, model: &LocalizationModel, pose_in_map: Pose, radius_m: f64, angle_rad: f64) {
        if !self.is_adrift(model) {
            return;
        }
        let quiet = self.surroundings(model).quiet;
        let (column, row) = model.grid.fractional(pose_in_map.point());
        let reach = radius_m / model.grid.cell_m;
        let [columns, rows] =
            [column, row].map(|middle| libm::floor(middle - reach) as i64..=libm::ceil(middle + reach) as i64);
        let near = |number: &u32| model.grid.meets(*number, &columns, &rows);
        let numbers: Vec<u32> = model.ground.numbers().iter().copied().filter(near).collect();
        for heading in 0..self.planes.len() {
            let away_rad = wrap_angle_rad(self.heading_rad(model, heading) - pose_in_map.heading_rad);
            let plane = &mut self.planes[heading];
            if libm::fabs(away_rad) > angle_rad || numbers.iter().all(|&number| plane.tile(number).is_some()) {
                continue;
            }
            let missing = numbers.iter().filter(|&&number| plane.tile(number).is_none());
            let fresh = missing.filter_map(|&number| Some(Tile::new(number, model.ground.tile(number)?.filled(quiet))));
            let fresh: Vec<Tile> = fresh.collect();
            let tiles = plane.tiles_mut();
            tiles.extend(fresh);
            tiles.sort_by_key(|tile| tile.number);
        }
    }

    /// How many states are worth at least a bound.
    pub(super) fn states_above(&self, bound: f64) -> usize {
        let above = |cell: &&f32| self.value(**cell) >= bound;
        let tiles = self.tiles().filter(|tile| self.value(tile.peak) >= bound);
        tiles.map(|tile| tile.cells.iter().filter(above).count()).sum()
    }

    /// How much of the belief sleeps.
    pub(super) fn mass_asleep(&self, model: &LocalizationModel) -> f64 {
        self.asleep * self.cells_asleep(model) as f64
    }

    /// Puts tiles whose cells are all below θ together with what sleeps.
    fn put_to_sleep(&mut self, model: &LocalizationModel) {
        let is_quiet = |tile: &Tile| self.value(tile.peak) < self.threshold;
        let quiet: Vec<&Tile> = self.tiles().filter(|tile| is_quiet(tile)).collect();
        if quiet.is_empty() {
            return;
        }
        let before = self.cells_asleep(model) as f64;
        let cells: usize =
            quiet.iter().filter_map(|tile| model.ground.tile(tile.number)).map(|ground| ground.cells).sum();
        let mass: f64 = quiet.iter().map(|tile| self.mass_of(model, tile)).sum();
        self.asleep = (self.asleep * before + mass) / (before + cells as f64);
        let (factor, floor, threshold) = (self.factor, self.floor, self.threshold);
        let stays = |tile: &Tile| factor * f64::from(tile.peak) + floor >= threshold;
        for plane in self.planes.iter_mut().filter(|plane| !plane.tiles.iter().all(stays)) {
            plane.tiles_mut().retain(stays);
        }
    }
}

fn normal(sigmas: f64) -> f64 {
    libm::exp(-0.5 * sigmas * sigmas)
}

/// Spreads planes over their neighbours in turn, between one that was before them and one after them.
fn blur_stretch(around: &Surroundings, planes: &mut [Plane], mut before: Plane, after: &Plane, spread: f32) {
    let mut spare = Spare::default();
    for heading in 0..planes.len() {
        let own = planes[heading].clone();
        let shares = [&before, planes.get(heading + 1).unwrap_or(after)].map(|plane| {
            let away = |axis: usize| plane.offset_cells[axis] - own.offset_cells[axis];
            Share { plane, by_cells: [0, 1].map(|axis| libm::round(away(axis)) as i64) }
        });
        if own.is_active() || shares.iter().any(|share| share.plane.is_active()) {
            planes[heading].tiles = around.blended(&own, &shares, spread, &mut spare);
        }
        spare.keep(std::mem::replace(&mut before, own).tiles);
    }
}

/// Whether there is enough to do for several threads.
fn is_for_threads(planes: &[Plane]) -> bool {
    let tiles: usize = planes.iter().map(|plane| plane.tiles.len()).sum();
    tiles >= TILES_FOR_THREADS && rayon::current_num_threads() > 1
}

/// Visits every plane, on several threads if many tiles are awake. A plane never looks at another one,
/// so the threads do not change the result.
fn update_planes(planes: &mut [Plane], update: impl Fn(usize, &mut Plane, &mut Spare) + Sync) {
    if is_for_threads(planes) {
        let planes = planes.par_iter_mut().enumerate();
        planes.for_each_init(Spare::default, |spare, (heading, plane)| update(heading, plane, spare));
    } else {
        let mut spare = Spare::default();
        planes.iter_mut().enumerate().for_each(|(heading, plane)| update(heading, plane, &mut spare));
    }
}
