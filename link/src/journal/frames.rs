//! Frames: stretches of bytes with length and checksum, one behind the other, so that a file that was cut
//! off or changed is read up to the last whole one.
//!
//! A frame is its length and the checksum of length and content, little-endian u32 both, and the content.

/// What stands before a content: length and checksum.
pub const HEAD: usize = 2 * size_of::<u32>();

/// No frame is longer: lengths are counted in 32 bits.
pub const MOST_BYTES: usize = u32::MAX as usize;

/// A file of frames as far as it is whole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frames<'b> {
    /// The contents, in order.
    pub whole: Vec<&'b [u8]>,
    /// Bytes up to the end of the last whole frame.
    pub length: usize,
}

impl Frames<'_> {
    /// Bytes behind the last whole frame: the rest of one that was not written to its end, or that was
    /// changed.
    pub fn torn(&self, bytes: &[u8]) -> usize {
        bytes.len() - self.length
    }
}

/// Adds a frame.
///
/// # Panics
/// The content is longer than [`MOST_BYTES`].
pub fn push(bytes: &mut Vec<u8>, content: &[u8]) {
    bytes.reserve(HEAD + content.len());
    bytes.extend_from_slice(&head(content));
    bytes.extend_from_slice(content);
}

/// What stands before the content of a frame, for who writes that without a copy.
///
/// # Panics
/// The content is longer than [`MOST_BYTES`].
pub fn head(content: &[u8]) -> [u8; HEAD] {
    let length = u32::try_from(content.len()).unwrap_or_else(|_| panic!("no frame is so long: {}", content.len()));
    let mut head = [0; HEAD];
    head[..4].copy_from_slice(&length.to_le_bytes());
    head[4..].copy_from_slice(&checksum(length, content).to_le_bytes());
    head
}

/// Reads frames up to the first that is not whole.
pub fn read(bytes: &[u8]) -> Frames<'_> {
    let mut frames = Frames { whole: Vec::new(), length: 0 };
    while let Some(content) = first(&bytes[frames.length..]) {
        frames.length += HEAD + content.len();
        frames.whole.push(content);
    }
    frames
}

fn first(bytes: &[u8]) -> Option<&[u8]> {
    let (length, rest) = word(bytes)?;
    let (expected, rest) = word(rest)?;
    let content = rest.get(..usize::try_from(length).ok()?)?;
    (checksum(length, content) == expected).then_some(content)
}

fn word(bytes: &[u8]) -> Option<(u32, &[u8])> {
    let (word, rest) = bytes.split_first_chunk()?;
    Some((u32::from_le_bytes(*word), rest))
}

fn checksum(length: u32, content: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&length.to_le_bytes());
    hasher.update(content);
    hasher.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONTENTS: [&[u8]; 4] = [b"first", b"", b"a third one, longer", b"z"];

    fn written() -> Vec<u8> {
        let mut bytes = Vec::new();
        CONTENTS.iter().for_each(|content| push(&mut bytes, content));
        bytes
    }

    #[test]
    fn what_was_cut_off_is_read_up_to_the_last_whole_frame() {
        let bytes = written();
        let mut ends = vec![0];
        ends.extend(CONTENTS.iter().scan(0, |end, content| {
            *end += HEAD + content.len();
            Some(*end)
        }));
        for cut in 0..=bytes.len() {
            let frames = read(&bytes[..cut]);
            let whole = ends.iter().filter(|&&end| end > 0 && end <= cut).count();
            assert_eq!(frames.whole, CONTENTS[..whole]);
            assert_eq!((frames.length, frames.torn(&bytes[..cut])), (ends[whole], cut - ends[whole]));
        }
    }

    #[test]
    fn a_flipped_bit_ends_the_frames_before_its_own() {
        let bytes = written();
        for bit in 0..bytes.len() * 8 {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let frames = read(&flipped);
            assert!(frames.whole.len() < CONTENTS.len() && frames.length <= bit / 8, "bit {bit}");
            assert_eq!(frames.whole, CONTENTS[..frames.whole.len()]);
        }
    }
}
