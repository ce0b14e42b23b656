//! What is measured in missions: quantities, with the names that tables, files and parts have for them.

use serde::{Deserialize, Serialize, Serializer};

/// Quantities of missions, each with its name and its unit.
macro_rules! quantities {
    ($($(#[$doc:meta])* $variant:ident => $name:literal,)*) => {
        /// What is measured in a mission.
        #[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
        pub enum Quantity {
            $($(#[$doc])* #[serde(rename = $name)] $variant,)*
            /// What the plan measures itself, by the name it has there.
            #[serde(rename = "own")]
            Own(String),
        }

        impl Quantity {
            /// Its name, with its unit.
            pub fn name(&self) -> &str {
                match self {
                    $(Self::$variant => $name,)*
                    Self::Own(name) => name,
                }
            }
        }
    };
}

quantities! {
    /// How long the run took.
    Time => "time [s]",
    /// The way that the robot drove.
    Distance => "distance [m]",
    /// Contacts that the robot caused.
    ContactsCaused => "contacts caused",
    /// Distance by time.
    MeanSpeed => "mean speed [m/s]",
    /// How often active localization was started.
    Relocalizations => "relocalizations",
    /// How far the estimate was off, on the average.
    EstimateOff => "estimate off [m]",
    /// The share of the time with an estimate that is wrong.
    Astray => "astray [%]",
    /// The way from a disturbance until it was noticed.
    NoticedAfter => "noticed after [m]",
    /// Whether it was noticed within two metres.
    NoticedWithin2M => "noticed within 2 m",
    /// How often the position counted as found where it was not.
    WrongRecoveries => "wrong recoveries",
    /// How often the position counted as lost while the estimate was right.
    FalseAlarms => "false alarms",
    /// Orders of a day at the office.
    OrdersDue => "orders due",
    /// Things that lie where they were ordered to.
    OrdersDelivered => "orders delivered",
    /// Things that lie neither where they were nor where they were ordered to.
    OrdersLost => "orders lost",
    /// Things that were put down twice.
    OrdersDoubled => "orders doubled",
    /// Orders that were delivered in time, as the plan says.
    OrdersInTime => "orders in time",
    /// How often an order was interrupted.
    Interruptions => "interruptions",
    /// How often an interrupted one went on.
    Continued => "continued",
    /// How far the robot stood from its goal at the end.
    OffTheGoal => "off the goal [m]",
    /// How far the thing lay from there.
    ThingOff => "thing off [m]",
    /// The way driven by the shortest one.
    WayByOptimum => "way / optimum",
}

/// A quantity as its name alone, where it is not read back.
pub fn as_name<S: Serializer>(quantity: &Quantity, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(quantity.name())
}
