//! What a robot that drives by cases learns in ten days of errands.

use super::Building;
use crate::experiment::request::ExperimentRequest;
use crate::experiment::statistics::{Proportion, Summary};
use crate::terminal::page::Block;
use crate::terminal::table::{NOTHING, Table};
use anyhow::Result;
use rpl_robot::simulator::{SimulatorModel, SimulatorSettings};
use rpl_rupart::places::Places;
use rpl_rupart::trial::{Day, DrivingGround, Errand};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The name of the row in `rupart`.
pub const ROW: &str = "ten days";

/// How many days.
const DAYS: u32 = 10;

/// Where there are people.
const WORLD: &str = "olin-rice-crowded";

/// Where the days are spent.
pub struct DayGround {
    model: Arc<SimulatorModel>,
    places: Places,
}

impl DayGround {
    /// The world that is asked for, or that with people.
    ///
    /// # Errors
    /// There is no such world.
    pub fn of(request: &ExperimentRequest) -> Result<Self> {
        let Building { world, robot, places } = Building::or(request, WORLD)?;
        let model = Arc::new(SimulatorModel::new(Arc::new(world), SimulatorSettings::of(robot)));
        Ok(Self { model, places })
    }

    /// The days of the robot of a seed.
    pub fn days(&self, seed: u64) -> RobotDays {
        let days = DrivingGround { model: &self.model, places: &self.places }.days(DAYS, seed);
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
    /// Errands that came to their end.
    pub arrived: Proportion,
    /// Errands without a contact that the robot caused.
    pub without_contact: Proportion,
    /// Seconds for each metre of the shortest way, of the errands that arrived.
    pub pace_s: Option<Summary>,
}

impl DayResult {
    /// The days of some robots, day by day.
    pub fn of(robots: &[RobotDays]) -> Vec<Self> {
        let days = robots.iter().map(|robot| robot.days.len()).max().unwrap_or(0);
        (0..days)
            .map(|day| {
                Self::of_day(day + 1, &robots.iter().filter_map(|robot| robot.days.get(day)).collect::<Vec<_>>())
            })
            .collect()
    }

    fn of_day(day: usize, of_robots: &[&Day]) -> Self {
        let errands: Vec<&Errand> = of_robots.iter().flat_map(|day| &day.errands).collect();
        let count = |is_so: fn(&Errand) -> bool| {
            Proportion::new(errands.iter().filter(|errand| is_so(errand)).count(), errands.len())
        };
        let arrived = errands.iter().filter(|errand| errand.has_arrived);
        let pace_s: Vec<f64> = arrived.map(|errand| errand.time_s / errand.length_m).collect();
        let cases: usize = of_robots.iter().map(|day| day.cases).sum();
        Self {
            day,
            cases: cases as f64 / of_robots.len().max(1) as f64,
            arrived: count(|errand| errand.has_arrived),
            without_contact: count(|errand| errand.contacts == 0),
            pace_s: Summary::of(&pace_s),
        }
    }
}

/// A line for each day.
pub fn blocks(days: &[DayResult]) -> Vec<Block> {
    let mut table = Table::new(&["day", "cases", "arrived", "95 % interval", "no contact", "for each metre"]);
    for day in days {
        let pace =
            day.pace_s.map_or(NOTHING.to_string(), |pace| format!("{:.3} ± {:.3} s", pace.spread.mean, pace.half_95));
        table.row([
            day.day.to_string(),
            format!("{:.0}", day.cases),
            day.arrived.fraction(),
            day.arrived.interval(),
            day.without_contact.fraction(),
            pace,
        ]);
    }
    vec![Block::Table(table)]
}

/// Every errand as a line of comma-separated values.
pub fn lines(robots: &[RobotDays]) -> String {
    let mut text = String::from("seed,day,errand,arrived,time_s,length_m,contacts\n");
    for RobotDays { seed, days } in robots {
        for (day, number, errand) in (1..)
            .zip(days)
            .flat_map(|(day, of_day)| (1..).zip(&of_day.errands).map(move |(number, one)| (day, number, one)))
        {
            let Errand { has_arrived, time_s, length_m, contacts } = errand;
            text += &format!("{seed},{day},{number},{},{time_s:.2},{length_m:.2},{contacts}\n", u8::from(*has_arrived));
        }
    }
    text
}
