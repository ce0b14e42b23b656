//! The directions around one point, cut where the cones of sonars begin and end.

use crate::geometry::{Vector, wrap_angle_rad};
use std::f64::consts::{FRAC_PI_4, TAU};

/// Edges nearer to each other than this are one.
const SAME_RAD: f64 = 1e-9;

/// No sector is wider: a straight edge that begins and ends in one sector lies in it.
const WIDEST_RAD: f64 = TAU / 3.0;

/// Tangents of the edges of the papers' ring of 24 cones, from an axis to the next diagonal: 7.5°, 22.5°
/// and 37.5°. Computed ones differ from these in the last bit; that decides where an arc ends on an edge,
/// and runs that were recorded would not be repeated.
const EDGES_OF_24: [f64; 3] = [0.131_652_497_587_395_85, 0.414_213_562_373_095_03, 0.767_326_987_978_960_3];

/// Which eighth of the turn lies at which signs, and whether its angles run back from the axis.
const EIGHTHS: [(u8, bool); 8] =
    [(0, false), (1, true), (3, true), (2, false), (7, true), (6, false), (4, false), (5, true)];

/// Sonars, by the sectors that their cones cover. Sector 0 is the one after the last edge, around
/// straight ahead; the others follow counter-clockwise.
#[derive(Clone, Debug, PartialEq)]
pub struct Sectors {
    /// Unit vectors along the edge at which each sector ends, counter-clockwise.
    ends: Vec<Vector>,
    /// By the signs of y and x, and by which of them is larger.
    octants: [Octant; 8],
    /// Of the edges, measured from the axis of their octant, ascending in each; octant after octant.
    tangents: Vec<f64>,
    /// The sectors between these edges: in each octant one more than edges.
    between: Vec<usize>,
    /// The sonars whose cones cover each sector.
    sonars: Vec<Vec<usize>>,
}

/// An eighth of the turn, from an axis to a diagonal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Octant {
    /// The first of its edges among the tangents.
    first: usize,
    /// How many it has.
    edges: usize,
}

impl Sectors {
    /// A ring of cones that tile the full turn, the first of them around straight ahead.
    pub fn ring(cones: usize) -> Self {
        let edges_rad = (0..cones).map(|cone| (cone as f64 + 0.5) * TAU / cones as f64).collect();
        let mut sectors = Self::cut(edges_rad);
        if cones == 24 {
            sectors.tangents = EDGES_OF_24.repeat(sectors.octants.len());
        }
        sectors.sonars = (0..cones).map(|cone| vec![cone]).collect();
        sectors
    }

    /// Cones of one opening, given as numbers and headings of their sonars: with gaps between them, or one
    /// over another.
    pub fn of(cones: &[(usize, f64)], cone_rad: f64) -> Self {
        let half_rad = cone_rad / 2.0;
        let around = |angle_rad: f64| libm::fmod(libm::fmod(angle_rad, TAU) + TAU, TAU);
        let ends_rad = cones.iter().flat_map(|&(_, heading_rad)| [heading_rad - half_rad, heading_rad + half_rad]);
        let mut edges_rad: Vec<f64> = ends_rad.map(around).collect();
        edges_rad.sort_by(f64::total_cmp);
        edges_rad.dedup_by(|one, other| (*one - *other).abs() < SAME_RAD);
        let wide: Vec<f64> = (0..edges_rad.len()).flat_map(|edge| splits_after(&edges_rad, edge)).map(around).collect();
        edges_rad.extend(wide);
        edges_rad.sort_by(f64::total_cmp);
        let middles_rad: Vec<f64> = (0..edges_rad.len()).map(|sector| middle_rad(&edges_rad, sector)).collect();
        let covers = |heading_rad: f64, middle_rad: f64| wrap_angle_rad(middle_rad - heading_rad).abs() < half_rad;
        let over = |middle_rad: f64| cones.iter().filter(move |(_, heading_rad)| covers(*heading_rad, middle_rad));
        let sonars = middles_rad.into_iter().map(|middle| over(middle).map(|&(sonar, _)| sonar).collect()).collect();
        Self { sonars, ..Self::cut(edges_rad) }
    }

    /// Cuts the turn at these directions, ascending in [0, 2π).
    fn cut(edges_rad: Vec<f64>) -> Self {
        let count = edges_rad.len();
        let before = |angle_rad: f64| edges_rad.iter().filter(|&&edge_rad| edge_rad < angle_rad).count();
        let (mut octants, mut tangents, mut between) = ([Octant::default(); 8], Vec::new(), Vec::new());
        for (octant, (eighth, runs_back)) in octants.iter_mut().zip(EIGHTHS) {
            let (from_rad, to_rad) = (f64::from(eighth) * FRAC_PI_4, f64::from(eighth + 1) * FRAC_PI_4);
            let inside = edges_rad.iter().filter(|&&edge_rad| edge_rad >= from_rad && edge_rad < to_rad);
            let mut folded_rad: Vec<f64> =
                inside.map(|edge_rad| if runs_back { to_rad - edge_rad } else { edge_rad - from_rad }).collect();
            folded_rad.sort_by(f64::total_cmp);
            *octant = Octant { first: tangents.len(), edges: folded_rad.len() };
            let sector = |passed: usize| if runs_back { before(to_rad) - passed } else { before(from_rad) + passed };
            between.extend((0..=folded_rad.len()).map(|passed| sector(passed) % count));
            tangents.extend(folded_rad.into_iter().map(libm::tan));
        }
        let unit = |angle_rad: &f64| {
            let (sin, cos) = libm::sincos(*angle_rad);
            Vector::new(cos, sin)
        };
        let ends = edges_rad.iter().map(unit).collect();
        Self { ends, octants, tangents, between, sonars: vec![Vec::new(); count] }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.ends.len()
    }

    /// The sector a direction lies in; found without an arctangent.
    pub fn around(&self, direction: Vector) -> usize {
        let (x, y) = (direction.x.abs(), direction.y.abs());
        let (across, along) = (x.min(y), x.max(y));
        let signs = 4 * usize::from(direction.y < 0.0) + 2 * usize::from(direction.x < 0.0) + usize::from(y > x);
        let Octant { first, edges } = self.octants[signs];
        let mut passed = 0;
        for tangent in &self.tangents[first..first + edges] {
            passed += usize::from(across > tangent * along);
        }
        self.between[first + signs + passed]
    }

    /// Unit vector along the edge at which a sector ends, counter-clockwise.
    pub fn end(&self, sector: usize) -> Vector {
        self.ends[sector]
    }

    /// The sonars whose cones cover a sector.
    pub fn sonars(&self, sector: usize) -> &[usize] {
        &self.sonars[sector]
    }
}

/// How far it is from the edge before a sector to the one after it.
fn width_rad(edges_rad: &[f64], sector: usize) -> f64 {
    match sector.checked_sub(1) {
        Some(before) => edges_rad[sector] - edges_rad[before],
        None => edges_rad[0] + TAU - edges_rad[edges_rad.len() - 1],
    }
}

fn middle_rad(edges_rad: &[f64], sector: usize) -> f64 {
    edges_rad[sector] - width_rad(edges_rad, sector) / 2.0
}

/// Where a sector that is too wide is cut besides.
fn splits_after(edges_rad: &[f64], sector: usize) -> Vec<f64> {
    let width_rad = width_rad(edges_rad, sector);
    let parts = libm::ceil(width_rad / WIDEST_RAD).max(1.0);
    (1..parts as usize).map(|part| edges_rad[sector] - width_rad * part as f64 / parts).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn unit(angle_rad: f64) -> Vector {
        Vector::new(libm::cos(angle_rad), libm::sin(angle_rad))
    }

    #[test]
    fn a_direction_in_a_ring_is_in_the_cone_about_the_nearest_axis() {
        for cones in [3, 5, 8, 16, 24, 31] {
            let sectors = Sectors::ring(cones);
            for degree in 0..720 {
                let bearing_rad = (0.5 * f64::from(degree) + 0.1).to_radians();
                let nearest = libm::round(bearing_rad * cones as f64 / TAU) as usize % cones;
                assert_eq!(sectors.sonars(sectors.around(2.0 * unit(bearing_rad))), [nearest], "{bearing_rad}");
            }
        }
    }

    proptest! {
        #[test]
        fn a_direction_is_in_the_cones_whose_axes_are_near_it(
            headings in proptest::collection::vec(-7.0..7.0f64, 1..20),
            cone_rad in 0.05..3.1f64,
            bearings in proptest::collection::vec(-3.2..3.2f64, 50),
        ) {
            let cones: Vec<(usize, f64)> = headings.iter().copied().enumerate().collect();
            let sectors = Sectors::of(&cones, cone_rad);
            for bearing_rad in bearings {
                let off_rad = |heading_rad: f64| wrap_angle_rad(bearing_rad - heading_rad).abs();
                if cones.iter().any(|&(_, heading_rad)| (off_rad(heading_rad) - cone_rad / 2.0).abs() < 1e-6) {
                    continue;
                }
                let near: Vec<usize> =
                    cones.iter().filter(|cone| off_rad(cone.1) < cone_rad / 2.0).map(|cone| cone.0).collect();
                prop_assert_eq!(sectors.sonars(sectors.around(unit(bearing_rad))), near);
            }
            for sector in 0..sectors.count() {
                let (from, to) = (sectors.end((sector + sectors.count() - 1) % sectors.count()), sectors.end(sector));
                prop_assert!(from.perp(&to) > 0.0, "sector {} is wider than half a turn", sector);
            }
        }
    }
}
