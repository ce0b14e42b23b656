//! The experiments with a name, row by row.

use rpl_robot::active::Exploration;
use rpl_robot::description::RobotDescription;
use rpl_robot::office::{OfficeSettings, PositionBy};

/// An experiment with a name: a mission, and what it is compared with.
pub struct Experiment {
    /// What a user types.
    pub name: &'static str,
    /// What it is about: what is run, and what is shown besides the table.
    pub subject: ExperimentSubject,
    /// The first is the experiment itself.
    pub rows: &'static [Row],
}

/// What an experiment is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExperimentSubject {
    /// How many runs succeed.
    Success,
    /// What the certainty is worth, over all rows together.
    Calibration,
    /// What single departures from the papers are worth: a line for each row, nothing else.
    Comparison,
    /// Whether the robot knows where it is with people around it: rows of its own.
    Crowd,
    /// Drives from anywhere to any place, world by world.
    Worlds,
    /// Drives in buildings that are drawn from the seed, and on recorded floor plans.
    Buildings,
    /// Deliveries on whose way a door is closed for a while, world by world.
    Doors,
    /// How long drives take, beside what is foreseen.
    DriveTimes,
    /// Deliveries beside what either grain of projection has foretold of them.
    Grains,
    /// Whether what is projected comes true: no missions of the simulator, and rows of its own.
    Projections,
    /// What foresight is worth: the same.
    Foresight,
    /// How the shortcut of active navigation does beside the exact sum.
    Choices,
    /// Courses nobody has mapped: no missions, and rows of its own.
    Barn,
    /// Where the robot is by a single scan: no missions, and rows of its own.
    OneScan,
    /// Where to look: no missions, and rows of its own.
    Sensing,
    /// What is perceived of hallways: no missions, and rows of its own.
    HallwayFeatures,
    /// Whether openings are counted right: the same.
    CountOpenings,
    /// Whole routes by instructions: the same.
    OfficeDelivery,
    /// Where the robot is on a complete topological map: the same.
    TopologicalGlobal,
    /// Whether the camera finds the markers of hallways: the same.
    MarkerDetection,
    /// Routes of a case memory: no missions, and rows of its own.
    Routes,
    /// Whether the kind of case comes back that is needed: the same.
    CaseKinds,
    /// How well a robot drives by behaviour cases: the same.
    Behaviours,
    /// Errands by cases, which may begin with a memory of the user's own.
    Errands,
}

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

impl Row {
    /// Whether it drives with a robot of its own, whatever `--robot` says.
    pub fn chooses_robot(&self) -> bool {
        let mut settings = OfficeSettings::default();
        (self.change)(&mut settings);
        settings.robot.name != OfficeSettings::default().robot.name
    }
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

/// All experiments.
pub const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        name: "rotated",
        subject: ExperimentSubject::Success,
        rows: &[
            ROTATED,
            UNDISTURBED,
            Row { name: "no relocalization", plan: "experiments/no-relocalization.rpl", ..ROTATED },
            Row { name: "literal equations", change: literal, ..ROTATED },
        ],
    },
    Experiment {
        name: "kidnapped",
        subject: ExperimentSubject::Success,
        rows: &[
            KIDNAPPED,
            Row { name: "turned by 20–180°", scenario: Some("experiments/turned.rpl"), ..KIDNAPPED },
            ABOUT_FACE,
        ],
    },
    Experiment {
        name: "global",
        subject: ExperimentSubject::Success,
        rows: &[
            GLOBAL,
            Row { name: "random wandering", change: |settings| lost(settings, Exploration::Wander), ..GLOBAL },
            Row { name: "wall following", change: |settings| lost(settings, Exploration::WallFollow), ..GLOBAL },
            Row { name: "spin and back up", change: |settings| lost(settings, Exploration::SpinAndBackUp), ..GLOBAL },
        ],
    },
    Experiment { name: "false-alarms", subject: ExperimentSubject::Comparison, rows: &[PATROL, FURNISHED] },
    Experiment {
        name: "calibration",
        subject: ExperimentSubject::Calibration,
        rows: &[ROTATED, KIDNAPPED, GLOBAL, UNDISTURBED],
    },
    Experiment {
        name: "deviations",
        subject: ExperimentSubject::Comparison,
        rows: &[
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
        ],
    },
    Experiment {
        name: "people",
        subject: ExperimentSubject::Success,
        rows: &[PEOPLE, Row { name: "in the department", world: "dept-crowded", ..PEOPLE }],
    },
    Experiment { name: "office", subject: ExperimentSubject::Success, rows: &[OFFICE] },
    Experiment { name: "crowd", subject: ExperimentSubject::Crowd, rows: &[] },
    Experiment { name: "worlds", subject: ExperimentSubject::Worlds, rows: &[] },
    Experiment { name: "buildings", subject: ExperimentSubject::Buildings, rows: &[] },
    Experiment { name: "doors", subject: ExperimentSubject::Doors, rows: &[] },
    Experiment { name: "barn", subject: ExperimentSubject::Barn, rows: &[] },
    Experiment { name: "choices", subject: ExperimentSubject::Choices, rows: &[GLOBAL, ABOUT_FACE] },
    Experiment { name: "drive-times", subject: ExperimentSubject::DriveTimes, rows: &[] },
    Experiment { name: "grains", subject: ExperimentSubject::Grains, rows: &[] },
    Experiment { name: "projections", subject: ExperimentSubject::Projections, rows: &[] },
    Experiment { name: "foresight", subject: ExperimentSubject::Foresight, rows: &[] },
    Experiment { name: "one-scan", subject: ExperimentSubject::OneScan, rows: &[] },
    Experiment { name: "sensing", subject: ExperimentSubject::Sensing, rows: &[] },
    Experiment { name: "hallway-features", subject: ExperimentSubject::HallwayFeatures, rows: &[] },
    Experiment { name: "count-openings", subject: ExperimentSubject::CountOpenings, rows: &[] },
    Experiment { name: "office-delivery", subject: ExperimentSubject::OfficeDelivery, rows: &[] },
    Experiment { name: "topological-global", subject: ExperimentSubject::TopologicalGlobal, rows: &[] },
    Experiment { name: "marker-detection", subject: ExperimentSubject::MarkerDetection, rows: &[] },
    Experiment { name: "routes", subject: ExperimentSubject::Routes, rows: &[] },
    Experiment { name: "case-kinds", subject: ExperimentSubject::CaseKinds, rows: &[] },
    Experiment { name: "behaviours", subject: ExperimentSubject::Behaviours, rows: &[] },
    Experiment {
        name: "rupart",
        subject: ExperimentSubject::Errands,
        rows: &[
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
        ],
    },
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
