//! What is kept of a drive for registration: scans and where they were taken.

use rpl_robot::geometry::{Pose, wrap_angle_rad};
use rpl_robot::sensors::{SonarArray, SonarScan};
use serde::{Deserialize, Serialize};

/// After moving or turning by this the sonars have another view.
const VIEW_M: f64 = 0.025;
const VIEW_RAD: f64 = 0.05;

/// Views from farther back on the way are dropped: over a longer way dead reckoning bends the walls.
const KEPT_M: f64 = 2.0;

/// More are not kept, however the robot turned on the spot.
const MOST_VIEWS: usize = 120;

/// One scan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct View {
    pub from_in_odom: Pose,
    /// The way driven until then.
    pub driven_m: f64,
    pub ranges_m: Vec<f32>,
}

impl View {
    pub fn scan<'a>(&'a self, sonars: &'a SonarArray) -> SonarScan<'a> {
        SonarScan { sonars, ranges_m: &self.ranges_m }
    }
}

/// The latest scans, oldest first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Views {
    kept: Vec<View>,
    last_in_odom: Option<Pose>,
    driven_m: f64,
}

impl Views {
    /// Takes in a scan. One from where the last was taken replaces it: what stood there may have gone.
    pub fn take_in(&mut self, from_in_odom: Pose, scan: SonarScan<'_>) {
        self.driven_m += self.last_in_odom.map_or(0.0, |last| from_in_odom.distance_m(last));
        self.last_in_odom = Some(from_in_odom);
        let view = View { from_in_odom, driven_m: self.driven_m, ranges_m: scan.ranges_m.to_vec() };
        let is_new = |before: &View| {
            let turned_rad = wrap_angle_rad(from_in_odom.heading_rad - before.from_in_odom.heading_rad).abs();
            from_in_odom.distance_m(before.from_in_odom) >= VIEW_M || turned_rad >= VIEW_RAD
        };
        match self.kept.len().checked_sub(2).map(|before_last| &self.kept[before_last]) {
            Some(before_last) if !is_new(before_last) => {
                self.kept.pop();
            }
            Some(_) | None => {}
        }
        self.kept.push(view);
        let driven_m = self.driven_m;
        self.kept.retain(|view| driven_m - view.driven_m <= KEPT_M);
        if self.kept.len() > MOST_VIEWS {
            self.kept.remove(0);
        }
    }

    /// The way driven since the start.
    pub fn driven_m(&self) -> f64 {
        self.driven_m
    }

    /// The way on which the scans were taken that are kept.
    pub fn way_m(&self) -> f64 {
        self.kept.first().map_or(0.0, |first| self.driven_m - first.driven_m)
    }

    /// Those of the last part of the way, of this length.
    pub fn latest(&self, way_m: f64) -> &[View] {
        let first = self.kept.partition_point(|view| self.driven_m - view.driven_m > way_m);
        &self.kept[first..]
    }

    /// How much the robot turned, to and fro alike, on the last part of the way, of this length.
    pub fn turned_since_rad(&self, way_m: f64) -> f64 {
        let turn_rad =
            |pair: &[View]| wrap_angle_rad(pair[1].from_in_odom.heading_rad - pair[0].from_in_odom.heading_rad).abs();
        self.latest(way_m).windows(2).map(turn_rad).sum()
    }

    /// Drops what is older.
    pub fn forget_before(&mut self, way_m: f64) {
        let driven_m = self.driven_m;
        self.kept.retain(|view| driven_m - view.driven_m <= way_m);
    }
}
