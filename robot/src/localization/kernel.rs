//! The loops over the cells of one plane. Every sum has one fixed order.

use super::grid::BLOCK;

/// Length of the table of weights, a power of two above the largest sum of costs.
pub(super) const WEIGHTS: usize = 8192;

/// One reading against one plane: the bins expected there, and what each costs.
pub(super) struct Beam<'a> {
    /// A padded plane of expected bins.
    pub expected: &'a [u8],
    /// Costs by expected bin.
    pub costs: &'a [u8; 256],
}

/// The sum of a block, lane by lane and then across the lanes.
fn block_sum(cells: &[f32; BLOCK]) -> f64 {
    let mut lanes = [0f32; 16];
    for chunk in cells.as_chunks::<16>().0 {
        for (lane, cell) in lanes.iter_mut().zip(chunk) {
            *lane += cell;
        }
    }
    lanes.iter().map(|&lane| f64::from(lane)).sum()
}

fn block_peak(cells: &[f32; BLOCK]) -> f32 {
    let mut lanes = [0f32; 16];
    for chunk in cells.as_chunks::<16>().0 {
        for (lane, &cell) in lanes.iter_mut().zip(chunk) {
            *lane = if cell > *lane { cell } else { *lane };
        }
    }
    lanes.iter().fold(0.0, |peak, &lane| if lane > peak { lane } else { peak })
}

/// The sum of a padded plane.
pub(super) fn sum(cells: &[f32]) -> f64 {
    cells.as_chunks::<BLOCK>().0.iter().map(block_sum).sum()
}

/// The largest cell of a padded plane.
pub(super) fn peak(cells: &[f32]) -> f32 {
    cells.as_chunks::<BLOCK>().0.iter().map(block_peak).fold(0.0, f32::max)
}

/// Sums the costs of all beams for one block of cells.
fn block_costs(beams: &[Beam], block: usize) -> [u16; BLOCK] {
    let mut sums = [0u16; BLOCK];
    let mut fours = beams.chunks_exact(4);
    for four in &mut fours {
        let [a, b, c, d] = four else { continue };
        let at = |beam: &Beam| -> [u8; BLOCK] { beam.expected.as_chunks::<BLOCK>().0[block] };
        let (at_a, at_b, at_c, at_d) = (at(a), at(b), at(c), at(d));
        for lane in 0..BLOCK {
            sums[lane] += u16::from(a.costs[usize::from(at_a[lane])])
                + u16::from(b.costs[usize::from(at_b[lane])])
                + u16::from(c.costs[usize::from(at_c[lane])])
                + u16::from(d.costs[usize::from(at_d[lane])]);
        }
    }
    for beam in fours.remainder() {
        let expected = &beam.expected.as_chunks::<BLOCK>().0[block];
        for (sum, &bin) in sums.iter_mut().zip(expected) {
            *sum += u16::from(beam.costs[usize::from(bin)]);
        }
    }
    sums
}

/// Multiplies a plane by the weights of a scan (Eq. (2) without the normalizer) and returns its
/// sum; cells below `threshold` are multiplied by the average weight (Eq. (3)), also those that share
/// a block with others: a mirror pose must not gain on its twin because it lies beside the track.
/// Cells that are not admissible become 0.
pub(super) fn weigh(
    cells: &mut [f32],
    admissible: &[f32],
    beams: &[Beam],
    weights: &[f32; WEIGHTS],
    average: f32,
    threshold: f32,
) -> f64 {
    let mut mass = 0.0;
    let blocks = cells.as_chunks_mut::<BLOCK>().0.iter_mut().zip(admissible.as_chunks::<BLOCK>().0);
    for (block, (cells, admissible)) in blocks.enumerate() {
        let peak = block_peak(cells);
        if peak == 0.0 {
            continue;
        }
        if peak < threshold || beams.is_empty() {
            for (cell, admissible) in cells.iter_mut().zip(admissible) {
                *cell *= average * admissible;
            }
        } else {
            let sums = block_costs(beams, block);
            for ((cell, admissible), &sum) in cells.iter_mut().zip(admissible).zip(&sums) {
                let weight = if *cell < threshold { average } else { weights[usize::from(sum) & (WEIGHTS - 1)] };
                *cell *= weight * admissible;
            }
        }
        mass += block_sum(cells);
    }
    mass
}

/// Smallest value of an admissible cell: no product of such a cell and a tempered weight becomes
/// a denormal number, which would cost a factor of five in time.
const FLOOR: f32 = 1e-30;

/// `cell · scale + add` where admissible; returns the largest cell.
pub(super) fn rescale(cells: &mut [f32], admissible: &[f32], scale: f32, add: f32) -> f32 {
    let mut lanes = [0f32; 16];
    let chunks = cells.as_chunks_mut::<16>().0.iter_mut().zip(admissible.as_chunks::<16>().0);
    for (cells, admissible) in chunks {
        for ((cell, admissible), lane) in cells.iter_mut().zip(admissible).zip(&mut lanes) {
            let value = *cell * scale + add;
            let value = if value > FLOOR { value } else { FLOOR } * admissible;
            *cell = value;
            *lane = if value > *lane { value } else { *lane };
        }
    }
    lanes.iter().fold(0.0, |peak, &lane| if lane > peak { lane } else { peak })
}

/// Moves a plane by whole cells; what leaves it is lost, what enters is 0.
pub(super) fn shift(cells: &mut [f32], columns: usize, rows: usize, by_columns: i64, by_rows: i64) {
    if by_columns == 0 && by_rows == 0 {
        return;
    }
    let across = by_columns.unsigned_abs() as usize;
    if across >= columns || by_rows.unsigned_abs() as usize >= rows {
        cells.fill(0.0);
        return;
    }
    for step in 0..rows {
        let to = if by_rows > 0 { rows - 1 - step } else { step };
        let from = to as i64 - by_rows;
        if from < 0 || from >= rows as i64 {
            cells[to * columns..][..columns].fill(0.0);
            continue;
        }
        let from = from as usize * columns;
        let to = to * columns;
        if by_columns >= 0 {
            cells.copy_within(from..from + columns - across, to + across);
            cells[to..to + across].fill(0.0);
        } else {
            cells.copy_within(from + across..from + columns, to);
            cells[to + columns - across..to + columns].fill(0.0);
        }
    }
}

/// Spreads every cell by `[g, 1 − 2g, g]` along each axis: mean 0, variance 2g cells².
pub(super) fn blur(cells: &mut [f32], columns: usize, rows: usize, spread_x: f32, spread_y: f32) {
    let mut padded = vec![0f32; columns + 2];
    let mut above = vec![0f32; columns];
    let mut this = vec![0f32; columns];
    for row in cells.chunks_exact_mut(columns).take(rows) {
        padded[1..=columns].copy_from_slice(row);
        let (left, middle, right) = (&padded[..columns], &padded[1..=columns], &padded[2..]);
        for (cell, ((left, middle), right)) in row.iter_mut().zip(left.iter().zip(middle).zip(right)) {
            *cell = (1.0 - 2.0 * spread_x) * middle + spread_x * (left + right);
        }
    }
    for row in 0..rows {
        let (head, tail) = cells.split_at_mut((row + 1) * columns);
        let out = &mut head[row * columns..];
        this.copy_from_slice(out);
        for (cell, above) in out.iter_mut().zip(&above) {
            *cell = (1.0 - 2.0 * spread_y) * *cell + spread_y * above;
        }
        if row + 1 < rows {
            for (cell, below) in out.iter_mut().zip(&tail[..columns]) {
                *cell += spread_y * below;
            }
        }
        std::mem::swap(&mut above, &mut this);
    }
}

/// Adds `share` of another plane, moved by whole cells.
pub(super) fn add_shifted(
    out: &mut [f32],
    other: &[f32],
    (columns, rows): (usize, usize),
    (by_columns, by_rows): (i64, i64),
    share: f32,
) {
    let clip = |by: i64, count: usize| {
        let first = by.clamp(0, count as i64);
        let end = (count as i64 + by).clamp(first, count as i64);
        (first as usize, end as usize)
    };
    let (left, right) = clip(by_columns, columns);
    let (low, high) = clip(by_rows, rows);
    for row in low..high {
        let from = (row as i64 - by_rows) as usize * columns;
        let source = &other[(from as i64 + left as i64 - by_columns) as usize..][..right - left];
        for (cell, value) in out[row * columns + left..row * columns + right].iter_mut().zip(source) {
            *cell += share * value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shift_moves_a_point_and_drops_what_leaves() {
        for (dx, dy) in [(2, 1), (-2, 1), (2, -1), (-1, -2), (0, 3), (-3, 0)] {
            let mut cells = vec![0.0; 64];
            cells[3 * 7 + 3] = 1.0;
            cells[6] = 0.5;
            shift(&mut cells, 7, 7, dx, dy);
            assert_eq!(cells[((3 + dy) * 7 + 3 + dx) as usize], 1.0);
            let corner_stays = dx <= 0 && dy >= 0;
            assert_eq!(cells.iter().filter(|&&cell| cell == 0.5).count(), usize::from(corner_stays));
        }
    }

    #[test]
    fn a_blur_keeps_mass_and_mean_and_adds_its_variance() {
        let (columns, rows) = (9, 7);
        let mut cells = vec![0.0; 64];
        cells[3 * columns + 4] = 1.0;
        blur(&mut cells, columns, rows, 0.1, 0.2);
        let moment = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
            (0..columns * rows)
                .map(|i| f64::from(cells[i]) * f((i % columns) as f64 - 4.0, (i / columns) as f64 - 3.0))
                .sum()
        };
        assert!((moment(&|_, _| 1.0) - 1.0).abs() < 1e-6);
        assert!(moment(&|x, _| x).abs() < 1e-6 && moment(&|_, y| y).abs() < 1e-6);
        assert!((moment(&|x, _| x * x) - 0.2).abs() < 1e-6 && (moment(&|_, y| y * y) - 0.4).abs() < 1e-6);
    }

    #[test]
    fn adding_a_shifted_plane_is_shifting_and_adding() {
        let source: Vec<f32> = (0..64).map(|i| if i < 63 { i as f32 } else { 0.0 }).collect();
        for (dx, dy) in [(0, 0), (1, -1), (-2, 2), (9, 0)] {
            let mut moved = source.clone();
            shift(&mut moved, 9, 7, dx, dy);
            let mut out = vec![0.0; 64];
            add_shifted(&mut out, &source, (9, 7), (dx, dy), 1.0);
            assert_eq!(moved[..63], out[..63]);
        }
    }
}
