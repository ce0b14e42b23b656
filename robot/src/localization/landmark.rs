//! A landmark that was seen, as one more beam: how likely each state is by it.

use super::belief::Belief;
use super::grid::{Place, TILE, TILE_EDGE};
use super::kernel;
use super::model::LocalizationModel;
use super::summary::NEAR_M;
use super::tile::Tile;
use crate::geometry::{Point, Pose, Transform, Vector};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// How far what a camera tells of a landmark is off, as standard deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LandmarkNoise {
    /// Of its bearing.
    pub bearing_rad: f64,
    /// Of its distance: an error of part of a pixel, which grows with the square of the distance ...
    pub range_per_m2: f64,
    /// ... and never is less.
    pub least_range_m: f64,
}

impl LandmarkNoise {
    /// Set for the camera of `pioneer-2dx`; a test of [`vision`](crate::vision) holds it against the errors in 400
    /// places.
    pub const USUAL: LandmarkNoise = LandmarkNoise { bearing_rad: 0.004, range_per_m2: 0.012, least_range_m: 0.02 };

    /// Of a distance.
    pub fn range_m(&self, off_m: f64) -> f64 {
        self.least_range_m + self.range_per_m2 * off_m * off_m
    }
}

/// The share of all sightings that are of something else: a colour by chance, a sheet that hangs elsewhere by now.
const MISTAKEN: f64 = 0.1;

/// A sheet is seen from so far aside of its wall, as the sine of the angle to it, at the least.
const LEAST_ASLANT: f64 = 0.15;

/// What hides a landmark is at least so far off its wall, and off the robot.
const BETWEEN_M: f64 = 0.2;

/// Weights farther off than this many standard deviations are those of a mistake.
const DEVIATIONS: f64 = 4.0;

/// A sheet that was seen, and the landmarks that it may be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LandmarkSighting {
    /// Where it was seen from the robot.
    pub at_in_base: Point,
    /// Where landmarks that look like it hang, and where they face.
    pub candidates_in_map: Vec<Pose>,
}

/// Where a robot of some heading stands that sees a landmark so, and how surely.
struct Spot {
    in_map: Point,
    /// To the landmark, of unit length.
    towards: Vector,
    along_m: f64,
    across_m: f64,
}

impl Spot {
    /// The likelihood of a point, 1 at the spot.
    fn likelihood(&self, point_in_map: Point) -> f64 {
        let off = point_in_map - self.in_map;
        let along = off.dot(&self.towards) / self.along_m;
        let across = off.perp(&self.towards) / self.across_m;
        libm::exp(-0.5 * (along * along + across * across))
    }

    fn reach_m(&self) -> f64 {
        DEVIATIONS * self.along_m.max(self.across_m)
    }
}

impl LocalizationModel {
    /// Where a robot of this heading sees one of the landmarks so.
    fn spots(&self, sighting: &LandmarkSighting, heading_rad: f64) -> Vec<Spot> {
        let off_m = sighting.at_in_base.coords.norm();
        let noise = LandmarkNoise::USUAL;
        let part = |step: f64| step * step / 12.0;
        let cell = part(self.grid.cell_m);
        let deviation = |deviation_m: f64| libm::sqrt(deviation_m * deviation_m + cell);
        let bearing_rad = libm::sqrt(noise.bearing_rad * noise.bearing_rad + part(self.grid.angle_step_rad()));
        let (along_m, across_m) = (deviation(noise.range_m(off_m)), deviation(bearing_rad * off_m));
        let to_sheet = Transform::new(Pose::new(0.0, 0.0, heading_rad)).apply(sighting.at_in_base).coords;
        let towards = to_sheet / off_m.max(f64::MIN_POSITIVE);
        let spot = |landmark_in_map: &Pose| {
            let (sin, cos) = libm::sincos(landmark_in_map.heading_rad);
            let is_before = -towards.dot(&Vector::new(cos, sin)) > LEAST_ASLANT;
            let at = landmark_in_map.point();
            let between_m = off_m - 2.0 * BETWEEN_M;
            let sees = |from: Point| {
                self.distances.cast_m(from, (-towards.x, -towards.y), between_m)
                    >= between_m - self.distances.resolution_m
            };
            (is_before && (between_m <= 0.0 || sees(at - towards * BETWEEN_M))).then(|| Spot {
                in_map: at - to_sheet,
                towards,
                along_m,
                across_m,
            })
        };
        sighting.candidates_in_map.iter().filter_map(spot).collect()
    }

    /// Whether one of the landmarks that a sighting may be of is seen so from about a pose, within 0.5 m.
    pub(super) fn explains(&self, pose_in_map: Pose, sighting: &LandmarkSighting) -> bool {
        let spots = self.spots(sighting, pose_in_map.heading_rad);
        spots.iter().any(|spot| (spot.in_map - pose_in_map.point()).norm() <= NEAR_M)
    }

    fn admissible_m2(&self) -> f64 {
        self.ground.cells() as f64 * self.grid.cell_m * self.grid.cell_m
    }
}

impl Belief {
    /// Eq. (2) for a landmark that was seen from where the robot was at the last update. A state is as likely as a
    /// camera there tells such a bearing and distance of one of the candidates that it can see; but a sighting may
    /// be a mistake, which any state explains alike. Cost: a pass over the tiles that are awake.
    pub(super) fn see(&mut self, model: &LocalizationModel, sighting: &LandmarkSighting) {
        let headings: Vec<f64> = (0..self.planes.len()).map(|heading| self.heading_rad(model, heading)).collect();
        let terms = self.terms();
        let mut average = MISTAKEN;
        for (plane, heading_rad) in self.planes.iter_mut().zip(headings) {
            let spots = model.spots(sighting, heading_rad);
            let volume_m2 = |spot: &Spot| std::f64::consts::TAU * spot.along_m * spot.across_m;
            average += spots.iter().map(volume_m2).sum::<f64>() / model.admissible_m2() / model.grid.headings as f64;
            let seen = Seen { model, spots: &spots, terms };
            if plane.is_active() {
                let offset_cells = plane.offset_cells;
                plane.tiles_mut().iter_mut().for_each(|tile| seen.weigh(tile, offset_cells));
            }
        }
        self.weighed(model, average, 1.0, 0.0);
    }
}

/// A landmark that is seen from some spots.
struct Seen<'m> {
    model: &'m LocalizationModel,
    spots: &'m [Spot],
    /// Factor and floor by which cells are read.
    terms: [f32; 2],
}

impl Seen<'_> {
    /// Weighs every cell of a tile by what is seen from it; one from which two may be it counts by the likelier.
    fn weigh(&self, tile: &mut Tile, offset_cells: [f64; 2]) {
        let Some(ground) = self.model.ground.tile(tile.number) else { return };
        let mut likelihoods = [0.0; TILE];
        for spot in self.spots {
            self.add(spot, tile.number, offset_cells, &mut likelihoods);
        }
        let cells = Arc::make_mut(&mut tile.cells);
        kernel::apply_terms(cells, &ground.admissible, self.terms);
        let mistaken = MISTAKEN as f32;
        cells.iter_mut().zip(likelihoods).for_each(|(cell, likelihood)| {
            *cell *= mistaken + (1.0 - mistaken) * likelihood as f32;
        });
        let extent = kernel::extent(cells);
        (tile.mass, tile.peak) = (extent.mass, extent.peak);
    }

    /// The likelihoods of the cells of a tile that are near a spot.
    fn add(&self, spot: &Spot, tile: u32, [dx, dy]: [f64; 2], likelihoods: &mut [f64; TILE]) {
        let grid = &self.model.grid;
        let (x, y) = grid.fractional(spot.in_map);
        let reach = spot.reach_m() / grid.cell_m;
        let [first_column, first_row] = grid.column_and_row(Place { tile: tile as usize, cell: 0 });
        let along = |middle: f64, first: i64| {
            let within = |place: f64| (place - first as f64).clamp(0.0, TILE_EDGE as f64) as usize;
            within(libm::ceil(middle - reach))..within(libm::floor(middle + reach + 1.0))
        };
        for row in along(y - dy, first_row) {
            for column in along(x - dx, first_column) {
                let (x, y) = ((first_column + column as i64) as f64 + dx, (first_row + row as i64) as f64 + dy);
                let likelihood = spot.likelihood(grid.origin_in_map + Vector::new(x, y) * grid.cell_m);
                let before = &mut likelihoods[row * TILE_EDGE + column];
                *before = before.max(likelihood);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::localization::{Localization, LocalizationParameters, Spread};
    use crate::occupancy::{Cell, OccupancyGrid};
    use std::f64::consts::PI;

    /// A landmark at the west end of a bare hall of 12 × 3 m, and one beside it that a wall of 1 m hides from most of
    /// the hall.
    const WEST: Pose = Pose { x_m: 0.1, y_m: 1.5, heading_rad: 0.0 };
    const HIDDEN: Pose = Pose { x_m: 2.1, y_m: 0.1, heading_rad: PI / 2.0 };

    fn model() -> LocalizationModel {
        let mut map = OccupancyGrid::filled(Point::origin(), 0.1, 120, 30, Cell::Free);
        for (column, row) in (0..120).flat_map(|column| (0..30).map(move |row| (column, row))) {
            let is_edge = column == 0 || column == 119 || row == 0 || row == 29;
            if is_edge || column == 24 && row < 10 {
                map.set(column, row, Cell::Occupied);
            }
        }
        let parameters = LocalizationParameters {
            cell_m: 0.2,
            angle_step_deg: 5,
            activity_threshold: 0.0,
            ..LocalizationParameters::default()
        };
        LocalizationModel::new(&map, parameters).expect("it is a map")
    }

    fn seen_from(robot_in_map: Pose, landmark: Pose) -> LandmarkSighting {
        let at_in_base = robot_in_map.inverse().transform(landmark.point());
        LandmarkSighting { at_in_base, candidates_in_map: vec![WEST, HIDDEN] }
    }

    #[test]
    fn every_state_gains_as_it_sees_a_landmark_there_and_all_sum_to_one() {
        let model = model();
        let truth = Pose::new(3.1, 1.3, 2.9);
        let sighting = LandmarkSighting { candidates_in_map: vec![WEST], ..seen_from(truth, WEST) };
        let mut belief = Belief::uniform(&model);
        belief.see(&model, &sighting);
        assert!((belief.mass(&model) - 1.0).abs() < 1e-4, "{}", belief.mass(&model));
        let states = belief.all_states(&model);
        let most = states.iter().map(|at| at.share).fold(0.0, f64::max);
        let mistaken = most * MISTAKEN;
        for at in &states {
            // Where the camera would see it from there.
            let centre = model.grid.centre(at.state.column, at.state.row);
            let pose = Pose::new(centre.x, centre.y, model.grid.heading_rad(at.state.heading));
            let seen = pose.inverse().transform(WEST.point());
            let off_m = (seen - sighting.at_in_base).norm();
            match off_m {
                // The wall hides it from farther south.
                near if near < 0.1 && centre.y > 1.2 => assert!(at.share > 0.5 * most, "{at:?}"),
                far if far > 1.5 => assert!(at.share < 2.0 * mistaken, "{at:?}"),
                _ => {}
            }
        }
    }

    #[test]
    fn what_a_wall_hides_is_not_seen() {
        let model = model();
        let probability = |pose: Pose| {
            let mut belief = Belief::uniform(&model);
            belief.see(&model, &seen_from(pose, HIDDEN));
            belief.probability(&model, model.state_at(pose).expect("on the map"))
        };
        let before = probability(Pose::new(1.7, 1.1, -70f64.to_radians()));
        let behind = probability(Pose::new(3.5, 0.5, -165f64.to_radians()));
        assert!(before > 5.0 * behind, "{before} {behind}");
    }

    #[test]
    fn along_a_bare_hall_a_landmark_sets_the_position_right_and_counts_once_for_each_update() {
        let model = model();
        let (believed, truth) = (Pose::new(6.0, 1.5, PI), Pose::new(5.2, 1.5, PI));
        let spread = Spread { position_m: 0.4, ..Spread::default() };
        let mut localization = Localization::start_at(&model, believed, spread);
        let mut odometry = Pose::default();
        let scan = |pose: Pose| -> Vec<f32> {
            let expected = model.expected_scan(0, model.state_at(pose).expect("on the map")).into_iter();
            expected.map(|bin| model.sensors[0].likelihood.range_m(bin) as f32).collect()
        };
        for _ in 0..8 {
            odometry = odometry.compose(Pose::new(0.2, 0.0, 0.0));
            let here = truth.compose(odometry);
            localization.observe(&model, odometry, &[Some(&scan(here))]);
            assert!(localization.see(&model, &[seen_from(here, WEST)]));
            let before = localization.clone();
            assert!(!localization.see(&model, &[seen_from(here, WEST)]));
            assert_eq!(localization, before);
        }
        let estimate = localization.estimate(&model);
        assert!(estimate.pose_in_map.distance_m(truth.compose(odometry)) < 0.15, "{estimate:?}");
    }
}
