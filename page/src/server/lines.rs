//! The lines of a series, in blocks that answers share: however many are sent at a time, each is there once.

use hyper::body::Bytes;

/// A block is closed at the first end of a line behind this many bytes.
const BLOCK_BYTES: usize = 16 << 10;

/// A block of whole lines.
#[derive(Debug)]
struct Block {
    /// The byte of the series with which it begins.
    from: usize,
    text: Bytes,
}

/// The lines so far.
#[derive(Debug, Default)]
pub struct Lines {
    blocks: Vec<Block>,
    /// What lies behind the last block; whole lines, too.
    open: Vec<u8>,
    bytes: usize,
}

impl Lines {
    /// Adds lines, each ended.
    pub fn push(&mut self, lines: &str) {
        self.open.extend_from_slice(lines.as_bytes());
        self.bytes += lines.len();
        if self.open.len() >= BLOCK_BYTES {
            self.blocks.push(Block { from: self.open_from(), text: Bytes::copy_from_slice(&self.open) });
            self.open.clear();
        }
    }

    /// How long they are.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// The lines from a byte on, as far as the end of the block with which they have at least `long` bytes; and where
    /// that is. Cost: what they have in blocks, and a copy of what is in none yet.
    pub fn from(&self, from: usize, long: usize) -> (Vec<Bytes>, usize) {
        let mut next = from.min(self.bytes);
        let end = next.saturating_add(long);
        let mut parts = Vec::new();
        let first = self.blocks.partition_point(|block| block.from + block.text.len() <= next);
        for block in &self.blocks[first..] {
            if next >= end {
                return (parts, next);
            }
            parts.push(block.text.slice(next - block.from..));
            next = block.from + block.text.len();
        }
        if next < end && next < self.bytes {
            parts.push(Bytes::copy_from_slice(&self.open[next - self.open_from()..]));
            next = self.bytes;
        }
        (parts, next)
    }

    fn open_from(&self) -> usize {
        self.bytes - self.open.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_from_any_byte_are_those_of_the_whole_text_and_end_at_an_end_of_a_line() {
        let mut lines = Lines::default();
        let mut whole = Vec::new();
        for number in 0..9_000 {
            let line = format!("[{number},{{}}]\n");
            lines.push(&line);
            whole.extend_from_slice(line.as_bytes());
        }
        assert!(lines.blocks.len() > 3 && !lines.open.is_empty(), "the text has blocks, and something behind them");
        assert_eq!(lines.bytes(), whole.len());
        for from in (0..whole.len() + 20).step_by(997).chain([whole.len() - 1, whole.len(), usize::MAX]) {
            for long in [1, BLOCK_BYTES, 3 * BLOCK_BYTES + 1, usize::MAX] {
                let (parts, next) = lines.from(from, long);
                let from = from.min(whole.len());
                assert_eq!(parts.concat(), &whole[from..next], "from {from}, {long} long");
                assert!(next == whole.len() || next - from >= long && whole[next - 1] == b'\n', "{from} {long} {next}");
            }
        }
    }
}
