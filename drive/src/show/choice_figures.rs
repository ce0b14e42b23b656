//! What active navigation considered, as pictures like the papers' (Beetz et al., Figs. 5 to 8): probability of being
//! occupied, cost, expected entropy and pay-off of every action, the darker the more.

use anyhow::Result;
use rpl_drawing::shades::{STEPS, ShadeScale};
use rpl_drawing::{Field, MarkKind};
use rpl_robot::active::{ActionField, Choice};
use rpl_robot::geometry::{Point, distance_m};
use rpl_shell::files::outputs::OutputFolder;

/// Targets that are shown beside the chosen one, and how far they are apart at least.
const ALTERNATIVES: usize = 4;
const APART_M: f64 = 2.0;

/// The next best targets that are apart from each other and from the chosen one, the best first, and how much less they
/// pay, in nats. Cost: the cells, for each.
pub(crate) fn alternatives(choice: &Choice, field: &ActionField) -> Vec<(Point, f64)> {
    let mut found = vec![choice.target_in_base];
    let mut others = Vec::new();
    let pays = |cell: usize| f64::from(field.payoff[cell]);
    let chosen = field.grid.cell_at(choice.target_in_base).map_or(0.0, pays);
    while others.len() < ALTERNATIVES {
        let is_apart = |cell: &usize| {
            let point = field.grid.point_in_base(*cell);
            point.coords.norm() >= APART_M && found.iter().all(|other| distance_m(point, *other) >= APART_M)
        };
        let cells = (0..field.payoff.len()).filter(|&cell| pays(cell).is_finite()).filter(is_apart);
        let Some(best) = cells.reduce(|best, cell| if pays(cell) > pays(best) { cell } else { best }) else { break };
        found.push(field.grid.point_in_base(best));
        others.push((field.grid.point_in_base(best), chosen - pays(best)));
    }
    others
}

/// Writes the pictures of one choice into a folder.
///
/// # Errors
/// A picture cannot be written.
pub fn write(folder: &mut OutputFolder, name: &str, choice: &Choice, field: &ActionField) -> Result<()> {
    let widened = |values: &[f32]| values.iter().map(|&value| f64::from(value)).collect::<Vec<f64>>();
    let pictures = [
        ("occupancy", "Probability that a target point is occupied", "P_occ", widened(&field.occupancy)),
        ("cost", "Cost of the way to a target point", "v [m of free way]", field.cost_m.clone()),
        ("entropy", "Expected entropy at a target point", "E[H] [nats]", widened(&field.expected_entropy)),
        ("payoff", "Pay-off of a target point", "−E[H] − α v [nats]", widened(&field.payoff)),
    ];
    for (kind, title, means, values) in pictures {
        folder.draw(&format!("{name}-{kind}.svg"), &picture(title, means, &values, choice, field))?;
    }
    Ok(())
}

/// One picture, in the robot's frame: it stands at (0, 0) and looks along x; white where nothing is known or no way leads.
fn picture(title: &str, means: &str, values: &[f64], choice: &Choice, field: &ActionField) -> String {
    let known = values.iter().copied().filter(|value| value.is_finite());
    let (low, high) =
        known.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    let room = if high > low { high - low } else { 1.0 };
    let step = |value: f64| value.is_finite().then(|| (((value - low) / room * STEPS as f64) as usize).min(STEPS - 1));
    let tick = |quarter: usize| {
        let share = quarter as f64 / 4.0;
        (share * STEPS as f64, format!("{:.2}", low + share * room))
    };
    let others = alternatives(choice, field);
    let marks = others.iter().map(|&(target, less)| (MarkKind::Alternative, target, format!("−{less:.2}")));
    Field {
        title,
        subtitle: "seen from the robot, which stands at (0, 0) and looks along x; metres",
        grid: field.grid,
        steps: values.iter().map(|&value| step(value)).collect(),
        scale: ShadeScale { means: means.to_string(), ticks: (0..=4).map(tick).collect() },
        way_in_base: std::iter::once(Point::origin()).chain(choice.path_in_base.iter().copied()).collect(),
        marks: marks
            .chain([
                (MarkKind::Target, choice.target_in_base, String::new()),
                (MarkKind::Robot, Point::origin(), String::new()),
            ])
            .collect(),
    }
    .draw()
}
