//! What only world files have: rectangles, axes, travel modes, and sensors that see things.

use super::{Axis, Rect, SeenBy, TravelMode};
use crate::file_text::{Reader, TomlTable};
use crate::geometry::Point;

impl<'i> Reader<'i> {
    pub(super) fn rect(&mut self, table: &TomlTable<'_, 'i>, key: &str) -> Option<Rect> {
        let example = "[2.0, 1.0, 3.5, 1.8]";
        let value = self.required(table, key, example)?;
        let [x0, y0, x1, y1] = self.numbers(value, key, example)?;
        if x0 < x1 && y0 < y1 {
            return Some(Rect { min: Point::new(x0, y0), max: Point::new(x1, y1) });
        }
        let message = format!("`{key}` has no area: it runs from ({x0}, {y0}) to ({x1}, {y1})");
        self.note(value.span(), key, message, "write [x0, y0, x1, y1] with x0 < x1 and y0 < y1");
        None
    }

    pub(super) fn axis(&mut self, table: &TomlTable<'_, 'i>) -> Option<Axis> {
        self.choice(table, "axis", &[("x", Axis::X), ("y", Axis::Y)])
    }

    pub(super) fn mode(&mut self, table: &TomlTable<'_, 'i>) -> Option<TravelMode> {
        let modes =
            [("hallway", TravelMode::Hallway), ("office", TravelMode::Office), ("doorway", TravelMode::Doorway)];
        self.choice(table, "mode", &modes)
    }

    pub(super) fn seen_by(&mut self, table: &TomlTable<'_, 'i>) -> SeenBy {
        let mut seen_by = SeenBy { sonar: true, laser: true };
        let Some(value) = table.values.get("seen_by") else { return seen_by };
        let Some(elements) = value.get_ref().as_array() else {
            self.expected(value, "seen_by", "an array of sensors", "[\"sonar\"]");
            return seen_by;
        };
        seen_by = SeenBy { sonar: false, laser: false };
        for element in elements.iter() {
            match self.choice_value(element, "seen_by", &[("sonar", true), ("laser", false)]) {
                Some(true) => seen_by.sonar = true,
                Some(false) => seen_by.laser = true,
                None => {}
            }
        }
        seen_by
    }
}
