//! Histogram back-projection (Swain and Ballard, "Color Indexing", 1991): where in an image a thing is whose
//! colours are known.

use super::histogram::{Histogram, bin};
use crate::sensors::CameraImage;
use std::ops::Range;

/// The least that the neighbourhood of a pixel of the model tells of it, from 0 to 1.
const LEAST_TOLD: f64 = 0.4;

/// Pixels beside each other that belong to the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Blob {
    /// Column and row of each.
    pub pixels: Vec<(usize, usize)>,
}

impl Blob {
    /// The columns it spans.
    pub fn columns(&self) -> Range<usize> {
        span(self.pixels.iter().map(|&(column, _)| column))
    }

    /// The rows it spans.
    pub fn rows(&self) -> Range<usize> {
        span(self.pixels.iter().map(|&(_, row)| row))
    }
}

fn span(values: impl Iterator<Item = usize>) -> Range<usize> {
    let (first, last) = values.fold((usize::MAX, 0), |(first, last), value| (first.min(value), last.max(value)));
    first..last + 1
}

/// The blobs of a model in some rows of an image, the largest first; of two alike the one further up. The
/// model counts as many pixels as the thing may have in the image. Cost: the pixels of the rows.
///
/// # Deviation
/// Swain and Ballard look for the peak of the ratios under a mask of the thing's size, for one thing in the
/// image. Here any number may be in it, so that neighbouring pixels are put together instead.
pub fn blobs(model: &Histogram, image: &CameraImage, rows: Range<usize>) -> Vec<Blob> {
    let columns = image.columns;
    let pixel = |number: usize| image.at(number % columns, rows.start + number / columns);
    let bins: Vec<Option<usize>> = (0..rows.len() * columns).map(|number| bin(pixel(number))).collect();
    let mut seen = Histogram::default();
    bins.iter().flatten().for_each(|&bin| seen.counts[bin] += 1.0);
    let ratios = model.ratio_to(&seen);
    let told: Vec<f64> = bins.iter().map(|bin| bin.map_or(0.0, |bin| ratios[bin])).collect();
    let mut belongs: Vec<bool> = smooth(&told, columns).into_iter().map(|told| told >= LEAST_TOLD).collect();
    let mut blobs = Vec::new();
    for first in 0..belongs.len() {
        if belongs[first] {
            blobs.push(grow(&mut belongs, columns, first, rows.start));
        }
    }
    blobs.sort_by_key(|blob| std::cmp::Reverse(blob.pixels.len()));
    blobs
}

/// The mean of each pixel and its neighbours in the row, the pixel counted twice: a pixel that noise has
/// moved to another bin stays in its blob, and one that it has moved to the model's makes none.
fn smooth(told: &[f64], columns: usize) -> Vec<f64> {
    let row = |row: &[f64]| -> Vec<f64> {
        let at = |column: usize| row.get(column).copied().unwrap_or(0.0);
        let mean = |column: usize| (at(column.wrapping_sub(1)) + 2.0 * at(column) + at(column + 1)) / 4.0;
        (0..row.len()).map(mean).collect()
    };
    told.chunks(columns).flat_map(row).collect()
}

/// Takes the pixels out that hang together with the first, over edges and corners.
fn grow(belongs: &mut [bool], columns: usize, first: usize, first_row: usize) -> Blob {
    let mut pixels = Vec::new();
    let mut rim = vec![first];
    belongs[first] = false;
    while let Some(number) = rim.pop() {
        let (column, row) = (number % columns, number / columns);
        pixels.push((column, first_row + row));
        for near_row in row.saturating_sub(1)..=row + 1 {
            for near_column in column.saturating_sub(1)..=(column + 1).min(columns - 1) {
                let near = near_row * columns + near_column;
                if belongs.get(near) == Some(&true) {
                    belongs[near] = false;
                    rim.push(near);
                }
            }
        }
    }
    pixels.sort_unstable_by_key(|&(column, row)| (row, column));
    Blob { pixels }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PINK: [u8; 3] = [250, 40, 140];
    const GREY: [u8; 3] = [120, 120, 120];

    /// An image from a picture: `#` is pink, all else grey.
    fn image(picture: &[&str]) -> CameraImage {
        let rgb = picture.iter().flat_map(|row| row.bytes()).flat_map(|byte| if byte == b'#' { PINK } else { GREY });
        CameraImage { columns: picture[0].len(), rgb: rgb.collect() }
    }

    fn pink(pixels: f64) -> Histogram {
        Histogram::of([PINK].into_iter()).scaled_to(pixels)
    }

    #[test]
    fn pixels_that_touch_are_one_blob_and_the_largest_comes_first() {
        let image = image(&["........", ".##...##", ".##....#", "...#####", "........"]);
        let found = blobs(&pink(20.0), &image, 0..5);
        assert_eq!(found.len(), 1, "over a corner: {found:?}");
        let apart = super::tests::image(&["........", ".##..###", ".##..###", "........"]);
        let found = blobs(&pink(20.0), &apart, 0..4);
        assert_eq!(found.iter().map(|blob| blob.pixels.len()).collect::<Vec<_>>(), [6, 4]);
        assert_eq!((found[0].columns(), found[0].rows()), (5..8, 1..3));
    }

    #[test]
    fn only_the_rows_that_are_asked_for_are_looked_at() {
        let image = image(&["##......", "........", "....##..", "....##.."]);
        let found = blobs(&pink(20.0), &image, 2..4);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].pixels, [(4, 2), (5, 2), (4, 3), (5, 3)]);
    }

    #[test]
    fn a_single_pixel_is_noise_and_a_hole_does_not_tear_a_blob() {
        assert_eq!(blobs(&pink(20.0), &image(&[".....", "..#..", "....."]), 0..3).len(), 1);
        let holed = image(&["#####", "##.##", "#####"]);
        let found = blobs(&pink(20.0), &holed, 0..3);
        assert_eq!((found.len(), found[0].pixels.len()), (1, 15));
    }

    #[test]
    fn a_wall_of_the_colour_tells_nothing() {
        let rows = vec!["########"; 6];
        assert_eq!(blobs(&pink(12.0), &image(&rows), 0..6), []);
        assert_eq!(blobs(&pink(48.0), &image(&rows), 0..6).len(), 1);
    }
}
