//! A file that a run was read from, and what shows that it is still the same.

use rpl_shell::files::inputs;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// A file as it was.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeptFile {
    /// From the root.
    pub path: PathBuf,
    /// CRC-32 of its bytes.
    pub checksum: u32,
}

impl KeptFile {
    /// A file as it is now; none if it is not there.
    pub fn now(path: &Path) -> Option<Self> {
        // Pipes and devices are not what they were, and would be waited for.
        let is_file = path.metadata().is_ok_and(|known| known.is_file());
        let file = is_file.then(|| File::open(path).ok())??;
        let mut bytes = Vec::new();
        // A longer file was never read.
        file.take(inputs::MAX_BYTES + 1).read_to_end(&mut bytes).ok()?;
        let path = std::path::absolute(path).ok()?;
        Some(Self { path, checksum: crc32fast::hash(&bytes) })
    }
}
