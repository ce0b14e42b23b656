//! The exact Euclidean distance transform of a grid.

use rayon::prelude::*;

/// With fewer rows than this, handing them to another thread costs more than it gains.
const ROWS_FOR_THREAD: usize = 64;

/// For each cell of a row-major grid the squared distance, in cells, from its centre to the centre
/// of the nearest obstacle cell: Meijster, Roerdink, Hesselink, "A General Algorithm for Computing
/// Distance Transforms in Linear Time". Integer arithmetic, hence exact; O(cells), 4 bytes each. A grid without
/// obstacles gives `(columns + rows)²` everywhere, which is more than any distance in it. What does not fit is cut to
/// `u32::MAX`, the square of 65,536 cells.
pub fn squared_distances_cells(columns: usize, rows: usize, is_obstacle: &[bool]) -> Vec<u32> {
    let mut distances = vertical_distances(columns, rows, is_obstacle);
    let rows = distances.par_chunks_exact_mut(columns.max(1)).with_min_len(ROWS_FOR_THREAD);
    rows.for_each_init(|| Envelope::of(columns), Envelope::transform);
    distances
}

/// Per cell the distance along its column to the nearest obstacle of that column.
fn vertical_distances(columns: usize, rows: usize, is_obstacle: &[bool]) -> Vec<u32> {
    let far = u32::try_from(columns + rows).unwrap_or(u32::MAX - 1);
    let mut vertical = vec![far; columns * rows];
    let mut above = vec![far; columns];
    for row in 0..rows {
        for (column, above) in above.iter_mut().enumerate() {
            let cell = row * columns + column;
            *above = if is_obstacle[cell] { 0 } else { (*above + 1).min(far) };
            vertical[cell] = *above;
        }
    }
    let mut below = vec![far; columns];
    for row in (0..rows).rev() {
        for (column, below) in below.iter_mut().enumerate() {
            let cell = row * columns + column;
            *below = (*below + 1).min(vertical[cell]);
            vertical[cell] = *below;
        }
    }
    vertical
}

/// The lower envelope of one row's parabolas; `sites[k]` is lowest from `starts[k]` on.
struct Envelope {
    sites: Vec<i64>,
    starts: Vec<i64>,
    heights: Vec<i64>,
}

impl Envelope {
    /// Scratch for rows of `columns` cells.
    fn of(columns: usize) -> Self {
        Self { sites: vec![0; columns], starts: vec![0; columns], heights: vec![0; columns] }
    }

    /// Replaces the vertical distances of a row by squared distances.
    fn transform(&mut self, row: &mut [u32]) {
        self.heights.iter_mut().zip(&*row).for_each(|(height, &distance)| *height = i64::from(distance));
        let (heights, columns) = (&self.heights, row.len() as i64);
        let parabola = |x: i64, site: i64| (x - site) * (x - site) + heights[site as usize] * heights[site as usize];
        let mut last = 0;
        self.sites[0] = 0;
        self.starts[0] = 0;
        for site in 1..columns {
            let is_below =
                |kept: usize| parabola(self.starts[kept], self.sites[kept]) > parabola(self.starts[kept], site);
            while last > 0 && is_below(last) {
                last -= 1;
            }
            if is_below(last) {
                self.sites[last] = site;
                continue;
            }
            let start = 1 + separation(heights, self.sites[last], site);
            if start < columns {
                last += 1;
                self.sites[last] = site;
                self.starts[last] = start;
            }
        }
        for x in (0..columns).rev() {
            row[x as usize] = u32::try_from(parabola(x, self.sites[last])).unwrap_or(u32::MAX);
            if x == self.starts[last] && last > 0 {
                last -= 1;
            }
        }
    }
}

/// The last x at which the parabola of `left` is not above that of `right`.
fn separation(heights: &[i64], left: i64, right: i64) -> i64 {
    let square = |site: i64| site * site + heights[site as usize] * heights[site as usize];
    (square(right) - square(left)).div_euclid(2 * (right - left))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn agrees_with_the_search_over_all_obstacles(
            columns in 1usize..14,
            rows in 1usize..14,
            seed in proptest::collection::vec(0u8..8, 196),
        ) {
            let mut is_obstacle: Vec<bool> = seed[..columns * rows].iter().map(|&value| value == 0).collect();
            is_obstacle[seed[0] as usize % (columns * rows)] = true;
            let squared = squared_distances_cells(columns, rows, &is_obstacle);
            for (cell, &found) in squared.iter().enumerate() {
                let nearest = (0..columns * rows)
                    .filter(|&other| is_obstacle[other])
                    .map(|other| {
                        let dx = (cell % columns).abs_diff(other % columns) as i64;
                        let dy = (cell / columns).abs_diff(other / columns) as i64;
                        dx * dx + dy * dy
                    })
                    .min();
                prop_assert_eq!(Some(i64::from(found)), nearest);
            }
        }
    }
}
