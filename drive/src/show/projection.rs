//! How a mission would probably go on, as tables.

use rpl_runtime::state::figures::Figures;
use rpl_runtime::state::projected::Grain;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};

/// What runs are called beside those in events.
fn of_grain(grain: Grain) -> &'static str {
    match grain {
        Grain::Abstract => "",
        Grain::Simulated => "simulated ",
    }
}

/// What is told of a projection.
pub fn blocks(figures: &Figures) -> Vec<Block> {
    let [share, low, high] = figures.success.map(|share| 100.0 * share);
    let mut lines = vec![format!(
        "{} of {} {}runs succeed: success is probable to {share:.0} % (95 % interval {low:.0} to {high:.0} %)",
        figures.successes,
        figures.runs,
        of_grain(figures.grain)
    )];
    lines.push(match figures.time_s {
        Some([early, median, late]) => {
            format!("they take {median:.0} s; one in ten less than {early:.0} s, one in ten more than {late:.0} s")
        }
        None => format!("none succeeds within {:.0} s", figures.horizon_s),
    });
    let mut blocks = vec![Block::Lines(lines.join("\n"))];
    if !figures.failures.is_empty() {
        let mut table = Table::new(&["what goes wrong", "share", "where", "the first says"]);
        for failure in &figures.failures {
            let place = if failure.place.is_empty() { NOTHING.to_string() } else { failure.place.clone() };
            let share = format!("{:.0} %", 100.0 * failure.share);
            table.row([failure.class.clone(), share, place, failure.message.clone()]);
        }
        blocks.push(Block::Table(table));
    }
    if !figures.timeline.is_empty() {
        let mut table = Table::new(&["step", "share", "begins early [s]", "median", "late"]);
        for step in &figures.timeline {
            let share = format!("{:.0} %", 100.0 * step.share);
            let [early, median, late] = step.begins_s.map(|time_s| format!("{time_s:.0}"));
            table.row([step.path.clone(), share, early, median, late]);
        }
        blocks.push(Block::Table(table));
    }
    let mut table = Table::new(&["fluent in the end", "low", "median", "high"]);
    for fluent in &figures.fluents {
        let [low, median, high] = fluent.quantiles.map(|number| format!("{number:.2}"));
        table.row([fluent.name.clone(), low, median, high]);
    }
    if !figures.fluents.is_empty() {
        blocks.push(Block::Table(table));
    }
    blocks
}
