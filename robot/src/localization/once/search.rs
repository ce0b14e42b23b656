//! Branch and bound: which blocks and headings may explain a scan.

use super::bound::{HEADINGS, SearchBeam, costs};
use super::locator::ScanLocator;
use super::scan::Scan;
use crate::geometry::Pose;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// What costs more than the best pose by this much is no explanation beside it, in eighths of a nat.
const MARGIN: u16 = 108;

/// Groups of blocks that are looked into for a first explanation, those that may fit best.
const FIRST_GROUPS: usize = 512;

/// Beams by which they are found.
const FIRST_BEAMS: usize = 20;

/// Poses of them that are judged, and that are refined.
const FIRST_JUDGED: usize = 96;
const FIRST_REFINED: usize = 8;

/// Headings that are one candidate.
const SECTOR: usize = 5;

/// Candidates that are judged, at the most.
pub(super) const MOST_CANDIDATES: usize = 2048;

/// A block and a few headings in which the scan may be explained.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    /// The place and the heading where the scan fits best.
    pub pose: Pose,
    /// −ln of its likelihood there, tempered.
    pub nats: f64,
    /// How many places and headings are as good as that, by their likelihood.
    pub volume: f64,
}

/// What may explain a scan.
#[derive(Debug, Default)]
pub(super) struct Candidates {
    /// The likeliest by their bounds.
    pub some: Vec<Candidate>,
    /// What the others are worth at the most, as one.
    pub others: Option<Candidate>,
}

/// A block, some headings of it, and the least bound of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Sector {
    bound: u16,
    block: usize,
    first_heading: usize,
}

impl ScanLocator {
    /// All blocks and headings that cost more than the best pose found by no more than a margin.
    ///
    /// # Method
    /// Branch and bound as Olson, "Real-time correlative scan matching", 2009, and Hess et al., "Real-time loop closure in
    /// 2D LIDAR SLAM", 2016, have it, with other bounds: the distances expected from all places of a block lie in an
    /// interval, which tells of walls that a ray would have to go through as well as of its end.
    pub(super) fn candidates(&self, scan: &Scan) -> Candidates {
        let least = |group: usize, beams: &[SearchBeam], limit: u16| {
            let costs = costs(&self.blocks.group_intervals.of(group), beams, limit);
            costs.and_then(|costs| costs[..HEADINGS].iter().copied().min()).unwrap_or(u16::MAX)
        };
        let first_beams = &scan.searched[..scan.searched.len().min(FIRST_BEAMS)];
        let groups = (0..self.blocks.group_count()).into_par_iter();
        let mut first: Vec<(u16, usize)> = groups.map(|group| (least(group, first_beams, u16::MAX), group)).collect();
        first.sort_unstable();
        let limit = self.first_cost(scan, &first).saturating_add(MARGIN);
        let within = first.partition_point(|&(least, _)| least <= limit);
        let groups: Vec<usize> = (first[..within].par_iter())
            .map(|&(_, group)| group)
            .filter(|&group| least(group, &scan.searched, limit) <= limit)
            .collect();
        let mut sectors: Vec<Sector> =
            groups.par_iter().flat_map_iter(|&group| self.sectors_in(scan, group, limit)).collect();
        sectors.sort_unstable();
        let others = sectors.split_off(sectors.len().min(MOST_CANDIDATES));
        let some: Vec<Candidate> = sectors.par_iter().map(|sector| self.judged(scan, sector)).collect();
        let best = some.iter().map(|candidate| candidate.nats).fold(f64::INFINITY, f64::min);
        // A sector is worth at most as much as those that were judged with the same bound.
        let others = others.first().zip(some.last()).map(|(first, last)| {
            let per_unit = Self::tempering_of_bound(scan);
            let share = |other: &Sector| libm::exp(-per_unit * f64::from(other.bound - first.bound));
            Candidate {
                nats: best.max(last.nats),
                volume: others.iter().map(share).sum::<f64>() * last.volume,
                ..*last
            }
        });
        Candidates { some, others }
    }

    /// The cost of a pose that explains the scan well: the best one costs at most that.
    fn first_cost(&self, scan: &Scan, first: &[(u16, usize)]) -> u16 {
        let groups = &first[..first.len().min(FIRST_GROUPS)];
        let mut sectors: Vec<Sector> =
            groups.par_iter().flat_map_iter(|&(_, group)| self.best_of_blocks(scan, group)).collect();
        sectors.sort_unstable();
        sectors.truncate(FIRST_JUDGED);
        let judged = |sector: &Sector| self.judged(scan, sector);
        let mut judged: Vec<Candidate> = sectors.par_iter().map(judged).collect();
        judged.sort_by(|a, b| a.nats.total_cmp(&b.nats));
        judged.truncate(FIRST_REFINED);
        let cost = |first: &Candidate| {
            let refined = self.judge.refined(scan, first.pose);
            self.judge.search_cost(scan, &self.scale, refined)
        };
        judged.par_iter().map(cost).min().unwrap_or(u16::MAX)
    }

    /// The sector with the least bound in each block.
    fn best_of_blocks(&self, scan: &Scan, group: usize) -> impl Iterator<Item = Sector> {
        self.blocks.in_group(group).filter_map(|block| {
            let costs = costs(&self.blocks.intervals.of(block), &scan.searched, u16::MAX)?;
            let (heading, &bound) = costs[..HEADINGS].iter().enumerate().min_by_key(|&(_, cost)| cost)?;
            Some(Sector { bound, block, first_heading: heading / SECTOR * SECTOR })
        })
    }

    /// All sectors of a group with a bound up to the limit.
    fn sectors_in(&self, scan: &Scan, group: usize, limit: u16) -> Vec<Sector> {
        let mut found = Vec::new();
        for block in self.blocks.in_group(group) {
            let Some(costs) = costs(&self.blocks.intervals.of(block), &scan.searched, limit) else { continue };
            for (sector, costs) in costs[..HEADINGS].chunks(SECTOR).enumerate() {
                let bound = costs.iter().copied().min().unwrap_or(u16::MAX);
                if bound <= limit {
                    found.push(Sector { bound, block, first_heading: sector * SECTOR });
                }
            }
        }
        found
    }

    /// How well the scan fits at the places and headings of a sector.
    fn judged(&self, scan: &Scan, sector: &Sector) -> Candidate {
        let headings = sector.first_heading..sector.first_heading + SECTOR;
        let states =
            self.blocks.in_block(sector.block).flat_map(|place| headings.clone().map(move |heading| (place, heading)));
        let judged: Vec<(f64, (usize, usize))> = states
            .map(|(place, heading)| {
                let nats = scan.coarse_nats(&self.blocks.expected[place], heading);
                (scan.independent * nats, (place, heading))
            })
            .collect();
        let first = (f64::INFINITY, (0, 0));
        let (nats, (place, heading)) =
            judged.iter().copied().fold(first, |best, one| if one.0 < best.0 { one } else { best });
        let at = self.blocks.places[place];
        let pose = Pose::new(at.x, at.y, heading as f64 * TAU / HEADINGS as f64);
        Candidate { pose, nats, volume: judged.iter().map(|(other, _)| libm::exp(nats - other)).sum() }
    }

    /// Tempered nats of one unit of a bound.
    fn tempering_of_bound(scan: &Scan) -> f64 {
        let beams = scan.searched.len() as f64;
        scan.independent / beams / 8.0
    }
}
