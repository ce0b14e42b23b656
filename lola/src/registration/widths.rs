//! How wide the hallway is, by all that was heard of it.

use serde::{Deserialize, Serialize};

/// Widths that differ by no more than this count as one.
const SAME_M: f64 = 0.15;

/// How many are kept; a hallway has one, and boxes and rooms with open doors make a few more.
const MOST: usize = 8;

/// The widths that fits have found, each with the way on which they did.
///
/// The first may be that beside a box; what most of the way agrees on is the hallway's.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct HallwayWidths {
    kept: Vec<Width>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Width {
    mean_m: f64,
    way_m: f64,
}

impl HallwayWidths {
    /// Adds what was found on a bit of the way.
    pub fn add(&mut self, width_m: f64, way_m: f64) {
        match self.kept.iter_mut().find(|width| (width.mean_m - width_m).abs() <= SAME_M) {
            Some(width) => {
                width.way_m += way_m;
                width.mean_m += (width_m - width.mean_m) * way_m / width.way_m;
            }
            None => self.kept.push(Width { mean_m: width_m, way_m }),
        }
        self.kept.sort_by(|a, b| b.way_m.total_cmp(&a.way_m));
        // The newest may yet become the longest.
        if self.kept.len() > MOST {
            self.kept.remove(MOST - 1);
        }
    }

    /// The one that was found on most of the way.
    pub fn likeliest_m(&self) -> Option<f64> {
        self.kept.first().map(|width| width.mean_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_at_the_start_is_outweighed_by_the_hallway() {
        let mut widths = HallwayWidths::default();
        widths.add(1.8, 0.8);
        assert_eq!(widths.likeliest_m(), Some(1.8));
        for _ in 0..9 {
            widths.add(2.2, 0.1);
        }
        assert!(widths.likeliest_m().is_some_and(|width_m| (width_m - 2.2).abs() < 1e-9));
    }

    #[test]
    fn few_are_kept_of_many() {
        let mut widths = HallwayWidths::default();
        for number in 0..100 {
            widths.add(1.0 + f64::from(number), 0.1);
        }
        assert_eq!(widths.kept.len(), MOST);
    }
}
