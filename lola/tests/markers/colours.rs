//! The histograms in `robot/src/vision/marker_colours/measured.rs` are those of the calibration.
//! `WRITE_MARKERS=1 cargo test -p rpl-lola --test markers` writes them anew.

use rpl_lola::markers::calibration::calibrate;
use rpl_robot::description::RobotDescription;
use rpl_robot::world::MarkerColour;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// How many places, each with its own light.
const PLACES: u64 = 400;

/// Of a marker's pixels, bins with less than this are noise.
const LEAST: u32 = 20;

/// The parts in which shares are written.
const PARTS: f64 = 10_000.0;

fn measured() -> String {
    let robot = RobotDescription::builtin("b21-camera").expect("built in");
    let mut text = format!(
        "//! Measured in {PLACES} places; `WRITE_MARKERS=1 cargo test -p rpl-lola --test markers` writes this.\n\n\
         /// For each colour its bins, with their shares in parts of {PARTS}.\n\
         pub(super) const MEASURED: [&[(usize, u32)]; {}] = [\n",
        MarkerColour::ALL.len()
    );
    for colour in MarkerColour::ALL {
        let histogram = calibrate(&robot, colour, 0, PLACES).scaled_to(PARTS);
        let shares = histogram.counts.iter().map(|count| libm::round(*count) as u32).enumerate();
        let bins: Vec<String> =
            shares.filter(|(_, share)| *share >= LEAST).map(|(bin, share)| format!("({bin}, {share})")).collect();
        writeln!(text, "    // {}\n    &[{}],", colour.name(), bins.join(", ")).expect("a string takes it");
    }
    text + "];\n"
}

#[test]
#[expect(clippy::disallowed_methods, reason = "the file of the repository is what is tested")]
fn the_colours_of_markers_are_those_that_the_calibration_measures() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robot/src/vision/marker_colours/measured.rs");
    let measured = measured();
    if std::env::var_os("WRITE_MARKERS").is_some() {
        fs::write(&path, &measured).expect("it can be written");
    }
    let shipped = fs::read_to_string(&path).expect("it is there");
    assert!(shipped == measured, "not what is measured:\n{measured}\n`WRITE_MARKERS=1` writes it");
}
