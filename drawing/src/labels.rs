//! Names beside points: each where it covers no other name, and rather the floor than a wall.

use super::writing::{self, rounded, text, with_halo};
use svg::node::element::Group;

/// The sheet is divided into squares of this size, each of which is free or not.
const GRAIN_PX: f64 = 3.0;

/// A name is so far from its mark; farther only where there is no room nearer.
const AWAY_PX: [f64; 3] = [4.0, 11.0, 20.0];

/// What lies in the squares of a sheet.
pub struct Labels {
    columns: usize,
    rows: usize,
    /// Names and marks are there.
    taken: Vec<bool>,
    /// Walls and the like are there: rather not.
    crossed: Vec<bool>,
    drawn: Group,
    /// Names for which there was no room.
    pub left_out: usize,
}

/// A rectangle of the sheet: left, top, right, bottom.
type Box4 = (f64, f64, f64, f64);

impl Labels {
    /// A sheet of this size with nothing on it.
    pub fn new(width_px: f64, height_px: f64) -> Self {
        let count = |length_px: f64| (length_px / GRAIN_PX).ceil() as usize + 1;
        let (columns, rows) = (count(width_px), count(height_px));
        let none = vec![false; columns * rows];
        Self {
            columns,
            rows,
            taken: none.clone(),
            crossed: none,
            drawn: Group::new().set("class", "labels"),
            left_out: 0,
        }
    }

    fn squares(&self, (left, top, right, bottom): Box4) -> impl Iterator<Item = usize> + use<> {
        let index = |at_px: f64, count: usize| (at_px / GRAIN_PX).max(0.0).min(count as f64 - 1.0) as usize;
        let columns = index(left, self.columns)..=index(right, self.columns);
        let rows = index(top, self.rows)..=index(bottom, self.rows);
        let width = self.columns;
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
    }

    /// No name may be there.
    pub fn take(&mut self, area: Box4) {
        for square in self.squares(area) {
            self.taken[square] = true;
        }
    }

    /// A name is rather elsewhere.
    pub fn cross(&mut self, area: Box4) {
        for square in self.squares(area) {
            self.crossed[square] = true;
        }
    }

    /// A line from point to point, as something a name is rather not on.
    pub fn cross_line(&mut self, from: (f64, f64), to: (f64, f64)) {
        let steps = ((to.0 - from.0).hypot(to.1 - from.1) / GRAIN_PX).ceil().max(1.0);
        for step in 0..=steps as usize {
            let share = step as f64 / steps;
            let (x, y) = (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
            self.cross((x, y, x, y));
        }
    }

    /// How bad a name is there: the squares it would cross. None if something is there, or it would leave the sheet.
    fn cost(&self, area: Box4) -> Option<usize> {
        let (width_px, height_px) = (self.columns as f64 * GRAIN_PX, self.rows as f64 * GRAIN_PX);
        if area.0 < 0.0 || area.1 < 0.0 || area.2 > width_px || area.3 > height_px {
            return None;
        }
        let mut crossed = 0;
        for square in self.squares(area) {
            if self.taken[square] {
                return None;
            }
            crossed += usize::from(self.crossed[square]);
        }
        Some(crossed)
    }

    /// Writes a name beside a mark of this radius: to the right, the left, above, below, or between these.
    pub fn beside(&mut self, name: &str, (x_px, y_px): (f64, f64), radius_px: f64, size_px: f64, colour: &str) {
        let width_px = writing::width_px(name, size_px);
        let around = |away_px: f64| {
            let slant_px = away_px * 0.8;
            [
                (x_px + away_px, y_px - size_px / 2.0),
                (x_px - away_px - width_px, y_px - size_px / 2.0),
                (x_px - width_px / 2.0, y_px - away_px - size_px),
                (x_px - width_px / 2.0, y_px + away_px),
                (x_px + slant_px, y_px - slant_px - size_px),
                (x_px + slant_px, y_px + slant_px),
                (x_px - slant_px - width_px, y_px - slant_px - size_px),
                (x_px - slant_px - width_px, y_px + slant_px),
            ]
        };
        let corners: Vec<(f64, f64)> = AWAY_PX.into_iter().flat_map(|away_px| around(radius_px + away_px)).collect();
        self.write(name, &corners, (width_px, size_px), colour);
    }

    /// Writes a name around a point, or somewhat above or below it.
    pub fn around(&mut self, name: &str, (x_px, y_px): (f64, f64), size_px: f64, colour: &str) {
        let width_px = writing::width_px(name, size_px);
        let corner = |lines: f64, along: f64| (x_px + (along - 0.5) * width_px, y_px + (lines - 0.5) * size_px);
        let corners: Vec<(f64, f64)> = [0.0, -1.5, 1.5, -3.0, 3.0]
            .into_iter()
            .flat_map(|lines| [0.0, -0.4, 0.4].map(|along| corner(lines, along)))
            .collect();
        self.write(name, &corners, (width_px, size_px), colour);
    }

    fn write(&mut self, name: &str, corners: &[(f64, f64)], (width_px, size_px): (f64, f64), colour: &str) {
        let area = |&(x, y): &(f64, f64)| (x, y, x + width_px, y + size_px);
        let costs = corners.iter().map(area).filter_map(|area| Some((self.cost(area)?, area)));
        let Some((_, best)) = costs.min_by_key(|(cost, _)| *cost) else {
            self.left_out += 1;
            return;
        };
        self.take(best);
        let written = text(name, best.0, rounded(best.3 - 0.2 * size_px), size_px).set("fill", colour);
        let drawn = std::mem::replace(&mut self.drawn, Group::new());
        self.drawn = drawn.add(with_halo(written));
    }

    /// What was written.
    pub fn drawn(self) -> Group {
        self.drawn
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_names_overlap_and_what_has_no_room_is_counted() {
        let mut labels = Labels::new(300.0, 60.0);
        let written = 40;
        for number in 0..written {
            labels.beside("a-place", (20.0 + 7.0 * f64::from(number), 30.0), 3.0, 11.0, "black");
        }
        let (left_out, drawn) = (labels.left_out, labels.drawn().to_string());
        let value = |tag: &str, name: &str| -> f64 {
            let rest = tag.split(&format!(" {name}=\"")).nth(1).expect("it is there");
            rest.split('"').next().expect("its end").parse().expect("a number")
        };
        let corners: Vec<(f64, f64)> =
            drawn.split("<text").skip(1).map(|tag| (value(tag, "x"), value(tag, "y"))).collect();
        assert_eq!(corners.len() + left_out, written as usize);
        assert!(corners.len() > 5 && left_out > 0);
        let width_px = writing::width_px("a-place", 11.0);
        for (number, one) in corners.iter().enumerate() {
            for other in &corners[number + 1..] {
                let apart = (one.0 - other.0).abs() >= width_px || (one.1 - other.1).abs() >= 11.0;
                assert!(apart, "{one:?} {other:?}");
            }
        }
    }

    #[test]
    fn a_name_is_rather_on_the_floor_than_on_a_wall() {
        let mut labels = Labels::new(300.0, 100.0);
        labels.cross((150.0, 0.0, 300.0, 100.0));
        labels.beside("here", (140.0, 50.0), 3.0, 11.0, "black");
        let drawn = labels.drawn().to_string();
        let x: f64 =
            drawn.split(" x=\"").nth(1).and_then(|rest| rest.split('"').next()).expect("x").parse().expect("a number");
        assert!(x < 140.0, "{drawn}");
    }
}
