//! What is read: files and standard input, within limits, and remembered, so that nothing is written
//! over it.

use anyhow::{Context, Result, anyhow, bail};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// A longer text is refused: places in a text are counted in 32 bits, and no plan is that long.
pub const MAX_BYTES: u64 = 64 << 20;

/// A world file may not be longer; the department of the papers takes 8 KiB.
const WORLD_BYTES: u64 = 2 << 20;

/// Nor a file with seven keys, or with the parameters of the filter.
const SHORT_BYTES: u64 = 64 << 10;

/// The name of standard input among files.
pub const STANDARD_INPUT: &str = "-";

/// A file as text.
///
/// # Errors
/// One clause that says why not.
pub fn read_text(path: &Path) -> Result<String, String> {
    text_of(read_bytes(path, MAX_BYTES)?)
}

/// How many bytes of a file say what it is.
pub const HEAD_BYTES: usize = 512;

/// The first bytes of what is read, at most [`HEAD_BYTES`].
///
/// # Errors
/// It cannot be read.
pub fn head_of(from: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    from.take(HEAD_BYTES as u64).read_to_end(&mut head)?;
    Ok(head)
}

/// All of it behind its head, at most `most` bytes; or a clause that says that it is longer.
///
/// # Errors
/// It cannot be read.
pub fn whole(head: Vec<u8>, from: &mut impl Read, most: u64) -> io::Result<Result<Vec<u8>, String>> {
    let mut bytes = head;
    from.take((most + 1).saturating_sub(bytes.len() as u64)).read_to_end(&mut bytes)?;
    Ok(within_limit(bytes, most))
}

/// What makes a file the same under whatever name.
#[cfg(unix)]
pub type Identity = (u64, u64);

/// What makes a file the same under whatever name.
#[cfg(not(unix))]
pub type Identity = PathBuf;

/// The identity of a file; none of what is not there, or is a pipe or a device.
pub(crate) fn identity(path: &Path) -> Option<Identity> {
    let known = path.metadata().ok().filter(std::fs::Metadata::is_file)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        Some((known.dev(), known.ino()))
    }
    #[cfg(not(unix))]
    {
        drop(known);
        path.canonicalize().ok()
    }
}

/// The files this process has read.
static INPUTS: Mutex<Vec<(Identity, PathBuf)>> = Mutex::new(Vec::new());

/// The name under which this process has read the file that is at a path, if it has.
pub fn input_at(path: &Path) -> Option<PathBuf> {
    let identity = identity(path)?;
    let inputs = INPUTS.lock().ok()?;
    inputs.iter().find(|(known, _)| *known == identity).map(|(_, input)| input.clone())
}

/// The files this process has read so far, each once.
pub fn files() -> Vec<PathBuf> {
    let Ok(inputs) = INPUTS.lock() else { return Vec::new() };
    let mut files: Vec<PathBuf> = inputs.iter().map(|(_, path)| path.clone()).collect();
    files.sort();
    files.dedup();
    files
}

/// The text of a world file.
///
/// # Errors
/// One clause that says why not.
pub(crate) fn world_text(path: &Path) -> Result<String, String> {
    text_of(read_bytes(path, WORLD_BYTES)?)
}

/// The text of a file that is short by its nature.
///
/// # Errors
/// One clause that says why not.
pub fn short_text(path: &Path) -> Result<String, String> {
    text_of(read_bytes(path, SHORT_BYTES)?)
}

/// A file or a pipe to read from, remembered as read.
///
/// # Errors
/// One clause that says why not.
pub fn open(path: &Path) -> Result<File, String> {
    let file = File::open(path).map_err(|error| reason(&error))?;
    if let Some(identity) = identity(path)
        && let Ok(mut inputs) = INPUTS.lock()
    {
        inputs.push((identity, path.to_path_buf()));
    }
    if file.metadata().is_ok_and(|known| known.is_dir()) {
        return Err("it is a folder; name a file in it".to_string());
    }
    Ok(file)
}

/// The bytes of a file, at most `most`: it may be a pipe or a device without an end.
///
/// # Errors
/// One clause that says why not.
pub fn read_bytes(path: &Path, most: u64) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    open(path)?.take(most + 1).read_to_end(&mut bytes).map_err(|error| reason(&error))?;
    within_limit(bytes, most)
}

fn within_limit(bytes: Vec<u8>, most: u64) -> Result<Vec<u8>, String> {
    if bytes.len() as u64 > most {
        let most = if most < 1 << 20 { format!("{} KiB", most >> 10) } else { format!("{} MiB", most >> 20) };
        return Err(format!("it is longer than {most}"));
    }
    Ok(bytes)
}

/// Whether somebody has read standard input.
static IS_READ: AtomicBool = AtomicBool::new(false);

/// All of standard input as text.
///
/// # Errors
/// Why it cannot be read, also that it has been read: who names it twice would get nothing.
pub fn standard_input() -> Result<String> {
    if IS_READ.swap(true, Ordering::Relaxed) {
        bail!("standard input can be read once only; `-` stands for it in two places");
    }
    let mut bytes = Vec::new();
    io::stdin().take(MAX_BYTES + 1).read_to_end(&mut bytes).context("cannot read standard input")?;
    within_limit(bytes, MAX_BYTES).and_then(text_of).map_err(|reason| anyhow!("cannot read standard input: {reason}"))
}

/// Bytes as text.
///
/// # Errors
/// One clause that says why not.
pub fn text_of(bytes: Vec<u8>) -> Result<String, String> {
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..at].iter().filter(|&&byte| byte == b'\n').count() + 1;
        format!("it is not a text in UTF-8 (byte {at}, line {line})")
    })
}

/// Why a file cannot be read or written, as a clause.
pub fn reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file".to_string(),
        io::ErrorKind::PermissionDenied => "permission denied".to_string(),
        io::ErrorKind::IsADirectory => "it is a folder; name a file in it".to_string(),
        _ => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_binary_text_is_refused_with_its_place() {
        let found = text_of(b"(print 1)\n\xff".to_vec());
        assert_eq!(found, Err("it is not a text in UTF-8 (byte 10, line 2)".to_string()));
    }
}
