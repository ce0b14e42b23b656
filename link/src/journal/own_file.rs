//! Files of a journal's own: none of them is a link, a pipe or a device that somebody has put there.

use rustix::fs::OFlags;
use rustix::io::Errno;
use std::fs::{File, OpenOptions};
use std::io::{self, Read};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

/// A longer file is none of a journal.
const MOST_BYTES: u64 = 4 << 30;

/// Opens a file of a journal.
///
/// # Errors
/// It cannot be opened so, or is a link or something else than a file.
pub fn open(path: &Path, options: &mut OpenOptions) -> io::Result<File> {
    opened(path, options, OFlags::NOFOLLOW)
}

/// Opens a file that a journal names, such as a trace, which may be a link.
///
/// # Errors
/// It cannot be opened so, or is something else than a file.
pub fn open_named(path: &Path, options: &mut OpenOptions) -> io::Result<File> {
    opened(path, options, OFlags::empty())
}

fn opened(path: &Path, options: &mut OpenOptions, flags: OFlags) -> io::Result<File> {
    // A pipe would be waited for.
    let flags = (flags | OFlags::NONBLOCK).bits().cast_signed();
    let file = options.custom_flags(flags).open(path).map_err(|error| match Errno::from_io_error(&error) {
        Some(Errno::LOOP) => io::Error::other("it is a link, and a journal has none"),
        Some(_) | None => error,
    })?;
    if !file.metadata()?.is_file() {
        return Err(io::Error::other("it is no file, but a folder, a pipe or a device"));
    }
    Ok(file)
}

/// The bytes of a file of a journal.
///
/// # Errors
/// It cannot be read, is a link or something else than a file, or is too long.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let file = open(path, File::options().read(true))?;
    if file.metadata()?.len() > MOST_BYTES {
        return Err(io::Error::other(format!("it is longer than {} GiB", MOST_BYTES >> 30)));
    }
    let mut bytes = Vec::new();
    file.take(MOST_BYTES).read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::os::unix::fs::symlink;

    #[test]
    fn links_and_what_is_no_file_are_refused_and_files_are_not() {
        let folder = std::env::temp_dir().join(format!("rpl-own-file-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("it can be made");
        let at = |name: &str| folder.join(name);
        fs::write(at("file"), "bytes").expect("it can be written");
        symlink("file", at("link")).expect("it can be made");
        symlink("nowhere", at("dangling")).expect("it can be made");
        let writes = |name: &str| open(&at(name), File::options().write(true).create(true).truncate(false));
        assert_eq!(read(&at("file")).expect("it is a file"), b"bytes");
        assert!(writes("file").is_ok() && writes("new").is_ok());
        for link in ["link", "dangling"] {
            let refused = "it is a link, and a journal has none";
            assert_eq!(read(&at(link)).expect_err("it is a link").to_string(), refused);
            assert_eq!(writes(link).expect_err("it is a link").to_string(), refused);
        }
        assert!(!at("nowhere").exists());
        assert!(read(&folder).is_err() && read(Path::new("/dev/zero")).is_err());
        assert!(open_named(&at("link"), File::options().read(true)).is_ok());
        assert!(open_named(Path::new("/dev/zero"), File::options().read(true)).is_err());
        File::create(at("huge")).and_then(|file| file.set_len(MOST_BYTES + 1)).expect("it can be made");
        assert!(read(&at("huge")).expect_err("it is too long").to_string().contains("longer than 4 GiB"));
        fs::remove_dir_all(folder).ok();
    }
}
