//! Tiles as a saved run has them: stretches of equal cells once. A saved run is mostly cells, and in many of these
//! nobody can stand, or they are worth the same.
//!
//! Layout of the cells of a tile: stretches until there are as many as a tile has. A stretch is the number of cells
//! that are written out and how often the last of them comes again behind it, little-endian u16 both, and those
//! cells, little-endian.

use super::grid::TILE;
use super::ground::Cells;
use super::tile::Tile;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serializer};
use serde_bytes::ByteBuf;
use std::sync::Arc;

/// Fewer equal cells than this behind one are written out: a stretch of their own would be no shorter.
const FEWEST_REPEATS: usize = 2;

/// Places that are looked at together.
const TOGETHER: usize = 16;

/// A tile as it is written: number, cells, their sum and the largest of them.
type Saved = (u32, ByteBuf, f64, f32);

/// Writes tiles. Cost: one pass over their cells.
///
/// # Errors
/// The serializer's.
pub(super) fn serialize<S: Serializer>(tiles: &Arc<Vec<Tile>>, serializer: S) -> Result<S::Ok, S::Error> {
    let saved = |tile: &Tile| -> Saved { (tile.number, packed(&tile.cells).into(), tile.mass, tile.peak) };
    serializer.collect_seq(tiles.iter().map(saved))
}

/// Reads tiles.
///
/// # Errors
/// The bytes are none that were written so.
pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Arc<Vec<Tile>>, D::Error> {
    let tile =
        |(number, bytes, mass, peak): Saved| Some(Tile { number, cells: Arc::new(unpacked(&bytes)?), mass, peak });
    let tiles: Option<Vec<Tile>> = Vec::<Saved>::deserialize(deserializer)?.into_iter().map(tile).collect();
    let tiles = tiles.ok_or_else(|| D::Error::custom("the cells of a tile do not add up"))?;
    if !tiles.is_sorted_by(|one, next| one.number < next.number) {
        return Err(D::Error::custom("the tiles of a plane are out of order"));
    }
    Ok(Arc::new(tiles))
}

fn packed(cells: &Cells) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(size_of::<Cells>() / 4);
    let mut rest = cells.as_slice();
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

/// Adds cells that are written out, and how often the last of them comes again.
fn push(bytes: &mut Vec<u8>, cells: &[f32], repeats: usize) {
    bytes.extend_from_slice(&(cells.len() as u16).to_le_bytes());
    bytes.extend_from_slice(&(repeats as u16).to_le_bytes());
    let begin = bytes.len();
    bytes.resize(begin + size_of_val(cells), 0);
    for (place, cell) in bytes[begin..].as_chunks_mut().0.iter_mut().zip(cells) {
        *place = cell.to_le_bytes();
    }
}

/// None if the stretches have not as many cells as a tile.
fn unpacked(mut bytes: &[u8]) -> Option<Cells> {
    let mut cells = Vec::with_capacity(TILE);
    while let Some((&[a, b, c, d], rest)) = bytes.split_first_chunk() {
        let (written, repeats) = (usize::from(u16::from_le_bytes([a, b])), usize::from(u16::from_le_bytes([c, d])));
        let (words, rest) = rest.split_at_checked(size_of::<f32>() * written)?;
        if cells.len() + written + repeats > TILE || written == 0 {
            return None;
        }
        cells.extend(words.as_chunks().0.iter().map(|word| f32::from_le_bytes(*word)));
        let last = *cells.last()?;
        cells.resize(cells.len() + repeats, last);
        bytes = rest;
    }
    if bytes.is_empty() { cells.try_into().ok() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn bits(cells: &Cells) -> Vec<u32> {
        cells.iter().map(|cell| cell.to_bits()).collect()
    }

    proptest! {
        #[test]
        fn cells_come_back_bit_by_bit(stretches in prop::collection::vec((0..6_u32, 1..90_usize), 1..60)) {
            // Among them 0, −0 and what is no number.
            let value = |kind: u32| f32::from_bits([0, 0x8000_0000, 0x7fc0_0001, 1, 0x3f80_0000, 0x3f80_0001][kind as usize]);
            let mut cells = stretches.iter().cycle().flat_map(|&(kind, count)| vec![value(kind); count]);
            let cells: Cells = std::array::from_fn(|_| cells.next().expect("they go round"));
            let again = unpacked(&packed(&cells)).expect("they were written");
            prop_assert_eq!(bits(&again), bits(&cells));
        }
    }

    #[test]
    fn equal_cells_take_next_to_nothing_and_different_ones_as_much_as_they_are() {
        let same = [0.25; TILE];
        let bytes = packed(&same);
        assert!(bytes.len() < 16, "{}", bytes.len());
        assert_eq!(unpacked(&bytes), Some(same));
        let others: Cells = std::array::from_fn(|at| at as f32);
        assert_eq!(unpacked(&packed(&others)), Some(others));
        assert!(packed(&others).len() <= size_of::<Cells>() + 8);
    }

    #[test]
    fn what_does_not_add_up_is_refused() {
        let cells: Cells = std::array::from_fn(|at| if at < 4 { 1.0 } else { at as f32 });
        let bytes = packed(&cells);
        for cut in 0..40 {
            assert_eq!(unpacked(&bytes[..bytes.len() - 1 - cut]), None, "cut by {cut}");
        }
        let more = |at: usize| {
            let mut bytes = bytes.clone();
            bytes[at] += 1;
            unpacked(&bytes)
        };
        assert_eq!((more(0), more(1), more(2)), (None, None, None));
    }
}
