//! Which sightings are one marker.

use rpl_robot::geometry::{Point, Pose, distance_m};
use rpl_robot::sensors::CameraView;
use rpl_robot::vision::FloorSighting;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A marker that was seen in several images.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SeenMarker {
    /// How many were seen before it.
    pub number: u64,
    /// Where it lies.
    pub at_in_odom: Point,
    /// In how many images it was found.
    pub images: u32,
    /// In how many it should have been, and was not: something stood before it.
    pub missed: u32,
    /// The sum of what each image counts for its place.
    weight: f64,
}

/// A sighting within this is of the same marker. Doors, and so their markers, are farther apart.
const SAME_M: f64 = 0.4;

/// Fewer images may be chance.
const FEWEST_IMAGES: u32 = 3;

/// Of the images it should be in, it must be in one of this many.
const ONE_OF: u32 = 3;

/// What is farther off than this has been passed, or was given up.
const FAR_M: f64 = 8.0;

/// A marker should be seen if it is this many pixels within the edge of the image, and as many rows within those
/// looked at.
const WITHIN: f64 = 6.0;

/// Farther markers have so few pixels that one may be missed.
const SURELY_SEEN_M: f64 = 2.8;

impl SeenMarker {
    /// Whether it is no chance.
    fn is_sure(&self) -> bool {
        self.images >= FEWEST_IMAGES && ONE_OF * self.images >= self.images + self.missed
    }

    fn is_nothing(&self) -> bool {
        ONE_OF * self.images + FEWEST_IMAGES < self.images + self.missed
    }
}

/// All that may be markers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Tracks {
    seen: Vec<SeenMarker>,
    /// How many there were so far.
    count: u64,
}

impl Tracks {
    pub fn markers(&self) -> impl Iterator<Item = &SeenMarker> {
        self.seen.iter().filter(|marker| marker.is_sure())
    }

    /// Takes in what was found in some rows of an image.
    pub fn take_in(&mut self, view: &CameraView, rows: Range<usize>, pan_in_odom: Pose, sightings: &[FloorSighting]) {
        let should_see = |marker: &SeenMarker| is_in_view(view, &rows, pan_in_odom, marker.at_in_odom);
        let mut is_due: Vec<bool> = self.seen.iter().map(should_see).collect();
        for sighting in sightings {
            let at_in_odom = pan_in_odom.transform(sighting.at_in_pan);
            // What a pixel more or less moves grows with the square of the distance.
            let off_m2 = sighting.at_in_pan.coords.norm_squared();
            let weight = 1.0 / (off_m2 * off_m2);
            match self.nearest(at_in_odom) {
                Some(index) => {
                    self.seen[index].add(at_in_odom, weight);
                    if let Some(due) = is_due.get_mut(index) {
                        *due = false;
                    }
                }
                None => {
                    self.seen.push(SeenMarker { number: self.count, at_in_odom, images: 1, missed: 0, weight });
                    self.count += 1;
                }
            }
        }
        for (marker, _) in self.seen.iter_mut().zip(is_due).filter(|(_, is_due)| *is_due) {
            marker.missed += 1;
        }
        let here = pan_in_odom.point();
        self.seen.retain(|marker| !marker.is_nothing() && distance_m(marker.at_in_odom, here) <= FAR_M);
    }

    fn nearest(&self, at_in_odom: Point) -> Option<usize> {
        let off_m = |marker: &SeenMarker| distance_m(marker.at_in_odom, at_in_odom);
        let near = self.seen.iter().enumerate().filter(|(_, marker)| off_m(marker) <= SAME_M);
        near.min_by(|(_, a), (_, b)| off_m(a).total_cmp(&off_m(b))).map(|(index, _)| index)
    }
}

impl SeenMarker {
    fn add(&mut self, at_in_odom: Point, weight: f64) {
        self.weight += weight;
        self.at_in_odom += (at_in_odom - self.at_in_odom) * (weight / self.weight);
        self.images += 1;
    }
}

fn is_in_view(view: &CameraView, rows: &Range<usize>, pan_in_odom: Pose, at_in_odom: Point) -> bool {
    let at_in_pan = pan_in_odom.inverse().transform(at_in_odom);
    let Some(pixel) = view.pixel_of(at_in_pan) else { return false };
    let within = |value: f64, edges: Range<f64>| (edges.start + WITHIN..edges.end - WITHIN).contains(&value);
    at_in_pan.coords.norm() < SURELY_SEEN_M
        && within(pixel.column, 0.0..view.columns as f64)
        && within(pixel.row, rows.start as f64..rows.end as f64)
}
