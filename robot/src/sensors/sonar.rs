//! Sonars: where each of them sits and looks.

use super::sectors::Sectors;
use crate::geometry::{Point, Vector, wrap_angle_rad};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::f64::consts::TAU;

/// Where a sonar sits and looks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SonarMount {
    /// The apex of its cone.
    pub at_in_base: Point,
    /// Its axis.
    pub heading_rad: f64,
}

impl SonarMount {
    /// How far ahead of the middle of the robot it sits, along its axis.
    pub fn ahead_m(&self) -> f64 {
        let (sin, cos) = libm::sincos(self.heading_rad);
        self.at_in_base.coords.dot(&Vector::new(cos, sin))
    }
}

/// How the sonars of a robot are mounted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum SonarLayout {
    /// A number of sonars on a ring, evenly spread: the first looks ahead, the others follow counter-clockwise.
    ///
    /// # Deviation
    /// The cones of a real ring start on its rim. Here they start in its middle, as in the look-up of
    /// expected distances that the papers' filter uses; near the rim that closes the gaps between the
    /// cones, as the side lobes of a real sonar do.
    Ring(usize),
    /// Each at a place of its own.
    Mounts(Vec<SonarMount>),
}

impl SonarLayout {
    /// Where each sonar sits and looks.
    pub fn mounts(&self) -> Vec<SonarMount> {
        match self {
            Self::Ring(count) => {
                let step_rad = TAU / *count as f64;
                let mount = |sonar| SonarMount { at_in_base: Point::origin(), heading_rad: sonar as f64 * step_rad };
                (0..*count).map(mount).collect()
            }
            Self::Mounts(mounts) => mounts.clone(),
        }
    }
}

/// The sonars of a robot, ready for looking up which of them hear what.
#[derive(Clone, Debug, PartialEq)]
pub struct SonarArray {
    /// Where each sits and looks.
    pub mounts: Vec<SonarMount>,
    /// Opening of a cone.
    pub cone_rad: f64,
    /// Echoes from farther away are not heard; a reading of this value heard nothing.
    pub range_m: f64,
    /// The cones, by where they start.
    pub apexes: Vec<SonarApex>,
}

/// A point where cones start.
#[derive(Clone, Debug, PartialEq)]
pub struct SonarApex {
    /// The point.
    pub at_in_base: Point,
    /// The cones.
    pub sectors: Sectors,
}

impl SonarArray {
    /// Sonars with cones of one opening. Cost: the square of their number.
    pub fn new(layout: &SonarLayout, cone_rad: f64, range_m: f64) -> Self {
        let mounts = layout.mounts();
        let apexes = match layout {
            SonarLayout::Ring(count) if cone_rad == TAU / *count as f64 => {
                vec![SonarApex { at_in_base: Point::origin(), sectors: Sectors::ring(*count) }]
            }
            SonarLayout::Ring(_) | SonarLayout::Mounts(_) => apexes(&mounts, cone_rad),
        };
        Self { mounts, cone_rad, range_m, apexes }
    }

    /// The sonars in whose cones a point lies, each with where the point is from the apex of its cone.
    pub fn hearing(&self, point_in_base: Point) -> impl Iterator<Item = (usize, Vector)> {
        self.apexes.iter().flat_map(move |apex| {
            let from_apex = point_in_base - apex.at_in_base;
            let sonars = apex.sectors.sonars(apex.sectors.around(from_apex));
            sonars.iter().map(move |&sonar| (sonar, from_apex))
        })
    }

    /// Whether any sonar in whose cone a point lies, and where the point is from its apex, is as asked: for
    /// what is asked often, [`SonarArray::hearing`] without its cost.
    pub fn is_heard(&self, point_in_base: Point, asked: impl Fn(usize, Vector) -> bool) -> bool {
        self.apexes.iter().any(|apex| {
            let from_apex = point_in_base - apex.at_in_base;
            apex.sectors.sonars(apex.sectors.around(from_apex)).iter().any(|&sonar| asked(sonar, from_apex))
        })
    }

    /// Whether a sonar looks in a direction.
    pub fn looks(&self, direction_rad: f64) -> bool {
        let off_rad = |mount: &SonarMount| wrap_angle_rad(direction_rad - mount.heading_rad).abs();
        self.mounts.iter().any(|mount| off_rad(mount) <= self.cone_rad / 2.0)
    }
}

/// The cones gathered by where they start.
fn apexes(mounts: &[SonarMount], cone_rad: f64) -> Vec<SonarApex> {
    let mut starts: Vec<Point> = Vec::new();
    for mount in mounts {
        if !starts.contains(&mount.at_in_base) {
            starts.push(mount.at_in_base);
        }
    }
    let apex = |at_in_base: Point| {
        let here = mounts.iter().enumerate().filter(|(_, mount)| mount.at_in_base == at_in_base);
        let cones: Vec<(usize, f64)> = here.map(|(sonar, mount)| (sonar, mount.heading_rad)).collect();
        SonarApex { at_in_base, sectors: Sectors::of(&cones, cone_rad) }
    };
    starts.into_iter().map(apex).collect()
}

/// What the sonars heard at a moment.
#[derive(Clone, Copy, Debug)]
pub struct SonarScan<'a> {
    /// The sonars.
    pub sonars: &'a SonarArray,
    /// The distance from each mount; one that is not in (0, range) heard nothing.
    pub ranges_m: &'a [f32],
}

impl<'a> SonarScan<'a> {
    /// The readings as from the middle of the robot, in the direction of each sonar; silence is infinite.
    ///
    /// # Deviation
    /// A sonar that does not sit on the line of its axis through the middle hears a little beside that line.
    /// What it hears is taken to be on it: at most by how far the mount is off the line.
    pub fn ranges_from_middle_m(&self) -> Cow<'a, [f32]> {
        let SonarScan { sonars, ranges_m } = *self;
        if sonars.mounts.iter().all(|mount| mount.at_in_base == Point::origin()) {
            return Cow::Borrowed(ranges_m);
        }
        let from_middle_m = |(mount, &range_m): (&SonarMount, &f32)| {
            let heard = f64::from(range_m) < sonars.range_m;
            if heard { range_m + mount.ahead_m() as f32 } else { f32::INFINITY }
        };
        sonars.mounts.iter().zip(ranges_m).map(from_middle_m).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_heard_by_the_sonar_before_it_and_measured_from_its_mount() {
        let mount = |x, y, degrees: f64| SonarMount { at_in_base: Point::new(x, y), heading_rad: degrees.to_radians() };
        let layout = SonarLayout::Mounts(vec![mount(0.2, 0.0, 0.0), mount(0.1, 0.1, 90.0), mount(0.1, -0.1, -90.0)]);
        let sonars = SonarArray::new(&layout, 30_f64.to_radians(), 3.0);
        let heard = |x, y| sonars.hearing(Point::new(x, y)).collect::<Vec<_>>();
        assert_eq!(heard(1.2, 0.1), [(0, Vector::new(1.0, 0.1))]);
        assert_eq!(heard(0.1, 1.1), [(1, Vector::new(0.0, 1.0))]);
        assert_eq!(heard(-1.0, 0.0), [], "nobody looks back");
        assert!(sonars.looks(-1.5) && !sonars.looks(std::f64::consts::PI));
    }
}
