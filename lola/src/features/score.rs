//! How right the percepts of a drive were: percepts against the true features of the sides, counted.

use crate::feature::{Feature, HiddenWall, Percept, Side};
use serde::{Deserialize, Serialize};

/// A feature as it really is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrueFeature {
    /// On which side, for a robot that drives along the axis.
    pub side: Side,
    /// What it is.
    pub is: Feature,
    /// Where it begins and ends along the axis, in metres from where the detection was started.
    pub from_m: f64,
    /// Where it ends.
    pub to_m: f64,
}

impl TrueFeature {
    /// Whether something stood before its middle, and it is none that shows all the same.
    fn is_hidden_by(&self, wall: &HiddenWall) -> bool {
        let middle_m = (self.from_m + self.to_m) / 2.0;
        self.is == Feature::ClosedDoor && wall.side == self.side && (wall.from_m..=wall.to_m).contains(&middle_m)
    }
}

/// What features were taken for: counts of drives. Add up those of many with [`Confusion::add`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Confusion {
    /// `taken[feature][percept]` in the order of [`Feature::ALL`]; the percept `Wall` is a miss.
    pub taken: [[u32; 5]; 5],
    /// Percepts where there is but wall, by what was seen.
    pub false_alarms: [u32; 5],
    /// How many true features were perceived more than once.
    pub doubled: u32,
    /// The way driven, along each of the two sides.
    pub driven_m: f64,
}

/// A percept tells of a feature when they overlap, or are less than this apart.
const SLACK_M: f64 = 0.3;

/// A feature counts that begins at least this far after the detection was started ...
pub const BEFORE_M: f64 = 0.3;
/// ... and ends at least this far before the detection was stopped: the way on which percepts are made up.
pub const BEHIND_M: f64 = 1.0;

impl Confusion {
    /// Compares the percepts of a drive of `driven_m` with the truth. Each percept tells of the feature of its
    /// side that it overlaps most; of several that tell of one, the one that overlaps most counts, the others
    /// are doubled. A feature that was not driven past from [`BEFORE_M`] before it to [`BEHIND_M`] behind it
    /// counts neither way, nor does a closed door before which something stood that is among `hidden`: state sets and
    /// judgements count on none there. Percepts are where the odometry puts them, which over tens of metres is a
    /// door's width off: shift each before by how far the robot was from where it took itself to be along the axis when it
    /// perceived it. Cost: their product.
    pub fn of(percepts: &[Percept], truth: &[TrueFeature], hidden: &[HiddenWall], driven_m: f64) -> Self {
        let mut confusion = Self { driven_m, ..Self::default() };
        let mut told: Vec<Option<(f64, Feature)>> = vec![None; truth.len()];
        for percept in percepts {
            let overlaps = truth.iter().enumerate().filter(|(_, feature)| feature.side == percept.side);
            let overlaps = overlaps.map(|(index, feature)| (index, overlap_m(percept, feature)));
            let best = overlaps.max_by(|(_, a), (_, b)| a.total_cmp(b)).filter(|(_, overlap_m)| *overlap_m > -SLACK_M);
            match best {
                None => confusion.false_alarms[percept.seen as usize] += 1,
                Some((index, overlap_m)) => {
                    confusion.doubled += u32::from(told[index].is_some());
                    if told[index].is_none_or(|(before_m, _)| overlap_m > before_m) {
                        told[index] = Some((overlap_m, percept.seen));
                    }
                }
            }
        }
        let is_passed = |feature: &TrueFeature| feature.from_m >= BEFORE_M && feature.to_m + BEHIND_M <= driven_m;
        let counts =
            |feature: &TrueFeature| is_passed(feature) && !hidden.iter().any(|wall| feature.is_hidden_by(wall));
        for (feature, told) in truth.iter().zip(told).filter(|(feature, _)| counts(feature)) {
            let seen = told.map_or(Feature::Wall, |(_, seen)| seen);
            confusion.taken[feature.is as usize][seen as usize] += 1;
        }
        confusion
    }

    /// Adds another drive.
    pub fn add(&mut self, other: &Self) {
        for (row, others) in self.taken.iter_mut().zip(other.taken) {
            for (count, more) in row.iter_mut().zip(others) {
                *count += more;
            }
        }
        for (count, more) in self.false_alarms.iter_mut().zip(other.false_alarms) {
            *count += more;
        }
        self.doubled += other.doubled;
        self.driven_m += other.driven_m;
    }

    /// How many true features there were.
    pub fn features(&self) -> u32 {
        self.taken.iter().flatten().sum()
    }

    /// How many were taken for what they are.
    pub fn right(&self) -> u32 {
        (0..Feature::ALL.len()).map(|kind| self.taken[kind][kind]).sum()
    }

    /// Percepts of nothing, and of a feature that was told of before, in 100 m of driving.
    pub fn false_in_100_m(&self) -> f64 {
        f64::from(self.false_alarms.iter().sum::<u32>() + self.doubled) * 100.0 / self.driven_m
    }

    /// The matrix C(percept | feature), `certainty[feature][percept]`, each row summing to 1. Each count is
    /// raised by `prior`, so that nothing is impossible that has not happened yet. The row of the wall is per
    /// place at which there might be a feature, one in `place_m` of the two sides.
    pub fn certainties(&self, prior: f64, place_m: f64) -> [[f64; 5]; 5] {
        let mut counts = self.taken.map(|row| row.map(f64::from));
        let wall = Feature::Wall as usize;
        for (kind, alarms) in self.false_alarms.into_iter().enumerate() {
            counts[wall][kind] += f64::from(alarms);
        }
        let places = 2.0 * self.driven_m / place_m;
        counts[wall][wall] += (places - f64::from(self.false_alarms.iter().sum::<u32>())).max(0.0);
        counts.map(|row| {
            let sum: f64 = row.iter().sum::<f64>() + prior * row.len() as f64;
            row.map(|count| (count + prior) / sum)
        })
    }
}

/// How far they overlap along the axis; negative is how far they are apart.
fn overlap_m(percept: &Percept, feature: &TrueFeature) -> f64 {
    percept.to_m.min(feature.to_m) - percept.from_m.max(feature.from_m)
}
