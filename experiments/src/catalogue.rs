//! The rows of experiments that are missions.

use rpl_robot::active::Exploration;
use rpl_robot::description::RobotDescription;
use rpl_robot::office::{OfficeSettings, PositionBy};

/// One row of a table.
#[derive(Clone, Copy)]
pub struct Row {
    /// What it is called.
    pub name: &'static str,
    /// The mission.
    pub plan: &'static str,
    /// What happens on the way.
    pub scenario: Option<&'static str>,
    /// Where.
    pub world: &'static str,
    /// Where the robot must really be at the end, if anywhere.
    pub goal: Option<&'static str>,
    /// What must really lie there then, if anything.
    pub item: Option<&'static str>,
    /// How the robot differs from the usual one.
    pub change: fn(&mut OfficeSettings),
    /// Whether its driving by cases brakes before what it hears.
    pub is_braked: bool,
}

const ROTATED: Row = Row {
    name: "rotated",
    plan: "delivery.rpl",
    scenario: Some("experiments/rotated.rpl"),
    world: "dept",
    goal: Some("wolframs-shelf"),
    item: Some("mail"),
    change: |_| (),
    is_braked: true,
};

const UNDISTURBED: Row = Row { name: "undisturbed", scenario: None, ..ROTATED };

const KIDNAPPED: Row = Row { name: "kidnapped", scenario: Some("experiments/kidnapped.rpl"), ..ROTATED };

const ABOUT_FACE: Row = Row { name: "turned by 180°", scenario: Some("experiments/about-face.rpl"), ..ROTATED };

const GLOBAL: Row = Row {
    name: "global",
    plan: "experiments/to-room-a.rpl",
    scenario: Some("experiments/global.rpl"),
    world: "dept",
    goal: Some("a-desk"),
    item: None,
    change: |settings| settings.start_known = false,
    is_braked: true,
};

const PATROL: Row =
    Row { name: "clean department", plan: "experiments/patrol.rpl", scenario: None, goal: None, item: None, ..ROTATED };

const FURNISHED: Row = Row { name: "furniture, people", world: "dept-furnished", ..PATROL };

const PEOPLE: Row = Row {
    name: "in the corridor",
    plan: "experiments/to-and-fro.rpl",
    scenario: None,
    world: "corridor-crowded",
    goal: None,
    item: None,
    change: |_| (),
    is_braked: true,
};

/// An errand by cases in the science hall, by the robot of RUPART.
const ERRAND: Row = Row {
    name: "to any place",
    plan: "experiments/by-cases-anywhere.rpl",
    scenario: None,
    world: "olin-rice",
    goal: None,
    item: None,
    change: pioneer,
    is_braked: true,
};

/// The same to a goal.
const fn errand(name: &'static str, plan: &'static str, goal: &'static str) -> Row {
    Row { name, plan, goal: Some(goal), ..ERRAND }
}

const OFFICE: Row = Row {
    name: "office",
    plan: "office.rpl",
    scenario: Some("experiments/office-day.rpl"),
    world: "dept-staffed",
    ..PEOPLE
};

/// A row of the table of deviations: `rotated` with one of them taken back.
const fn without(name: &'static str, change: fn(&mut OfficeSettings)) -> Row {
    Row { name, change, ..ROTATED }
}

/// The same over furniture and people that are in no map.
const fn furnished_without(name: &'static str, change: fn(&mut OfficeSettings)) -> Row {
    Row { name, change, ..FURNISHED }
}

/// The worlds of the experiment `worlds`.
pub const WORLDS: [&str; 12] = [
    "long-corridor",
    "two-wings",
    "hall",
    "flat",
    "small-office",
    "lab",
    "warehouse",
    "gallery",
    "ring",
    "school",
    "dept",
    "dept-furnished",
];

/// The rows of `rotated`.
pub const ROTATED_ROWS: &[Row] = &[
    ROTATED,
    UNDISTURBED,
    Row { name: "no relocalization", plan: "experiments/no-relocalization.rpl", ..ROTATED },
    Row { name: "literal equations", change: literal, ..ROTATED },
];

/// The rows of `kidnapped`.
pub const KIDNAPPED_ROWS: &[Row] =
    &[KIDNAPPED, Row { name: "turned by 20–180°", scenario: Some("experiments/turned.rpl"), ..KIDNAPPED }, ABOUT_FACE];

/// The rows of `global`.
pub const GLOBAL_ROWS: &[Row] = &[
    GLOBAL,
    Row { name: "random wandering", change: |settings| lost(settings, Exploration::Wander), ..GLOBAL },
    Row { name: "wall following", change: |settings| lost(settings, Exploration::WallFollow), ..GLOBAL },
    Row { name: "spin and back up", change: |settings| lost(settings, Exploration::SpinAndBackUp), ..GLOBAL },
];

/// The rows of `false-alarms`.
pub const FALSE_ALARMS_ROWS: &[Row] = &[PATROL, FURNISHED];

/// The rows of `calibration`.
pub const CALIBRATION_ROWS: &[Row] = &[ROTATED, KIDNAPPED, GLOBAL, UNDISTURBED];

/// The rows of `deviations`.
pub const DEVIATIONS_ROWS: &[Row] = &[
    ROTATED,
    without("– tempering", untempered),
    without("– mixing", |settings| settings.localization.mixing = 0.0),
    without("– gating", ungated),
    without("– update spacing", unspaced),
    without("– coarse watch", |settings| settings.localization.watch = None),
    without("– calibration", |settings| settings.localization.calibration = None),
    without("– confirmation", found_at_once),
    without("– lower threshold", |settings| settings.localization.activity_threshold = 0.01),
    without("– centred grid", |settings| settings.localization.centred = false),
    without("all literal", literal),
    FURNISHED,
    furnished_without("– gating", ungated),
    furnished_without("– tempering", untempered),
];

/// The rows of `people`.
pub const PEOPLE_ROWS: &[Row] = &[PEOPLE, Row { name: "in the department", world: "dept-crowded", ..PEOPLE }];

/// The rows of `office`.
pub const OFFICE_ROWS: &[Row] = &[OFFICE];

/// The rows of `choices`.
pub const CHOICES_ROWS: &[Row] = &[GLOBAL, ABOUT_FACE];

/// The rows of `rupart`.
pub const RUPART_ROWS: &[Row] = &[
    ERRAND,
    errand("near", "experiments/by-cases-near.rpl", "room-113-inside"),
    errand("halfway", "experiments/by-cases-middle.rpl", "room-106-inside"),
    errand("far", "experiments/by-cases-far.rpl", "optics-lab-south-inside"),
    Row { name: "turned by 70°", scenario: Some("experiments/turned-on-the-way.rpl"), ..ERRAND },
    Row { name: "crowded", world: "olin-rice-crowded", ..ERRAND },
    Row { name: "not braked", is_braked: false, ..ERRAND },
    errand("two goals", "experiments/by-cases-two-goals.rpl", "room-113-inside"),
    errand("another goal comes", "experiments/by-cases-another-goal.rpl", "room-113-inside"),
    Row { name: "by the map", plan: "experiments/by-map-anywhere.rpl", ..ERRAND },
    Row { name: "position by landmarks", change: by_landmarks, ..ERRAND },
    Row { name: "position by the grid", change: by_grid, ..ERRAND },
];

fn pioneer(settings: &mut OfficeSettings) {
    if let Some(robot) = RobotDescription::builtin("pioneer-2dx") {
        *settings = OfficeSettings::of(robot);
    }
}

/// Odometry, set right at landmarks.
fn by_landmarks(settings: &mut OfficeSettings) {
    pioneer(settings);
    settings.position_by = PositionBy::Landmarks;
}

/// Sonars alone.
fn by_grid(settings: &mut OfficeSettings) {
    pioneer(settings);
    settings.position_by = PositionBy::GridWithoutLandmarks;
}

fn literal(settings: &mut OfficeSettings) {
    settings.localization = settings.localization.clone().literal();
}

fn untempered(settings: &mut OfficeSettings) {
    settings.localization.sensors.iter_mut().for_each(|sensor| sensor.tempering = 1.0);
}

fn ungated(settings: &mut OfficeSettings) {
    settings.localization.sensors.iter_mut().for_each(|sensor| sensor.gating = None);
}

/// Found at the same certainty at which the position is lost, at the first update.
fn found_at_once(settings: &mut OfficeSettings) {
    settings.active.found_certainty = settings.active.certainty;
    settings.active.confirmations = 1;
}

fn unspaced(settings: &mut OfficeSettings) {
    settings.localization.update_distance_m = 0.0;
    settings.localization.update_angle_rad = 0.0;
}

fn lost(settings: &mut OfficeSettings, exploration: Exploration) {
    settings.start_known = false;
    settings.active.exploration = exploration;
}
