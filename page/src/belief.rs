//! A belief as it is drawn: a few steps of a logarithmic scale, and the places where most of it lies.

use crate::place::Spot;
use serde::Serialize;

/// Steps of the scale beside "hardly"; three to a factor of ten, so that a hundredth of the likeliest is seen well.
pub const STEPS: u32 = 9;
const STEPS_PER_DECADE: f64 = 3.0;

/// What lies within this of a maximum is its share.
const NEAR_M: f64 = 0.5;

/// The most maxima that are shown, each of at least this share.
const MOST_MAXIMA: usize = 3;
const LEAST_SHARE: f64 = 0.02;

/// A belief over positions: probabilities `cells[row][column]`, row-major, of a grid in the map frame.
#[derive(Clone, Copy, Debug)]
pub struct PositionGrid<'a> {
    /// The lower left corner, in metres.
    pub corner_m: [f64; 2],
    /// The edge of a cell.
    pub cell_m: f64,
    /// Cells along x.
    pub columns: usize,
    /// Summed over headings; the sum of all is 1.
    pub cells: &'a [f64],
}

/// A belief as it is drawn.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DrawnBelief {
    /// The lower left corner of the grid.
    pub corner: Spot,
    /// The edge of a cell.
    pub cell: i32,
    /// Cells along x.
    pub columns: usize,
    /// Steps of the cells, row by row from the lower left: a letter for the step, `a` for hardly, and how many cells have it,
    /// unless that is one.
    pub steps: String,
    /// x, y and share in thousandths of the places where most of it lies.
    pub maxima: Vec<[i32; 3]>,
}

impl DrawnBelief {
    /// The drawing of a belief. Cost: a pass over the grid, and one over its likely cells for each maximum.
    pub fn of(grid: PositionGrid<'_>) -> Self {
        let most = grid.cells.iter().copied().fold(0.0, f64::max);
        let mm = |length_m: f64| (length_m * 1000.0).round() as i32;
        Self {
            corner: grid.corner_m.map(mm),
            cell: mm(grid.cell_m),
            columns: grid.columns,
            steps: runs(grid.cells.iter().map(|&share| step(share, most))),
            maxima: maxima(grid, most).into_iter().map(|(x_m, y_m, share)| [mm(x_m), mm(y_m), mm(share)]).collect(),
        }
    }
}

/// The step of a probability on a scale from the largest down.
fn step(share: f64, most: f64) -> u32 {
    // Most cells of a belief are hardly likely, and a logarithm takes long.
    if share <= 0.0 || share * 1000.0 < most {
        return 0;
    }
    let below = libm::log10(most / share) * STEPS_PER_DECADE;
    STEPS.saturating_sub(below.round() as u32)
}

fn runs(steps: impl Iterator<Item = u32>) -> String {
    let mut text = String::new();
    let mut add = |step: u32, count: usize| {
        text.push((b'a' + step as u8) as char);
        if count > 1 {
            text.push_str(&count.to_string());
        }
    };
    let mut run: Option<(u32, usize)> = None;
    for step in steps {
        match &mut run {
            Some((same, count)) if *same == step => *count += 1,
            _ => {
                if let Some((before, count)) = run.replace((step, 1)) {
                    add(before, count);
                }
            }
        }
    }
    // What follows the last likely cell need not be written.
    if let Some((step, count)) = run.filter(|&(step, _)| step > 0) {
        add(step, count);
    }
    text
}

/// Middle and share of the places where most of a belief lies, the largest first.
fn maxima(grid: PositionGrid<'_>, most: f64) -> Vec<(f64, f64, f64)> {
    let PositionGrid { corner_m, cell_m, columns, cells } = grid;
    let place = |at: usize| {
        let (column, row) = (at % columns.max(1), at / columns.max(1));
        (corner_m[0] + (column as f64 + 0.5) * cell_m, corner_m[1] + (row as f64 + 0.5) * cell_m)
    };
    let likely = cells.iter().enumerate().filter(|&(_, &share)| share > 0.0 && share * 1000.0 >= most);
    let mut left: Vec<(usize, f64)> = likely.map(|(at, &share)| (at, share)).collect();
    let mut found = Vec::new();
    while found.len() < MOST_MAXIMA {
        let largest = left.iter().copied().reduce(|one, other| if other.1 > one.1 { other } else { one });
        let Some((at, _)) = largest else { break };
        let (x_m, y_m) = place(at);
        let is_near = |at: usize| {
            let (other_x_m, other_y_m) = place(at);
            (other_x_m - x_m).powi(2) + (other_y_m - y_m).powi(2) <= NEAR_M * NEAR_M
        };
        let share = left.iter().filter(|&&(at, _)| is_near(at)).map(|&(_, share)| share).sum::<f64>();
        if share < LEAST_SHARE {
            break;
        }
        left.retain(|&(at, _)| !is_near(at));
        found.push((x_m, y_m, share));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_follow_a_logarithm_and_a_hundredth_is_seen() {
        assert_eq!(step(0.5, 0.5), STEPS);
        assert_eq!(step(0.05, 0.5), STEPS - 3);
        assert_eq!(step(0.005, 0.5), STEPS - 6);
        assert_eq!(step(0.0, 0.5), 0);
        assert_eq!(step(0.0, 0.0), 0);
    }

    #[test]
    fn cells_are_written_as_runs_and_the_empty_end_is_left_out() {
        assert_eq!(runs([0, 0, 9, 9, 9, 3, 0, 0].into_iter()), "a2j3d");
        assert_eq!(runs([0, 0].into_iter()), "");
        assert_eq!(runs(std::iter::empty()), "");
    }

    #[test]
    fn two_places_share_a_belief() {
        let mut cells = vec![0.0; 100 * 10];
        (cells[5 * 100 + 10], cells[5 * 100 + 11], cells[5 * 100 + 80]) = (0.5, 0.2, 0.3);
        let drawn = DrawnBelief::of(PositionGrid { corner_m: [0.0, 1.0], cell_m: 0.1, columns: 100, cells: &cells });
        assert_eq!(drawn.maxima, [[1050, 1550, 700], [8050, 1550, 300]]);
        assert_eq!(drawn.steps, "a510jia68i");
    }
}
