//! Reading a robot file.

use super::{
    BatteryDescription, Camera, Driving, GripperDescription, LEAST_RADIUS_M, Laser, Motors, OdometryDrift,
    RobotDescription, Sonar,
};
use crate::file_text::{FileFaults, Findings, Reader, TomlTable, TomlValue, example_help};
use crate::geometry::Point;
use crate::sensors::{CameraView, LaserScanner, SonarLayout, SonarMount};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::ops::RangeInclusive;
use toml::de::DeTable;

/// The keys at the top of a robot file.
const ROBOT_KEYS: [&str; 12] = [
    "name", "step", "radius", "bumper", "motors", "driving", "sonar", "laser", "camera", "gripper", "battery",
    "odometry",
];

/// More sonars are more than a filter weighs.
pub(super) const MOST_SONARS: usize = 128;

/// A ring of fewer sonars would have cones of more than half a turn.
const FEWEST_IN_RING: usize = 3;

/// The most readings a laser may have.
const MOST_READINGS: usize = 2_000;

/// The least width and height of an image, in pixels ...
const FEWEST_PIXELS: usize = 8;

/// ... and the greatest: a line that a host says holds one.
const MOST_PIXELS: usize = 320;

/// The share of the motors' braking and turning that is counted on, unless the file says otherwise.
const COUNTED_ON: f64 = 0.9;

/// What a number may be, and how it is written.
#[derive(Clone, Copy)]
struct Bounds<'b> {
    least: f64,
    most: f64,
    unit: &'b str,
    example: &'b str,
}

const fn metres(least: f64, most: f64, example: &str) -> Bounds<'_> {
    Bounds { least, most, unit: "m", example }
}

const fn seconds(least: f64, most: f64, example: &str) -> Bounds<'_> {
    Bounds { least, most, unit: "s", example }
}

const PROBABILITY: Bounds<'_> = Bounds { least: 0.0, most: 1.0, unit: "", example: "0.01" };
const SPEED: Bounds<'_> = Bounds { least: 0.01, most: 5.0, unit: "m/s", example: "0.5" };
const ACCELERATION: Bounds<'_> = Bounds { least: 0.01, most: 20.0, unit: "m/s²", example: "0.5" };
const NOISE: Bounds<'_> = metres(0.0, 1.0, "0.02");
const SHARE: Bounds<'_> = Bounds { least: 0.0, most: 0.5, unit: "", example: "0.01" };

/// What an angle may be, in degrees.
#[derive(Clone, Copy)]
struct Angles {
    least_deg: f64,
    most_deg: f64,
    example: &'static str,
}

const TURNING: Angles = Angles { least_deg: 1.0, most_deg: 1_000.0, example: "\"60deg\"" };
const DRIFT: Angles = Angles { least_deg: 0.0, most_deg: 30.0, example: "\"0.5deg\"" };

impl RobotDescription {
    /// Reads the text of a robot file; `file_name` is for the messages only.
    ///
    /// # Errors
    /// All faults of the file at once: text that is not TOML, unknown or missing keys, values of the wrong
    /// kind or size, speeds that the motors do not reach, a robot that sees nothing.
    pub fn parse(text: &str, file_name: &str) -> Result<Self, FileFaults> {
        let mut reader = Reader {
            kind: "robot",
            keys_above: &["step", "radius", "bumper"],
            file: file_name,
            text,
            findings: Findings::default(),
        };
        let (document, errors) = DeTable::parse_recoverable(text);
        reader.syntax_errors(&errors);
        let top = TomlTable { values: document.get_ref(), span: 0..0, header: String::new() };
        let robot = if errors.is_empty() { read_robot(&mut reader, &top) } else { None };
        reader.findings.or_value(robot)
    }
}

fn read_robot<'i>(reader: &mut Reader<'i>, top: &TomlTable<'_, 'i>) -> Option<RobotDescription> {
    reader.only_keys(top, &ROBOT_KEYS);
    let name = reader.text(top, "name", "\"my-robot\"");
    let step_s = number(reader, top, "step", seconds(0.01, 0.5, "0.05"));
    let radius_m = number(reader, top, "radius", metres(LEAST_RADIUS_M, 2.0, "0.25"));
    let bumper = reader.flag(top, "bumper", false);
    let motors = reader.required_table(top, "motors").and_then(|table| read_motors(reader, &table));
    let driving = reader.required_table(top, "driving").and_then(|table| read_driving(reader, &table, motors.as_ref()));
    let sonar = optional(reader, top, "sonar", |reader, table| read_sonar(reader, table, radius_m));
    let laser = optional(reader, top, "laser", read_laser);
    let camera = optional(reader, top, "camera", read_camera);
    let gripper = optional(reader, top, "gripper", read_gripper);
    let battery = optional(reader, top, "battery", read_battery);
    let odometry = reader.required_table(top, "odometry").and_then(|table| read_odometry(reader, &table));
    if !top.values.contains_key("sonar") && !top.values.contains_key("laser") {
        let message = "the robot sees nothing: it has neither a sonar nor a laser";
        let help = "a robot that cannot measure distances drives into whatever is there and never knows where it is; add [sonar] or [laser]";
        reader.note(0..0, "sonar", message, help);
    }
    Some(RobotDescription {
        name: name?,
        purpose: purpose(reader.text),
        step_us: libm::round(step_s? * 1e6) as u64,
        radius_m: radius_m?,
        motors: motors?,
        driving: driving?,
        sonar: sonar?,
        laser: laser?,
        camera: camera?,
        bumper,
        gripper: gripper?,
        battery: battery?,
        odometry: odometry?,
    })
}

/// The first sentence of the comment that a file begins with.
pub(super) fn purpose(text: &str) -> String {
    let comment: Vec<&str> = text.lines().map_while(|line| line.strip_prefix('#')).map(str::trim).collect();
    let comment = comment.join(" ");
    comment.split_once(". ").map_or(comment.clone(), |(first, _)| format!("{first}."))
}

/// What a table says that may be left out: outside, whether it could be read.
fn optional<'t, 'i, T>(
    reader: &mut Reader<'i>,
    top: &TomlTable<'t, 'i>,
    key: &str,
    read: impl FnOnce(&mut Reader<'i>, &TomlTable<'t, 'i>) -> Option<T>,
) -> Option<Option<T>> {
    if !top.values.contains_key(key) {
        return Some(None);
    }
    let table = reader.required_table(top, key)?;
    read(reader, &table).map(Some)
}

/// How many times as fast closing brakes stop a robot as it brakes when it drives, if nothing else is said.
const HALTING_BY_BRAKING: f64 = 2.5;

fn read_motors<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Option<Motors> {
    reader.only_keys(table, &["speed", "turning", "acceleration", "braking", "halting", "turning_acceleration"]);
    let max_translation_mps = number(reader, table, "speed", SPEED);
    let max_rotation_radps = angle(reader, table, "turning", TURNING);
    let translation_acceleration_mps2 = number(reader, table, "acceleration", ACCELERATION);
    let translation_deceleration_mps2 = number(reader, table, "braking", ACCELERATION);
    let rotation_acceleration_radps2 = angle(reader, table, "turning_acceleration", TURNING);
    let halt_deceleration_mps2 = match table.values.contains_key("halting") {
        true => number(reader, table, "halting", ACCELERATION),
        false => translation_deceleration_mps2.map(|braking_mps2| HALTING_BY_BRAKING * braking_mps2),
    };
    Some(Motors {
        max_translation_mps: max_translation_mps?,
        max_rotation_radps: max_rotation_radps?,
        translation_acceleration_mps2: translation_acceleration_mps2?,
        translation_deceleration_mps2: translation_deceleration_mps2?,
        rotation_acceleration_radps2: rotation_acceleration_radps2?,
        halt_deceleration_mps2: halt_deceleration_mps2?,
        halt_deceleration_radps2: HALTING_BY_BRAKING * rotation_acceleration_radps2?,
    })
}

/// What is counted on is no more than the motors can do.
fn read_driving<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>, motors: Option<&Motors>) -> Option<Driving> {
    reader.only_keys(table, &["turning", "braking", "turning_acceleration", "hallway", "office", "doorway"]);
    let can = |of: fn(&Motors) -> f64| motors.map_or(f64::INFINITY, of);
    let (speed_mps, turning_radps) = (can(|can| can.max_translation_mps), can(|can| can.max_rotation_radps));
    let braking_mps2 = can(|can| can.translation_deceleration_mps2);
    let turning_radps2 = can(|can| can.rotation_acceleration_radps2);
    let slower = |unit| Bounds { most: speed_mps.min(SPEED.most), unit, ..SPEED };
    let hallway_mps = number(reader, table, "hallway", slower("m/s"));
    let office_mps = number(reader, table, "office", slower("m/s"));
    let doorway_mps = number(reader, table, "doorway", slower("m/s"));
    let braking = Bounds { most: braking_mps2.min(ACCELERATION.most), ..ACCELERATION };
    let translation_deceleration_mps2 = match table.values.contains_key("braking") {
        true => number(reader, table, "braking", braking),
        false => Some(COUNTED_ON * braking_mps2),
    };
    let mut turn = |key, most_rad: f64| match table.values.contains_key(key) {
        true => angle(reader, table, key, Angles { most_deg: most_rad.to_degrees().min(TURNING.most_deg), ..TURNING }),
        false => Some(COUNTED_ON * most_rad),
    };
    let max_rotation_radps = turn("turning", turning_radps);
    let rotation_acceleration_radps2 = turn("turning_acceleration", turning_radps2);
    Some(Driving {
        max_rotation_radps: max_rotation_radps?,
        translation_deceleration_mps2: translation_deceleration_mps2?,
        rotation_acceleration_radps2: rotation_acceleration_radps2?,
        hallway_mps: hallway_mps?,
        office_mps: office_mps?,
        doorway_mps: doorway_mps?,
    })
}

fn read_sonar<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>, radius_m: Option<f64>) -> Option<Sonar> {
    let keys = [
        "ring",
        "mounts",
        "cone",
        "range",
        "noise",
        "noise_per_metre",
        "specular_angle",
        "specular_misses",
        "edge_misses",
        "specular_silence",
        "specular_coherence",
        "specular_coherence_angle",
        "crosstalk",
        "dropouts",
    ];
    reader.only_keys(table, &keys);
    let layout = read_layout(reader, table, radius_m);
    let cone = Angles { least_deg: 1.0, most_deg: 180.0, example: "\"15deg\"" };
    let cone_rad = match (&layout, table.values.contains_key("cone")) {
        (Some(SonarLayout::Ring(count)), false) => Some(TAU / *count as f64),
        // Whether a layout with faults needs one cannot be told.
        (None, false) => None,
        (Some(SonarLayout::Mounts(_)), false) | (Some(_) | None, true) => angle(reader, table, "cone", cone),
    };
    let range_m = number(reader, table, "range", metres(0.2, 50.0, "5.0"));
    let noise_m = number(reader, table, "noise", NOISE);
    let noise_per_m = number(reader, table, "noise_per_metre", SHARE);
    let incidence = Angles { least_deg: 0.0, most_deg: 90.0, example: "\"27deg\"" };
    let specular_angle_rad = angle(reader, table, "specular_angle", incidence);
    let specular_miss_probability = number(reader, table, "specular_misses", PROBABILITY);
    let edge_miss_probability = number(reader, table, "edge_misses", PROBABILITY);
    let specular_silence_probability = number(reader, table, "specular_silence", PROBABILITY);
    let specular_coherence_m = number(reader, table, "specular_coherence", metres(0.001, 10.0, "0.1"));
    let patch = Angles { least_deg: 0.1, most_deg: 180.0, example: "\"5deg\"" };
    let specular_coherence_rad = angle(reader, table, "specular_coherence_angle", patch);
    let crosstalk_probability = number(reader, table, "crosstalk", PROBABILITY);
    let dropout_probability = number(reader, table, "dropouts", PROBABILITY);
    Some(Sonar {
        layout: layout?,
        cone_rad: cone_rad?,
        range_m: as_reading(range_m?),
        noise_m: noise_m?,
        noise_per_m: noise_per_m?,
        specular_angle_rad: specular_angle_rad?,
        specular_miss_probability: specular_miss_probability?,
        edge_miss_probability: edge_miss_probability?,
        specular_silence_probability: specular_silence_probability?,
        specular_coherence_m: specular_coherence_m?,
        specular_coherence_rad: specular_coherence_rad?,
        crosstalk_probability: crosstalk_probability?,
        dropout_probability: dropout_probability?,
    })
}

/// A ring, or a list of mounts.
fn read_layout<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>, radius_m: Option<f64>) -> Option<SonarLayout> {
    let help = "write `ring = 24` for sonars all around, or `mounts = [[x, y, \"heading\"], ...]`";
    match (table.values.get("ring"), table.values.get("mounts")) {
        (Some(ring), None) => {
            whole_number(reader, ring, "ring", FEWEST_IN_RING..=MOST_SONARS, "24").map(SonarLayout::Ring)
        }
        (None, Some(mounts)) => read_mounts(reader, mounts, radius_m).map(SonarLayout::Mounts),
        (found, _) => {
            let both = if found.is_some() { "both" } else { "neither" };
            let message = format!("[sonar] has either `ring` or `mounts`, found {both}");
            reader.note(table.span_of("ring"), "ring", message, help);
            None
        }
    }
}

/// Sonars sit on the body, and look outwards or along it.
fn read_mounts<'i>(reader: &mut Reader<'i>, mounts: &TomlValue<'i>, radius_m: Option<f64>) -> Option<Vec<SonarMount>> {
    const EXAMPLE: &str = "[[0.15, 0.08, \"30deg\"], [0.15, -0.08, \"-30deg\"]]";
    let Some(elements) = mounts.get_ref().as_array() else {
        reader.expected(mounts, "mounts", "an array of mounts", EXAMPLE);
        return None;
    };
    if !(1..=MOST_SONARS).contains(&elements.len()) {
        let message = format!("`mounts` must have from 1 to {MOST_SONARS} sonars, found {}", elements.len());
        reader.note(mounts.span(), "mounts", message, example_help("mounts", EXAMPLE));
        return None;
    }
    let read: Vec<Option<SonarMount>> = elements
        .iter()
        .map(|element| {
            let values = reader.elements(element, "mounts", 3, EXAMPLE)?;
            let x_m = reader.number_value(&values[0], "mounts", EXAMPLE);
            let y_m = reader.number_value(&values[1], "mounts", EXAMPLE);
            let heading_rad = reader.angle_value(&values[2], "mounts");
            let at_in_base = Point::new(x_m?, y_m?);
            let off_m = at_in_base.coords.norm();
            if let Some(radius_m) = radius_m.filter(|radius_m| off_m > *radius_m) {
                let message = format!("a sonar sits {off_m:.3} m off the middle, and the body reaches {radius_m} m");
                reader.note(
                    element.span(),
                    "mounts",
                    message,
                    "mounts are in metres from the robot's middle, x ahead and y to the left",
                );
                return None;
            }
            Some(SonarMount { at_in_base, heading_rad: heading_rad? })
        })
        .collect();
    read.into_iter().collect()
}

fn read_laser<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Option<Laser> {
    reader.only_keys(table, &["field_of_view", "resolution", "range", "noise", "dropouts"]);
    let field = Angles { least_deg: 10.0, most_deg: 360.0, example: "\"180deg\"" };
    let field_rad = angle(reader, table, "field_of_view", field);
    let steps = Angles { least_deg: 0.1, most_deg: 10.0, example: "\"1deg\"" };
    let resolution_rad = angle(reader, table, "resolution", steps);
    let range_m = number(reader, table, "range", metres(0.2, 100.0, "8.0"));
    let noise_m = number(reader, table, "noise", NOISE);
    let dropout_probability = number(reader, table, "dropouts", PROBABILITY);
    let (field_deg, resolution_deg) = (whole_deg(field_rad?), whole_deg(resolution_rad?));
    // A full turn ends where it began.
    let ends = usize::from(field_deg < 360.0);
    let readings = libm::floor(field_deg / resolution_deg + 1e-9) as usize + ends;
    if readings > MOST_READINGS {
        let message = format!("the laser has {readings} readings, and a scan has at most {MOST_READINGS}");
        reader.note(table.span_of("resolution"), "resolution", message, "take a coarser resolution");
        return None;
    }
    let scanner = LaserScanner { readings, resolution_deg, range_m: as_reading(range_m?) };
    Some(Laser { scanner, noise_m: noise_m?, dropout_probability: dropout_probability? })
}

/// A range as a reading tells it: a reading that is equal to the range has no echo.
fn as_reading(range_m: f64) -> f64 {
    f64::from(range_m as f32)
}

/// An angle as it was written: to a millionth of a degree.
fn whole_deg(angle_rad: f64) -> f64 {
    libm::round(angle_rad.to_degrees() * 1e6) / 1e6
}

fn read_camera<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Option<Camera> {
    let keys = [
        "columns",
        "rows",
        "field_of_view",
        "height",
        "tilt",
        "period",
        "pan_range",
        "pan_speed",
        "pan_acceleration",
        "noise",
    ];
    reader.only_keys(table, &keys);
    let columns = pixels(reader, table, "columns", "80");
    let rows = pixels(reader, table, "rows", "60");
    let field = Angles { least_deg: 10.0, most_deg: 120.0, example: "\"60deg\"" };
    let field_of_view_rad = angle(reader, table, "field_of_view", field);
    let height_m = number(reader, table, "height", metres(0.05, 3.0, "1.1"));
    let down = Angles { least_deg: 0.0, most_deg: 80.0, example: "\"28deg\"" };
    let tilt_rad = angle(reader, table, "tilt", down);
    let period_s = number(reader, table, "period", seconds(0.01, 10.0, "0.2"));
    let aside = Angles { least_deg: 0.0, most_deg: 180.0, example: "\"159deg\"" };
    let pan_range_rad = angle(reader, table, "pan_range", aside);
    let max_pan_radps = angle(reader, table, "pan_speed", TURNING);
    let quick = Angles { most_deg: 10_000.0, ..TURNING };
    let pan_acceleration_radps2 = angle(reader, table, "pan_acceleration", quick);
    let noise = number(reader, table, "noise", SHARE);
    let view = CameraView {
        columns: columns?,
        rows: rows?,
        field_of_view_rad: field_of_view_rad?,
        height_m: height_m?,
        tilt_rad: tilt_rad?,
    };
    if view.tilt_rad + view.half_height_rad() >= FRAC_PI_2 {
        let message = "the lower edge of the image looks behind the camera";
        reader.note(table.span_of("tilt"), "tilt", message, "take a smaller `tilt`, or fewer `rows`");
        return None;
    }
    Some(Camera {
        view,
        period_us: libm::round(period_s? * 1e6) as u64,
        pan_range_rad: pan_range_rad?,
        max_pan_radps: max_pan_radps?,
        pan_acceleration_radps2: pan_acceleration_radps2?,
        noise: noise?,
    })
}

fn pixels<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>, key: &str, example: &str) -> Option<usize> {
    let value = reader.required(table, key, example)?;
    whole_number(reader, value, key, FEWEST_PIXELS..=MOST_PIXELS, example)
}

fn whole_number(
    reader: &mut Reader,
    value: &TomlValue,
    key: &str,
    range: RangeInclusive<usize>,
    example: &str,
) -> Option<usize> {
    let number = value.get_ref().as_integer().and_then(|digits| digits.to_string().parse::<usize>().ok());
    let count = number.filter(|count| range.contains(count));
    if count.is_none() {
        reader.expected(value, key, &format!("a whole number from {} to {}", range.start(), range.end()), example);
    }
    count
}

fn read_gripper<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Option<GripperDescription> {
    reader.only_keys(table, &["reach", "grasp", "release", "grasp_failures", "release_failures"]);
    let reach_m = number(reader, table, "reach", metres(0.01, 5.0, "0.8"));
    let grasp_s = number(reader, table, "grasp", seconds(0.0, 600.0, "3.0"));
    let release_s = number(reader, table, "release", seconds(0.0, 600.0, "2.0"));
    let grasp_failure_probability = number(reader, table, "grasp_failures", PROBABILITY);
    let release_failure_probability = number(reader, table, "release_failures", PROBABILITY);
    let in_us = |time_s: f64| libm::round(time_s * 1e6) as u64;
    Some(GripperDescription {
        reach_m: reach_m?,
        grasp_us: in_us(grasp_s?),
        release_us: in_us(release_s?),
        grasp_failure_probability: grasp_failure_probability?,
        release_failure_probability: release_failure_probability?,
    })
}

fn read_battery<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Option<BatteryDescription> {
    reader.only_keys(table, &["standing", "driving", "charging"]);
    let lasts = |example| seconds(1.0, 1e5, example);
    let standing_s = number(reader, table, "standing", lasts("28800.0"));
    let driving_s = number(reader, table, "driving", lasts("14400.0"));
    let charging_s = number(reader, table, "charging", lasts("900.0"));
    Some(BatteryDescription { standing_s: standing_s?, driving_s: driving_s?, charging_s: charging_s? })
}

fn read_odometry<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Option<OdometryDrift> {
    let keys = ["distance_noise", "turning_noise", "heading_noise", "distance_bias", "turning_bias", "heading_bias"];
    reader.only_keys(table, &keys);
    let translation_noise_m_per_sqrt_m = number(reader, table, "distance_noise", SHARE);
    let rotation_noise_rad_per_sqrt_rad = number(reader, table, "turning_noise", SHARE);
    let rotation_noise_rad_per_sqrt_m = angle(reader, table, "heading_noise", DRIFT);
    let translation_bias = number(reader, table, "distance_bias", SHARE);
    let rotation_bias = number(reader, table, "turning_bias", SHARE);
    let heading_bias_radpm = angle(reader, table, "heading_bias", DRIFT);
    Some(OdometryDrift {
        translation_noise_m_per_sqrt_m: translation_noise_m_per_sqrt_m?,
        rotation_noise_rad_per_sqrt_rad: rotation_noise_rad_per_sqrt_rad?,
        rotation_noise_rad_per_sqrt_m: rotation_noise_rad_per_sqrt_m?,
        translation_bias: translation_bias?,
        rotation_bias: rotation_bias?,
        heading_bias_radpm: heading_bias_radpm?,
    })
}

fn number<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>, key: &str, bounds: Bounds<'_>) -> Option<f64> {
    let value = reader.required(table, key, bounds.example)?;
    let number = reader.number_value(value, key, bounds.example)?;
    if (bounds.least..=bounds.most).contains(&number) {
        return Some(number);
    }
    out_of_bounds(reader, value, key, number, bounds);
    None
}

fn angle<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>, key: &str, angles: Angles) -> Option<f64> {
    // An angle at the end of what is allowed is allowed, however it was rounded.
    const SLACK_DEG: f64 = 1e-9;
    let Angles { least_deg: least, most_deg: most, example } = angles;
    let value = reader.required(table, key, example)?;
    let angle_rad = reader.angle_value(value, key)?;
    let degrees = angle_rad.to_degrees();
    if (least - SLACK_DEG..=most + SLACK_DEG).contains(&degrees) {
        return Some(angle_rad);
    }
    out_of_bounds(reader, value, key, degrees, Bounds { least, most, unit: "°", example });
    None
}

fn out_of_bounds(reader: &mut Reader, value: &TomlValue, key: &str, number: f64, bounds: Bounds<'_>) {
    let Bounds { least, most, unit, example } = bounds;
    let gap = if unit.is_empty() || unit == "°" { "" } else { " " };
    let [least, most, found] =
        [least, most, number].map(|number| format!("{}{gap}{unit}", libm::round(number * 1e4) / 1e4));
    let message = format!("`{key}` must be from {least} to {most}, found {found}");
    reader.note(value.span(), key, message, example_help(key, example));
}
