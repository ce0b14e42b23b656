//! A checkpoint as bytes: a saved run, and beside it what whoever drives it keeps.
//!
//! Layout: `RPLPOINT`, then two frames: what is kept, as JSON; and the saved run. It is not packed: most of it is
//! a belief, whose numbers halve at best, and packing would cost more than all the rest.

use super::frames;
use serde::Serialize;
use serde::de::DeserializeOwned;

const MAGIC: &[u8; 8] = b"RPLPOINT";

/// Why bytes are no checkpoint.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CheckpointFault {
    /// They do not begin as one does.
    #[error("it is no checkpoint: it does not begin with `RPLPOINT`")]
    Foreign,
    /// They were changed or cut off.
    #[error("its bytes were changed or cut off")]
    Damaged,
    /// What is kept was written by another version.
    #[error("what is kept beside the run cannot be read: {0}")]
    Kept(String),
}

/// What stands before the saved run in a checkpoint; the run follows as it is, without a copy.
///
/// # Errors
/// What is kept cannot be written, which is a fault of its type.
pub fn before<K: Serialize>(kept: &K, run: &[u8]) -> serde_json::Result<Vec<u8>> {
    let mut bytes = MAGIC.to_vec();
    frames::push(&mut bytes, &serde_json::to_vec(kept)?);
    bytes.extend_from_slice(&frames::head(run));
    Ok(bytes)
}

/// What is kept, and the saved run.
///
/// # Errors
/// The bytes are no checkpoint.
pub fn read<K: DeserializeOwned>(bytes: &[u8]) -> Result<(K, &[u8]), CheckpointFault> {
    let (kept, run) = read_frames(bytes)?;
    Ok((parsed(kept)?, run))
}

fn read_frames(bytes: &[u8]) -> Result<(&[u8], &[u8]), CheckpointFault> {
    let Some(rest) = bytes.strip_prefix(MAGIC) else {
        // A beginning of the first word is what a torn write leaves.
        let is_torn = bytes.len() < MAGIC.len() && MAGIC.starts_with(bytes);
        return Err(if is_torn { CheckpointFault::Damaged } else { CheckpointFault::Foreign });
    };
    let found = frames::read(rest);
    match found.whole[..] {
        [kept, run] if found.length == rest.len() => Ok((kept, run)),
        _ => Err(CheckpointFault::Damaged),
    }
}

fn parsed<K: DeserializeOwned>(kept: &[u8]) -> Result<K, CheckpointFault> {
    serde_json::from_slice(kept).map_err(|error| CheckpointFault::Kept(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_checkpoint_is_read_whole_or_not_at_all() {
        let run: Vec<u8> = (0..300_u32).map(|at| at as u8).collect();
        let bytes = [before(&"kept", &run).expect("it can be written"), run.clone()].concat();
        assert_eq!(read::<String>(&bytes), Ok(("kept".to_string(), &run[..])));
        for cut in 0..bytes.len() {
            assert_eq!(read::<String>(&bytes[..cut]), Err(CheckpointFault::Damaged), "cut at {cut}");
        }
        for bit in 0..bytes.len() * 8 {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let fault = read::<String>(&flipped).expect_err("it was changed");
            assert_eq!(fault == CheckpointFault::Foreign, bit / 8 < MAGIC.len(), "bit {bit}");
        }
        let longer = [&bytes[..], b"x"].concat();
        assert_eq!(read::<String>(&longer), Err(CheckpointFault::Damaged));
        assert!(matches!(read::<u32>(&bytes), Err(CheckpointFault::Kept(_))));
    }
}
