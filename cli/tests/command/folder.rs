//! Folders of the tests: each has its own, so that tests can run side by side.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// A folder of a test's own, empty.
///
/// # Panics
/// If another test has taken the name.
pub fn folder(name: &str) -> PathBuf {
    static TAKEN: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    let is_new = TAKEN.lock().is_ok_and(|mut taken| taken.insert(name.to_string()));
    assert!(is_new, "another test has a folder `{name}`");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    // That of an earlier run may not be there.
    fs::remove_dir_all(&folder).ok();
    fs::create_dir_all(&folder).expect("the folder can be made");
    folder
}

/// Writes a file into a folder, and gives its path as a user would type it.
pub fn put(folder: &Path, name: &str, content: impl AsRef<[u8]>) -> String {
    let path = folder.join(name);
    fs::write(&path, content).expect("the file can be written");
    path.to_string_lossy().into_owned()
}

/// The text of a file in a folder.
pub fn text_in(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}
