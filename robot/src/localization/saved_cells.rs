//! Cells as a saved run has them: stretches of equal ones once. A saved run is mostly cells, and most of these are
//! below θ and worth the same, or none can be stood in.
//!
//! Layout: the number of cells, little-endian u32; then stretches until there are so many. A stretch is the number
//! of cells that are written out and how often the last of them comes again behind it, little-endian u16 both, and
//! those cells, little-endian.

use serde::de::Error;
use serde::{Deserializer, Serializer};
use serde_bytes::ByteBuf;
use std::sync::Arc;

/// Fewer equal cells than this behind one are written out: a stretch of their own would be no shorter.
const FEWEST_REPEATS: usize = 2;

/// Places that are looked at together.
const TOGETHER: usize = 16;

/// More cells than any plane has: one of a square kilometre in cells of 15 cm has 45 million.
const MOST_CELLS: usize = 1 << 26;

/// What a stretch counts with.
const MOST_OF_A_KIND: usize = u16::MAX as usize;

/// Writes cells. Cost: one pass over them.
///
/// # Errors
/// The serializer's.
pub(super) fn serialize<S: Serializer>(cells: &Arc<Vec<f32>>, serializer: S) -> Result<S::Ok, S::Error> {
    serde_bytes::serialize(&packed(cells), serializer)
}

/// Reads cells.
///
/// # Errors
/// The bytes are none that were written so.
pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Arc<Vec<f32>>, D::Error> {
    let bytes: ByteBuf = serde_bytes::deserialize(deserializer)?;
    unpacked(&bytes).map(Arc::new).ok_or_else(|| D::Error::custom("the cells of a plane do not add up"))
}

fn packed(cells: &[f32]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(size_of::<u32>() + size_of_val(cells) / 4);
    bytes.extend_from_slice(&(cells.len() as u32).to_le_bytes());
    let mut rest = cells;
    while !rest.is_empty() {
        let single = before_repeats(rest);
        let Some(repeated) = rest.get(single) else {
            push(&mut bytes, rest, 0);
            break;
        };
        let repeats = rest[single + 1..].iter().take_while(|cell| cell.to_bits() == repeated.to_bits()).count();
        push(&mut bytes, &rest[..=single], repeats);
        rest = &rest[single + 1 + repeats..];
    }
    bytes
}

/// How many cells stand before the first that is repeated often enough.
fn before_repeats(cells: &[f32]) -> usize {
    let is_repeated =
        |cells: &[f32]| cells[1..].iter().fold(true, |all, cell| all & (cell.to_bits() == cells[0].to_bits()));
    // Several places at once, which the compiler makes one comparison of: most have no repeats behind them.
    let among = |cells: &[f32; TOGETHER + FEWEST_REPEATS]| {
        (0..TOGETHER).fold(false, |any, at| any | is_repeated(&cells[at..=at + FEWEST_REPEATS]))
    };
    let mut at = 0;
    while cells[at..].first_chunk().is_some_and(|part| !among(part)) {
        at += TOGETHER;
    }
    let place = cells[at..].windows(1 + FEWEST_REPEATS).position(is_repeated);
    place.map_or(cells.len(), |place| at + place)
}

/// Adds cells that are written out, and how often the last of them comes again; as many stretches as it takes.
fn push(bytes: &mut Vec<u8>, cells: &[f32], mut repeats: usize) {
    let mut parts = cells.chunks(MOST_OF_A_KIND).peekable();
    while let Some(part) = parts.next() {
        let now = if parts.peek().is_none() { repeats.min(MOST_OF_A_KIND) } else { 0 };
        push_stretch(bytes, part, now);
        repeats -= now;
    }
    while repeats > 0 {
        let now = (repeats - 1).min(MOST_OF_A_KIND);
        push_stretch(bytes, &cells[cells.len() - 1..], now);
        repeats -= now + 1;
    }
}

fn push_stretch(bytes: &mut Vec<u8>, cells: &[f32], repeats: usize) {
    bytes.extend_from_slice(&(cells.len() as u16).to_le_bytes());
    bytes.extend_from_slice(&(repeats as u16).to_le_bytes());
    let begin = bytes.len();
    bytes.resize(begin + size_of_val(cells), 0);
    for (place, cell) in bytes[begin..].as_chunks_mut().0.iter_mut().zip(cells) {
        *place = cell.to_le_bytes();
    }
}

/// None if the stretches have not as many cells as there are to be.
fn unpacked(bytes: &[u8]) -> Option<Vec<f32>> {
    let (count, mut bytes) = bytes.split_first_chunk()?;
    let count = u32::from_le_bytes(*count) as usize;
    let mut cells = Vec::new();
    if count > MOST_CELLS {
        return None;
    }
    while let Some((&[a, b, c, d], rest)) = bytes.split_first_chunk() {
        let (written, repeats) = (usize::from(u16::from_le_bytes([a, b])), usize::from(u16::from_le_bytes([c, d])));
        let (words, rest) = rest.split_at_checked(size_of::<f32>() * written)?;
        if cells.len() + written + repeats > count || written == 0 {
            return None;
        }
        cells.reserve(if cells.is_empty() { count } else { 0 });
        cells.extend(words.as_chunks().0.iter().map(|word| f32::from_le_bytes(*word)));
        let last = *cells.last()?;
        cells.resize(cells.len() + repeats, last);
        bytes = rest;
    }
    (cells.len() == count && bytes.is_empty()).then_some(cells)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn cells_come_back_bit_by_bit(stretches in prop::collection::vec((0..6_u32, 1..9_usize), 0..60)) {
            // Among them 0, −0 and what is no number.
            let value = |kind: u32| f32::from_bits([0, 0x8000_0000, 0x7fc0_0001, 1, 0x3f80_0000, 0x3f80_0001][kind as usize]);
            let cells: Vec<f32> = stretches.iter().flat_map(|&(kind, count)| vec![value(kind); count]).collect();
            let again = unpacked(&packed(&cells)).expect("they were written");
            let bits = |cells: &[f32]| cells.iter().map(|cell| cell.to_bits()).collect::<Vec<_>>();
            prop_assert_eq!(bits(&again), bits(&cells));
        }
    }

    #[test]
    fn long_stretches_are_counted_in_parts() {
        for count in [MOST_OF_A_KIND - 1, MOST_OF_A_KIND, MOST_OF_A_KIND + 1, MOST_OF_A_KIND + 2, 5 * MOST_OF_A_KIND] {
            let same = vec![0.25; count];
            let bytes = packed(&same);
            assert!(bytes.len() < 64, "{count} cells take {} bytes", bytes.len());
            assert_eq!(unpacked(&bytes), Some(same));
            let others: Vec<f32> = (0..count).map(|at| at as f32).collect();
            assert_eq!(unpacked(&packed(&others)), Some(others));
        }
    }

    #[test]
    fn what_does_not_add_up_is_refused() {
        let bytes = packed(&[1.0, 1.0, 1.0, 1.0, 2.0, 3.0]);
        for cut in 0..bytes.len() {
            assert_eq!(unpacked(&bytes[..cut]), None, "cut at {cut}");
        }
        let more = |at: usize| {
            let mut bytes = bytes.clone();
            bytes[at] += 1;
            unpacked(&bytes)
        };
        assert_eq!((more(0), more(3), more(4), more(6)), (None, None, None, None));
    }
}
