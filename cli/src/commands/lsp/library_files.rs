//! The texts of the library as files, for editors that open nothing else: in the user's folder for what can be made again,
//! only to be read, and never in the place of another file.

use std::env;
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Files of one name that are tried: somebody may have changed one, and that stays.
const MOST_TRIES: usize = 100;

/// The folder of the files.
pub struct LibraryFiles {
    /// None if nothing says where the user keeps such files.
    folder: Option<PathBuf>,
}

impl Default for LibraryFiles {
    fn default() -> Self {
        let absolute = |name: &str| env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
        let caches = || match cfg!(windows) {
            true => absolute("LOCALAPPDATA"),
            false => absolute("XDG_CACHE_HOME").or_else(|| Some(absolute("HOME")?.join(".cache"))),
        };
        Self { folder: caches().map(|caches| caches.join("rpl").join("library").join(env!("CARGO_PKG_VERSION"))) }
    }
}

impl LibraryFiles {
    /// The file with a text, by its name or that name with a number, written if no such file has it.
    pub fn file(&self, name: &str, text: &str) -> Option<PathBuf> {
        let folder = self.folder.as_deref()?;
        fs::create_dir_all(folder).ok()?;
        let (stem, extension) = name.rsplit_once('.').unwrap_or((name, "rpl"));
        let names = (1..=MOST_TRIES).map(|number| match number {
            1 => folder.join(name),
            _ => folder.join(format!("{stem}-{number}.{extension}")),
        });
        names.into_iter().find_map(|file| match write_new(&file, text) {
            Ok(()) => Some(file),
            Err(_) => fs::read(&file).is_ok_and(|there| there == text.as_bytes()).then_some(file),
        })
    }

    /// Whether a file lies there.
    pub fn has(&self, path: &Path) -> bool {
        self.folder.as_deref().is_some_and(|folder| path.starts_with(folder))
    }
}

/// Writes a file that is not there yet, and that nobody writes again.
fn write_new(file: &Path, text: &str) -> io::Result<()> {
    let mut new = OpenOptions::new().write(true).create_new(true).open(file)?;
    new.write_all(text.as_bytes())?;
    let mut may = new.metadata()?.permissions();
    may.set_readonly(true);
    new.set_permissions(may)
}
