//! Runs over seeds on several threads, and each of them as a line.

use super::trial::{MissionTrial, Sample};
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

/// Every sample of every run, ten a second, as lines of comma-separated values.
pub fn sample_rows(rows: &[(&str, Vec<MissionTrial>)]) -> String {
    let mut text = String::from("row,seed,sample,certainty,off_m,off_deg,right\n");
    for (row, trials) in rows {
        for trial in trials {
            for (at, Sample { certainty, off_m, off_rad, is_right }) in trial.samples.iter().enumerate() {
                let (off_deg, right) = (off_rad.to_degrees(), u8::from(*is_right));
                text += &format!("\"{row}\",{},{at},{certainty:.4},{off_m:.3},{off_deg:.2},{right}\n", trial.seed);
            }
        }
    }
    text
}

/// Every run as a line of comma-separated values, with the names above.
pub fn raw_rows(rows: &[(&str, Vec<MissionTrial>)]) -> String {
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
}
