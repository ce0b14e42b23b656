//! Runs over seeds on several threads, and their table.

use super::statistics::{Spread, wilson_95};
use crossbeam::channel;
use std::sync::atomic::{AtomicUsize, Ordering};

/// One run of an experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Its seed.
    pub seed: u64,
    /// Whether the plan succeeded.
    pub succeeded: bool,
    /// What was measured: name with unit, and value, if there was anything to measure in this run;
    /// the same names in every run.
    pub measures: Vec<(&'static str, Option<f64>)>,
}

/// One result for each seed, in the order of the seeds however the threads were scheduled.
/// `done` is called after each.
pub fn run_all<T: Send>(seeds: &[u64], jobs: usize, run: impl Fn(u64) -> T + Sync, mut done: impl FnMut()) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = channel::unbounded();
    let mut results: Vec<(usize, T)> = Vec::with_capacity(seeds.len());
    std::thread::scope(|scope| {
        for _ in 0..jobs.clamp(1, seeds.len().max(1)) {
            let sender = sender.clone();
            let (next, run) = (&next, &run);
            scope.spawn(move || {
                loop {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    let Some(&seed) = seeds.get(at) else { return };
                    if sender.send((at, run(seed))).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        for result in &receiver {
            results.push(result);
            done();
        }
    });
    results.sort_by_key(|&(at, _)| at);
    results.into_iter().map(|(_, result)| result).collect()
}

/// The table of an experiment.
pub fn table(name: &str, trials: &[Trial]) -> String {
    let successes = trials.iter().filter(|trial| trial.succeeded).count();
    let (low, high) = wilson_95(successes, trials.len());
    let seeds = match (trials.first(), trials.last()) {
        (Some(first), Some(last)) if trials.len() > 1 => format!("seeds {} to {}", first.seed, last.seed),
        (Some(first), _) => format!("seed {}", first.seed),
        _ => "no seeds".to_string(),
    };
    let rate = if trials.is_empty() { 0.0 } else { 100.0 * successes as f64 / trials.len() as f64 };
    let mut lines = vec![
        format!("{name}: {} runs, {seeds}", trials.len()),
        format!(
            "succeeded {successes} of {}: {rate:.1} %, 95 % interval {:.1} to {:.1} % (Wilson)",
            trials.len(),
            100.0 * low,
            100.0 * high
        ),
        format!(
            "{:20} {:>6} {:>10} {:>10} {:>10} {:>10} {:>10}",
            "", "runs", "mean", "deviation", "min", "median", "max"
        ),
    ];
    let names: Vec<&str> =
        trials.first().map_or(Vec::new(), |trial| trial.measures.iter().map(|&(name, _)| name).collect());
    for (at, name) in names.into_iter().enumerate() {
        let numbers: Vec<f64> =
            trials.iter().filter_map(|trial| trial.measures.get(at)).filter_map(|&(_, value)| value).collect();
        if let Some(spread) = Spread::of(&numbers) {
            let Spread { mean, deviation, min, median, max } = spread;
            let count = numbers.len();
            lines.push(format!(
                "{name:20} {count:>6} {mean:>10.2} {deviation:>10.2} {min:>10.2} {median:>10.2} {max:>10.2}"
            ));
        }
    }
    let failed: Vec<String> =
        trials.iter().filter(|trial| !trial.succeeded).take(20).map(|trial| trial.seed.to_string()).collect();
    if !failed.is_empty() {
        lines.push(format!("failed with seed {}", failed.join(", ")));
    }
    lines.join("\n")
}

/// One line for each row of an experiment, so that they can be compared.
pub fn comparison(rows: &[(&str, Vec<Trial>)]) -> String {
    let mut lines = vec![format!(
        "{:18} {:>10} {:>16} {:>9} {:>6} {:>12} {:>11}",
        "", "delivered", "95 % interval", "contacts", "wrong", "noticed [m]", "time [s]"
    )];
    for (name, trials) in rows {
        let successes = trials.iter().filter(|trial| trial.succeeded).count();
        let (low, high) = wilson_95(successes, trials.len());
        let numbers = |measure: &str| -> Vec<f64> {
            trials
                .iter()
                .flat_map(|trial| &trial.measures)
                .filter(|(name, _)| *name == measure)
                .filter_map(|&(_, value)| value)
                .collect()
        };
        let total = |measure: &str| numbers(measure).iter().fold(0.0, |sum, number| sum + number);
        let median = |measure: &str| {
            Spread::of(&numbers(measure)).map_or("–".to_string(), |spread| format!("{:.2}", spread.median))
        };
        lines.push(format!(
            "{name:18} {:>10} {:>16} {:>9} {:>6} {:>12} {:>11}",
            format!("{successes}/{}", trials.len()),
            format!("{:.1}–{:.1} %", 100.0 * low, 100.0 * high),
            total("contacts caused"),
            total("wrong recoveries"),
            median("noticed after [m]"),
            median("time [s]"),
        ));
    }
    lines.push("contacts and wrong recoveries are totals, noticed and time are medians".to_string());
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_the_order_of_the_seeds_whatever_the_jobs() {
        let seeds: Vec<u64> = (100..164).collect();
        // Later seeds take less time, so that they overtake the earlier ones.
        let run = |seed: u64| (0..(164 - seed) * 2000).fold(seed, |sum, n| sum.wrapping_mul(31).wrapping_add(n));
        let alone = run_all(&seeds, 1, run, || ());
        let mut count = 0;
        let together = run_all(&seeds, 8, run, || count += 1);
        assert_eq!(alone, together);
        assert_eq!(count, seeds.len());
        assert!(run_all(&[], 4, run, || ()).is_empty());
    }

    #[test]
    fn the_table_counts_successes_and_names_failed_seeds() {
        let trial = |seed, succeeded, time_s| Trial { seed, succeeded, measures: vec![("time [s]", time_s)] };
        let text = table("rotated", &[trial(1, true, Some(10.0)), trial(2, false, Some(30.0)), trial(3, true, None)]);
        assert!(text.contains("succeeded 2 of 3: 66.7 %"), "{text}");
        assert!(text.contains("time [s]                  2      20.00"), "{text}");
        assert!(text.ends_with("failed with seed 2"), "{text}");
    }
}
