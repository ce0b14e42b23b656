//! The rows of the table: which sensors are read, and how the next direction is chosen.

/// Which sensors can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensors {
    /// The 24 sonars.
    Sonars,
    /// The 181 directions of the laser.
    Laser,
    /// All of them.
    Both,
}

impl Sensors {
    /// Their numbers in the model, which has the sonars first.
    pub fn numbers(self) -> &'static [usize] {
        match self {
            Sensors::Sonars => &[0],
            Sensors::Laser => &[1],
            Sensors::Both => &[0, 1],
        }
    }
}

/// How the next direction is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Policy {
    /// By the entropy expected after reading it.
    Active,
    /// Each as likely as the other.
    Random,
}

/// A row of the table.
#[derive(Debug)]
pub struct SensingSetting {
    /// Its name.
    pub name: &'static str,
    /// What can be read.
    pub sensors: Sensors,
    /// How it is chosen.
    pub policy: Policy,
}

pub static SETTINGS: [SensingSetting; 6] = [
    SensingSetting { name: "both, active", sensors: Sensors::Both, policy: Policy::Active },
    SensingSetting { name: "both, random", sensors: Sensors::Both, policy: Policy::Random },
    SensingSetting { name: "sonars, active", sensors: Sensors::Sonars, policy: Policy::Active },
    SensingSetting { name: "sonars, random", sensors: Sensors::Sonars, policy: Policy::Random },
    SensingSetting { name: "laser, active", sensors: Sensors::Laser, policy: Policy::Active },
    SensingSetting { name: "laser, random", sensors: Sensors::Laser, policy: Policy::Random },
];
