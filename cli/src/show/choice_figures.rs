//! What active navigation considered, as pictures like the papers': probability of being occupied,
//! cost, expected entropy and pay-off of every action, the darker the more.

use crate::files::outputs::OutputFolder;
use anyhow::Result;
use rpl_robot::active::{ActionField, Choice, choose};
use rpl_robot::localization::Localization;
use rpl_robot::office::{MapModel, OfficeModel};
use svg::Document;
use svg::node::element::{Circle, Group, Rectangle, Text};

/// Edge of a cell in a picture, in pixels.
const CELL: usize = 2;

/// Steps of darkness.
const SHADES: f64 = 12.0;

/// Room above a picture for its title.
const TITLE: usize = 40;

/// Writes the pictures of one choice into a folder.
///
/// # Errors
/// A picture cannot be written.
pub fn write(folder: &mut OutputFolder, name: &str, office: &OfficeModel, localization: &Localization) -> Result<()> {
    let Some(MapModel { localization: model, .. }) = &office.map else { return Ok(()) };
    let parameters = &office.settings.active;
    let maxima = localization.maxima(model, parameters.max_maxima, parameters.min_mass);
    let Some((choice, field)) = choose(model, &maxima, &[], parameters) else { return Ok(()) };
    let widened = |values: &[f32]| values.iter().map(|&value| f64::from(value)).collect::<Vec<f64>>();
    let pictures = [
        ("occupancy", "P_occ: probability of being occupied", widened(&field.occupancy)),
        ("cost", "cost of the way [m of free way]", field.cost_m.clone()),
        ("entropy", "expected entropy [nats]", widened(&field.expected_entropy)),
        ("payoff", "pay-off [nats]", widened(&field.payoff)),
    ];
    for (kind, title, values) in pictures {
        folder.draw(&format!("{name}-{kind}.svg"), &draw(title, &values, &field, &choice))?;
    }
    Ok(())
}

/// One picture: the robot in the middle looks to the right; white where nothing is known or no way
/// leads.
fn draw(title: &str, values: &[f64], field: &ActionField, choice: &Choice) -> String {
    let side = field.grid.side();
    let known = values.iter().copied().filter(|value| value.is_finite());
    let (low, high) =
        known.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    let shade = |value: f64| {
        let share = if high > low { (value - low) / (high - low) } else { 0.0 };
        if value.is_finite() { (share * SHADES).round() as usize + 1 } else { 0 }
    };
    let mut cells = Group::new().set("shape-rendering", "crispEdges");
    for (row, line) in values.chunks(side).enumerate() {
        let mut column = 0;
        for run in line.chunk_by(|&a, &b| shade(a) == shade(b)) {
            let darkness = shade(run[0]);
            if darkness > 1 {
                let strip = Rectangle::new()
                    .set("x", CELL * column)
                    .set("y", TITLE + CELL * (side - 1 - row))
                    .set("width", CELL * run.len())
                    .set("height", CELL)
                    .set("fill-opacity", (darkness as f64 - 1.0) / SHADES * 0.9);
                cells = cells.add(strip);
            }
            column += run.len();
        }
    }
    let place = |x_m: f64, y_m: f64| {
        let along = |m: f64| (m / field.grid.resolution_m + field.grid.reach as f64 + 0.5) * CELL as f64;
        (along(x_m), (TITLE + CELL * side) as f64 - along(y_m))
    };
    let mark = |(x, y): (f64, f64), fill: &str| {
        Circle::new()
            .set("cx", x)
            .set("cy", y)
            .set("r", 6)
            .set("fill", fill)
            .set("stroke", "black")
            .set("stroke-width", 2)
    };
    let text = format!("{title}, {low:.2} (white) to {high:.2} (black); robot ●, target ○");
    Document::new()
        .set("viewBox", (0, 0, CELL * side, CELL * side + TITLE))
        .set("width", CELL * side)
        .set("height", CELL * side + TITLE)
        .set("font-family", "sans-serif")
        .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", "white"))
        .add(Text::new(text).set("x", 8).set("y", 25).set("font-size", 15))
        .add(cells)
        .add(mark(place(0.0, 0.0), "black"))
        .add(mark(place(choice.target_in_base.x, choice.target_in_base.y), "white"))
        .to_string()
}
