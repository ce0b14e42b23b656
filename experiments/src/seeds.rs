//! Runs over seeds on several threads, handed on in the order of the seeds.

use super::kind::Run;
use anyhow::{Context, Result};
use crossbeam::channel::RecvTimeoutError;
use rayon::{ThreadPool, ThreadPoolBuilder};
use rpl_shell::interrupt;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

/// How often a signal is looked for.
const LOOK: Duration = Duration::from_millis(50);

/// Some runs of a series, by their numbers, with the seed of the first of all.
#[derive(Clone, Debug)]
pub struct Seeds {
    /// The numbers of the runs.
    pub numbers: Range<u64>,
    /// The seed of the run 0.
    pub first_seed: u64,
}

impl Seeds {
    /// The run of a number.
    pub fn run(&self, number: u64) -> Run {
        Run { number, seed: self.first_seed.wrapping_add(number) }
    }
}

/// Runs all of them, a given number at a time, and hands the results on in their order however the threads were
/// scheduled. Answers whether all were done: after a signal only those are handed on that had ended before it, and what
/// still runs is left to the end of the process. Runs at the same time share out the threads that one alone would have.
///
/// # Errors
/// The first error of `take`, nothing is taken after it; threads cannot be had.
pub fn run_in_order<T: Send + 'static>(
    seeds: &Seeds,
    jobs: usize,
    one: impl Fn(Run) -> T + Send + Sync + 'static,
    mut take: impl FnMut(Run, T) -> Result<()>,
) -> Result<bool> {
    let (one, next) = (Arc::new(one), Arc::new(AtomicU64::new(seeds.numbers.start)));
    let is_over = Arc::new(Over(AtomicBool::new(false)));
    let _ends_with_this = EndsRuns(is_over.clone());
    let (sender, receiver) = crossbeam::channel::unbounded();
    let most = usize::try_from(seeds.numbers.end - seeds.numbers.start).unwrap_or(usize::MAX);
    let jobs = jobs.clamp(1, most.max(1));
    let pools: Vec<Option<ThreadPool>> = (0..jobs).map(|_| pool_of_one(jobs)).collect::<Result<_>>()?;
    let threads: Vec<JoinHandle<()>> = pools
        .into_iter()
        .map(|pool| {
            let (one, next, is_over, sender, seeds) =
                (one.clone(), next.clone(), is_over.clone(), sender.clone(), seeds.clone());
            std::thread::spawn(move || {
                loop {
                    let run = seeds.run(next.fetch_add(1, Ordering::Relaxed));
                    if run.number >= seeds.numbers.end || is_over.0.load(Ordering::Relaxed) {
                        return;
                    }
                    let result = match &pool {
                        Some(pool) => pool.install(|| one(run)),
                        None => one(run),
                    };
                    // A run that was told to stop has not come to its own end.
                    if interrupt::is_asked() || sender.send((run.number, result)).is_err() {
                        return;
                    }
                }
            })
        })
        .collect();
    drop(sender);
    let mut due = seeds.numbers.start;
    let mut early = BTreeMap::new();
    loop {
        match receiver.recv_timeout(LOOK) {
            Ok((number, result)) => {
                early.insert(number, result);
                while let Some(result) = early.remove(&due) {
                    take(seeds.run(due), result)?;
                    due += 1;
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        if interrupt::is_asked() {
            early.extend(receiver.try_iter());
            for (number, result) in early {
                take(seeds.run(number), result)?;
            }
            return Ok(false);
        }
    }
    for thread in threads {
        if let Err(panic) = thread.join() {
            std::panic::resume_unwind(panic);
        }
    }
    Ok(due == seeds.numbers.end)
}

/// The threads of one of `jobs` runs at the same time; none if it may have all.
fn pool_of_one(jobs: usize) -> Result<Option<ThreadPool>> {
    if jobs == 1 {
        return Ok(None);
    }
    let share = (rayon::current_num_threads() / jobs).max(1);
    ThreadPoolBuilder::new().num_threads(share).build().map(Some).context("cannot have the threads of a run")
}

/// Whether no further run is to begin.
struct Over(AtomicBool);

/// When it is dropped, no further run begins.
struct EndsRuns(Arc<Over>);

impl Drop for EndsRuns {
    fn drop(&mut self) {
        self.0.0.store(true, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::bail;

    #[test]
    fn results_come_in_the_order_of_the_seeds_whatever_the_jobs() {
        let seeds = Seeds { numbers: 3..67, first_seed: 97 };
        // Later runs take less time, so that they overtake the earlier ones.
        let one =
            |run: Run| (0..(67 - run.number) * 2000).fold(run.seed, |sum, n| sum.wrapping_mul(31).wrapping_add(n));
        let all = |jobs: usize| {
            let mut taken = Vec::new();
            let done = run_in_order(&seeds, jobs, one, |run, result| {
                taken.push((run, result));
                Ok(())
            });
            assert!(done.expect("nothing is wrong"));
            taken
        };
        let alone = all(1);
        assert_eq!(alone, all(8));
        assert_eq!((alone.len(), alone[0].0), (64, Run { number: 3, seed: 100 }));
        let none = Seeds { numbers: 0..0, first_seed: 1 };
        assert!(run_in_order(&none, 4, |_| (), |_, ()| bail!("there is none")).expect("nothing to do"));
    }

    #[test]
    fn nothing_is_taken_after_an_error() {
        let seeds = Seeds { numbers: 0..1000, first_seed: 0 };
        let mut taken = 0;
        let done = run_in_order(
            &seeds,
            2,
            |run| run.number,
            |_, number| {
                taken += 1;
                if number == 5 {
                    bail!("the sixth")
                }
                Ok(())
            },
        );
        assert_eq!((done.expect_err("the sixth").to_string(), taken), ("the sixth".to_string(), 6));
    }
}
