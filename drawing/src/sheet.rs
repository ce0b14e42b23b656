//! One page: a title, the map below it, scale and legend below that.

use super::frame::Frame;
use super::legend::Legend;
use super::palette;
use super::writing::{self, FAMILY, SMALL_PX, TEXT_PX, TITLE_PX, rounded, text};
use rpl_robot::geometry::Point;
use rpl_robot::world::Rect;
use svg::Document;
use svg::node::element::{Group, Line, Rectangle};

/// Around everything.
const MARGIN_PX: f64 = 18.0;

/// A map is drawn at most so large.
const MOST_WIDTH_PX: f64 = 960.0;
const MOST_HEIGHT_PX: f64 = 760.0;

/// The least width for title and legend.
const LEAST_WIDTH_PX: f64 = 560.0;

/// From the baseline of a line of the title to the next.
const TITLE_LINE_PX: f64 = 21.0;

/// A page and where things go on it.
pub struct Sheet {
    /// From the map frame to the page.
    pub frame: Frame,
    /// Of the whole page.
    pub width_px: f64,
    /// Upper left corner of the map.
    pub map_from_px: (f64, f64),
    /// Its lower right corner.
    pub map_to_px: (f64, f64),
    head: Group,
}

impl Sheet {
    /// A page for what lies within these bounds.
    pub fn new(bounds_in_map: Rect, title: &str, subtitle: &str) -> Self {
        let size_m = bounds_in_map.max - bounds_in_map.min;
        let px_per_m = (MOST_WIDTH_PX / size_m.x).min(MOST_HEIGHT_PX / size_m.y);
        let (map_width_px, map_height_px) = (size_m.x * px_per_m, size_m.y * px_per_m);
        let room_px = map_width_px.max(LEAST_WIDTH_PX);
        let mut y_px = MARGIN_PX + TITLE_PX * 0.8;
        let mut head = Group::new();
        for line in writing::wrap(title, TITLE_PX, room_px) {
            head = head.add(text(&line, MARGIN_PX, y_px, TITLE_PX).set("font-weight", "bold"));
            y_px += TITLE_LINE_PX;
        }
        for line in writing::wrap(subtitle, TEXT_PX, room_px) {
            head = head.add(text(&line, MARGIN_PX, y_px - 2.0, TEXT_PX).set("fill", palette::QUIET));
            y_px += TEXT_PX * 1.4;
        }
        let (left_px, top_px) = (MARGIN_PX + (room_px - map_width_px) / 2.0, y_px - 6.0);
        let corner_in_map = Point::new(bounds_in_map.min.x, bounds_in_map.max.y);
        Self {
            frame: Frame { px_per_m, corner_in_map, left_px, top_px },
            width_px: room_px + 2.0 * MARGIN_PX,
            map_from_px: (left_px, top_px),
            map_to_px: (left_px + map_width_px, top_px + map_height_px),
            head,
        }
    }

    /// The page with its map, and what its signs mean.
    pub fn finish(self, map: Group, legend: &Legend) -> String {
        let top_px = self.map_to_px.1 + 14.0;
        let (bar, bar_px) = self.scale_bar(top_px);
        let (legend, bottom_px) = legend.drawn(MARGIN_PX + bar_px + 28.0, MARGIN_PX, top_px, self.width_px - MARGIN_PX);
        let height_px = rounded(bottom_px.max(top_px + 24.0) + MARGIN_PX);
        let width_px = rounded(self.width_px);
        Document::new()
            .set("viewBox", (0, 0, width_px, height_px))
            .set("width", width_px)
            .set("height", height_px)
            .set("font-family", FAMILY)
            .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", palette::PAPER))
            .add(map)
            .add(self.head)
            .add(bar)
            .add(legend)
            .to_string()
    }

    /// A round length of about a tenth of the page, and how wide it is with its name.
    fn scale_bar(&self, top_px: f64) -> (Group, f64) {
        let length_m = round_below(110.0 / self.frame.px_per_m);
        let length_px = self.frame.length(length_m);
        let (from_px, to_px, y_px) = (MARGIN_PX, rounded(MARGIN_PX + length_px), rounded(top_px + 10.0));
        let line = |x1: f64, y1: f64, x2: f64, y2: f64| {
            Line::new().set("x1", x1).set("y1", y1).set("x2", x2).set("y2", y2).set("stroke", palette::INK)
        };
        let bar = Group::new()
            .set("class", "scale")
            .set("stroke-width", 1.5)
            .add(line(from_px, y_px, to_px, y_px))
            .add(line(from_px, y_px - 4.0, from_px, y_px + 4.0))
            .add(line(to_px, y_px - 4.0, to_px, y_px + 4.0))
            .add(text(&format!("{length_m} m"), to_px + 6.0, y_px + 4.0, SMALL_PX));
        (bar, length_px + 6.0 + writing::width_px(&format!("{length_m} m"), SMALL_PX))
    }
}

/// The largest of 1, 2 and 5 times a power of ten that is no more than this.
pub fn round_below(value: f64) -> f64 {
    let power = libm::exp10(libm::floor(libm::log10(value)));
    let share = value / power;
    let digit = if share >= 5.0 {
        5.0
    } else if share >= 2.0 {
        2.0
    } else {
        1.0
    };
    // A power below one is not exact: 5 times it is.
    if power < 1.0 { digit / (1.0 / power).round() } else { digit * power }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_is_a_round_number() {
        for (value, round) in [(3.9, 2.0), (5.0, 5.0), (0.13, 0.1), (0.07, 0.05), (999.0, 500.0), (1000.0, 1000.0)] {
            assert_eq!(round_below(value), round);
        }
    }
}
