//! The tables of behaviours, fluents and valves a plan sees.

use rpl_runtime::behaviour::{BehaviourSpec, FluentSpec};

/// Numbers of the behaviours in [`BEHAVIOURS`].
pub(super) const POSITION_TRACKING: u16 = 0;
pub(super) const ACTIVE_LOCALIZATION: u16 = 1;
pub(super) const NAVIGATION: u16 = 2;
pub(super) const GRIPPER: u16 = 3;
pub(super) const LOOK_AROUND: u16 = 4;

/// The behaviours.
pub const BEHAVIOURS: &[BehaviourSpec] = &[
    BehaviourSpec {
        name: "position-tracking",
        doc: "Keeps the belief about the position up to date; active from the start, needs no valve.",
        valve: None,
        parameters: "",
    },
    BehaviourSpec {
        name: "active-localization",
        doc: "Drives to where the robot learns most about its position; gives up the belief first if the certainty is at or below 0.8. Succeeds when the position is known, fails with localization-failure after ten minutes.",
        valve: Some("wheels"),
        parameters: "",
    },
    BehaviourSpec {
        name: "navigation",
        doc: "Drives to the points of `:targets`, lists (x y) or, for the last, (x y heading). Succeeds close to the last one; fails with unreachable, or with blocked if for the time of `:patience`, without it two minutes, the robot gets no nearer.",
        valve: Some("wheels"),
        parameters: ":targets :patience",
    },
    BehaviourSpec {
        name: "gripper",
        doc: "Takes the thing named by `:grasp`, or lets go with `:release t`; both take time. Fails with grasp-failure.",
        valve: Some("arm"),
        parameters: ":grasp :release",
    },
    BehaviourSpec {
        name: "look-around",
        doc: "Turns a little to the left, to the right, and back, so that the sensors see more. Succeeds after that.",
        valve: Some("wheels"),
        parameters: "",
    },
];

/// The valves.
pub const VALVES: &[&str] = &["wheels", "arm"];

/// Numbers of the fluents in [`FLUENTS`].
pub(super) const X: usize = 0;
pub(super) const Y: usize = 1;
pub(super) const O: usize = 2;
pub(super) const POS_CERTAINTY: usize = 3;
pub(super) const NAVIGATION_ACTIVE: usize = 4;
pub(super) const NR_OF_NAV_GOALS: usize = 5;
pub(super) const TRAVEL_MODE: usize = 6;
pub(super) const REGION: usize = 7;
pub(super) const SPEED: usize = 8;
pub(super) const BUMPED: usize = 9;
pub(super) const HOLDING: usize = 10;
pub(super) const BATTERY: usize = 11;
pub(super) const MESSAGES: usize = 12;

/// The fluents.
pub const FLUENTS: &[FluentSpec] = &[
    FluentSpec { name: "x*", doc: "Estimated x, in metres, map frame." },
    FluentSpec { name: "y*", doc: "Estimated y, in metres, map frame." },
    FluentSpec { name: "o*", doc: "Estimated heading, in radians counter-clockwise from the map's x axis." },
    FluentSpec {
        name: "pos-certainty*",
        doc: "Probability that the position is within 0.5 m and 15° of the estimate; calibrated, so that 0.8 is right four times in five.",
    },
    FluentSpec { name: "navigation-active?*", doc: "True while a navigation plan is executed." },
    FluentSpec { name: "nr-of-nav-goals*", doc: "Target points not yet reached." },
    FluentSpec { name: "travel-mode*", doc: "How the robot drives: hallway, office or doorway." },
    FluentSpec { name: "region*", doc: "The travel mode of the region the robot believes itself to be in, or nil." },
    FluentSpec { name: "speed*", doc: "Measured speed ahead, in metres a second." },
    FluentSpec { name: "bumped?*", doc: "Whether something touches the robot." },
    FluentSpec { name: "holding*", doc: "The thing in the gripper, or nil." },
    FluentSpec { name: "battery*", doc: "Charge of the battery, from 0 to 1, in thousandths." },
    FluentSpec { name: "messages*", doc: "How many messages have not been read." },
];
