//! Cells that hang together.

use std::ops::Range;

/// Closes the open cells of a row-major grid that hang together with some cells, given as column and row, by their
/// edges, and hands over each run of them with its row. Row by row: of the cells beside a run only the first of each run
/// is kept in mind. Cost: cells.
pub fn flood(
    columns: usize,
    is_closed: &mut [bool],
    from: impl IntoIterator<Item = (usize, usize)>,
    mut take: impl FnMut(usize, Range<usize>),
) {
    let rows = is_closed.len() / columns.max(1);
    let mut open: Vec<(usize, usize)> = from.into_iter().collect();
    while let Some((column, row)) = open.pop() {
        let cells = &mut is_closed[row * columns..][..columns];
        if cells[column] {
            continue;
        }
        let first = cells[..column].iter().rposition(|&is_closed| is_closed).map_or(0, |west| west + 1);
        let end = cells[column..].iter().position(|&is_closed| is_closed).map_or(columns, |east| column + east);
        cells[first..end].fill(true);
        take(row, first..end);
        for beside in [row.checked_sub(1), Some(row + 1).filter(|&north| north < rows)].into_iter().flatten() {
            let cells = &is_closed[beside * columns..][..columns];
            let begins = |&at: &usize| !cells[at] && (at == first || cells[at - 1]);
            open.extend((first..end).filter(begins).map(|at| (at, beside)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn it_closes_what_can_be_walked_to(
            columns in 1usize..12,
            rows in 1usize..12,
            seed in proptest::collection::vec(0u8..3, 121),
            from in 0usize..121,
        ) {
            let closed: Vec<bool> = seed[..columns * rows].iter().map(|&value| value == 0).collect();
            let from = from % closed.len();
            // Cell by cell, until nothing is added.
            let mut reached = vec![false; closed.len()];
            reached[from] = !closed[from];
            loop {
                let is_new = |cell: &usize| {
                    let (column, row) = (cell % columns, cell / columns);
                    let besides = [
                        (column > 0).then(|| cell - 1),
                        (column + 1 < columns).then(|| cell + 1),
                        (row > 0).then(|| cell - columns),
                        (row + 1 < rows).then(|| cell + columns),
                    ];
                    !closed[*cell] && !reached[*cell] && besides.into_iter().flatten().any(|beside| reached[beside])
                };
                let Some(cell) = (0..closed.len()).find(is_new) else { break };
                reached[cell] = true;
            }
            let (mut now_closed, mut times) = (closed.clone(), vec![0; closed.len()]);
            flood(columns, &mut now_closed, [(from % columns, from / columns)], |row, run| {
                run.for_each(|column| times[row * columns + column] += 1);
            });
            for cell in 0..closed.len() {
                prop_assert_eq!(times[cell], usize::from(reached[cell]));
                prop_assert_eq!(now_closed[cell], closed[cell] || reached[cell]);
            }
        }
    }
}
