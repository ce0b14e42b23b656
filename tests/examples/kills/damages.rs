//! Journals whose files are cut off or changed.

use crate::bench::{BEGIN, Bench, Files, Left, Place, SHORT};
use std::fs;
use std::io;
use std::process::Output;
use std::sync::atomic::{AtomicU64, Ordering};

/// Bytes of the end of a file that are cut off one by one.
const END: usize = 4096;

/// What is done to a file.
enum Damage {
    Cut(usize),
    Flip,
}

/// How many damaged journals were gone on with wrongly: every file cut at every byte of its end, and a number of bits
/// flipped.
///
/// # Errors
/// The command cannot be started, or the disk is full.
pub fn damages(bench: &Bench, flips: usize) -> io::Result<u64> {
    let (files, _) = short_run(&mut bench.place("one")?)?;
    let cuts = files.0.iter().enumerate();
    let cuts = cuts.flat_map(|(at, (_, bytes))| (1..=bytes.len().min(END)).map(move |cut| (at, Damage::Cut(cut))));
    let flips = (0..flips).map(|number| (number % files.0.len(), Damage::Flip));
    let cases: Vec<(usize, Damage)> = cuts.chain(flips).collect();
    let refused = AtomicU64::new(0);
    let findings = bench.each(cases.len(), short_run, |place, (files, whole), number| {
        let (file, damage) = &cases[number];
        files.put_back(place)?;
        let Some(what) = damaged(place, files, *file, damage)? else { return Ok(None) };
        let Output { status, stderr, .. } = place.rpl(&["resume", "j"]).output()?;
        let told = String::from_utf8_lossy(&stderr);
        let finding = match status.code() {
            Some(0) => whole.difference(place),
            Some(2) if told.contains("the journal") || told.contains("is no journal") => {
                refused.fetch_add(1, Ordering::Relaxed);
                None
            }
            other => Some(format!("exit status {other:?}: {told}")),
        };
        Ok(finding.map(|finding| format!("{what}: {finding}")))
    })?;
    println!("{} damages, {} refused, {findings} findings", cases.len(), refused.into_inner());
    Ok(findings)
}

/// A short run that stood still twice and took new definitions, before it goes on; and what it is to leave.
fn short_run(place: &mut Place) -> io::Result<(Files, Left)> {
    fs::write(place.folder.join("plan.rpl"), SHORT)?;
    place.rpl(&[&BEGIN[..], &["--until", "2s"]].concat()).output()?;
    fs::write(place.folder.join("plan.rpl"), format!("{SHORT}(defun unused () 1)\n"))?;
    place.rpl(&["resume", "j", "--changed", "--until", "5s"]).output()?;
    fs::remove_file(place.folder.join("plan.rpl"))?;
    let files = place.files()?;
    place.rpl(&["resume", "j"]).output()?;
    let whole = Left::by(place)?;
    Ok((files, whole))
}

/// Damages a file; how, unless there is nothing to damage.
fn damaged(place: &mut Place, files: &Files, file: usize, damage: &Damage) -> io::Result<Option<String>> {
    let (path, bytes) = &files.0[file];
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    match damage {
        Damage::Cut(bytes_off) => {
            fs::write(path, &bytes[..bytes.len().saturating_sub(*bytes_off)])?;
            Ok(Some(format!("{bytes_off} bytes cut off `{name}`")))
        }
        Damage::Flip if bytes.is_empty() => Ok(None),
        Damage::Flip => {
            let (mut bytes, bit) = (bytes.clone(), place.chance.below(bytes.len() as u64 * 8) as usize);
            bytes[bit / 8] ^= 1 << (bit % 8);
            fs::write(path, &bytes)?;
            Ok(Some(format!("bit {bit} of `{name}` flipped")))
        }
    }
}
