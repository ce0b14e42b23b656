//! Hours of the office that are killed again and again.

use crate::bench::{Bench, Left, Place, bytes_in};
use std::fmt;
use std::fs;
use std::io;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// An hour of the office, without its seed.
const OFFICE: [&str; 9] = [
    "run",
    "office.rpl",
    "--world",
    "dept-staffed",
    "--scenario",
    "experiments/office-day.rpl",
    "--until",
    "60min",
    "--quiet",
];

/// How often an hour is lived through with kills for each time without.
const HOURS: usize = 5;

/// A process lives no longer than the time that the hour takes, divided by this.
const LIVES: u64 = 7;

/// How often a file that grows is looked at.
const LOOK: Duration = Duration::from_millis(2);

/// One kill in this many is followed by a look at how long it takes to stand where the run was.
const RESUMED_ONE_IN: u64 = 10;

/// What came of kills.
#[derive(Default)]
struct Count {
    kills: u64,
    hours: u64,
    /// Kills while a checkpoint was being written.
    while_writing: u64,
    /// From the start of the command to where the run was when it was killed.
    resumed: Vec<Duration>,
    most_bytes: u64,
}

impl fmt::Display for Count {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kills, hours, while_writing, resumed, most_bytes } = self;
        let mut sorted = resumed.clone();
        sorted.sort();
        let at = |share: f64| {
            let place = ((sorted.len() as f64 - 1.0) * share) as usize;
            sorted.get(place).copied().unwrap_or_default().as_secs_f64()
        };
        writeln!(out, "{kills} kills in {hours} hours, {while_writing} of them while a checkpoint was written")?;
        writeln!(out, "at most {:.1} MB on the disk", *most_bytes as f64 / 1e6)?;
        write!(
            out,
            "gone on with {} times: where it was within {:.2} s in the median, {:.2} s in 95 %, {:.2} s at most",
            sorted.len(),
            at(0.5),
            at(0.95),
            at(1.0)
        )
    }
}

/// How many runs did not come to what they should.
///
/// # Errors
/// The command cannot be started, or the disk is full.
pub fn kills(bench: &Bench, kills: u64) -> io::Result<u64> {
    let count = Mutex::new(Count::default());
    // As many seeds as kills are enough, because every hour dies at least once.
    let findings = bench.each(
        kills as usize,
        |_| Ok(()),
        |place, (), number| {
            if counted(&count).kills >= kills {
                return Ok(None);
            }
            let seed = (bench.seed + number as u64).to_string();
            let run = [&OFFICE[..], &["--seed", &seed, "--journal", "j", "--trace", "t.jsonl"]].concat();
            place.clear()?;
            let began = Instant::now();
            place.start(&run)?.wait()?;
            let (took, whole) = (began.elapsed(), Left::by(place)?);
            for _ in 0..HOURS {
                if counted(&count).kills >= kills {
                    break;
                }
                place.clear()?;
                if let Some(difference) = hour(place, &run, took, &whole, &count)? {
                    return Ok(Some(format!("seed {seed}: {difference}")));
                }
            }
            Ok(None)
        },
    )?;
    println!("{}", counted(&count));
    Ok(findings)
}

fn counted(count: &Mutex<Count>) -> std::sync::MutexGuard<'_, Count> {
    // What another one has counted is right even if it has panicked.
    count.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// One hour of the office, which dies many times; how it differs from one that does not.
fn hour(
    place: &mut Place,
    run: &[&str],
    took: Duration,
    whole: &Left,
    count: &Mutex<Count>,
) -> io::Result<Option<String>> {
    let mut arguments = run.to_vec();
    loop {
        let mut child = place.start(&arguments)?;
        let began = Instant::now();
        let end = Duration::from_nanos(place.chance.below(took.as_nanos() as u64 / LIVES));
        let mut is_over = false;
        let mut most_bytes = 0;
        while began.elapsed() < end && !is_over {
            std::thread::sleep(LOOK.min(end.saturating_sub(began.elapsed())));
            most_bytes = most_bytes.max(bytes_in(&place.journal()));
            is_over = child.try_wait()?.is_some();
        }
        if is_over {
            break;
        }
        child.kill()?;
        child.wait()?;
        let done_since = newest_checkpoint(place).unwrap_or(Duration::MAX).min(began.elapsed());
        let was_writing = place.files()?.0.iter().any(|(path, _)| path.extension().is_some_and(|end| end == "new"));
        {
            let mut count = counted(count);
            count.kills += 1;
            count.while_writing += u64::from(was_writing);
            count.most_bytes = count.most_bytes.max(most_bytes);
        }
        if place.journal().join("run").exists() {
            arguments = vec!["resume", "j", "--quiet"];
            if place.chance.below(RESUMED_ONE_IN) == 0 {
                let took = resumed(place, done_since)?;
                counted(count).resumed.push(took);
            }
        }
    }
    counted(count).hours += 1;
    Ok(whole.difference(place))
}

/// How long it takes to stand where the run was: to read the journal and stand at its last checkpoint, which is tried,
/// and to do again what had been done since, which takes as long as it took. The journal is left as it is.
fn resumed(place: &Place, done_since: Duration) -> io::Result<Duration> {
    let files = place.files()?;
    let began = Instant::now();
    place.rpl(&["resume", "j", "--quiet", "--until", "1ms"]).output()?;
    let took = began.elapsed() + done_since;
    files.put_back(place)?;
    Ok(took)
}

/// How long ago the newest checkpoint was there.
fn newest_checkpoint(place: &Place) -> Option<Duration> {
    let entries = fs::read_dir(place.journal()).ok()?.flatten();
    let is_checkpoint = |name: &str| name.starts_with("checkpoint-") && !name.ends_with(".new");
    let files = entries.filter(|entry| entry.file_name().to_str().is_some_and(is_checkpoint));
    files.filter_map(|entry| entry.metadata().ok()?.modified().ok()?.elapsed().ok()).min()
}
