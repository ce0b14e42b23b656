//! Numbers as darkness, and what the darkness means.

use super::frame::Frame;
use super::ink::Raster;
use super::palette;
use super::writing::{SMALL_PX, centred, rounded, text};
use rpl_mission::sight::PositionBelief;
use svg::node::element::{Group, Rectangle};

/// Steps of darkness.
pub const STEPS: usize = palette::SHADES.len();

/// A step of the scale is drawn so wide.
const STEP_PX: f64 = 34.0;

/// So far into the page, so that the first number has room around where it stands.
const INDENT_PX: f64 = 16.0;

/// What darkness means.
#[derive(Clone, Debug, PartialEq)]
pub struct ShadeScale {
    /// What is shown, with its unit.
    pub means: String,
    /// Where steps begin and end, from left to right: what is written below the scale, and after how many steps.
    pub ticks: Vec<(f64, String)>,
}

impl ShadeScale {
    /// A scale is so high.
    pub(crate) const HEIGHT_PX: f64 = 44.0;

    /// The scale with its left upper corner there.
    pub fn drawn(&self, left_px: f64, top_px: f64) -> Group {
        let mut group = Group::new().set("class", "shades");
        group = group.add(text(&self.means, left_px, top_px + SMALL_PX * 0.8, SMALL_PX));
        let (left_px, bar_px) = (left_px + INDENT_PX, top_px + SMALL_PX + 4.0);
        for (step, colour) in palette::SHADES.iter().enumerate() {
            let square = Rectangle::new().set("x", rounded(left_px + step as f64 * STEP_PX)).set("y", rounded(bar_px));
            group = group.add(square.set("width", STEP_PX).set("height", 10).set("fill", *colour));
        }
        for (steps, said) in &self.ticks {
            group = group.add(centred(said, left_px + steps * STEP_PX, bar_px + 10.0 + SMALL_PX + 1.0, SMALL_PX));
        }
        group
    }
}

/// The least probability of a square metre that is drawn, in powers of ten, and steps of darkness for each: a hypothesis
/// of 1 % is seen, and two drawings are the same where the beliefs are.
const LEAST_POWER: f64 = -3.0;
const STEPS_PER_POWER: f64 = 2.0;

/// The scale of beliefs.
pub(crate) fn belief_scale() -> ShadeScale {
    let powers = STEPS as f64 / STEPS_PER_POWER;
    let tick = |power: f64| (power * STEPS_PER_POWER, format!("{}", libm::exp10(LEAST_POWER + power)));
    let ticks = (0..=powers as usize).map(|power| tick(power as f64)).collect();
    ShadeScale { means: "belief: probability per m², each colour three times the one before".to_string(), ticks }
}

/// The step of darkness of a probability of a square metre; none for what is less than the scale shows.
fn belief_step(per_m2: f64) -> Option<usize> {
    let step = (libm::log10(per_m2.max(f64::MIN_POSITIVE)) - LEAST_POWER) * STEPS_PER_POWER;
    (step >= 0.0).then(|| (step as usize).min(STEPS - 1))
}

/// A belief as darkness.
pub(crate) fn belief(belief: &PositionBelief, frame: Frame) -> Group {
    let raster = Raster {
        origin_in_map: belief.origin_in_map,
        resolution_m: belief.resolution_m,
        columns: belief.columns,
        rows: belief.cells.len() / belief.columns.max(1),
    };
    let cell_m2 = belief.resolution_m * belief.resolution_m;
    let steps: Vec<Option<usize>> = belief.cells.iter().map(|&cell| belief_step(cell / cell_m2)).collect();
    shaded(&raster, &steps, frame).set("class", "belief")
}

/// Cells in their steps of darkness, `steps[row][column]`, row-major.
pub(crate) fn shaded(raster: &Raster, steps: &[Option<usize>], frame: Frame) -> Group {
    let mut group = Group::new();
    for (step, colour) in palette::SHADES.iter().enumerate() {
        let path = raster.path(frame, |column, row| steps[row * raster.columns + column] == Some(step));
        if let Some(path) = path {
            group = group.add(path.set("fill", *colour));
        }
    }
    group
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_percent_in_one_place_is_seen_beside_a_belief_that_is_everywhere() {
        let everywhere = belief_step(1.0 / 500.0);
        let hypothesis = belief_step(0.01 / 0.25);
        assert!(everywhere.is_some() && hypothesis > everywhere, "{everywhere:?} {hypothesis:?}");
        assert_eq!(belief_step(40.0), Some(STEPS - 1), "certain");
        assert_eq!(belief_step(0.0), None);
        assert_eq!(belief_scale().ticks.last().map(|tick| tick.1.as_str()), Some("10"));
    }
}
