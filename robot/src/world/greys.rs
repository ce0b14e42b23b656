//! How the greys of a map's image are read, and what is probably meant otherwise.

use super::image::GreyImage;
use super::ros_map::{MapMode, RosMap};
use crate::occupancy::Cell;

/// The grey that map_saver writes for unknown space.
const SAVED_UNKNOWN: usize = 205;

/// A grey that so large a share of the pixels has is there on purpose.
const COMMON: f64 = 0.005;

/// Greys that are told of.
const MOST_TOLD: usize = 6;

/// Less than this share of what is known, occupied, is as good as nothing.
const HARDLY: f64 = 0.001;

/// Where so large a share of the edge is free, the map does not end with walls.
const MOSTLY: f64 = 0.5;

/// The pixels of an image, counted.
#[derive(Clone, Debug, PartialEq)]
pub struct Greys<'m> {
    map: &'m RosMap,
    /// By shade, from 0, black, to 255.
    pixels: [usize; 256],
    /// The same along the edge of the image.
    at_edge: [usize; 256],
    total: usize,
}

impl<'m> Greys<'m> {
    /// Counts the pixels of a map's image.
    pub fn of(map: &'m RosMap, image: &GreyImage) -> Self {
        let (mut pixels, mut at_edge) = ([0; 256], [0; 256]);
        let greys: Vec<usize> =
            (0..=image.white).map(|value| libm::roundf(image.shade(value) * 255.0) as usize).collect();
        for (row, values) in image.values.chunks_exact(image.columns).enumerate() {
            let is_edge = row == 0 || row + 1 == image.rows;
            for (column, &value) in values.iter().enumerate() {
                let grey = greys[usize::from(value)];
                pixels[grey] += 1;
                at_edge[grey] += usize::from(is_edge || column == 0 || column + 1 == image.columns);
            }
        }
        Self { map, pixels, at_edge, total: image.values.len() }
    }

    fn cell(&self, grey: usize) -> Cell {
        self.map.cell(grey as f32 / 255.0, false)
    }

    fn occupancy(&self, grey: usize) -> Option<f64> {
        self.map.occupancy(grey as f32 / 255.0)
    }

    /// The share of all pixels that are read so.
    fn share(&self, counts: &[usize; 256], cell: Cell) -> f64 {
        let of_kind: usize = (0..256).filter(|&grey| self.cell(grey) == cell).map(|grey| counts[grey]).sum();
        of_kind as f64 / counts.iter().sum::<usize>().max(1) as f64
    }

    /// The greys that many pixels have, the darkest first.
    fn common(&self) -> Vec<usize> {
        (0..256).filter(|&grey| self.pixels[grey] as f64 >= COMMON * self.total as f64).collect()
    }

    /// How the image is read, in a line.
    pub fn legend(&self) -> String {
        let percent = |cell| 100.0 * self.share(&self.pixels, cell);
        let mut greys = self.common();
        greys.sort_by_key(|&grey| std::cmp::Reverse(self.pixels[grey]));
        greys.truncate(MOST_TOLD);
        greys.sort_unstable();
        let told = greys.iter().map(|&grey| format!("{grey} {}", name_of(self.cell(grey))));
        format!(
            "{:.1} % free, {:.1} % occupied, {:.1} % unknown; greys: {}",
            percent(Cell::Free),
            percent(Cell::Occupied),
            percent(Cell::Unknown),
            told.collect::<Vec<_>>().join(", ")
        )
    }

    /// What is probably not meant as it is read, each with what to write.
    pub fn warnings(&self) -> Vec<String> {
        let of_occupied = self.hardly_occupied();
        let of_free = self.nothing_free();
        let of_unknown = self.saved_unknown().or_else(|| self.free_at_edge());
        let found = [of_occupied, of_free, of_unknown];
        let mut warnings: Vec<String> = found.into_iter().flatten().collect();
        if !warnings.is_empty() {
            warnings[0] += &format!(" ({})", self.legend());
        }
        warnings
    }

    fn hardly_occupied(&self) -> Option<String> {
        let (free, occupied) = (self.share(&self.pixels, Cell::Free), self.share(&self.pixels, Cell::Occupied));
        if occupied > free && free > 0.0 {
            return Some(format!(
                "more of the map is occupied, {:.0} %, than free, {:.0} %; if {} is free in it, write `negate: {}`",
                100.0 * occupied,
                100.0 * free,
                self.darker(),
                u8::from(!self.map.negate)
            ));
        }
        if occupied > HARDLY * (free + occupied) || free + occupied == 0.0 {
            return None;
        }
        let what = if occupied == 0.0 { "nothing" } else { "hardly anything" };
        // The grey that is surest to be occupied, and the next one.
        let mut likely: Vec<f64> = self.common().into_iter().filter_map(|grey| self.occupancy(grey)).collect();
        likely.sort_by(|a, b| b.total_cmp(a));
        Some(match likely[..] {
            [first, next, ..] if first <= self.map.occupied_thresh && first > self.map.free_thresh => format!(
                "{what} in the map is occupied; if its darkest grey is a wall, write `occupied_thresh: {}`",
                between(first, next.max(self.map.free_thresh))
            ),
            _ => format!("{what} in the map is occupied: it has no walls that the robot could find itself by"),
        })
    }

    /// What is occupied as the map is read.
    fn darker(&self) -> &'static str {
        if self.map.negate { "white" } else { "black" }
    }

    fn nothing_free(&self) -> Option<String> {
        if self.share(&self.pixels, Cell::Free) > 0.0 {
            return None;
        }
        let mut likely: Vec<f64> = self.common().into_iter().filter_map(|grey| self.occupancy(grey)).collect();
        likely.sort_by(f64::total_cmp);
        Some(match (self.map.mode, &likely[..]) {
            (MapMode::Raw, _) => {
                "nothing in the map is free: `mode: raw` takes greys from 0 to 100 for percent; an ordinary map has `mode: trinary`".to_owned()
            }
            (MapMode::Trinary | MapMode::Scale, [first, next, ..]) if *first < self.map.occupied_thresh => format!(
                "nothing in the map is free; if its lightest grey is floor, write `free_thresh: {}`",
                between(*first, next.min(self.map.occupied_thresh))
            ),
            (MapMode::Trinary | MapMode::Scale, _) => {
                let (darker, negate) = (self.darker(), u8::from(!self.map.negate));
                format!("nothing in the map is free; if {darker} is free in it, write `negate: {negate}`")
            }
        })
    }

    /// The grey that map_saver writes for unknown space is read as free.
    fn saved_unknown(&self) -> Option<String> {
        let pixels = self.pixels[SAVED_UNKNOWN];
        let reads_as_free = self.map.mode == MapMode::Trinary && self.cell(SAVED_UNKNOWN) == Cell::Free;
        (reads_as_free && pixels > 0).then(|| {
            format!(
                "{pixels} pixels have the grey 205 that map_saver writes for unknown space, but `free_thresh: {}` makes them free; \
                 write `free_thresh: 0.196` if they are unknown",
                self.map.free_thresh
            )
        })
    }

    /// Outside of a building nothing is known.
    fn free_at_edge(&self) -> Option<String> {
        let share = self.share(&self.at_edge, Cell::Free);
        if share <= MOSTLY {
            return None;
        }
        let free = |grey: &usize| self.cell(*grey) == Cell::Free;
        let edge = (0..256).filter(free).max_by_key(|&grey| self.at_edge[grey])?;
        let outside = self.occupancy(edge)?;
        let floors = self.common().into_iter().filter(free).filter_map(|grey| self.occupancy(grey));
        let advice = match floors.filter(|floor| *floor < outside).max_by(f64::total_cmp) {
            Some(floor) => {
                format!("if its grey there, {edge}, is the outside, write `free_thresh: {}`", between(outside, floor))
            }
            None => "if that is the outside, paint it grey (205), or crop the image".to_owned(),
        };
        Some(format!("the map is free along {:.0} % of its edge, where nothing is seen; {advice}", 100.0 * share))
    }
}

fn name_of(cell: Cell) -> &'static str {
    match cell {
        Cell::Free => "free",
        Cell::Occupied => "occupied",
        Cell::Unknown => "unknown",
    }
}

/// A threshold between two occupancies, to two digits where these tell them apart.
fn between(one: f64, other: f64) -> f64 {
    let middle = (one + other) / 2.0;
    let short = libm::round(middle * 100.0) / 100.0;
    let is_between = (short - one) * (short - other) < 0.0;
    if is_between { short } else { libm::round(middle * 10_000.0) / 10_000.0 }
}
