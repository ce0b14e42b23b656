//! Histograms of colours, which do not mind how bright the light is.

use crate::sensors::Rgb;
use serde::{Deserialize, Serialize};

/// Bins around the circle of hues ...
const HUES: usize = 24;

/// ... and from grey to pure.
const SATURATIONS: usize = 6;

/// How many bins there are: row-major, `[hue][saturation]`.
pub const BINS: usize = HUES * SATURATIONS;

/// A pixel none of whose values is above this is too dark to have a colour.
const DARKEST: u8 = 30;

/// Below this saturation, in 256 parts, a hue is nothing but noise.
const PALEST: u32 = 60;

/// The bin of a colour by its hue and saturation; none if it is dark or grey.
pub fn bin(rgb: Rgb) -> Option<usize> {
    let [red, green, blue] = rgb.map(i32::from);
    let (most, least) = (red.max(green).max(blue), red.min(green).min(blue));
    let spread = most - least;
    let saturation = (256 * spread) as u32 / most.max(1) as u32;
    if most <= i32::from(DARKEST) || saturation < PALEST {
        return None;
    }
    // The circle of hues in six sectors, in which one of the values rises or falls.
    let sixths = |from: i32, rise: i32| f64::from(from) + f64::from(rise) / f64::from(spread);
    let hue = if most == red {
        sixths(0, green - blue)
    } else if most == green {
        sixths(2, blue - red)
    } else {
        sixths(4, red - green)
    };
    let hue = (if hue < 0.0 { hue + 6.0 } else { hue }) / 6.0;
    let hue = ((hue * HUES as f64) as usize).min(HUES - 1);
    let saturation = ((saturation - PALEST) as usize * SATURATIONS / (257 - PALEST as usize)).min(SATURATIONS - 1);
    Some(hue * SATURATIONS + saturation)
}

/// How often each colour occurs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Histogram {
    /// In each bin.
    pub counts: Vec<f64>,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { counts: vec![0.0; BINS] }
    }
}

impl Histogram {
    /// Of some pixels. What has no colour is in no bin.
    pub fn of(pixels: impl Iterator<Item = Rgb>) -> Self {
        let mut histogram = Self::default();
        pixels.filter_map(bin).for_each(|bin| histogram.counts[bin] += 1.0);
        histogram
    }

    /// The same proportions with another number of pixels in all; an empty one stays empty.
    #[must_use]
    pub fn scaled_to(&self, pixels: f64) -> Self {
        let all: f64 = self.counts.iter().sum();
        let scale = if all > 0.0 { pixels / all } else { 0.0 };
        Self { counts: self.counts.iter().map(|count| count * scale).collect() }
    }

    /// For each bin, how much a pixel of that colour tells of the model: the ratio of what the model has of it
    /// to what the image has, at most 1 (Swain and Ballard, "Color Indexing", 1991, Eq. for R).
    pub fn ratio_to(&self, image: &Self) -> Vec<f64> {
        let ratio = |(&model, &image): (&f64, &f64)| if model > 0.0 { (model / image.max(1.0)).min(1.0) } else { 0.0 };
        self.counts.iter().zip(&image.counts).map(ratio).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_colour_keeps_its_bin_in_half_the_light() {
        for rgb in [[250, 80, 150], [240, 120, 20], [60, 220, 50], [20, 100, 230]] {
            let dim = rgb.map(|value| value / 2);
            assert!(bin(rgb).is_some() && bin(rgb) == bin(dim), "{rgb:?}");
        }
    }

    #[test]
    fn grey_and_black_have_no_colour_and_every_other_has_a_bin() {
        for value in 0..=255u8 {
            assert_eq!(bin([value; 3]), None);
        }
        assert_eq!(bin([DARKEST, 0, 0]), None);
        let steps = || (0..=255u8).step_by(5);
        let bins =
            steps().flat_map(|red| steps().flat_map(move |green| steps().map(move |blue| bin([red, green, blue]))));
        let mut hit = [false; BINS];
        bins.flatten().for_each(|bin| hit[bin] = true);
        assert!(hit.iter().all(|&hit| hit));
    }

    #[test]
    fn what_the_model_has_and_the_image_has_seldom_tells_most() {
        let (model_colour, wall_colour) = ([250, 40, 140], [60, 220, 50]);
        let model = Histogram::of(vec![model_colour; 10].into_iter().chain(vec![wall_colour; 10]));
        let image = Histogram::of(vec![model_colour; 5].into_iter().chain(vec![wall_colour; 1000]));
        let ratios = model.ratio_to(&image);
        let of = |rgb| ratios[bin(rgb).expect("a colour")];
        assert_eq!((of(model_colour), of(wall_colour), of([20, 100, 230])), (1.0, 0.01, 0.0));
    }
}
