//! The files of this repository that tests read: documents, examples, cases, the tests themselves.

use std::fs;
use std::path::{Path, PathBuf};

/// The root of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// All files below a folder whose names end so, without the dot, in order.
///
/// # Panics
/// If the folder cannot be read.
pub fn files_below(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.to_string_lossy()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("a folder can be read").path()).collect();
    paths.sort();
    let is_meant = |path: &Path| path.extension().is_some_and(|found| extensions.iter().any(|known| found == *known));
    paths
        .into_iter()
        .flat_map(|path| match path.is_dir() {
            true => files_below(&path, extensions),
            false if is_meant(&path) => vec![path],
            false => Vec::new(),
        })
        .collect()
}

/// The text of a file by its path from the root.
///
/// # Panics
/// If there is none.
pub fn text_of(name: &str) -> String {
    fs::read_to_string(root().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}
