//! From blobs to sheets on the floor: where each lies, and which are none.

use super::back_projection::{Blob, blobs};
use super::histogram::Histogram;
use crate::geometry::{Point, Vector};
use crate::sensors::{CameraImage, CameraView, Pixel};
use crate::world::MarkerColour;
use std::ops::Range;

/// A sheet of a known colour and size that lies on the floor: what is looked for.
#[derive(Clone, Debug, PartialEq)]
pub struct FloorMark {
    /// Its colours, as often as they occur in it.
    pub colours: Histogram,
    /// Length of its sides.
    pub size_m: f64,
}

impl FloorMark {
    /// A marker of a colour and size.
    pub fn marker(colour: MarkerColour, size_m: f64) -> Self {
        Self { colours: Histogram::of_marker(colour), size_m }
    }
}

/// A sheet that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FloorSighting {
    /// Its middle, in the frame `pan`.
    pub at_in_pan: Point,
    /// How many pixels it has.
    pub pixels: usize,
}

/// A blob of fewer pixels says nothing of its shape.
const FEWEST_PIXELS: usize = 4;

/// A sheet may be cut by what stands before it, and pixels at its edge are of two colours: the least and the greatest
/// share of its true area that is seen.
const AREA: [f64; 2] = [0.2, 1.7];

/// How many times its true length it is at most, beside what a pixel more at each end makes.
const LENGTH: f64 = 1.5;

/// Two sheets and their edges at most are in view at once, as near as can be.
const IN_VIEW: f64 = 2.0;

/// All sheets of this kind in some rows of an image, the nearest first.
///
/// What lies flat covers as much of the floor as it is large; what stands upright is seen before the floor
/// behind it, and would be metres long if it lay there. Blobs at the edge of the rows are left out: what is
/// beyond is not known. Cost: some 10 µs for 1,600 pixels.
pub fn floor_sightings(
    mark: &FloorMark,
    view: &CameraView,
    image: &CameraImage,
    rows: Range<usize>,
) -> Vec<FloorSighting> {
    let nearest = Pixel { column: view.columns as f64 / 2.0, row: rows.end as f64 };
    let Some(nearest) = view.floor_point(nearest) else { return Vec::new() };
    let model = mark.colours.scaled_to(IN_VIEW * pixels_at(mark.size_m, view, nearest));
    let found = blobs(&model, image, rows.clone());
    let mut sightings: Vec<FloorSighting> = found.iter().filter_map(|blob| sighting(mark, view, &rows, blob)).collect();
    let off_m2 = |sighting: &FloorSighting| sighting.at_in_pan.coords.norm_squared();
    sightings.sort_by(|a, b| off_m2(a).total_cmp(&off_m2(b)));
    sightings
}

/// How many pixels a sheet has that lies straight ahead.
fn pixels_at(size_m: f64, view: &CameraView, middle_in_pan: Point) -> f64 {
    let corner = |ahead: f64, left: f64| {
        let reach = Vector::new(ahead, left) * (size_m / 2.0);
        view.pixel_of(middle_in_pan + reach)
    };
    let corners = (corner(1.0, 0.0), corner(-1.0, 0.0), corner(0.0, 1.0), corner(0.0, -1.0));
    let (Some(far), Some(near), Some(left), Some(right)) = corners else { return 0.0 };
    (near.row - far.row) * (right.column - left.column)
}

fn sighting(mark: &FloorMark, view: &CameraView, rows: &Range<usize>, blob: &Blob) -> Option<FloorSighting> {
    let (across, down) = (blob.columns(), blob.rows());
    let is_cut = down.start == rows.start || down.end == rows.end || across.start == 0 || across.end == view.columns;
    if blob.pixels.len() < FEWEST_PIXELS || is_cut {
        return None;
    }
    let (mut area_m2, mut moment) = (0.0, Vector::zeros());
    for &(column, row) in &blob.pixels {
        let (middle, pixel_m2) = footprint(view, column, row)?;
        area_m2 += pixel_m2;
        moment += middle.coords * pixel_m2;
    }
    let at_in_pan = Point::from(moment / area_m2);
    let share = area_m2 / (mark.size_m * mark.size_m);
    let is_flat = length_m(view, &across, &down)? <= LENGTH * mark.size_m + 2.0 * row_m(view, &across, down.start)?;
    ((AREA[0]..=AREA[1]).contains(&share) && is_flat).then_some(FloorSighting { at_in_pan, pixels: blob.pixels.len() })
}

/// Middle and area of the floor that a pixel shows, in `pan`.
fn footprint(view: &CameraView, column: usize, row: usize) -> Option<(Point, f64)> {
    let at =
        |right: f64, below: f64| view.floor_point(Pixel { column: column as f64 + right, row: row as f64 + below });
    let across = at(1.0, 0.5)? - at(0.0, 0.5)?;
    let along = at(0.5, 0.0)? - at(0.5, 1.0)?;
    Some((at(0.5, 0.5)?, (across.x * along.y - across.y * along.x).abs()))
}

/// How far a blob would reach over the floor, away from the camera.
fn length_m(view: &CameraView, across: &Range<usize>, down: &Range<usize>) -> Option<f64> {
    let column = (across.start + across.end) as f64 / 2.0;
    let off_m = |row: usize| view.floor_point(Pixel { column, row: row as f64 }).map(|point| point.coords.norm());
    Some(off_m(down.start)? - off_m(down.end)?)
}

/// How much of the floor a row shows.
fn row_m(view: &CameraView, across: &Range<usize>, row: usize) -> Option<f64> {
    length_m(view, across, &(row..row + 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::RobotDescription;

    const PINK: [u8; 3] = [250, 45, 150];

    fn view() -> CameraView {
        RobotDescription::builtin("b21-camera").and_then(|robot| robot.camera).expect("it has one").view
    }

    fn mark() -> FloorMark {
        FloorMark::marker(MarkerColour::Pink, 0.3)
    }

    /// An image in which the pixels are pink that look at something, given by its floor point and pixel.
    fn image(is_pink: impl Fn(Point, Pixel) -> bool) -> CameraImage {
        let view = view();
        let pixel = |number: usize| {
            let (column, row) = (number % view.columns, number / view.columns);
            let middle = Pixel { column: column as f64 + 0.5, row: row as f64 + 0.5 };
            let floor = view.floor_point(middle).expect("it looks down");
            if is_pink(floor, middle) { PINK } else { [110, 112, 115] }
        };
        CameraImage { columns: view.columns, rgb: (0..view.columns * view.rows).flat_map(pixel).collect() }
    }

    fn sheet(middle: Point, size_m: f64) -> impl Fn(Point, Pixel) -> bool {
        move |floor, _| (floor - middle).amax() <= size_m / 2.0
    }

    fn found(image: &CameraImage) -> Vec<FloorSighting> {
        floor_sightings(&mark(), &view(), image, 0..view().rows)
    }

    #[test]
    fn a_sheet_on_the_floor_is_found_where_it_lies() {
        for (ahead_m, left_m) in [(1.1, 0.2), (1.5, -0.5), (2.0, 0.6), (2.5, -0.9), (3.0, 0.0), (3.5, 1.2)] {
            let at = Point::new(ahead_m, left_m);
            let found = found(&image(sheet(at, 0.3)));
            assert_eq!(found.len(), 1, "{at}: {found:?}");
            let off_m = crate::geometry::distance_m(found[0].at_in_pan, at);
            assert!(off_m < 0.04 * ahead_m, "{at} found at {}", found[0].at_in_pan);
        }
    }

    #[test]
    fn two_sheets_are_two_and_the_nearest_comes_first() {
        let (near, far) = (sheet(Point::new(1.4, 0.5), 0.3), sheet(Point::new(2.6, -0.9), 0.3));
        let found = found(&image(|floor, pixel| near(floor, pixel) || far(floor, pixel)));
        assert_eq!(found.len(), 2);
        assert!(found[0].at_in_pan.x < found[1].at_in_pan.x);
    }

    #[test]
    fn what_stands_upright_is_no_sheet() {
        // Trousers from their feet at two metres up, and a jacket that seems to float over the floor.
        let (view, feet) = (view(), view().pixel_of(Point::new(2.0, 0.0)).expect("ahead"));
        let beside = |pixel: Pixel| (pixel.column - view.columns as f64 / 2.0).abs() < 6.0;
        let trousers = image(|_, pixel| beside(pixel) && (5.0..feet.row).contains(&pixel.row));
        assert_eq!(found(&trousers), []);
        let jacket = image(|_, pixel| beside(pixel) && (3.0..20.0).contains(&pixel.row));
        assert_eq!(found(&jacket), []);
    }

    #[test]
    fn a_sheet_of_another_size_or_at_the_edge_is_left_out() {
        assert_eq!(found(&image(sheet(Point::new(1.6, 0.0), 0.7))), []);
        assert_eq!(found(&image(sheet(Point::new(1.6, 0.0), 0.1))), []);
        assert_eq!(found(&image(sheet(Point::new(1.5, 0.95), 0.3))), []);
    }

    #[test]
    fn a_sheet_that_something_hides_half_of_is_found_near_where_it_lies() {
        let at = Point::new(1.8, 0.4);
        let half = sheet(at, 0.3);
        let found = found(&image(|floor, pixel| half(floor, pixel) && floor.y < at.y));
        assert_eq!(found.len(), 1);
        assert!(crate::geometry::distance_m(found[0].at_in_pan, at) < 0.12, "{:?}", found[0]);
    }
}
