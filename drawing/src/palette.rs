//! The colours of all drawings: one idea, one colour. Hues are after Okabe and Ito ("Color Universal Design", 2008), whom
//! people with any colour vision can follow; what is equally light differs in width, form or dashes, for prints in grey.

/// Walls, frames and what is written.
pub const INK: &str = "#1a1a1a";
/// What is written beside what matters.
pub const QUIET: &str = "#5c5f66";
/// Lines that help the eye.
pub const GRID: &str = "#d9dade";
/// What the map does not know.
pub(crate) const UNKNOWN: &str = "#eceae5";
/// The sheet.
pub const PAPER: &str = "#ffffff";
/// Furniture, and its edge.
pub(crate) const FURNITURE: &str = "#d8d0c0";
/// The edge of furniture.
pub(crate) const FURNITURE_EDGE: &str = "#8a8272";
/// Doors.
pub(crate) const DOOR: &str = "#b07a12";
/// Landmarks.
pub(crate) const LANDMARK: &str = "#8a4b86";
/// People.
pub(crate) const PERSON: &str = "#8a4b86";
/// Where the robot really is.
pub(crate) const TRUTH: &str = "#c44100";
/// Where it believes it is.
pub(crate) const ESTIMATE: &str = "#0072b2";
/// The estimate as a band under other lines.
pub(crate) const ESTIMATE_BAND: &str = "#86c5ea";
/// What it wants.
pub const TARGET: &str = "#00765a";
/// Names of places, and what links them.
pub const PLACE: &str = "#3c4043";

/// What is perceived of a hallway's sides.
pub const CLOSED_DOOR: &str = "#d9a441";
/// An open door.
pub const OPEN_DOOR: &str = "#86c5ea";
/// Another hallway.
pub const HALLWAY: &str = "#7fcfb9";
/// A foyer.
pub const FOYER: &str = "#cc79a7";

/// From hardly likely to certain: one hue, each step darker than the one before.
pub(crate) const SHADES: [&str; 8] =
    ["#e6e3f1", "#d0cce6", "#b4aed6", "#978dc4", "#7b69af", "#603f97", "#46197b", "#2a0653"];

/// Lines of a chart, one after the other.
pub const SERIES: [&str; 6] = ["#0072b2", "#c44100", "#00765a", "#8a4b86", "#b07a12", "#1a1a1a"];

/// How dark a probability is drawn, on a linear scale: the sheet for hardly any.
pub fn shade(probability: f64) -> &'static str {
    let step = (probability * SHADES.len() as f64).round() as usize;
    step.min(SHADES.len()).checked_sub(1).map_or(PAPER, |step| SHADES[step])
}
