//! Plans named on the command line: files, and folders with all the plans below them.

use crate::files::shown::Shown;
use std::collections::{BTreeSet, VecDeque};
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

/// A folder of what was built, and of no plans.
const BUILT: &str = "target";

/// The files that some names stand for, in their order, each once; for a folder all `*.rpl` files
/// below it, sorted by path. What is hidden, folders called `target`, and links to folders are left
/// out. Where something is wrong, the sentence that says so stands in its place.
pub fn named(names: &[String]) -> Vec<Result<String, String>> {
    let mut known = BTreeSet::new();
    let mut files: Vec<Result<String, String>> = Vec::new();
    for name in names {
        let found = if Path::new(name).is_dir() { below(Path::new(name)) } else { vec![Ok(name.clone())] };
        // By its own path a file is the same however it is named; standard input has none.
        let is_new = |file: &Result<String, String>| match file {
            Ok(file) => Path::new(file).canonicalize().map_or(true, |path| known.insert(path)),
            Err(_) => true,
        };
        files.extend(found.into_iter().filter(is_new));
    }
    files
}

fn below(folder: &Path) -> Vec<Result<String, String>> {
    let mut found: Vec<(PathBuf, Result<String, String>)> = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        match plans_in(&folder, &mut folders) {
            Ok(plans) => found.extend(plans.into_iter().map(|plan| (plan.clone(), text_of(&plan)))),
            Err(reason) => found.push((folder, Err(reason))),
        }
    }
    found.sort_by(|(a, _), (b, _)| a.cmp(b));
    if found.is_empty() {
        return vec![Err(format!(
            "there is no plan in the folder `{}`: no file below it ends in .rpl",
            folder.shown()
        ))];
    }
    found.into_iter().map(|(_, file)| file).collect()
}

/// The same plans of a folder, those nearest to it first, when no more than `most_folders` folders have been looked into
/// and `most_plans` plans were found. What cannot be read is left out.
pub fn nearest(folder: &Path, most_folders: usize, most_plans: usize) -> Vec<PathBuf> {
    let (mut found, mut folders) = (Vec::new(), VecDeque::from([folder.to_path_buf()]));
    for _ in 0..most_folders {
        let Some(next) = folders.pop_front().filter(|_| found.len() < most_plans) else { break };
        let mut inner = Vec::new();
        let mut plans = plans_in(&next, &mut inner).unwrap_or_default();
        plans.sort();
        inner.sort();
        found.extend(plans);
        folders.extend(inner);
    }
    found.truncate(most_plans);
    found
}

/// Whether a file is one of the plans of a folder, by its name and those of the folders between them.
pub fn is_of(folder: &Path, file: &Path) -> bool {
    let Ok(below) = file.strip_prefix(folder) else { return false };
    let is_hidden = |name: &OsStr| name.as_encoded_bytes().starts_with(b".");
    let mut between = below.parent().into_iter().flat_map(Path::iter);
    let is_left_out = below.iter().any(is_hidden) || between.any(|name| name == BUILT);
    !is_left_out && below.extension().is_some_and(|extension| extension == "rpl")
}

/// The plans that lie in a folder itself; the folders in it are added to `folders`.
fn plans_in(folder: &Path, folders: &mut Vec<PathBuf>) -> Result<Vec<PathBuf>, String> {
    let fault = |error| format!("cannot read the folder `{}`: {error}", folder.shown());
    let mut plans = Vec::new();
    for entry in fs::read_dir(folder).map_err(fault)? {
        let entry = entry.map_err(fault)?;
        let (path, name) = (entry.path(), entry.file_name());
        if name.as_encoded_bytes().starts_with(b".") {
            continue;
        }
        // Of a link this is told of the link itself: a link to a folder above would never end.
        let is_folder = entry.file_type().map_err(fault)?.is_dir();
        if is_folder && name != BUILT {
            folders.push(path);
        } else if path.extension().is_some_and(|extension| extension == "rpl") && path.is_file() {
            plans.push(path);
        }
    }
    Ok(plans)
}

fn text_of(path: &Path) -> Result<String, String> {
    // `./a.rpl` is `a.rpl`.
    let path = path.strip_prefix(".").unwrap_or(path);
    path.to_str().map(str::to_string).ok_or_else(|| format!("the name of the file `{}` is not UTF-8", path.shown()))
}
