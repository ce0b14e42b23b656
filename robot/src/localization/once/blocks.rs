//! The map as the search has it: blocks of places, and between which distances lies what is expected from them.

use super::bound::{Expected, HEADINGS};
use super::scale::RangeScale;
use crate::geometry::Point;
use crate::localization::BeamParameters;
use crate::occupancy::{DistanceField, OccupancyGrid, SweepMap};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Edge of a block.
pub(super) const BLOCK_M: f64 = 0.25;

/// Places of a block along its edge, both ends of which it shares with the blocks beside it.
const PLACES: usize = 3;

/// Between two places.
const PLACE_M: f64 = BLOCK_M / (PLACES - 1) as f64;

/// Blocks of a tile along its edge; a whole number of groups.
const TILE: usize = 32;

/// Blocks of a group along its edge.
const GROUP: usize = 2;

/// Directions in which rays are cast: every degree.
const RAYS: usize = 360;

/// What is expected in each direction from some blocks, one after the other.
#[derive(Debug, Default)]
pub(super) struct Intervals {
    shortest: Vec<[u8; HEADINGS]>,
    longest: Vec<[u8; HEADINGS]>,
}

impl Intervals {
    pub(super) fn of(&self, index: usize) -> Expected<'_> {
        Expected { shortest: &self.shortest[index], longest: &self.longest[index] }
    }

    fn append(&mut self, other: Self) {
        self.shortest.extend(other.shortest);
        self.longest.extend(other.longest);
    }
}

/// Blocks in which somebody can stand, in groups of up to four.
#[derive(Debug, Default)]
pub(super) struct Blocks {
    /// Places where the sensor can be.
    pub places: Vec<Point>,
    /// What is expected from each in each direction.
    pub expected: Vec<[u8; HEADINGS]>,
    /// The places of the blocks, block by block; neighbours share those between them.
    members: Vec<u32>,
    /// Where the places of each block begin; after the last one, where they end.
    begins: Vec<usize>,
    /// What is expected from each block.
    pub intervals: Intervals,
    /// The first block of each group; after the last one, how many blocks there are.
    pub groups: Vec<usize>,
    /// What is expected from each group.
    pub group_intervals: Intervals,
}

/// What blocks are made of.
pub(super) struct Ground<'a> {
    pub map: &'a OccupancyGrid,
    pub distances: &'a DistanceField,
    pub beam: &'a BeamParameters,
    pub scale: RangeScale,
    /// From the middle of the robot to the nearest thing at the least.
    pub clearance_m: f64,
}

impl Blocks {
    /// Cost: about a millisecond and 17 kB for each square metre, on one core.
    pub(super) fn new(ground: &Ground<'_>) -> Self {
        let sweeps = SweepMap::new(ground.map);
        let tiles = |cells: usize| libm::ceil(cells as f64 * ground.map.resolution_m / BLOCK_M / TILE as f64) as usize;
        let (columns, rows) = (tiles(ground.map.columns), tiles(ground.map.rows));
        let tiles: Vec<Self> = (0..columns * rows)
            .into_par_iter()
            .map(|tile| ground.tile(&sweeps, [tile % columns, tile / columns]))
            .collect();
        let mut all = Self::default();
        for tile in tiles {
            all.groups.extend(tile.groups.iter().map(|first| first + all.begins.len()));
            all.begins.extend(tile.begins.iter().map(|begin| begin + all.members.len()));
            all.members.extend(tile.members.iter().map(|place| place + all.places.len() as u32));
            all.places.extend(tile.places);
            all.expected.extend(tile.expected);
            all.intervals.append(tile.intervals);
            all.group_intervals.append(tile.group_intervals);
        }
        all.groups.push(all.begins.len());
        all.begins.push(all.members.len());
        all
    }

    /// The blocks of a group.
    pub(super) fn in_group(&self, group: usize) -> std::ops::Range<usize> {
        self.groups[group]..self.groups[group + 1]
    }

    /// The places of a block.
    pub(super) fn in_block(&self, block: usize) -> impl Iterator<Item = usize> {
        self.members[self.begins[block]..self.begins[block + 1]].iter().map(|&place| place as usize)
    }

    /// How many groups there are.
    pub(super) fn group_count(&self) -> usize {
        self.groups.len() - 1
    }
}

/// The places of a tile along its edge.
const TILE_PLACES: usize = TILE * (PLACES - 1) + 1;

impl Ground<'_> {
    fn is_standable(&self, place: Point) -> bool {
        self.map.at(place) == crate::occupancy::Cell::Free && self.distances.clearance_m(place) >= self.clearance_m
    }

    fn tile(&self, sweeps: &SweepMap, [column, row]: [usize; 2]) -> Blocks {
        let origin = self.map.origin_in_frame;
        let tile_m = BLOCK_M * TILE as f64;
        let along = |from: f64, tile: usize, place: usize| from + tile as f64 * tile_m + place as f64 * PLACE_M;
        let place = |at: usize| {
            let (x, y) = (at % TILE_PLACES, at / TILE_PLACES);
            Point::new(along(origin.x, column, x), along(origin.y, row, y))
        };
        let standable: Vec<(usize, Point)> = (0..TILE_PLACES * TILE_PLACES)
            .map(|at| (at, place(at)))
            .filter(|&(_, place)| self.is_standable(place))
            .collect();
        let mut number = vec![None; TILE_PLACES * TILE_PLACES];
        standable.iter().zip(0..).for_each(|(&(at, _), index)| number[at] = Some(index));
        let mut blocks = Blocks { places: standable.iter().map(|&(_, place)| place).collect(), ..Blocks::default() };
        for group in 0..(TILE / GROUP) * (TILE / GROUP) {
            let first = blocks.begins.len();
            for block in 0..GROUP * GROUP {
                let x = group % (TILE / GROUP) * GROUP + block % GROUP;
                let y = group / (TILE / GROUP) * GROUP + block / GROUP;
                let begin = blocks.members.len();
                let places = (0..PLACES * PLACES)
                    .map(|at| (y * (PLACES - 1) + at / PLACES) * TILE_PLACES + x * (PLACES - 1) + at % PLACES);
                blocks.members.extend(places.filter_map(|at| number[at]));
                if blocks.members.len() > begin {
                    blocks.begins.push(begin);
                }
            }
            if blocks.begins.len() > first {
                blocks.groups.push(first);
            }
        }
        self.fill(&mut blocks, sweeps);
        blocks
    }

    /// What is expected from blocks of these places.
    fn fill(&self, blocks: &mut Blocks, sweeps: &SweepMap) {
        let places = blocks.places.len();
        let numbered: Vec<(usize, Point)> = blocks.places.iter().copied().enumerate().collect();
        let points = sweeps.points(&numbered);
        let (mount_m, max_m) = (self.beam.mount_radius_m, self.beam.max_range_m);
        let rays: Vec<Vec<u8>> = (0..RAYS)
            .map(|ray| {
                let (sin, cos) = libm::sincos(ray as f64 * TAU / RAYS as f64);
                let mut steps = vec![0; places];
                let of_range_m = |range_m: f64| self.scale.step(range_m - mount_m + self.beam.wall_depth_m);
                let found = |place: usize, step| steps[place] = step;
                sweeps.sweep(&points, (cos, sin), max_m + mount_m, of_range_m, found);
                steps
            })
            .collect();
        let half_cone = self.beam.cone_deg as usize / 2;
        let nearest_in = |direction: usize, reach: usize, into: &mut [u8]| {
            into.fill(u8::MAX);
            for ray in direction + RAYS - reach..=direction + RAYS + reach {
                into.iter_mut().zip(&rays[ray % RAYS]).for_each(|(nearest, &step)| *nearest = step.min(*nearest));
            }
        };
        let ends = blocks.begins.iter().skip(1).copied().chain([blocks.members.len()]);
        let members: Vec<_> = blocks.begins.iter().copied().zip(ends).map(|(begin, end)| begin..end).collect();
        blocks.expected.resize(places, [0; HEADINGS]);
        blocks.intervals.shortest.resize(members.len(), [u8::MAX; HEADINGS]);
        blocks.intervals.longest.resize(members.len(), [0; HEADINGS]);
        let (mut shortest, mut longest, mut turned) = (vec![0; places], vec![0; places], vec![0; places]);
        for heading in 0..HEADINGS {
            let direction = heading * RAYS / HEADINGS;
            // A cone is turned by up to a degree to either side.
            nearest_in(direction, half_cone + 1, &mut shortest);
            longest.fill(0);
            for off in [RAYS - 1, 1, 0] {
                nearest_in((direction + off) % RAYS, half_cone, &mut turned);
                longest.iter_mut().zip(&turned).for_each(|(longest, &step)| *longest = step.max(*longest));
            }
            // The last one is that of the direction itself.
            blocks.expected.iter_mut().zip(&turned).for_each(|(expected, &step)| expected[heading] = step);
            for (block, members) in members.iter().enumerate() {
                for &place in &blocks.members[members.clone()] {
                    let place = place as usize;
                    let of_block = &mut blocks.intervals.shortest[block][heading];
                    *of_block = shortest[place].min(*of_block);
                    let of_block = &mut blocks.intervals.longest[block][heading];
                    *of_block = longest[place].max(*of_block);
                }
            }
        }
        let ends = blocks.groups.iter().skip(1).copied().chain([members.len()]);
        for (first, end) in blocks.groups.clone().into_iter().zip(ends) {
            let of_group = |of: &[[u8; HEADINGS]], better: fn(u8, u8) -> u8| {
                let mut bounds = of[first];
                for block in &of[first + 1..end] {
                    bounds.iter_mut().zip(block).for_each(|(bound, &step)| *bound = better(*bound, step));
                }
                bounds
            };
            blocks.group_intervals.shortest.push(of_group(&blocks.intervals.shortest, u8::min));
            blocks.group_intervals.longest.push(of_group(&blocks.intervals.longest, u8::max));
        }
    }
}
