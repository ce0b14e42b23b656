//! What plans have measured, as a chart: the mean of each measure in each variant, with its 95 % interval.

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

/// A measure in each variant that has it.
struct Panel<'r> {
    quantity: &'r Quantity,
    rows: Vec<(usize, &'r str, Summary)>,
}

impl Panel<'_> {
    /// The stretch of numbers that the intervals take, with some air.
    fn range(&self) -> (f64, f64) {
        let ends = self
            .rows
            .iter()
            .map(|(_, _, summary)| (summary.spread.mean - summary.half_95, summary.spread.mean + summary.half_95));
        let (low, high) =
            ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (a, b)| (low.min(a), high.max(b)));
        let air = ((high - low) / 12.0).max(low.abs().max(high.abs()) / 50.0).max(1e-3);
        (low - air, high + air)
    }

    fn height(&self) -> f64 {
        HEAD + ROW * self.rows.len() as f64 + FOOT
    }
}

/// The chart; none if no plan has measured anything.
pub fn means(results: &[RowResult]) -> Option<String> {
    let mut panels: Vec<Panel<'_>> = Vec::new();
    for (number, result) in results.iter().enumerate() {
        let own = result.measures.iter().filter(|measure| matches!(measure.quantity, Quantity::Own(_)));
        for measure in own {
            let row = (number, result.name.as_str(), measure.summary);
            match panels.iter_mut().find(|panel| *panel.quantity == measure.quantity) {
                Some(panel) => panel.rows.push(row),
                None => panels.push(Panel { quantity: &measure.quantity, rows: vec![row] }),
            }
        }
    }
    if panels.is_empty() {
        return None;
    }
    let names = results.iter().map(|result| width_px(&result.name, SMALL_PX));
    let left = EDGE + names.fold(40.0, f64::max).min(LONGEST_NAME) + 14.0;
    let height = TOP + panels.iter().map(Panel::height).sum::<f64>();
    let sheet_width = left + WIDTH + EDGE + 60.0;
    let mut document = Document::new()
        .set("viewBox", (0, 0, sheet_width, height))
        .set("width", sheet_width)
        .set("height", height)
        .set("font-family", FAMILY)
        .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", palette::PAPER))
        .add(text("What the plans measured: mean and 95 % interval", EDGE, 28.0, TITLE_PX).set("font-weight", "bold"));
    let mut top = TOP;
    for panel in &panels {
        document = drawn(document, panel, left, top);
        top += panel.height();
    }
    Some(document.to_string())
}

/// A measure below the others.
fn drawn(mut document: Document, panel: &Panel<'_>, left: f64, top: f64) -> Document {
    let (low, high) = panel.range();
    let x = |value: f64| rounded(left + WIDTH * (value - low) / (high - low));
    let bottom = top + HEAD + ROW * panel.rows.len() as f64;
    let line = |from: (f64, f64), to: (f64, f64), colour: &str| {
        Line::new().set("x1", from.0).set("y1", from.1).set("x2", to.0).set("y2", to.1).set("stroke", colour)
    };
    document = document.add(text(panel.quantity.name(), EDGE, top + 20.0, TEXT_PX).set("font-weight", "bold"));
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
    for (at, (number, name, summary)) in panel.rows.iter().enumerate() {
        let y = top + HEAD + ROW * (at as f64 + 0.5) - 3.0;
        let (mean, half) = (summary.spread.mean, summary.half_95);
        document = document
            .add(ending(&shortened(name, SMALL_PX, LONGEST_NAME), left - 12.0, y + 4.0, SMALL_PX))
            .add(line((x(mean - half), y), (x(mean + half), y), series(*number)).set("stroke-width", 3))
            .add(Circle::new().set("cx", x(mean)).set("cy", y).set("r", 5).set("fill", series(*number)))
            .add(text(&axis_label(mean), left + WIDTH + 10.0, y + 4.0, SMALL_PX));
    }
    document
}
