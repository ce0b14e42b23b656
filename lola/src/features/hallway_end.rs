//! The end of the hallway: a wall across it, as wide as the hallway.

use rpl_robot::geometry::wrap_angle_rad;
use rpl_robot::sensors::{SonarArray, SonarMount, SonarScan};
use serde::{Deserialize, Serialize};

/// Transducers that look ahead count up to here: beyond, they hear the side walls.
const WIDEST_RAD: f64 = 0.8;
/// No end is believed from farther off.
const FARTHEST_M: f64 = 2.5;
/// Echoes of one wall are within this distance of each other.
const WALL_M: f64 = 0.1;
/// An end must be heard from along this length of the way: a person walks meanwhile.
const HEARD_M: f64 = 0.25;
/// And over at least this width of it, or this share of the hallway's: boxes are narrower.
const LEAST_WIDTH_M: f64 = 1.0;
const LEAST_SHARE: f64 = 0.52;
/// An array whose cones are too wide to tell that much of a wall at this distance is believed with what it can tell
/// there, if no box is as wide.
const TOLD_M: f64 = 1.4;
const BOX_M: f64 = 0.45;
/// Walls reflect a pulse back up to this angle off the perpendicular.
const REFLECTED_RAD: f64 = 0.44;
/// The fewest echoes.
const LEAST_HITS: usize = 8;
/// An echo from at most this far before a side wall, or from behind it, may be the side wall's own.
const SIDE_WALL_M: f64 = 0.08;
/// How many of the echoes must be of cones that look along the axis.
const LEAST_AHEAD: usize = 4;
/// The length of the way for which echoes are kept.
const KEPT_M: f64 = 1.5;

/// A robot that stands before a wall hears it with all transducers whose cones reach within this angle of its
/// perpendicular: beyond, the wall reflects their pulses away.
const STANDING_RAD: f64 = 0.419;
/// The share of their echoes that are of one wall: each may miss once in a while.
const STANDING_SHARE: f64 = 0.8;
/// Three transducers are the fewest that tell a wall from a post.
const LEAST_STANDING: usize = 3;

/// How far a wall across the hallway is ahead, if what is right before the robot is one and not a box or somebody: a
/// cone passes by beside them, or hears them nearer than the wall. For a robot that stands; the heading is given from
/// the axis.
pub(crate) fn wall_ahead_m(heading_rad: f64, scan: SonarScan<'_>) -> Option<f64> {
    let (sin, cos) = libm::sincos(heading_rad);
    let half_cone_rad = scan.sonars.cone_rad / 2.0;
    let ahead = scan.sonars.mounts.iter().zip(scan.ranges_m).filter_map(|(mount, &range_m)| {
        let off_rad = wrap_angle_rad(heading_rad + mount.heading_rad).abs();
        let apex_m = cos * mount.at_in_base.x - sin * mount.at_in_base.y;
        let nearest_rad = (off_rad - half_cone_rad).max(0.0);
        (nearest_rad <= STANDING_RAD && range_m > 0.0).then(|| apex_m + f64::from(range_m) * libm::cos(nearest_rad))
    });
    let mut ahead_m: Vec<f64> = ahead.collect();
    ahead_m.sort_by(f64::total_cmp);
    let median_m = *ahead_m.get(ahead_m.len() / 2).filter(|_| ahead_m.len() >= LEAST_STANDING)?;
    let on_wall = ahead_m.iter().filter(|along_m| (*along_m - median_m).abs() <= WALL_M).count();
    (on_wall as f64 >= STANDING_SHARE * ahead_m.len() as f64).then_some(median_m)
}

/// How far apart across the hallway echoes of one wall must come from, for it to be the end of a hallway of this width.
fn needed_m(sonars: &SonarArray, hallway_width_m: Option<f64>) -> f64 {
    let nearest_rad = |mount: &SonarMount| (wrap_angle_rad(mount.heading_rad).abs() - sonars.cone_rad / 2.0).max(0.0);
    let reflected_rad = sonars.mounts.iter().map(nearest_rad).filter(|nearest_rad| *nearest_rad <= REFLECTED_RAD);
    let told_m = 2.0 * TOLD_M * libm::tan(reflected_rad.fold(0.0, f64::max));
    if (BOX_M..LEAST_WIDTH_M).contains(&told_m) {
        return told_m;
    }
    hallway_width_m.map_or(LEAST_WIDTH_M, |width_m| (LEAST_SHARE * width_m).max(LEAST_WIDTH_M))
}

/// An echo from ahead.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Hit {
    /// Where the robot was.
    from_along_m: f64,
    /// Whether the cone looked along the axis.
    is_ahead: bool,
    /// Where a wall across the hallway would be, and where on it the echo came from.
    along_m: f64,
    left_m: f64,
}

/// The monitor of the hallway's end.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct EndMonitor {
    hits: Vec<Hit>,
    end_m: Option<f64>,
}

impl EndMonitor {
    /// Takes in what is heard ahead.
    pub fn take_in(
        &mut self,
        along_m: f64,
        left_m: f64,
        heading_rad: f64,
        scan: SonarScan<'_>,
        walls_left_m: [Option<f64>; 2],
    ) {
        self.hits.retain(|hit| along_m - hit.from_along_m <= KEPT_M);
        let (sin, cos) = libm::sincos(heading_rad);
        let half_cone_rad = scan.sonars.cone_rad / 2.0;
        for (mount, &range_m) in scan.sonars.mounts.iter().zip(scan.ranges_m) {
            let off_rad = wrap_angle_rad(heading_rad + mount.heading_rad);
            let range_m = f64::from(range_m);
            if off_rad.abs() > WIDEST_RAD || range_m <= 0.0 || range_m >= scan.sonars.range_m.min(FARTHEST_M) {
                continue;
            }
            let nearest_rad = libm::copysign((off_rad.abs() - half_cone_rad).max(0.0), off_rad);
            let at = mount.at_in_base;
            let apex_left_m = left_m + sin * at.x + cos * at.y;
            let is_side_wall = walls_left_m.iter().flatten().any(|wall_left_m| {
                let edge_rad = libm::copysign(off_rad.abs() + half_cone_rad, off_rad);
                let wall_m = (wall_left_m - apex_left_m) / libm::sin(edge_rad);
                wall_m > 0.0 && range_m > wall_m - SIDE_WALL_M
            });
            if !is_side_wall {
                self.hits.push(Hit {
                    from_along_m: along_m,
                    is_ahead: off_rad.abs() <= half_cone_rad,
                    along_m: along_m + cos * at.x - sin * at.y + range_m * libm::cos(nearest_rad),
                    left_m: apex_left_m + range_m * libm::sin(nearest_rad),
                });
            }
        }
        let width_m = walls_left_m[0].zip(walls_left_m[1]).map(|(left_m, right_m)| left_m - right_m);
        let found_m = self.wall_across_m(needed_m(scan.sonars, width_m));
        match (self.end_m, found_m) {
            // It was something else, which has gone.
            (Some(end_m), _) if along_m > end_m => self.end_m = None,
            (Some(_) | None, Some(_)) => self.end_m = found_m,
            (Some(_) | None, None) => {}
        }
    }

    /// The wall on which most echoes of ahead agree, if they come from at least this width across the hallway.
    fn wall_across_m(&self, needed_m: f64) -> Option<f64> {
        let mut alongs_m: Vec<f64> = self.hits.iter().map(|hit| hit.along_m).collect();
        alongs_m.sort_by(f64::total_cmp);
        let agreeing = |from: usize| alongs_m[from..].partition_point(|along_m| along_m - alongs_m[from] <= WALL_M);
        let (most, from) = (0..alongs_m.len()).map(|from| (agreeing(from), from)).max_by_key(|&(most, _)| most)?;
        if most < LEAST_HITS {
            return None;
        }
        let (least_m, farthest_m) = (alongs_m[from], alongs_m[from + most - 1]);
        let on_wall = || self.hits.iter().filter(|hit| (least_m..=farthest_m).contains(&hit.along_m));
        let extent = |of: fn(&Hit) -> f64| {
            let least = on_wall().map(of).fold(f64::INFINITY, f64::min);
            on_wall().map(of).fold(f64::NEG_INFINITY, f64::max) - least
        };
        let is_ahead = on_wall().filter(|hit| hit.is_ahead).count() >= LEAST_AHEAD;
        let is_across = is_ahead && extent(|hit| hit.left_m) >= needed_m && extent(|hit| hit.from_along_m) >= HEARD_M;
        is_across.then(|| alongs_m[from + most / 2])
    }

    /// Where the hallway ends, by what was heard on the way.
    pub fn end_m(&self) -> Option<f64> {
        self.end_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_robot::sensors::SonarLayout;

    /// What a ring hears of things ahead, each a flat piece across the hallway: how far, and from where to where aside.
    fn ahead_m(count: usize, cone_rad: f64, heading_rad: f64, pieces: &[(f64, f64, f64)]) -> Option<f64> {
        let sonars = SonarArray::new(&SonarLayout::Ring(count), cone_rad, 5.0);
        let range_m = |mount_rad: f64| {
            let off_rad = wrap_angle_rad(heading_rad + mount_rad);
            let nearest_rad = libm::copysign((off_rad.abs() - cone_rad / 2.0).max(0.0), off_rad);
            let hit = pieces.iter().filter(|(far_m, from_m, to_m)| {
                off_rad.abs() < 1.0 && (*from_m..=*to_m).contains(&(far_m * libm::tan(nearest_rad)))
            });
            hit.map(|(far_m, ..)| far_m / libm::cos(nearest_rad)).fold(5.0, f64::min) as f32
        };
        let ranges_m: Vec<f32> = sonars.mounts.iter().map(|mount| range_m(mount.heading_rad)).collect();
        wall_ahead_m(heading_rad, SonarScan { sonars: &sonars, ranges_m: &ranges_m })
    }

    #[test]
    fn a_wall_across_the_hallway_is_ahead_and_somebody_before_it_is_not() {
        let of_b21 = |pieces: &[(f64, f64, f64)]| ahead_m(24, 15_f64.to_radians(), 0.0, pieces);
        assert!(of_b21(&[(0.8, -1.1, 1.1)]).is_some_and(|far_m| (far_m - 0.8).abs() < 0.01));
        assert_eq!(of_b21(&[(0.8, -0.25, 0.25)]), None, "somebody");
        assert_eq!(of_b21(&[(0.8, -0.25, 0.25), (1.4, -1.1, 1.1)]), None, "somebody before a wall");
        assert_eq!(of_b21(&[]), None);
    }

    #[test]
    fn few_sonars_hear_the_wall_ahead_however_the_robot_stands() {
        for heading_rad in [0.0, 0.1, -0.19, 0.19] {
            let far_m = ahead_m(16, 25_f64.to_radians(), heading_rad, &[(0.8, -1.1, 1.1)]);
            assert!(far_m.is_some_and(|far_m| (far_m - 0.8).abs() < 0.01), "{heading_rad}: {far_m:?}");
        }
    }
}
