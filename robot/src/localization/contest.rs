//! Whether scans of late speak for another place than the tracked one, or for a map that has aged.

use super::belief::Belief;
use super::grid::State;
use super::landmark::LandmarkSighting;
use super::model::LocalizationModel;
use super::parameters::OdometryError;
use super::sensor::BinnedScan;
use super::summary::Maximum;
use crate::geometry::{Point, Pose, wrap_angle_rad};
use serde::{Deserialize, Serialize};
use std::cell::LazyCell;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, VecDeque};

/// Updates that are kept: what they have told of one place.
pub(super) const KEPT_UPDATES: usize = 40;

/// Edge of a region of the map, of which it is one question whether it has changed.
const REGION_M: f64 = 1.0;

/// A reading that fits worse than this, in nats, needs an explanation.
const LEAST_NATS: f64 = 2.0;

/// What it costs at the most that a thing of the map is gone from a region: the negative logarithm of how often that is so.
const GONE_NATS: f64 = 3.5;

/// The same for something that stands in a region and is not in the map, furniture or people.
const NEW_NATS: f64 = 2.3;

/// The same for a landmark that was seen where none is.
const MISTAKEN_NATS: f64 = 2.3;

/// Another place must explain scans better by this, in nats: a robot is seldom carried away. Chosen, not fitted.
const CARRIED_NATS: f64 = 16.0;

/// And it must leave no more than this share of what the tracked one costs: how much of the map has changed is not known,
/// and where much has, all places cost much, and one of the wrong ones less than the right one.
const MOST_SHARE: f64 = 0.4;

/// And it must do so over as many updates: what was moved near by is in all scans from one spot.
const LEAST_UPDATES: usize = 6;

/// The same of the best of all places there are, of which nobody has objected with one: of thousands some fit well by
/// chance.
const ANYWHERE_NATS: f64 = 24.0;

/// Of a robot that gets no nearer it is likelier that it is elsewhere: then this is enough, whatever its share.
const HELD_UP_NATS: f64 = 8.0;

/// Another place is searched for so far around a pose of the coarse grid, in cells and steps of the fine one ...
const FIRST_AROUND: [i64; 2] = [1, 2];

/// ... and so far from where odometry leads from there.
const AROUND: [i64; 2] = [1, 1];

/// Why another place is compared with the tracked one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Claim {
    /// The coarse belief objects with it.
    Objection,
    /// It is one of all places.
    Review,
    /// The same, and the robot gets no nearer where it takes itself to be.
    HeldUp,
}

/// What comes of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// The robot is not where it is tracked.
    Won,
    /// A place is better over the last few updates, too few to tell.
    Pending,
    /// No place is better by enough.
    Dismissed,
}

/// What one update had.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Heard {
    /// As odometry told it.
    motion: Pose,
    /// The tracked pose after it.
    tracked_in_map: Pose,
    scans: Vec<BinnedScan>,
    /// Landmarks that were seen then.
    sightings: Vec<LandmarkSighting>,
}

/// The scans of late.
///
/// # Deviation
/// The papers multiply the likelihoods of all scans, as if the errors of each were its own. But where a piece of
/// furniture was moved, all scans from around there err alike, and of two rooms that are alike the wrong one gains scan by
/// scan. Here it is asked of each region of the map once whether it has changed, and that costs the same however often it
/// is looked at; the test is one of generalized likelihood ratios over the time at which the robot may have been carried
/// away (Willsky and Jones, "A generalized likelihood ratio approach to the detection and estimation of jumps in linear
/// systems", 1976).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Contest {
    /// The oldest first.
    heard: VecDeque<Heard>,
}

impl Contest {
    /// Takes in the scans of an update after a motion, and where the robot is tracked to be since.
    pub(super) fn hear(&mut self, motion: Pose, tracked_in_map: Pose, scans: &[BinnedScan]) {
        if self.heard.len() == KEPT_UPDATES {
            self.heard.pop_front();
        }
        self.heard.push_back(Heard { motion, tracked_in_map, scans: scans.to_vec(), sightings: Vec::new() });
    }

    /// Takes in a landmark that was seen at the last update.
    pub(super) fn see(&mut self, sighting: &LandmarkSighting) {
        if let Some(last) = self.heard.back_mut() {
            last.sightings.push(sighting.clone());
        }
    }

    /// Nothing is tracked any more.
    pub(super) fn forget(&mut self) {
        self.heard.clear();
    }

    /// Whether anything has been heard.
    pub(super) fn can_be_held(&self) -> bool {
        !self.heard.is_empty()
    }

    /// Whether the scans are so badly explained at the tracked poses that another place may win. O(updates · beams).
    pub(super) fn may_be_won(&self, model: &LocalizationModel) -> bool {
        let tracked: Vec<Pose> = self.heard.iter().rev().map(|heard| heard.tracked_in_map).collect();
        self.costs(model, &tracked).last().is_some_and(|&nats| nats >= CARRIED_NATS)
    }

    /// A coarse belief of a robot that knows nothing but these scans, wherever it is; what is less likely than θ sleeps.
    /// Cost: an update of all states, and more of those that do not sleep.
    pub(super) fn heard_anywhere(&self, coarse: &LocalizationModel, error: &OdometryError, threshold: f64) -> Belief {
        let mut belief = Belief::uniform(coarse);
        belief.sleep_below(threshold);
        for heard in &self.heard {
            belief.advance(coarse, heard.motion, error);
            belief.sense(coarse, &heard.scans);
            heard.sightings.iter().for_each(|sighting| belief.see(coarse, sighting));
        }
        belief
    }

    /// Whether one of some places explains the scans since some update so much better than the tracked one that the robot
    /// must have been carried there. O(updates · beams · places).
    pub(super) fn verdict(&self, model: &LocalizationModel, places: &[Maximum], claim: Claim) -> Verdict {
        let (least_nats, most_share) = match claim {
            Claim::Objection => (CARRIED_NATS, MOST_SHARE),
            Claim::Review => (ANYWHERE_NATS, MOST_SHARE),
            Claim::HeldUp => (HELD_UP_NATS, 1.0),
        };
        let tracked: Vec<Pose> = self.heard.iter().rev().map(|heard| heard.tracked_in_map).collect();
        let own = self.costs(model, &tracked);
        // Over how many updates a place is better, at the most.
        let longest = |place: &Maximum| {
            let costs = self.costs(model, &self.tracked_back(model, place.pose_in_map));
            let is_better = |(own, other): (&f64, f64)| own - other >= least_nats && other <= most_share * own;
            own.iter().zip(costs).rposition(is_better).map_or(0, |last| last + 1)
        };
        match places.iter().map(longest).max().unwrap_or(0) {
            0 => Verdict::Dismissed,
            updates if updates < LEAST_UPDATES => Verdict::Pending,
            _ => Verdict::Won,
        }
    }

    /// The pose at each update, the last first, of a robot that is about a place after the last one: by odometry, which
    /// errs, and each time where the scan fits best near there. The tracked pose has followed the scans as well.
    fn tracked_back(&self, model: &LocalizationModel, last_in_map: Pose) -> Vec<Pose> {
        let mut by_motion = last_in_map;
        let mut around = FIRST_AROUND;
        let back = self.heard.iter().rev().map(|heard| {
            let here = fitted(model, by_motion, &heard.scans, std::mem::replace(&mut around, AROUND));
            by_motion = here.compose(heard.motion.inverse());
            here
        });
        back.collect()
    }

    /// What it costs to explain the last scans, all from the last one on, the last two, and so on, at poses.
    fn costs(&self, model: &LocalizationModel, poses: &[Pose]) -> Vec<f64> {
        let (mut regions, mut nats) = (BTreeMap::<[i64; 2], f64>::new(), 0.0);
        let costs = self.heard.iter().rev().zip(poses).map(|(heard, &pose)| {
            nats += explained(model, pose, &heard.scans, &mut regions);
            let unexplained = heard.sightings.iter().filter(|sighting| !model.explains(pose, sighting));
            nats += MISTAKEN_NATS * unexplained.count() as f64;
            nats
        });
        costs.collect()
    }
}

/// The pose around one, within some cells and steps of the heading, that fits scans best.
fn fitted(model: &LocalizationModel, pose_in_map: Pose, scans: &[BinnedScan], [cells, steps]: [i64; 2]) -> Pose {
    let (cell_m, step_rad) = (model.grid.cell_m, model.grid.angle_step_rad());
    let by = |count: i64| -count..=count;
    let around = by(cells).flat_map(|x| by(cells).map(move |y| (x, y)));
    let around = around.flat_map(|(x, y)| by(steps).map(move |turn| (x, y, turn)));
    let poses = around.map(|(x, y, turn)| {
        let [x_m, y_m] = [x, y].map(|cells| cells as f64 * cell_m);
        let heading_rad = wrap_angle_rad(pose_in_map.heading_rad + turn as f64 * step_rad);
        Pose::new(pose_in_map.x_m + x_m, pose_in_map.y_m + y_m, heading_rad)
    });
    let fits = poses.filter_map(|pose| Some((pose, model.misfit(pose, scans)?.nats)));
    fits.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(pose_in_map, |(pose, _)| pose)
}

/// What a scan adds to what was to be explained of the regions of the map, in nats.
fn explained(
    model: &LocalizationModel,
    pose_in_map: Pose,
    scans: &[BinnedScan],
    regions: &mut BTreeMap<[i64; 2], f64>,
) -> f64 {
    let state = model.state_at(pose_in_map).filter(|state| model.is_admissible(state.column, state.row));
    // Nobody can stand there.
    let Some(state) = state else { return CARRIED_NATS };
    let mut added = 0.0;
    for_each_unexplained(model, pose_in_map, state, scans, |reading| {
        let most = if reading.is_gone { GONE_NATS } else { NEW_NATS };
        // One reading may be an outlier, the echo of a detour.
        match regions.entry(reading.region) {
            Entry::Vacant(entry) => _ = entry.insert(0.0),
            Entry::Occupied(mut entry) => {
                let more = reading.nats.min(most - *entry.get()).max(0.0);
                *entry.get_mut() += more;
                added += more;
            }
        }
    });
    added
}

/// A reading that does not fit.
pub(super) struct Unexplained {
    /// Where the map would be wrong.
    pub region: [i64; 2],
    /// Whether something would be gone from there, not new there.
    pub is_gone: bool,
    /// How badly it fits.
    pub nats: f64,
}

/// The readings of scans at a pose that need an explanation.
pub(super) fn for_each_unexplained(
    model: &LocalizationModel,
    pose_in_map: Pose,
    state: State,
    scans: &[BinnedScan],
    mut take: impl FnMut(Unexplained),
) {
    let headings = model.grid.headings;
    for (sensor, (tables, scan)) in model.sensors.iter().zip(scans).enumerate() {
        let beam = &tables.parameters.beam;
        let expected = model.expected_scan(sensor, state);
        // Along a wall half a step of the heading makes metres.
        let beside = LazyCell::new(|| {
            [1, headings - 1].map(|turn| {
                let heading = (state.heading + turn) % headings;
                model.expected_scan(sensor, State { heading, ..state })
            })
        });
        for (index, (&measured, &bearing_deg)) in scan.iter().zip(&tables.parameters.beams_deg).enumerate() {
            let Some(measured) = measured else { continue };
            let expected = expected[index];
            let nats = tables.likelihood.nats(measured, expected);
            if nats < LEAST_NATS {
                continue;
            }
            let nats = beside.iter().map(|scan| tables.likelihood.nats(measured, scan[index])).fold(nats, f64::min);
            if nats < LEAST_NATS {
                continue;
            }
            let is_gone = measured > expected;
            let seen = if is_gone { expected } else { measured };
            // Of an echo of a cone the middle of its arc is taken.
            let range_m = tables.likelihood.range_m(seen) + beam.mount_radius_m;
            let (sin, cos) = libm::sincos(pose_in_map.heading_rad + f64::from(bearing_deg).to_radians());
            let at_m = [pose_in_map.x_m + range_m * cos, pose_in_map.y_m + range_m * sin];
            let region = at_m.map(|along_m| libm::floor(along_m / REGION_M) as i64);
            take(Unexplained { region, is_gone, nats });
        }
    }
}

/// In the map.
pub(super) fn middle_of_region([column, row]: [i64; 2]) -> Point {
    let middle_m = |index: i64| (index as f64 + 0.5) * REGION_M;
    Point::new(middle_m(column), middle_m(row))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::localization::{LocalizationParameters, ScanParameters};
    use crate::occupancy::{Cell, OccupancyGrid};
    use crate::sensors::LaserScanner;

    fn laser() -> ScanParameters {
        ScanParameters::laser(&LaserScanner { readings: 181, resolution_deg: 1.0, range_m: 8.0 })
    }

    /// Rays, and cones.
    fn kinds() -> [ScanParameters; 2] {
        [laser(), ScanParameters::default()]
    }

    /// Two rooms of 6 × 6 m beside each other, with boxes, as lower left corners, and a sensor.
    fn rooms(boxes_m: &[[f64; 2]], sensor: &ScanParameters) -> LocalizationModel {
        let sensors = vec![sensor.clone()];
        let parameters = LocalizationParameters { sensors, watch: None, ..LocalizationParameters::default() };
        LocalizationModel::new(&rooms_map(boxes_m), parameters).expect("it is a map")
    }

    fn rooms_map(boxes_m: &[[f64; 2]]) -> OccupancyGrid {
        let mut map = OccupancyGrid::filled(Point::origin(), 0.1, 121, 61, Cell::Free);
        for (column, row) in (0..61).flat_map(|row| (0..121).map(move |column| (column, row))) {
            let at = map.centre(column, row);
            let in_box = |[x_m, y_m]: [f64; 2]| (x_m..x_m + 1.0).contains(&at.x) && (y_m..y_m + 1.0).contains(&at.y);
            if column % 60 == 0 || row % 60 == 0 || boxes_m.iter().copied().any(in_box) {
                map.set(column, row, Cell::Occupied);
            }
        }
        map
    }

    /// Whether a robot that is tracked in the left room, driving up, and sees what is to be seen from there or from
    /// elsewhere, is taken to be in the right one.
    fn is_carried(model: &LocalizationModel, truth: &LocalizationModel, updates: usize, from: Pose) -> bool {
        let mut contest = Contest::default();
        let motion = Pose::new(0.15, 0.0, 0.0);
        let (mut seen_from, mut tracked) = (from, Pose::new(2.0, 1.5, std::f64::consts::FRAC_PI_2));
        let other = Pose::new(tracked.x_m + 6.0, tracked.y_m, tracked.heading_rad);
        let mut place = other;
        for _ in 0..updates {
            let state = truth.state_at(seen_from).expect("a pose on the map");
            contest.hear(motion, tracked, &[truth.expected_scan(0, state).into_iter().map(Some).collect()]);
            (seen_from, tracked, place) = (seen_from.compose(motion), tracked.compose(motion), place.compose(motion));
        }
        let last_in_map = place.compose(motion.inverse());
        contest.verdict(model, &[Maximum { pose_in_map: last_in_map, mass: 0.5 }], Claim::Objection) == Verdict::Won
    }

    #[test]
    fn a_box_that_was_moved_does_not_carry_the_robot_away_however_long_it_is_looked_at() {
        for sensor in kinds() {
            let model = rooms(&[[3.0, 4.0], [10.0, 4.0]], &sensor);
            let truth = rooms(&[[1.0, 4.2], [10.0, 4.0]], &sensor);
            let here = Pose::new(2.0, 1.5, std::f64::consts::FRAC_PI_2);
            for updates in [1, 5, 15] {
                assert!(!is_carried(&model, &truth, updates, here), "{updates}, {}", sensor.beam.cone_deg);
            }
        }
    }

    #[test]
    fn a_robot_that_was_carried_is_told_by_few_scans() {
        for sensor in kinds() {
            let model = rooms(&[[3.0, 2.0], [0.5, 4.0], [10.0, 4.4], [9.6, 1.0]], &sensor);
            let there = Pose::new(8.0, 1.5, std::f64::consts::FRAC_PI_2);
            assert!(!is_carried(&model, &model, LEAST_UPDATES - 1, there), "all from about one spot");
            assert!(is_carried(&model, &model, LEAST_UPDATES, there), "{}", sensor.beam.cone_deg);
        }
    }

    #[test]
    fn one_region_costs_the_same_however_often_it_is_seen() {
        let model = rooms(&[[3.0, 4.0], [10.0, 4.0]], &laser());
        let truth = rooms(&[[-5.0, 4.0], [10.0, 4.0]], &laser());
        let pose = Pose::new(2.0, 1.5, std::f64::consts::FRAC_PI_2);
        let state = truth.state_at(pose).expect("a pose on the map");
        let scan: BinnedScan = truth.expected_scan(0, state).into_iter().map(Some).collect();
        let mut regions = BTreeMap::new();
        let costs: Vec<f64> =
            (0..20).map(|_| explained(&model, pose, std::slice::from_ref(&scan), &mut regions)).collect();
        assert!(costs.iter().sum::<f64>() > 0.0 && costs[19] == 0.0, "{costs:?}");
        assert!(regions.values().all(|&nats| nats <= GONE_NATS));
    }

    #[test]
    fn along_a_wall_a_step_of_the_heading_needs_no_explanation_and_three_do() {
        let model = rooms(&[], &laser());
        // Rays along the wall that is 0.4 m to the left end metres apart from each other.
        let cost_turned = |steps: f64| {
            let turned = Pose::new(2.0, 5.6, steps * model.grid.angle_step_rad());
            let state = model.state_at(turned).expect("a pose on the map");
            let scan = [model.expected_scan(0, state).into_iter().map(Some).collect()];
            // The first reading that needs an explanation has none for its own.
            let (at, mut regions) = (Pose::new(2.0, 5.6, 0.0), BTreeMap::new());
            (0..2).map(|_| explained(&model, at, &scan, &mut regions)).sum::<f64>()
        };
        assert_eq!([-1.0, 0.0, 1.0].map(cost_turned), [0.0; 3]);
        assert!(cost_turned(3.0) > 0.0);
    }

    #[test]
    fn a_belief_from_anywhere_names_the_place_of_which_the_scans_tell() {
        let boxes_m = [[3.0, 2.0], [0.5, 4.0], [10.0, 4.4], [9.6, 1.0]];
        for sensor in kinds() {
            let model = rooms(&boxes_m, &sensor);
            let parameters = LocalizationParameters { sensors: vec![sensor], ..LocalizationParameters::default() };
            let watching = LocalizationModel::new(&rooms_map(&boxes_m), parameters).expect("it is a map");
            let coarse = watching.watch.as_ref().expect("a coarse belief watches");
            let mut contest = Contest::default();
            let (mut here, motion) = (Pose::new(8.0, 1.5, std::f64::consts::FRAC_PI_2), Pose::new(0.15, 0.0, 0.0));
            let tracked = Pose::new(2.0, 1.5, std::f64::consts::FRAC_PI_2);
            for _ in 0..12 {
                here = here.compose(motion);
                let scan = model.expected_scan(0, model.state_at(here).expect("a pose on the map"));
                contest.hear(motion, tracked, &[scan.into_iter().map(Some).collect()]);
            }
            assert!(contest.may_be_won(&model));
            let anywhere = contest.heard_anywhere(coarse, &coarse.parameters.odometry, 1e-3 * coarse.prior());
            let best = anywhere.maxima(coarse, 1, 0.1)[0].pose_in_map;
            assert!(best.distance_m(here) < 0.5, "{best:?}, {here:?}");
            assert_eq!(contest.verdict(&model, &anywhere.maxima(coarse, 3, 0.01), Claim::Review), Verdict::Won);
        }
    }
}
