//! How often a robot said what of its position, and was right: counts by log odds, so that a run is few numbers.

use crate::reliability::{Counted, SURE};
use serde::{Deserialize, Serialize};

/// Cells of the log odds, the same number below even odds, from there up to [`SURE`], and beyond.
const CELLS: usize = 60;

/// Those from here on are sure.
const SURE_CELL: usize = 40;

/// Moments of about the same certainty.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CertaintyCell {
    /// Which one, by the log odds of the certainty.
    cell: usize,
    /// How many moments.
    pub looks: usize,
    /// At how many of them the estimate was right.
    pub right: usize,
    /// The sum of what was said.
    said: f64,
}

impl CertaintyCell {
    /// Whether the robot was sure at these moments.
    pub fn is_sure(&self) -> bool {
        self.cell >= SURE_CELL
    }

    /// As moments of a run.
    pub fn counted(&self, run: usize) -> Counted {
        let certainty = self.said / self.looks as f64;
        Counted { group: run, certainty, right: self.right, moments: self.looks }
    }
}

/// The moments of a run, by their certainty.
#[derive(Clone, Debug)]
pub struct CertaintyCounts([CertaintyCell; CELLS]);

impl Default for CertaintyCounts {
    fn default() -> Self {
        Self(std::array::from_fn(|cell| CertaintyCell { cell, ..CertaintyCell::default() }))
    }
}

impl CertaintyCounts {
    /// Takes in a moment.
    pub fn add(&mut self, certainty: f64, is_right: bool) {
        let cell = &mut self.0[cell_of(certainty)];
        cell.looks += 1;
        cell.right += usize::from(is_right);
        cell.said += certainty;
    }

    /// The cells that have moments.
    pub fn cells(&self) -> Vec<CertaintyCell> {
        self.0.iter().filter(|cell| cell.looks > 0).copied().collect()
    }
}

/// The first and the last cell reach on to 0 and to 1.
fn cell_of(certainty: f64) -> usize {
    let sure_odds = (SURE / (1.0 - SURE)).ln();
    let share = ((certainty / (1.0 - certainty)).ln() / sure_odds + 1.0) / 3.0;
    let cell = (share * CELLS as f64).max(0.0) as usize;
    // No rounding carries a moment over the edge.
    if certainty >= SURE { cell.clamp(SURE_CELL, CELLS - 1) } else { cell.min(SURE_CELL - 1) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_certainty_lies_in_the_cell_of_its_odds() {
        assert_eq!([0.0, 0.009, 0.5, 0.9899, 0.99, 0.9999, 1.0].map(cell_of), [0, 0, 20, 39, 40, 59, 59]);
        let cells: Vec<usize> = (1..1000).map(|n| cell_of(f64::from(n) / 1000.0)).collect();
        assert!(cells.is_sorted());
    }

    #[test]
    fn moments_are_counted_and_none_is_lost() {
        let mut counts = CertaintyCounts::default();
        for n in 0..200 {
            counts.add(f64::from(n) / 199.0, n % 4 != 0);
        }
        let cells = counts.cells();
        assert_eq!(cells.iter().map(|cell| cell.looks).sum::<usize>(), 200);
        assert_eq!(cells.iter().map(|cell| cell.right).sum::<usize>(), 150);
        let sure: usize = cells.iter().filter(|cell| cell.is_sure()).map(|cell| cell.looks).sum();
        assert_eq!(sure, 2, "198/199 and 1");
        assert!(cells.iter().all(|cell| cell.counted(7).group == 7 && cell_of(cell.counted(7).certainty) == cell.cell));
    }
}
