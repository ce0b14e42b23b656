//! What a robot that drives by cases learns in ten days of errands.

use super::Building;
use crate::request::ExperimentRequest;
use crate::statistics::{Proportion, Summary};
use anyhow::Result;
use rpl_robot::avoidance::DriveLimits;
use rpl_robot::navigation::NavigationModel;
use rpl_robot::simulator::{SimulatorModel, SimulatorSettings};
use rpl_rupart::places::Places;
use rpl_rupart::trial::{Day, DayGround, DrivingGround, Errand, ErrandEnding};
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The name of the row in `rupart`.
pub const ROW: &str = "ten days";

/// How many days.
const DAYS: u32 = 10;

/// Where there are people.
const WORLD: &str = "olin-rice-crowded";

/// Where the days are spent.
pub struct DayBuilding {
    model: Arc<SimulatorModel>,
    places: Places,
    navigation: NavigationModel,
}

impl DayBuilding {
    /// The world that is asked for, or that with people.
    ///
    /// # Errors
    /// There is no such world.
    pub fn of(request: &ExperimentRequest) -> Result<Self> {
        let Building { world, robot, places } = Building::or(request, WORLD)?;
        let navigation = NavigationModel::new(&world, DriveLimits::of(&robot));
        let model = Arc::new(SimulatorModel::new(Arc::new(world), SimulatorSettings::of(robot)));
        Ok(Self { model, places, navigation })
    }

    /// The days of the robot of a seed.
    pub fn days(&self, seed: u64) -> RobotDays {
        let driving = DrivingGround { model: &self.model, places: &self.places };
        let days = DayGround { driving, navigation: &self.navigation }.days(DAYS, seed);
        RobotDays { seed, days }
    }
}

/// The days of a robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotDays {
    seed: u64,
    days: Vec<Day>,
}

/// What came of a day, over all robots.
#[derive(Clone, Debug, Serialize)]
pub struct DayResult {
    /// Which, from 1.
    pub day: usize,
    /// Cases at its end, on the average.
    pub cases: f64,
    /// Errands that came to their end; the interval is that of errands that have nothing to do with each other.
    pub arrived: Proportion,
    /// Errands on which the robot nowhere got no further.
    pub never_blocked: Proportion,
    /// Errands without a contact that the robot caused.
    pub without_contact: Proportion,
    /// Of the robots: seconds for each metre of the shortest way, of the errands that arrived.
    pub pace_s: Option<Summary>,
    /// Of the robots: the same, less that of their first day.
    pub slower_s: Option<Summary>,
}

/// Seconds for each metre of the shortest way, of all errands that arrived together; none if none did.
fn pace_s(day: &Day) -> Option<f64> {
    let arrived = || day.errands.iter().filter(|errand| errand.has_arrived());
    let length_m: f64 = arrived().map(|errand| errand.length_m).sum();
    (length_m > 0.0).then(|| arrived().map(|errand| errand.time_s).sum::<f64>() / length_m)
}

impl DayResult {
    /// The days of some robots, day by day.
    pub fn of(robots: &[RobotDays]) -> Vec<Self> {
        let count = robots.iter().map(|robot| robot.days.len()).max().unwrap_or(0);
        let of_day = |day: usize| robots.iter().filter_map(|robot| robot.days.get(day)).collect::<Vec<_>>();
        let more = |day: usize, of: fn(&Day) -> Option<f64>| {
            let pair = |robot: &RobotDays| Some(of(robot.days.get(day)?)? - of(robot.days.first()?)?);
            Summary::of(&robots.iter().filter_map(pair).collect::<Vec<_>>())
        };
        let compared = |day: usize| Self { slower_s: more(day, pace_s), ..Self::of_day(day + 1, &of_day(day)) };
        (0..count).map(compared).collect()
    }

    fn of_day(day: usize, of_robots: &[&Day]) -> Self {
        let errands: Vec<&Errand> = of_robots.iter().flat_map(|day| &day.errands).collect();
        let count = |is_so: fn(&Errand) -> bool| {
            Proportion::new(errands.iter().filter(|errand| is_so(errand)).count(), errands.len())
        };
        // The errands of a robot hang together by what it knows of the way.
        let pace_s: Vec<f64> = of_robots.iter().filter_map(|day| pace_s(day)).collect();
        let cases: usize = of_robots.iter().map(|day| day.cases).sum();
        Self {
            day,
            cases: cases as f64 / of_robots.len().max(1) as f64,
            arrived: count(|errand| errand.has_arrived()),
            never_blocked: count(|errand| errand.blocked == 0),
            without_contact: count(|errand| errand.contacts == 0),
            pace_s: Summary::of(&pace_s),
            slower_s: None,
        }
    }
}

/// A line for each day.
pub fn blocks(days: &[DayResult]) -> Vec<Block> {
    let mut table = Table::new(&[
        "day",
        "cases",
        "arrived",
        "95 % interval",
        "never blocked",
        "95 % interval",
        "no contact",
        "each metre",
        "than first",
    ]);
    let told = |summary: Option<Summary>, scale: f64, decimals: usize, unit: &str| {
        summary.map_or(NOTHING.to_string(), |summary| format!("{} {unit}", summary.told(scale, decimals)))
    };
    for day in days {
        table.row([
            day.day.to_string(),
            format!("{:.0}", day.cases),
            day.arrived.fraction(),
            day.arrived.interval(),
            day.never_blocked.fraction(),
            day.never_blocked.interval(),
            day.without_contact.fraction(),
            told(day.pace_s, 1.0, 3, "s"),
            told(day.slower_s, 1.0, 3, "s"),
        ]);
    }
    vec![Block::Table(table)]
}

/// Every errand as a line of comma-separated values.
pub fn lines(robots: &[RobotDays]) -> String {
    let mut text = String::from("seed,day,errand,ending,blocked,time_s,length_m,contacts\n");
    for RobotDays { seed, days } in robots {
        for (day, number, errand) in (1..)
            .zip(days)
            .flat_map(|(day, of_day)| (1..).zip(&of_day.errands).map(move |(number, one)| (day, number, one)))
        {
            let Errand { ending, blocked, time_s, length_m, contacts } = errand;
            let ended = told_ending(*ending);
            text += &format!("{seed},{day},{number},{ended},{blocked},{time_s:.2},{length_m:.2},{contacts}\n");
        }
    }
    text
}

fn told_ending(ending: ErrandEnding) -> &'static str {
    match ending {
        ErrandEnding::Arrived => "arrived",
        ErrandEnding::Blocked => "blocked",
        ErrandEnding::TooLate => "too late",
    }
}
