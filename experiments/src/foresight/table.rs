//! What the rows have kept, kind by kind, and how far foresight comes from the reactive plan to the truth.

use super::rows::{FORESIGHT, ForesightDay, ONE_LOOK, REACTIVE, ROWS, RowDay, TRUTH};
use crate::findings::Findings;
use crate::statistics::Summary;
use rpl_shell::status::Status;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde::Serialize;
use serde_json::json;

/// A gap between reactive plan and truth, in points, that is worth closing; and one below which nothing can be said of
/// how much of it is closed.
const WIDE_GAP: f64 = 6.0;
const LEAST_GAP: f64 = 2.0;

/// Days of a kind.
#[derive(Clone, Debug, Serialize)]
struct KindOfDays {
    row: String,
    days: usize,
    orders: u32,
    /// Of all orders, row by row, in points.
    kept_percent: Vec<f64>,
    /// Foresight less the reactive plan, day by day, in points.
    gained_points: Option<Summary>,
    /// Foresight less one look ahead, day by day, in points.
    sampling_points: Option<Summary>,
    /// The truth less the reactive plan, in points.
    gap_points: f64,
    /// The part of that gap which foresight closes; none where it is small.
    gap_closed: Option<f64>,
    /// By how much later than with the reactive plan the work was done, in parts of a hundred.
    later_percent: Option<Summary>,
}

impl KindOfDays {
    fn of(row: &str, days: &[ForesightDay]) -> Self {
        let orders = days.iter().map(|day| day.orders).sum::<u32>();
        let kept = (0..ROWS.len()).map(|row| {
            let kept: u32 = days.iter().map(|day| day.rows[row].kept).sum();
            100.0 * f64::from(kept) / f64::from(orders.max(1))
        });
        let kept: Vec<f64> = kept.collect();
        let between = |row: usize, than: usize| {
            let of = |day: &ForesightDay| {
                100.0 * (f64::from(day.rows[row].kept) - f64::from(day.rows[than].kept)) / f64::from(day.orders.max(1))
            };
            Summary::of(&days.iter().map(of).collect::<Vec<_>>())
        };
        let later = |day: &ForesightDay| 100.0 * (day.rows[FORESIGHT].ended_s / day.rows[REACTIVE].ended_s - 1.0);
        let gap = kept[TRUTH] - kept[REACTIVE];
        Self {
            row: row.to_string(),
            days: days.len(),
            orders,
            gained_points: between(FORESIGHT, REACTIVE),
            sampling_points: between(FORESIGHT, ONE_LOOK),
            gap_points: gap,
            gap_closed: (gap >= LEAST_GAP).then(|| (kept[FORESIGHT] - kept[REACTIVE]) / gap),
            later_percent: Summary::of(&days.iter().map(later).collect::<Vec<_>>()),
            kept_percent: kept,
        }
    }
}

fn points(summary: &Option<Summary>) -> String {
    summary.map_or(NOTHING.to_string(), |Summary { spread, half_95, .. }| format!("{:+.1} ± {half_95:.1}", spread.mean))
}

/// A day that came to no end.
#[derive(Clone, Debug, Serialize)]
struct Failure<'a> {
    days: &'a str,
    seed: u64,
    plan: &'static str,
    failure: &'a str,
}

impl Failure<'_> {
    fn told(&self) -> String {
        let Self { days, seed, plan, failure } = self;
        format!("{days}, seed {seed}, {plan}: {failure}")
    }
}

/// How many of these are told below the table.
const MOST_FAILURES: usize = 10;

fn failures<'a>(kinds: &'a [String], tallies: &'a [Vec<ForesightDay>]) -> Vec<Failure<'a>> {
    let days = kinds.iter().zip(tallies).flat_map(|(kind, days)| days.iter().map(move |day| (kind, day)));
    let failed = days.flat_map(|(kind, day)| {
        ROWS.iter().zip(&day.rows).filter_map(|((plan, _), row)| {
            let failure = row.failure.as_deref()?;
            Some(Failure { days: kind, seed: day.seed, plan, failure })
        })
    });
    failed.collect()
}

/// The table, and what went wrong on any day.
pub(super) fn findings(kinds: &[String], tallies: &[Vec<ForesightDay>]) -> Findings {
    let all = tallies.concat();
    let mut rows: Vec<KindOfDays> = kinds.iter().zip(tallies).map(|(kind, days)| KindOfDays::of(kind, days)).collect();
    if rows.len() > 1 {
        let wide = rows.iter().zip(tallies).filter(|(row, _)| row.gap_points >= WIDE_GAP);
        let wide: Vec<ForesightDay> = wide.flat_map(|(_, days)| days.iter().cloned()).collect();
        if !wide.is_empty() {
            rows.push(KindOfDays::of("those with a gap of six points", &wide));
        }
        rows.push(KindOfDays::of("all", &all));
    }
    let mut heads = vec!["days", "number", "orders"];
    heads.extend(ROWS.iter().map(|row| row.0));
    heads.extend(["foresight gains", "sampling gains", "gap", "gap closed", "later [%]"]);
    let mut table = Table::new(&heads);
    for row in &rows {
        let mut cells = vec![row.row.clone(), row.days.to_string(), row.orders.to_string()];
        cells.extend(row.kept_percent.iter().map(|kept| format!("{kept:.1}")));
        cells.extend([points(&row.gained_points), points(&row.sampling_points)]);
        cells.push(format!("{:+.1}", row.gap_points));
        cells.push(row.gap_closed.map_or(NOTHING.to_string(), |share| format!("{:.0} %", 100.0 * share)));
        cells.push(points(&row.later_percent));
        table.row(cells);
    }
    let faults = |count: fn(&RowDay) -> u32| all.iter().flat_map(|day| &day.rows).map(count).sum::<u32>();
    let [on_floor, twice, held, failed] = [
        faults(|row| row.on_floor),
        faults(|row| row.twice),
        faults(|row| row.held),
        faults(|row| u32::from(row.failure.is_some())),
    ];
    let told = format!(
        "of {} days, each gone through by {} plans: things on the floor {on_floor}, put down twice {twice}, valves still \
         held {held}, days that failed {failed}",
        all.len(),
        ROWS.len()
    );
    let failures = failures(kinds, tallies);
    let told = [told].into_iter().chain(failures.iter().take(MOST_FAILURES).map(Failure::told)).collect::<Vec<_>>();
    let is_sound = on_floor + twice + held + failed == 0;
    let faults = json!({ "on_floor": on_floor, "twice": twice, "held": held, "failed": failed });
    let figures = json!({ "rows": rows, "faults": faults, "failures": failures });
    Findings {
        status: if is_sound { Status::Succeeded } else { Status::Failed },
        blocks: vec![Block::Table(table), Block::Lines(told.join("\n"))],
        figures,
        drawings: Vec::new(),
    }
}
