//! From blobs to sheets on walls: in which direction each is seen and how far off, and which are none.

use super::back_projection::{Blob, blobs};
use super::histogram::Histogram;
use crate::geometry::Point;
use crate::sensors::{CameraImage, CameraView, Pixel};
use crate::world::{Landmark, MarkerColour};

/// A sheet of a known colour and size that hangs upright on a wall, at a known height: what is looked for.
#[derive(Clone, Debug, PartialEq)]
pub struct WallMark {
    /// Its colour ...
    pub colour: MarkerColour,
    /// ... as a camera sees it.
    pub colours: Histogram,
    /// Along the wall.
    pub width_m: f64,
    /// From its lower edge to its upper one.
    pub height_m: f64,
    /// The lower edge, over the floor.
    pub bottom_m: f64,
}

/// What is less high or less wide in an image says nothing of its distance.
const FEWEST_ROWS: f64 = 4.0;
const FEWEST_COLUMNS: usize = 3;

/// The least share of its width that a sheet seen aslant shows; and edges may be a pixel off.
const NARROWEST: f64 = 0.25;

/// The pixels between its edges are nearly all of the sheet.
const FILLED: f64 = 0.75;

/// Its middle is at its height to within this, and this much more for each metre it is off.
const AT_HEIGHT_M: f64 = 0.05;
const AT_HEIGHT_PER_M: f64 = 0.03;

/// The most of an image that sheets fill.
const IN_VIEW: f64 = 0.5;

impl WallMark {
    /// What a landmark looks like.
    pub fn of(landmark: &Landmark) -> Self {
        let Landmark { width_m, height_m, bottom_m, colour, .. } = *landmark;
        Self { colour, colours: Histogram::of_marker(colour), width_m, height_m, bottom_m }
    }

    /// Whether a landmark looks like this.
    pub fn is_of(&self, landmark: &Landmark) -> bool {
        (self.colour, self.width_m, self.height_m, self.bottom_m)
            == (landmark.colour, landmark.width_m, landmark.height_m, landmark.bottom_m)
    }
}

/// The middles of all sheets of this kind in an image, in the frame `pan`, the nearest first.
///
/// How far off one is follows from how high it is in the image, whatever the angle it is seen at; whether it is
/// one, from the height it would then hang at and from its width. Sheets that the edge of the image cuts are left
/// out. Cost: a pass over the image.
pub fn wall_sightings(mark: &WallMark, view: &CameraView, image: &CameraImage) -> Vec<Point> {
    let rows = 0..image.rows();
    let model = mark.colours.scaled_to(IN_VIEW * (view.columns * view.rows) as f64);
    let mut middles: Vec<Point> =
        blobs(&model, image, rows).iter().filter_map(|blob| sighting(mark, view, blob)).collect();
    middles.sort_by(|a, b| a.coords.norm_squared().total_cmp(&b.coords.norm_squared()));
    middles
}

fn sighting(mark: &WallMark, view: &CameraView, blob: &Blob) -> Option<Point> {
    let (across, down) = (blob.columns(), blob.rows());
    let is_cut = down.start == 0 || down.end == view.rows || across.start == 0 || across.end == view.columns;
    let (pixels, columns) = (blob.pixels.len(), across.len());
    let rows = pixels as f64 / columns as f64;
    if is_cut || columns < FEWEST_COLUMNS || rows < FEWEST_ROWS || rows < FILLED * down.len() as f64 {
        return None;
    }
    let mean =
        |part: fn(&(usize, usize)) -> usize| blob.pixels.iter().map(part).sum::<usize>() as f64 / pixels as f64 + 0.5;
    let (column, row) = (mean(|pixel| pixel.0), mean(|pixel| pixel.1));
    let [top, bottom] = [row - rows / 2.0, row + rows / 2.0].map(|row| view.sight(Pixel { column, row }));
    let range_m = mark.height_m / (bottom.drop_per_m - top.drop_per_m);
    let middle = view.sight(Pixel { column, row });
    let off_height_m = view.height_m - middle.drop_per_m * range_m - (mark.bottom_m + mark.height_m / 2.0);
    let [left, right] = [across.start, across.end].map(|column| view.sight(Pixel { column: column as f64, row }));
    let width_m = range_m * (left.direction - right.direction).norm();
    let pixel_m = width_m / columns as f64;
    let is_one = off_height_m.abs() <= AT_HEIGHT_M + AT_HEIGHT_PER_M * range_m
        && (NARROWEST * mark.width_m - pixel_m..=mark.width_m + 2.0 * pixel_m).contains(&width_m);
    is_one.then(|| Point::from(middle.direction * range_m))
}

#[cfg(test)]
mod tests;
