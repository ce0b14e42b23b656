//! Which parts of a belief sleep, and when they wake.

use super::belief::Belief;
use super::model::LocalizationModel;
use super::plane::Plane;
use super::tile::Tile;
use crate::geometry::{Pose, wrap_angle_rad};
use std::sync::Arc;

impl Belief {
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
    pub(super) fn wake_what_must(&mut self, model: &LocalizationModel) {
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

    /// How many states are asleep.
    pub(super) fn cells_asleep(&self, model: &LocalizationModel) -> usize {
        let awake = self.tiles().filter_map(|tile| model.ground.tile(tile.number)).map(|ground| ground.cells);
        (model.ground.cells() * self.planes.len()).saturating_sub(awake.sum())
    }

    /// How much of the belief sleeps.
    pub(super) fn mass_asleep(&self, model: &LocalizationModel) -> f64 {
        self.asleep * self.cells_asleep(model) as f64
    }

    /// Puts tiles whose cells are all below θ together with what sleeps.
    pub(super) fn put_to_sleep(&mut self, model: &LocalizationModel) {
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
