//! How much of what is seen is not in the map: a map that has aged.

use super::contest::{for_each_unexplained, middle_of_region};
use super::model::LocalizationModel;
use super::sensor::BinnedScan;
use crate::geometry::{Point, Pose};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What was seen this many updates ago counts for 1/e.
const UPDATES: f64 = 200.0;

/// The fewest updates that tell of a map.
const LEAST_UPDATES: f64 = 50.0;

/// Regions that hold less of a reading than this are forgotten.
const LEAST_READINGS: f64 = 0.5;

/// Updates of late at places that were sure, their readings, and those that the map does not explain.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct MapFit {
    updates: f64,
    readings: f64,
    /// Where the map is wrong: something stands there and is not in it, or is in it and gone; by region.
    unexplained: BTreeMap<[i64; 2], f64>,
    /// Their share.
    misfit: f64,
}

impl MapFit {
    /// Takes in a scan of each sensor at a pose that is sure. O(beams + regions).
    pub(super) fn hear(&mut self, model: &LocalizationModel, pose_in_map: Pose, scans: &[BinnedScan]) {
        let kept = libm::exp(-1.0 / UPDATES);
        let heard = scans.iter().flatten().flatten().count();
        self.readings = kept * self.readings + heard as f64;
        self.updates = kept * self.updates + 1.0;
        self.unexplained.values_mut().for_each(|readings| *readings *= kept);
        let Some(state) = model.state_at(pose_in_map) else { return };
        for_each_unexplained(model, pose_in_map, state, scans, |reading| {
            *self.unexplained.entry(reading.region).or_default() += 1.0;
        });
        self.unexplained.retain(|_, readings| *readings >= LEAST_READINGS);
        self.misfit = if self.updates >= LEAST_UPDATES {
            self.unexplained.values().sum::<f64>() / self.readings.max(1.0)
        } else {
            0.0
        };
    }

    /// The share of the readings of late that the map does not explain; 0 before there were many: a few scans tell of one
    /// place and nothing of the map.
    pub(super) fn misfit(&self) -> f64 {
        self.misfit
    }

    /// Where these are, each with how many lie there.
    pub(super) fn unexplained(&self) -> impl Iterator<Item = (Point, f64)> {
        self.unexplained.iter().map(|(&region, &readings)| (middle_of_region(region), readings))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::localization::{LocalizationParameters, ScanParameters};
    use crate::occupancy::{Cell, OccupancyGrid};
    use crate::sensors::LaserScanner;

    /// A room of 8 × 8 m with a box, as its lower left corner.
    fn room(box_m: [f64; 2]) -> LocalizationModel {
        let mut map = OccupancyGrid::filled(Point::origin(), 0.1, 81, 81, Cell::Free);
        for (column, row) in (0..81).flat_map(|row| (0..81).map(move |column| (column, row))) {
            let at = map.centre(column, row);
            let in_box = (box_m[0]..box_m[0] + 1.5).contains(&at.x) && (box_m[1]..box_m[1] + 1.5).contains(&at.y);
            if column % 80 == 0 || row % 80 == 0 || in_box {
                map.set(column, row, Cell::Occupied);
            }
        }
        let sensors = vec![ScanParameters::laser(&LaserScanner { readings: 181, resolution_deg: 1.0, range_m: 8.0 })];
        LocalizationModel::new(
            &map,
            LocalizationParameters { sensors, watch: None, ..LocalizationParameters::default() },
        )
        .expect("it is a map")
    }

    fn fit(model: &LocalizationModel, truth: &LocalizationModel, updates: usize) -> MapFit {
        let mut fit = MapFit::default();
        for update in 0..updates {
            let pose = Pose::new(2.0 + 0.15 * (update % 20) as f64, 1.5, std::f64::consts::FRAC_PI_2);
            let scan = truth.expected_scan(0, truth.state_at(pose).expect("a pose on the map"));
            fit.hear(model, pose, &[scan.into_iter().map(Some).collect()]);
        }
        fit
    }

    #[test]
    fn a_box_that_was_moved_is_told_with_where_it_was_and_where_it_is() {
        let (model, truth) = (room([2.0, 5.0]), room([5.0, 5.0]));
        assert_eq!(fit(&model, &model, 100).misfit(), 0.0);
        let moved = fit(&model, &truth, 100);
        assert!((0.1..0.6).contains(&moved.misfit()), "{}", moved.misfit());
        let near = |at: [f64; 2]| {
            let is_near = |point: &Point| (at[0]..at[0] + 1.5).contains(&point.x) && (4.5..6.5).contains(&point.y);
            moved.unexplained().filter(|(point, _)| is_near(point)).map(|(_, readings)| readings).sum::<f64>()
        };
        assert!(near([2.0, 5.0]) > 20.0 && near([5.0, 5.0]) > 20.0, "{moved:?}");
    }

    #[test]
    fn a_few_scans_tell_nothing_of_the_map_and_what_was_seen_long_ago_is_forgotten() {
        let (model, truth) = (room([2.0, 5.0]), room([5.0, 5.0]));
        assert_eq!(fit(&model, &truth, 20).misfit(), 0.0);
        let mut fit = fit(&model, &truth, 100);
        let before = fit.misfit();
        let away = Pose::new(6.0, 6.0, -std::f64::consts::FRAC_PI_2);
        let scan = vec![model.expected_scan(0, model.state_at(away).expect("a pose")).into_iter().map(Some).collect()];
        (0..600).for_each(|_| fit.hear(&model, away, &scan));
        assert!(fit.misfit() < before / 10.0);
    }
}
