//! Cells as one outline each stretch, and lines with as few points as show their course.

use super::frame::Frame;
use super::writing::rounded;
use rpl_robot::geometry::Point;
use std::fmt::Write;
use svg::node::element::Path;

/// A line may be drawn so far beside its points.
const TOLERANCE_PX: f64 = 0.4;

/// Runs of equal values in a row: first column, length, value.
pub fn runs<T: Copy + PartialEq>(row: impl Iterator<Item = T>) -> Vec<(usize, usize, T)> {
    let mut runs: Vec<(usize, usize, T)> = Vec::new();
    for (column, value) in row.enumerate() {
        match runs.last_mut() {
            Some((_, length, last)) if *last == value => *length += 1,
            _ => runs.push((column, 1, value)),
        }
    }
    runs
}

/// A grid of square cells in the map frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Raster {
    /// Lower left corner.
    pub origin_in_map: Point,
    /// Edge of a cell.
    pub resolution_m: f64,
    /// Cells along x.
    pub columns: usize,
    /// Cells along y.
    pub rows: usize,
}

impl Raster {
    /// The cells that are chosen, as one path: stretches of a row, each grown downwards over rows with the same stretch.
    /// None if there are none. Cost: the cells.
    pub fn path(&self, frame: Frame, is_chosen: impl Fn(usize, usize) -> bool) -> Option<Path> {
        let mut data = String::new();
        // Stretches of the row below: first column, length, and the row they begin in.
        let mut open: Vec<(usize, usize, usize)> = Vec::new();
        for row in 0..=self.rows {
            let found: Vec<(usize, usize)> = match row < self.rows {
                true => {
                    let runs = runs((0..self.columns).map(|column| is_chosen(column, row)));
                    runs.into_iter().filter(|run| run.2).map(|(column, length, _)| (column, length)).collect()
                }
                false => Vec::new(),
            };
            let mut below = open.iter().copied().peekable();
            let mut next = Vec::with_capacity(found.len());
            for (column, length) in found {
                while let Some(ended) = below.next_if(|stretch| stretch.0 < column) {
                    self.rectangle(&mut data, frame, ended, row);
                }
                match below.next_if(|stretch| stretch.0 == column) {
                    Some(same) if same.1 == length => next.push(same),
                    Some(other) => {
                        self.rectangle(&mut data, frame, other, row);
                        next.push((column, length, row));
                    }
                    None => next.push((column, length, row)),
                }
            }
            below.for_each(|ended| self.rectangle(&mut data, frame, ended, row));
            open = next;
        }
        (!data.is_empty()).then(|| Path::new().set("d", data).set("shape-rendering", "crispEdges"))
    }

    fn rectangle(&self, data: &mut String, frame: Frame, stretch: (usize, usize, usize), end_row: usize) {
        let (column, length, row) = stretch;
        let x = |column: usize| frame.x(self.origin_in_map.x + column as f64 * self.resolution_m);
        let y = |row: usize| frame.y(self.origin_in_map.y + row as f64 * self.resolution_m);
        let (from_px, to_px) = (x(column), x(column + length));
        let _ = write!(data, "M{from_px} {}H{to_px}V{}H{from_px}Z", y(end_row), y(row));
    }
}

/// The points of a line on the sheet that show its course to less than half a pixel: from each on, as far as one straight
/// stretch passes all that lie between (Williams, "An efficient algorithm for the piecewise linear approximation of planar
/// curves", 1978). Cost: the points.
pub fn course(points_px: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut kept: Vec<(f64, f64)> = Vec::new();
    let mut sleeve: Option<Sleeve> = None;
    let mut last = None;
    for point in points_px {
        let Some(&from) = kept.last() else {
            kept.push(point);
            continue;
        };
        let reaches = match &mut sleeve {
            Some(sleeve) => sleeve.admits(from, point),
            None => true,
        };
        if !reaches && let Some(before) = last {
            kept.push(before);
            sleeve = Sleeve::towards(before, point);
        } else if sleeve.is_none() {
            sleeve = Sleeve::towards(from, point);
        }
        last = Some(point);
    }
    kept.extend(last);
    kept
}

/// The directions in which one stretch passes all points so far.
struct Sleeve {
    middle_rad: f64,
    /// Beside that.
    low_rad: f64,
    high_rad: f64,
    farthest_px: f64,
}

impl Sleeve {
    /// The directions towards a point; none if it is so near that any would do.
    fn towards(from: (f64, f64), to: (f64, f64)) -> Option<Self> {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let away_px = dx.hypot(dy);
        (away_px > TOLERANCE_PX).then(|| {
            let half_rad = (TOLERANCE_PX / away_px).asin();
            Self { middle_rad: dy.atan2(dx), low_rad: -half_rad, high_rad: half_rad, farthest_px: away_px }
        })
    }

    /// Whether the stretch can end at this point, and passes the earlier ones then.
    fn admits(&mut self, from: (f64, f64), to: (f64, f64)) -> bool {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let away_px = dx.hypot(dy);
        // Going back is a turn.
        if away_px + TOLERANCE_PX < self.farthest_px {
            return false;
        }
        self.farthest_px = self.farthest_px.max(away_px);
        let off_rad = rpl_robot::geometry::wrap_angle_rad(dy.atan2(dx) - self.middle_rad);
        if off_rad < self.low_rad || off_rad > self.high_rad {
            return false;
        }
        let half_rad = (TOLERANCE_PX / away_px).min(1.0).asin();
        self.low_rad = self.low_rad.max(off_rad - half_rad);
        self.high_rad = self.high_rad.min(off_rad + half_rad);
        true
    }
}

/// A line through points of the map.
pub fn line(points_in_map: &[Point], frame: Frame) -> Path {
    let mut data = String::new();
    for (number, (x_px, y_px)) in course(points_in_map.iter().map(|&point| frame.at(point))).into_iter().enumerate() {
        let _ = write!(data, "{}{} {}", if number == 0 { "M" } else { "L" }, rounded(x_px), rounded(y_px));
    }
    Path::new().set("d", data).set("fill", "none").set("stroke-linejoin", "round").set("stroke-linecap", "round")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_cover_a_row_once() {
        assert_eq!(runs([1, 1, 2, 1].into_iter()), [(0, 2, 1), (2, 1, 2), (3, 1, 1)]);
        assert!(runs(std::iter::empty::<u8>()).is_empty());
    }

    /// How far a point is from a line.
    fn off_px(point: (f64, f64), line: &[(f64, f64)]) -> f64 {
        let to_stretch = |pair: &[(f64, f64)]| {
            let ((ax, ay), (bx, by)) = (pair[0], pair[1]);
            let (dx, dy) = (bx - ax, by - ay);
            let along = ((point.0 - ax) * dx + (point.1 - ay) * dy) / (dx * dx + dy * dy).max(1e-12);
            let along = along.clamp(0.0, 1.0);
            (point.0 - ax - along * dx).hypot(point.1 - ay - along * dy)
        };
        line.windows(2).map(to_stretch).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn a_line_of_few_points_passes_all_that_are_left_out() {
        let mut stream = rpl_random::Stream::new(3, "course");
        for step_px in [0.05, 0.5, 3.0] {
            let (mut x, mut y, mut heading_rad) = (0.0_f64, 0.0_f64, 0.0_f64);
            let mut points = vec![(x, y)];
            for _ in 0..3000 {
                heading_rad += 0.3 * (stream.uniform() - 0.5);
                (x, y) = (x + step_px * heading_rad.cos(), y + step_px * heading_rad.sin());
                points.push((x, y));
            }
            let kept = course(points.iter().copied());
            assert!(kept.len() < points.len() / 2, "{step_px}: {} of {}", kept.len(), points.len());
            let worst = points.iter().map(|&point| off_px(point, &kept)).fold(0.0, f64::max);
            assert!(worst <= 2.0 * TOLERANCE_PX, "{step_px}: {worst}");
            assert_eq!((kept.first(), kept.last()), (points.first(), points.last()));
        }
        let back = [(0.0, 0.0), (10.0, 0.0), (20.0, 0.0), (5.0, 0.0)];
        assert_eq!(course(back.into_iter()), [(0.0, 0.0), (20.0, 0.0), (5.0, 0.0)], "a turn is a corner");
    }
}
