//! The folder of a journal: who has it, and files in it that are there whole or not at all.

use super::own_file;
use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

/// Who holds the lock; the kernel releases it with the process, however that ends.
const LOCK: &str = "lock";

/// What is written before it takes the place of the old.
const NEW: &str = ".new";

/// Why a folder cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum FolderFault {
    /// Another process writes it.
    #[error("process {0} has it, and only one can; wait for its end, or end it")]
    Taken(String),
    /// It cannot be read or written.
    #[error(transparent)]
    Disk(#[from] io::Error),
}

/// A folder that this process alone writes, as long as this lives.
#[derive(Debug)]
pub struct JournalFolder {
    path: PathBuf,
    _lock: File,
}

impl JournalFolder {
    /// Takes a folder, which is made if it is not there.
    ///
    /// # Errors
    /// Somebody has it, or it cannot be written.
    pub fn take(path: &Path) -> Result<Self, FolderFault> {
        fs::create_dir_all(path)?;
        let lock = path.join(LOCK);
        let mut file = own_file::open(&lock, File::options().read(true).write(true).create(true).truncate(false))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(FolderFault::Taken(holder(&mut file))),
            Err(TryLockError::Error(error)) => return Err(error.into()),
        }
        // Who cannot even say its name will not write a journal.
        file.set_len(0)?;
        file.write_all(std::process::id().to_string().as_bytes())?;
        Ok(Self { path: path.to_path_buf(), _lock: file })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file that is there with all its bytes or, after a crash or a fault, as it was. If it is to
    /// outlive a power cut it is on the disk when this comes back.
    ///
    /// # Errors
    /// The disk is full or gone.
    pub fn write(&self, name: &str, bytes: &[u8], outlives_power: bool) -> io::Result<()> {
        write_whole(&self.path, name, &[bytes], outlives_power)
    }
}

/// Who has the journal in a folder now; none if nobody has.
///
/// # Errors
/// It cannot be looked at.
pub fn taken_by(path: &Path) -> io::Result<Option<String>> {
    let mut file = own_file::open(&path.join(LOCK), File::options().read(true))?;
    match file.try_lock_shared() {
        Ok(()) => Ok(None),
        Err(TryLockError::WouldBlock) => Ok(Some(holder(&mut file))),
        Err(TryLockError::Error(error)) => Err(error),
    }
}

/// The process that a lock names.
fn holder(lock: &mut File) -> String {
    let mut name = String::new();
    match lock.take(20).read_to_string(&mut name) {
        Ok(_) if !name.is_empty() => name,
        Ok(_) | Err(_) => "another".to_string(),
    }
}

/// As [`JournalFolder::write`], for a thread that writes while the run goes on; the parts follow each other.
///
/// # Errors
/// The disk is full or gone.
pub fn write_whole(folder: &Path, name: &str, parts: &[&[u8]], outlives_power: bool) -> io::Result<()> {
    let new = folder.join(format!("{name}{NEW}"));
    // What a process that died has left makes room, whatever it is.
    match fs::remove_file(&new) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        Ok(()) | Err(_) => {}
    }
    let written = File::create_new(&new).and_then(|mut file| {
        parts.iter().try_for_each(|part| file.write_all(part))?;
        if outlives_power { file.sync_all() } else { Ok(()) }
    });
    let placed = written.and_then(|()| fs::rename(&new, folder.join(name)));
    if placed.is_err() {
        // What could not be written takes no room.
        fs::remove_file(&new).ok();
    }
    placed?;
    if outlives_power { File::open(folder)?.sync_all() } else { Ok(()) }
}
