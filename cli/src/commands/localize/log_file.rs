//! What a log is, by how it begins and not by its name: a CARMEN text or MCAP, either of them also packed, or a folder
//! with MCAP in it, as `ros2 bag record` makes it.

use anyhow::{Result, anyhow, bail};
use rpl_shell::files::inputs::{self, MAX_BYTES, text_of};
use rpl_shell::files::packed::Packing;
use rpl_shell::files::shown::Shown;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// How an MCAP file begins.
const MCAP: &[u8] = b"\x89MCAP";

/// A longer recording is refused: it is read as a whole. An hour of a robot with a laser takes a fifth of that.
const MOST_BYTES: u64 = 2 << 30;

/// What a log has in it.
pub enum Log {
    /// A text of CARMEN.
    Carmen(String),
    /// The bytes of an MCAP file.
    Mcap(Vec<u8>),
}

/// Reads a file, and unpacks it.
///
/// # Errors
/// It cannot be read or unpacked, is too long, or is of a kind that must be converted first, which is told.
pub fn read(path: &Path) -> Result<Log> {
    let name = path.shown();
    open(path).map_err(|reason| anyhow!("cannot read the log `{name}`: {reason}"))
}

fn open(path: &Path) -> Result<Log, String> {
    let unread = |error: io::Error| inputs::reason(&error);
    let mut file = inputs::open(path)?;
    let head = inputs::head_of(&mut file).map_err(unread)?;
    let Some(packing) = Packing::of(&head) else {
        let most = most_bytes(&head, path)?;
        return log_of(inputs::whole(head, &mut file, most).map_err(unread)??);
    };
    let packed = inputs::whole(head, &mut file, MOST_BYTES).map_err(unread)??;
    let damaged = |error: io::Error| format!("it is packed by {}, and damaged ({error})", packing.name());
    let mut reader = packing.reader(&packed);
    let head = inputs::head_of(&mut reader).map_err(damaged)?;
    if let Some(again) = Packing::of(&head) {
        return Err(format!("it is packed twice, by {} and {}; unpack it once", packing.name(), again.name()));
    }
    let most = most_bytes(&head, path)?;
    let unpacked = inputs::whole(head, &mut reader, most).map_err(damaged)?;
    log_of(unpacked.map_err(|reason| format!("unpacked, {reason}"))?)
}

fn log_of(bytes: Vec<u8>) -> Result<Log, String> {
    if bytes.starts_with(MCAP) { Ok(Log::Mcap(bytes)) } else { text_of(bytes).map(Log::Carmen) }
}

/// How long a file may be that begins so.
fn most_bytes(head: &[u8], path: &Path) -> Result<u64, String> {
    match foreign(head, path) {
        Some(advice) => Err(advice),
        None if head.starts_with(MCAP) => Ok(MOST_BYTES),
        None => Ok(MAX_BYTES),
    }
}

/// The recordings of a folder, in the order of their names.
///
/// # Errors
/// It cannot be read, or has none; what it has of another kind is told.
pub fn in_folder(folder: &Path) -> Result<Vec<PathBuf>> {
    let name = folder.shown();
    let cannot = |reason: String| anyhow!("cannot read the log `{name}`: {reason}");
    let entries = fs::read_dir(folder).map_err(|error| cannot(inputs::reason(&error)))?;
    let mut files: Vec<PathBuf> =
        entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|path| path.is_file()).collect();
    files.sort();
    let mut recordings = Vec::new();
    let mut advice = None;
    for file in files {
        let head = head(&file);
        if head.starts_with(MCAP) || (Packing::of(&head).is_some() && is_named_mcap(&file)) {
            recordings.push(file);
        } else if advice.is_none() {
            // A bag in SQLite is converted by its folder.
            advice = foreign(&head, folder);
        }
    }
    match (recordings.is_empty(), advice) {
        (false, _) => Ok(recordings),
        (true, Some(advice)) => Err(cannot(advice)),
        (true, None) => bail!(
            "cannot read the log `{name}`: the folder has no MCAP file; name a file, or a folder of \
                               `ros2 bag record -s mcap`"
        ),
    }
}

/// How a file begins; what cannot be read is no recording.
fn head(file: &Path) -> Vec<u8> {
    File::open(file).and_then(|mut file| inputs::head_of(&mut file)).unwrap_or_default()
}

/// Whether the name says that a packed file is a recording: a folder may have other files.
fn is_named_mcap(file: &Path) -> bool {
    file.file_name().is_some_and(|name| name.to_string_lossy().contains(".mcap"))
}

/// What to type for a file of a known kind that is not read, by how it begins.
fn foreign(head: &[u8], path: &Path) -> Option<String> {
    let name = typed(&path.shown());
    let stem = path.file_stem().map_or_else(|| "bag".to_string(), |stem| Path::new(stem).shown());
    let converted = typed(&format!("{stem}-mcap"));
    if head.starts_with(b"SQLite format 3\0") {
        return Some(format!(
            "it is a bag of ROS 2 in SQLite, and bags are read as MCAP; type `echo 'output_bags: [{{uri: {converted}, \
             storage_id: mcap, all: true}}]' > to-mcap.yaml && ros2 bag convert -i {name} -o to-mcap.yaml`, and name \
             the folder `{converted}`"
        ));
    }
    if head.starts_with(b"#ROSBAG V") {
        return Some(format!(
            "it is a bag of ROS 1, and bags are read as MCAP of ROS 2; type `pip install rosbags && rosbags-convert \
             --src {name} --dst {converted} --dst-storage mcap`, and name the folder `{converted}`"
        ));
    }
    let unpacked = [
        (&b"BZh"[..], 0, "bzip2", "bunzip2 -k"),
        (b"\xfd7zXZ\0", 0, "xz", "xz -dk"),
        (b"PK\x03\x04", 0, "zip", "unzip"),
        (b"7z\xbc\xaf\x27\x1c", 0, "7-Zip", "7z x"),
        (b"ustar", 257, "tar", "tar -xf"),
    ];
    let begins = |magic: &[u8], at: usize| head.get(at..).is_some_and(|rest| rest.starts_with(magic));
    let found = unpacked.into_iter().find(|(magic, at, ..)| begins(magic, *at));
    found.map(|(_, _, by, command)| format!("it is packed by {by}; type `{command} {name}`, and name what comes out"))
}

/// A name as a shell takes it.
fn typed(name: &str) -> String {
    let plain = |character: char| character.is_alphanumeric() || "./_-".contains(character);
    if name.chars().all(plain) { name.to_string() } else { format!("\"{name}\"") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_must_be_converted_is_known_by_its_beginning() {
        let advice = |head: &[u8]| foreign(head, Path::new("drives/a drive.log")).unwrap_or_default();
        assert!(advice(b"SQLite format 3\0...").contains("ros2 bag convert -i \"drives/a drive.log\" -o to-mcap.yaml"));
        assert!(
            advice(b"#ROSBAG V2.0\n").contains("rosbags-convert --src \"drives/a drive.log\" --dst \"a drive-mcap\"")
        );
        assert!(advice(b"BZh9").contains("bunzip2 -k"));
        assert!(advice(&[&[0; 257][..], b"ustar\0"].concat()).contains("tar -xf"));
        assert_eq!(advice(b"FLASER 3"), "");
    }
}
