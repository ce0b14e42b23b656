//! The poses that explain a scan, and what each of them is worth.

use super::bound::HEADINGS;
use super::locator::ScanLocator;
use super::scan::{RangeBeam, Scan};
use super::search::{Candidate, Candidates};
use crate::geometry::{Pose, wrap_angle_rad};
use rayon::prelude::*;

/// A pose and all within this of it are one.
const SAME_M: f64 = 0.5;
const SAME_RAD: f64 = 15.0 / 180.0 * std::f64::consts::PI;

/// Poses that are told, at the most.
pub const MOST_POSES: usize = 128;

/// What is less likely than the likeliest candidate by more than this is none, in tempered nats.
const COARSE_MARGIN: f64 = 12.0;

/// A pose that explains a scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LikelyPose {
    /// Where.
    pub pose_in_map: Pose,
    /// Of the robot being within 0.5 m and 15° of it.
    pub probability: f64,
}

/// Where the robot may be, by one scan. All probabilities together are 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Located {
    /// The likeliest first; each is more than 0.5 m or 15° from all others.
    pub poses: Vec<LikelyPose>,
    /// That it is at another place of the map.
    pub elsewhere: f64,
    /// That no place of the map explains the scan.
    pub nowhere: f64,
}

/// Poses that are one, and what they are worth beside each other.
#[derive(Clone, Copy, Debug)]
struct Cluster {
    pose: Pose,
    /// −ln of the tempered likelihood.
    nats: f64,
    volume: f64,
}

fn is_same(a: Pose, b: Pose) -> bool {
    a.distance_m(b) <= SAME_M && libm::fabs(wrap_angle_rad(a.heading_rad - b.heading_rad)) <= SAME_RAD
}

/// Clusters around the best ones; what lies near one of them adds to its volume. Those beyond the most come second.
fn clustered(mut all: Vec<Cluster>) -> (Vec<Cluster>, Vec<Cluster>) {
    all.sort_by(|a, b| a.nats.total_cmp(&b.nats));
    let (mut clusters, mut others): (Vec<Cluster>, Vec<Cluster>) = (Vec::new(), Vec::new());
    for one in all {
        match clusters.iter().position(|cluster| is_same(cluster.pose, one.pose)) {
            Some(near) => clusters[near].volume += one.volume * libm::exp(clusters[near].nats - one.nats),
            None if clusters.len() < MOST_POSES => clusters.push(one),
            None => others.push(one),
        }
    }
    (clusters, others)
}

impl ScanLocator {
    /// All poses that explain a scan. Cost: some ten milliseconds on 2,000 m² on one core; in proportion to the area.
    pub fn locate(&self, beams: &[RangeBeam]) -> Located {
        let scan = Scan::new(beams, &self.scale, &self.judge);
        if scan.is_empty() {
            return Located { poses: Vec::new(), elsewhere: 1.0, nowhere: 0.0 };
        }
        self.answer(&scan, &self.candidates(&scan))
    }

    /// What candidates are worth, and that nothing explains the scan.
    fn answer(&self, scan: &Scan, Candidates { some, others }: &Candidates) -> Located {
        let limit = some.iter().map(|candidate| candidate.nats).fold(f64::INFINITY, f64::min) + COARSE_MARGIN;
        let explaining = some.iter().filter(|candidate| candidate.nats <= limit);
        let (coarse, beyond) =
            clustered(explaining.map(|&Candidate { pose, nats, volume }| Cluster { pose, nats, volume }).collect());
        let refined = |cluster: &Cluster| {
            let pose = self.judge.refined(scan, cluster.pose);
            Cluster { pose, nats: scan.independent * self.judge.fine_nats(scan, pose), ..*cluster }
        };
        let (poses, _) = clustered(coarse.par_iter().map(refined).collect());
        // What is not refined is taken to be better than it seems by as much as the best one was.
        let (Some(best), Some(best_coarse)) = (poses.first(), coarse.first()) else {
            return Located { poses: Vec::new(), elsewhere: 0.0, nowhere: 1.0 };
        };
        let weight = |cluster: &Cluster| cluster.volume * libm::exp(best.nats - cluster.nats);
        let worth = |nats: f64, volume: f64| volume * libm::exp(best_coarse.nats - nats);
        let not_refined = beyond.iter().map(|one| worth(one.nats, one.volume));
        let not_judged = others.iter().map(|one| worth(one.nats, one.volume));
        let elsewhere = not_refined.chain(not_judged).fold(0.0, |sum, worth| sum + worth);
        let nowhere = self.nowhere_weight(scan, best.nats);
        let total = poses.iter().map(weight).sum::<f64>() + elsewhere + nowhere;
        let likely = |cluster: &Cluster| LikelyPose { pose_in_map: cluster.pose, probability: weight(cluster) / total };
        let mut poses: Vec<LikelyPose> = poses.iter().map(likely).collect();
        poses.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        Located { poses, elsewhere: elsewhere / total, nowhere: nowhere / total }
    }

    /// The weight of no place explaining a scan, beside that of a pose with these nats.
    fn nowhere_weight(&self, scan: &Scan, best_nats: f64) -> f64 {
        let states = (self.blocks.places.len() * HEADINGS) as f64;
        NOWHERE * states * libm::exp(best_nats - scan.independent * NOWHERE_NATS)
    }
}

/// How often a robot is asked for a place that its map does not explain.
const NOWHERE: f64 = 0.01;

/// What a beam costs there on the average, as the likelihood counts it.
const NOWHERE_NATS: f64 = 1.25;
