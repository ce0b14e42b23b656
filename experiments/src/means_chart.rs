//! Means with their 95 % intervals as charts: of each measure in each variant, and of how variants differ.

use super::chart::{axis_label, axis_up_to, series};
use super::quantity::Quantity;
use super::row_result::RowResult;
use super::statistics::Summary;
use rpl_drawing::palette;
use rpl_drawing::writing::{FAMILY, SMALL_PX, TEXT_PX, TITLE_PX, centred, ending, rounded, shortened, text, width_px};
use svg::Document;
use svg::node::element::{Circle, Line, Rectangle};

/// Where everything is on the sheet, in pixels.
const EDGE: f64 = 18.0;
const WIDTH: f64 = 420.0;
const ROW: f64 = 24.0;
const HEAD: f64 = 34.0;
const FOOT: f64 = 34.0;
const TOP: f64 = 44.0;
const LONGEST_NAME: f64 = 260.0;

/// A mean with its interval, of a variant.
pub struct Row<'r> {
    /// The number of the variant, which has its colour.
    pub variant: usize,
    /// Its name.
    pub name: &'r str,
    /// The mean.
    pub mean: f64,
    /// Its 95 % interval.
    pub interval_95: (f64, f64),
}

impl<'r> Row<'r> {
    /// The mean of a summary.
    pub fn of(variant: usize, name: &'r str, summary: &Summary) -> Self {
        let (mean, half) = (summary.spread.mean, summary.half_95);
        Self { variant, name, mean, interval_95: (mean - half, mean + half) }
    }
}

/// A quantity in each variant that has it.
struct Panel<'r> {
    quantity: &'r str,
    rows: Vec<Row<'r>>,
}

impl Panel<'_> {
    /// The stretch of numbers that the intervals take, with some air; of differences with their zero.
    fn range(&self, has_zero: bool) -> (f64, f64) {
        let start = if has_zero { (0.0, 0.0) } else { (f64::INFINITY, f64::NEG_INFINITY) };
        let ends = self.rows.iter().map(|row| row.interval_95);
        let (low, high) = ends.fold(start, |(low, high), (a, b)| (low.min(a), high.max(b)));
        let air = ((high - low) / 12.0).max(low.abs().max(high.abs()) / 50.0).max(1e-3);
        (low - air, high + air)
    }

    fn height(&self) -> f64 {
        HEAD + ROW * self.rows.len() as f64 + FOOT
    }
}

/// Panels, one below the other.
#[derive(Default)]
pub struct Panels<'r> {
    panels: Vec<Panel<'r>>,
    /// Whether the rows are differences: zero is marked.
    are_differences: bool,
}

impl<'r> Panels<'r> {
    /// None yet, of differences.
    pub fn of_differences() -> Self {
        Self { are_differences: true, ..Self::default() }
    }

    /// A row of a quantity, below those that it has.
    pub fn add(&mut self, quantity: &'r str, row: Row<'r>) {
        match self.panels.iter_mut().find(|panel| panel.quantity == quantity) {
            Some(panel) => panel.rows.push(row),
            None => self.panels.push(Panel { quantity, rows: vec![row] }),
        }
    }

    /// The chart; none without a panel.
    pub fn drawn(&self, title: &str) -> Option<String> {
        if self.panels.is_empty() {
            return None;
        }
        let names = self.panels.iter().flat_map(|panel| &panel.rows).map(|row| width_px(row.name, SMALL_PX));
        let left = EDGE + names.fold(40.0, f64::max).min(LONGEST_NAME) + 14.0;
        let height = TOP + self.panels.iter().map(Panel::height).sum::<f64>();
        let sheet_width = (left + WIDTH + EDGE + 60.0).max(2.0 * EDGE + 1.1 * width_px(title, TITLE_PX));
        let mut document = Document::new()
            .set("viewBox", (0, 0, sheet_width, height))
            .set("width", sheet_width)
            .set("height", height)
            .set("font-family", FAMILY)
            .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", palette::PAPER))
            .add(text(title, EDGE, 28.0, TITLE_PX).set("font-weight", "bold"));
        let mut top = TOP;
        for panel in &self.panels {
            document = drawn(document, panel, self.are_differences, left, top);
            top += panel.height();
        }
        Some(document.to_string())
    }
}

/// The chart of what plans have measured; none if no plan has measured anything.
pub fn means(results: &[RowResult]) -> Option<String> {
    let mut panels = Panels::default();
    for (number, result) in results.iter().enumerate() {
        let own = result.measures.iter().filter(|measure| matches!(measure.quantity, Quantity::Own(_)));
        own.for_each(|measure| {
            panels.add(measure.quantity.name(), Row::of(number, &result.name, &measure.summary));
        });
    }
    panels.drawn("What the plans measured: mean and 95 % interval")
}

/// A measure below the others.
fn drawn(mut document: Document, panel: &Panel<'_>, has_zero: bool, left: f64, top: f64) -> Document {
    let (low, high) = panel.range(has_zero);
    let x = |value: f64| rounded(left + WIDTH * (value - low) / (high - low));
    let bottom = top + HEAD + ROW * panel.rows.len() as f64;
    let line = |from: (f64, f64), to: (f64, f64), colour: &str| {
        Line::new().set("x1", from.0).set("y1", from.1).set("x2", to.0).set("y2", to.1).set("stroke", colour)
    };
    document = document.add(text(panel.quantity, EDGE, top + 20.0, TEXT_PX).set("font-weight", "bold"));
    let step = axis_up_to((high - low) / 4.0).0;
    let first = libm::ceil(low / step);
    for tick in 0..=libm::floor(high / step - first) as u32 {
        let value = (first + f64::from(tick)) * step;
        document = document.add(line((x(value), top + HEAD - 6.0), (x(value), bottom), palette::GRID)).add(centred(
            &axis_label(value),
            x(value),
            bottom + 15.0,
            SMALL_PX,
        ));
    }
    if has_zero {
        document =
            document.add(line((x(0.0), top + HEAD - 6.0), (x(0.0), bottom), palette::QUIET).set("stroke-width", 2));
    }
    for (at, Row { variant, name, mean, interval_95: (least, most) }) in panel.rows.iter().enumerate() {
        let y = top + HEAD + ROW * (at as f64 + 0.5) - 3.0;
        document = document
            .add(ending(&shortened(name, SMALL_PX, LONGEST_NAME), left - 12.0, y + 4.0, SMALL_PX))
            .add(line((x(*least), y), (x(*most), y), series(*variant)).set("stroke-width", 3))
            .add(Circle::new().set("cx", x(*mean)).set("cy", y).set("r", 5).set("fill", series(*variant)))
            .add(text(&axis_label(*mean), left + WIDTH + 10.0, y + 4.0, SMALL_PX));
    }
    document
}
