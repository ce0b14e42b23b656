//! Runs over seeds on several threads, and their table.

use super::statistics::{Spread, mean_95, poisson_95, wilson_95};
use super::trial::{Sample, Trial};
use crossbeam::channel;
use std::sync::atomic::{AtomicUsize, Ordering};

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
    let successes = trials.iter().filter(|trial| trial.succeeded()).count();
    let measured = trials.iter().filter(|trial| trial.is_measured()).count();
    let (low, high) = wilson_95(successes, measured);
    let seeds = match (trials.first(), trials.last()) {
        (Some(first), Some(last)) if trials.len() > 1 => format!("seeds {} to {}", first.seed, last.seed),
        (Some(first), _) => format!("seed {}", first.seed),
        _ => "no seeds".to_string(),
    };
    let rate = if measured == 0 { 0.0 } else { 100.0 * successes as f64 / measured as f64 };
    let mut lines = vec![
        format!("{name}: {} runs, {seeds}", trials.len()),
        format!(
            "succeeded {successes} of {measured}: {rate:.1} %, 95 % interval {:.1} to {:.1} % (Wilson)",
            100.0 * low,
            100.0 * high
        ),
        format!(
            "{:20} {:>6} {:>10} {:>8} {:>10} {:>10} {:>10} {:>10}",
            "", "runs", "mean", "± 95 %", "deviation", "min", "median", "max"
        ),
    ];
    let names: Vec<&str> =
        trials.first().map_or(Vec::new(), |trial| trial.measures.iter().map(|&(name, _)| name).collect());
    for (at, name) in names.into_iter().enumerate() {
        let numbers: Vec<f64> =
            trials.iter().filter_map(|trial| trial.measures.get(at)).filter_map(|&(_, value)| value).collect();
        if let Some(spread) = Spread::of(&numbers) {
            let Spread { mean, deviation, min, median, max } = spread;
            let (count, half) = (numbers.len(), mean_95(deviation, numbers.len()));
            lines.push(format!(
                "{name:20} {count:>6} {mean:>10.2} {half:>8.2} {deviation:>10.2} {min:>10.2} {median:>10.2} {max:>10.2}"
            ));
        }
    }
    lines.extend(failures(trials).map(|failures| format!("failed with seed {failures}")));
    lines.extend(not_measured(trials));
    lines.join("\n")
}

/// The seeds of the first runs that failed, each with the kind of fault; none if none did.
pub fn failures(trials: &[Trial]) -> Option<String> {
    let failed = trials.iter().filter_map(|trial| Some((trial.seed, trial.fault.as_ref()?)));
    let kind = |fault: &str| fault.split(':').next().unwrap_or_default().to_string();
    let named: Vec<String> = failed.take(20).map(|(seed, fault)| format!("{seed} ({})", kind(fault))).collect();
    (!named.is_empty()).then(|| named.join(", "))
}

/// Which runs count for nothing, and why; none if all count.
pub fn not_measured(trials: &[Trial]) -> Option<String> {
    let unmeasured: Vec<(u64, &str)> =
        trials.iter().filter_map(|trial| Some((trial.seed, trial.unmeasured.as_deref()?))).collect();
    let named: Vec<String> = unmeasured.iter().take(3).map(|(seed, why)| format!("{seed} ({why})")).collect();
    let (count, all) = (unmeasured.len(), trials.len());
    let more = if count > named.len() { ", …" } else { "" };
    (count > 0).then(|| {
        format!("not measured: {count} of {all}, because the scenario failed with seed {}{more}", named.join(", "))
    })
}

/// One line for each row of an experiment, so that they can be compared.
pub fn comparison(rows: &[(&str, Vec<Trial>)]) -> String {
    let mut lines = vec![format!(
        "{:18} {:>9} {:>15} {:>8} {:>14} {:>9} {:>7} {:>8} {:>17}",
        "", "succeeded", "95 % interval", "contacts", "wrong (95 %)", "noticed", "≤ 2 m", "time", "alarms/km (95 %)"
    )];
    lines.extend(rows.iter().map(|(name, trials)| compared(name, trials)));
    lines.extend(rows.iter().filter_map(|(name, trials)| Some(format!("{name}: {}", not_measured(trials)?))));
    lines.push(
        "contacts: caused by the robot, total; wrong: runs in which the position counted as found where it".into(),
    );
    lines.push("was not; noticed [m] and time [s]: medians; alarms: position lost while the estimate was right".into());
    lines.join("\n")
}

fn compared(name: &str, trials: &[Trial]) -> String {
    let rate = |successes: usize, runs: usize| {
        let (low, high) = wilson_95(successes, runs);
        format!("{:.1}–{:.1} %", 100.0 * low, 100.0 * high)
    };
    let numbers = |measure: &str| -> Vec<f64> { trials.iter().filter_map(|trial| trial.measure(measure)).collect() };
    let total = |measure: &str| numbers(measure).iter().fold(0.0, |sum, number| sum + number);
    let median = |measure: &str| {
        Spread::of(&numbers(measure)).map_or("–".to_string(), |spread| format!("{:.2}", spread.median))
    };
    let successes = trials.iter().filter(|trial| trial.succeeded()).count();
    let measured = trials.iter().filter(|trial| trial.is_measured()).count();
    let disturbed = numbers("wrong recoveries");
    let wrong = disturbed.iter().filter(|&&count| count > 0.0).count();
    let wrong = if disturbed.is_empty() {
        "–".to_string()
    } else {
        format!("{wrong} (≤{:.1} %)", 100.0 * wilson_95(wrong, disturbed.len()).1)
    };
    let within = numbers("noticed within 2 m");
    let within = if within.is_empty() {
        "–".to_string()
    } else {
        format!("{:.1} %", 100.0 * within.iter().sum::<f64>() / within.len() as f64)
    };
    let driven_km = total("distance [m]") / 1000.0;
    let alarms = total("false alarms");
    let (low, high) = poisson_95(alarms as u32);
    format!(
        "{name:18} {:>9} {:>15} {:>8} {wrong:>14} {:>9} {within:>7} {:>8} {:>17}",
        format!("{successes}/{measured}"),
        rate(successes, measured),
        total("contacts caused"),
        median("noticed after [m]"),
        median("time [s]"),
        format!("{:.2} ({:.2}–{:.2})", alarms / driven_km, low / driven_km, high / driven_km),
    )
}

/// Every sample of every run, ten a second, as lines of comma-separated values.
pub fn sample_rows(rows: &[(&str, Vec<Trial>)]) -> String {
    let mut text = String::from("row,seed,sample,certainty,off_m,right\n");
    for (row, trials) in rows {
        for trial in trials {
            for (at, Sample { certainty, off_m, is_right }) in trial.samples.iter().enumerate() {
                text += &format!("\"{row}\",{},{at},{certainty:.4},{off_m:.3},{}\n", trial.seed, u8::from(*is_right));
            }
        }
    }
    text
}

/// Every run as a line of comma-separated values, with the names above.
pub fn raw_rows(rows: &[(&str, Vec<Trial>)]) -> String {
    let names: Vec<&str> = rows
        .iter()
        .flat_map(|(_, trials)| trials)
        .next()
        .map_or(Vec::new(), |trial| trial.measures.iter().map(|&(name, _)| name).collect());
    let mut lines = vec![format!("row,seed,succeeded,fault,{}", names.join(","))];
    for (row, trials) in rows {
        for trial in trials {
            let value = |name: &&str| trial.measure(name).map_or(String::new(), |value| value.to_string());
            let values: Vec<String> = names.iter().map(value).collect();
            let unmeasured = trial.unmeasured.as_ref().map(|why| format!("not measured: {why}"));
            let fault = trial.fault.clone().or(unmeasured).unwrap_or_default().replace('"', "'");
            let succeeded = if trial.is_measured() { trial.succeeded().to_string() } else { String::new() };
            lines.push(format!("\"{row}\",{},{succeeded},\"{fault}\",{}", trial.seed, values.join(",")));
        }
    }
    lines.join("\n") + "\n"
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
        let trial = |seed, fault: Option<&str>, time_s| Trial {
            seed,
            fault: fault.map(str::to_string),
            unmeasured: None,
            measures: vec![("time [s]", time_s)],
            samples: vec![],
        };
        let blocked = Some("blocked: for 20 s");
        let text = table("rotated", &[trial(1, None, Some(10.0)), trial(2, blocked, Some(30.0)), trial(3, None, None)]);
        assert!(text.contains("succeeded 2 of 3: 66.7 %"), "{text}");
        assert!(text.contains("time [s]                  2      20.00"), "{text}");
        assert!(text.ends_with("failed with seed 2 (blocked)"), "{text}");
    }
}
