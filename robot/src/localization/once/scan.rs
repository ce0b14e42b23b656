//! A scan, and how badly it fits a pose.

use super::bound::{HEADINGS, MOST_BEAMS, SearchBeam};
use super::likelihood::{Likelihood, ReadingCost};
use super::scale::RangeScale;
use crate::geometry::{Point, Pose, wrap_angle_rad};
use crate::localization::BeamParameters;
use crate::localization::evidence::Evidence;
use crate::localization::scan_match::SCALES_M;
use crate::occupancy::DistanceField;
use nalgebra::{Matrix3, Vector3};
use std::collections::BTreeSet;
use std::f64::consts::TAU;

/// One reading of a scan, from the middle of the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeBeam {
    /// From straight ahead to the left.
    pub bearing_rad: f64,
    /// What was measured; at or beyond the range of the sensor is no echo. One that is not finite is missing.
    pub range_m: f64,
}

/// Readings that are judged at each pose, at the most.
const MOST_JUDGED: usize = 360;

/// Readings by which a pose is refined, at the most.
const MOST_REFINED: usize = 60;

/// How well the place in a block, and its heading, are known before the scan refines them.
const KNOWN_M: f64 = 0.15;
const KNOWN_RAD: f64 = 2.0 / 180.0 * std::f64::consts::PI;

/// A pose that is refined farther than this is another one.
const FARTHEST_M: f64 = 0.4;
const FARTHEST_RAD: f64 = 8.0 / 180.0 * std::f64::consts::PI;

/// Rays through a cone, to either side of its middle.
const BESIDE: i32 = 3;

/// A reading as poses are judged by it.
#[derive(Clone, Copy, Debug)]
struct JudgedBeam {
    /// Cosine and sine of its bearing.
    along: (f64, f64),
    cost: ReadingCost,
}

/// A scan as it is compared with the map.
pub(super) struct Scan {
    /// As how many independent beams it counts.
    pub independent: f64,
    /// In the order in which they are compared: a few of them tell.
    pub searched: Vec<SearchBeam>,
    /// The same as rays, ...
    rays: Vec<JudgedBeam>,
    /// ... and what each costs by the step that is expected, in nats.
    costs: Vec<[f32; STEPS]>,
    /// More of them, for refined poses.
    fine: Vec<JudgedBeam>,
    refined: Vec<RangeBeam>,
}

impl Scan {
    pub(super) fn new(beams: &[RangeBeam], scale: &RangeScale, judge: &Judge) -> Self {
        let mut present: Vec<RangeBeam> = (beams.iter().copied())
            .filter(|beam| beam.range_m.is_finite() && beam.bearing_rad.is_finite())
            .map(|beam| RangeBeam { bearing_rad: wrap_angle_rad(beam.bearing_rad), ..beam })
            .collect();
        present.sort_by(|a, b| a.bearing_rad.total_cmp(&b.bearing_rad));
        let (coarse, searched): (Vec<RangeBeam>, _) = mixed(&searched(&present, scale)).into_iter().unzip();
        let judged = |beams: &[RangeBeam], likelihood: &Likelihood| {
            let judged = |beam: &RangeBeam| {
                let (sin, cos) = libm::sincos(beam.bearing_rad);
                JudgedBeam { along: (cos, sin), cost: likelihood.of(beam.range_m) }
            };
            beams.iter().map(judged).collect()
        };
        Self {
            independent: independent(&present, judge.beam.cone_deg),
            searched,
            rays: judged(&coarse, &judge.coarse),
            costs: coarse.iter().map(|beam| costs(judge.coarse.of(beam.range_m), scale)).collect(),
            fine: judged(&spread(&present, MOST_JUDGED), &judge.fine),
            refined: spread(&present, MOST_REFINED),
        }
    }

    /// −ln of the likelihood of the scan, for each beam, where this is expected in each direction.
    pub(super) fn coarse_nats(&self, expected: &[u8; HEADINGS], heading: usize) -> f64 {
        let nats = |(beam, costs): (&SearchBeam, &[f32; STEPS])| {
            let direction = heading + beam.direction;
            let direction = if direction >= HEADINGS { direction - HEADINGS } else { direction };
            f64::from(costs[usize::from(expected[direction])])
        };
        self.searched.iter().zip(&self.costs).map(nats).sum::<f64>() / self.searched.len() as f64
    }

    /// Whether it has no reading.
    pub(super) fn is_empty(&self) -> bool {
        self.searched.is_empty()
    }
}

/// Beams within this angle count as one: they meet the same wall and the same people, and what is missing in the map.
const ALIKE_DEG: i64 = 9;

/// The same for cones.
const ALIKE_CONES_DEG: i64 = 30;

/// As how many independent beams some count.
fn independent(beams: &[RangeBeam], cone_deg: u32) -> f64 {
    let alike_deg = if cone_deg == 0 { ALIKE_DEG } else { ALIKE_CONES_DEG };
    let sector = |beam: &RangeBeam| (libm::floor(beam.bearing_rad.to_degrees()) as i64).rem_euclid(360) / alike_deg;
    beams.iter().map(sector).collect::<BTreeSet<i64>>().len() as f64
}

/// Steps of a scale.
const STEPS: usize = 256;

/// What a reading costs by the step that is expected.
fn costs(cost: ReadingCost, scale: &RangeScale) -> [f32; STEPS] {
    std::array::from_fn(|step| cost.nats(scale.range_m(step as u8)) as f32)
}

/// Some readings, evenly spread.
fn spread(beams: &[RangeBeam], most: usize) -> Vec<RangeBeam> {
    let count = beams.len().min(most);
    (0..count).map(|number| beams[number * beams.len() / count]).collect()
}

/// For each of as many directions as are searched, the reading nearest to it, if one is nearer than half a step.
fn searched(beams: &[RangeBeam], scale: &RangeScale) -> Vec<(RangeBeam, SearchBeam)> {
    let step_rad = TAU / HEADINGS as f64;
    let off_rad =
        |beam: &RangeBeam, direction: usize| libm::fabs(wrap_angle_rad(beam.bearing_rad - direction as f64 * step_rad));
    let mut nearest: Vec<Option<RangeBeam>> = vec![None; HEADINGS];
    for &beam in beams {
        let direction = libm::round(beam.bearing_rad / step_rad) as i64;
        let direction = direction.rem_euclid(HEADINGS as i64) as usize;
        let nearer = nearest[direction].is_none_or(|known| off_rad(&beam, direction) < off_rad(&known, direction));
        if nearer {
            nearest[direction] = Some(beam);
        }
    }
    let known: Vec<(usize, RangeBeam)> =
        nearest.into_iter().enumerate().filter_map(|(direction, beam)| Some((direction, beam?))).collect();
    let count = known.len().min(MOST_BEAMS);
    let chosen = (0..count).map(|number| known[number * known.len() / count]);
    chosen.map(|(direction, beam)| (beam, SearchBeam::new(direction, beam.range_m, scale))).collect()
}

/// The same so that any few that follow each other are spread over all of them.
fn mixed<T: Copy>(all: &[T]) -> Vec<T> {
    let bits = usize::BITS - all.len().leading_zeros();
    let reversed = (0usize..1 << bits).map(|number| number.reverse_bits() >> (usize::BITS - bits).min(usize::BITS - 1));
    reversed.filter_map(|number| all.get(number).copied()).collect()
}

/// The map and the sensor as scans are judged by them.
#[derive(Debug)]
pub(super) struct Judge {
    pub distances: DistanceField,
    pub beam: BeamParameters,
    /// Cosines and sines of rays in a beam, from its middle.
    pub rays: Vec<(f64, f64)>,
    /// Of the pose in a block, which is known to half of one.
    pub coarse: Likelihood,
    /// Of a refined pose.
    pub fine: Likelihood,
}

/// A direction turned by another one.
#[inline(always)]
fn turned((cos, sin): (f64, f64), (by_cos, by_sin): (f64, f64)) -> (f64, f64) {
    (cos * by_cos - sin * by_sin, sin * by_cos + cos * by_sin)
}

impl Judge {
    /// The rays of a beam.
    pub(super) fn rays(beam: &BeamParameters) -> Vec<(f64, f64)> {
        let beside = if beam.cone_deg == 0 { 0 } else { BESIDE };
        let half_rad = f64::from(beam.cone_deg).to_radians() / 2.0;
        let ray = |ray: i32| libm::sincos(half_rad * f64::from(ray) / f64::from(beside.max(1)));
        (-beside..=beside).map(ray).map(|(sin, cos)| (cos, sin)).collect()
    }

    /// What a beam is expected to measure; the range of the sensor where there is nothing.
    #[inline(always)]
    fn expected_m(&self, from: Point, along: (f64, f64)) -> f64 {
        let most_m = self.beam.max_range_m + self.beam.mount_radius_m;
        let nearest_m = self.rays.iter().fold(most_m, |nearest_m, &ray| {
            f64::min(nearest_m, self.distances.cast_m(from, turned(along, ray), nearest_m))
        });
        if nearest_m < most_m {
            nearest_m - self.beam.mount_radius_m + self.beam.wall_depth_m
        } else {
            self.beam.max_range_m
        }
    }

    /// −ln of the likelihood of a scan at a refined pose, for each beam.
    pub(super) fn fine_nats(&self, scan: &Scan, pose: Pose) -> f64 {
        let (from, (sin, cos)) = (pose.point(), libm::sincos(pose.heading_rad));
        let nats = |beam: &JudgedBeam| beam.cost.nats(self.expected_m(from, turned((cos, sin), beam.along)));
        scan.fine.iter().map(nats).sum::<f64>() / scan.fine.len() as f64
    }

    /// What the search would count for a pose if it were a block of its own.
    pub(super) fn search_cost(&self, scan: &Scan, scale: &RangeScale, pose: Pose) -> u16 {
        let (sin, cos) = libm::sincos(pose.heading_rad);
        let cost = |(beam, searched): (&JudgedBeam, &SearchBeam)| {
            let step = scale.step(self.expected_m(pose.point(), turned((cos, sin), beam.along)));
            u16::from(searched.cost(step, step))
        };
        scan.rays.iter().zip(&scan.searched).map(cost).sum()
    }

    /// The pose near one where the scan fits best: Gauss and Newton's steps, as inside the cells of a belief. The same pose
    /// for cones, which do not say from where in them an echo comes.
    pub(super) fn refined(&self, scan: &Scan, begun: Pose) -> Pose {
        if self.beam.cone_deg > 0 {
            return begun;
        }
        let known = |error: f64| 1.0 / (error * error);
        let prior = Matrix3::from_diagonal(&Vector3::new(known(KNOWN_M), known(KNOWN_M), known(KNOWN_RAD)));
        let tempering = (scan.independent / scan.refined.len() as f64).min(1.0);
        let mut pose = begun;
        for scale_m in SCALES_M {
            let mut evidence = Evidence::of_pose(prior, begun, pose);
            for beam in scan.refined.iter().filter(|beam| beam.range_m < self.beam.max_range_m) {
                let ray = (beam.bearing_rad, beam.range_m);
                evidence.add_ray(&self.distances, &self.beam, tempering, pose, ray, scale_m);
            }
            let Some(factors) = evidence.information.cholesky() else { return begun };
            let step = factors.solve(&evidence.pull);
            pose = Pose::new(pose.x_m + step.x, pose.y_m + step.y, pose.heading_rad + step.z);
        }
        let turned_rad = libm::fabs(wrap_angle_rad(pose.heading_rad - begun.heading_rad));
        let is_near = pose.distance_m(begun) <= FARTHEST_M && turned_rad <= FARTHEST_RAD;
        if is_near && self.distances.clearance_m(pose.point()) > 0.0 { pose } else { begun }
    }
}
