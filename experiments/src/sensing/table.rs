//! The table of the experiment, and its runs as lines.

use super::course::{CERTAIN_WITHIN_S, HELD_S, SensingRun, SensingRuns};
use crate::statistics::{Dispersion, Proportion, Summary};
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde::Serialize;

/// Times at which the error is told.
const AT_S: [f64; 4] = [100.0, 200.0, 400.0, 600.0];

/// What came of the runs of a row.
#[derive(Clone, Debug, Serialize)]
pub struct SensingRow {
    name: &'static str,
    certain: Proportion,
    /// When the robot became certain, in the runs in which it ever did.
    certain_after_s: Option<Summary>,
    error: Vec<ErrorAt>,
    /// Medians of the probability at the true position at the end, and at the mirrored one.
    there: Option<f64>,
    mirrored: Option<f64>,
}

/// The error at a time, mean over the runs.
#[derive(Clone, Copy, Debug, Serialize)]
struct ErrorAt {
    time_s: f64,
    mean_m: Option<f64>,
}

/// The figures of each row.
pub fn results(rows: &SensingRuns) -> Vec<SensingRow> {
    rows.iter().map(|(setting, courses)| SensingRow::of(setting.name, courses)).collect()
}

impl SensingRow {
    fn of(name: &'static str, courses: &[SensingRun]) -> Self {
        let median = |numbers: &[f64]| Dispersion::of(numbers).map(|spread| spread.median);
        let last = courses.iter().filter_map(|course| course.moments.last());
        Self {
            name,
            certain: Proportion::new(courses.iter().filter(|course| course.succeeded()).count(), courses.len()),
            certain_after_s: Summary::of(&courses.iter().filter_map(SensingRun::certain_after_s).collect::<Vec<f64>>()),
            error: AT_S.iter().map(|&time_s| ErrorAt { time_s, mean_m: error_at(courses, time_s) }).collect(),
            there: median(&last.map(|moment| moment.near).collect::<Vec<f64>>()),
            mirrored: median(&courses.iter().map(|course| course.mirrored).collect::<Vec<f64>>()),
        }
    }

    fn cells(&self) -> impl Iterator<Item = String> {
        let two = |number: Option<f64>| number.map_or(NOTHING.to_string(), |number| format!("{number:.2}"));
        let (low, high) = self.certain.interval_95;
        let after = self.certain_after_s.map_or(NOTHING.to_string(), |Summary { spread, .. }| {
            format!("{:.0} ({:.0}–{:.0})", spread.median, spread.min, spread.max)
        });
        let interval = format!("{:.0}–{:.0} %", 100.0 * low, 100.0 * high);
        [self.name.to_string(), self.certain.fraction(), interval, after]
            .into_iter()
            .chain(self.error.iter().map(move |error| two(error.mean_m)))
            .chain([two(self.there), two(self.mirrored)])
    }
}

/// Mean over the runs.
fn error_at(courses: &[SensingRun], at_s: f64) -> Option<f64> {
    let at =
        |course: &SensingRun| course.moments.iter().find(|moment| moment.time_s >= at_s).map(|moment| moment.error_m);
    let errors: Vec<f64> = courses.iter().filter_map(at).collect();
    Dispersion::of(&errors).map(|spread| spread.mean)
}

/// A line for each row.
pub fn blocks(rows: &[SensingRow]) -> Vec<Block> {
    let errors = AT_S.map(|at_s| format!("at {at_s:.0} s"));
    let head = ["", "certain", "95 % interval", "after [s]"].into_iter();
    let head: Vec<&str> = head.chain(errors.iter().map(String::as_str)).chain(["there", "mirrored"]).collect();
    let mut table = Table::new(&head);
    rows.iter().for_each(|row| table.row(row.cells()));
    let notes = format!(
        "certain: at least 0.9 within 0.4 m of the true position, from at most {CERTAIN_WITHIN_S:.0} s on and for \
         {HELD_S:.0} s; after: median, least and greatest, of all runs that ever were; at a time: error [m], L1, \
         weighted by the belief, mean; there, mirrored: probability at the end within 0.4 m of the true and of the \
         mirrored position, medians"
    );
    vec![Block::Table(table), Block::Lines(notes)]
}

/// The names of the values of [`line`].
pub const HEAD: &str = "row,seed,certain after [s],error at the end [m],at the position,at the mirrored";

/// A run as a line of comma-separated values.
pub fn line(row: &str, course: &SensingRun) -> String {
    let after = course.certain_after_s().map_or(String::new(), |time_s| time_s.to_string());
    let (error_m, near) = course.moments.last().map_or((0.0, 0.0), |moment| (moment.error_m, moment.near));
    format!("\"{row}\",{},{after},{error_m},{near},{}\n", course.seed, course.mirrored)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensing::course::SensingMoment;
    use crate::sensing::settings::SETTINGS;

    fn course(near: impl Fn(usize) -> f64) -> SensingRun {
        let moment = |second: usize| SensingMoment { time_s: second as f64, error_m: 0.5, near: near(second) };
        SensingRun { seed: 1, moments: (1..=600).map(moment).collect(), mirrored: 0.1 }
    }

    #[test]
    fn certain_is_who_stays_certain_for_a_while_and_soon_enough() {
        let late = course(|second| if second > 450 { 0.95 } else { 0.5 });
        let soon = course(|second| if (100..200).contains(&second) || second > 250 { 0.95 } else { 0.5 });
        let glimpse = course(|second| if second % 60 > 5 { 0.95 } else { 0.5 });
        assert_eq!(late.certain_after_s(), Some(451.0));
        assert_eq!(soon.certain_after_s(), Some(100.0));
        assert_eq!(glimpse.certain_after_s(), None);
        let result = SensingRow::of(SETTINGS[0].name, &[late, soon, glimpse]);
        let cells: Vec<String> = result.cells().collect();
        assert_eq!(cells[1..=3], ["1/3", "6–79 %", "276 (100–451)"]);
        assert_eq!(cells[4..8], ["0.50"; 4]);
    }
}
