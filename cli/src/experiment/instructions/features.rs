//! `hallway-features`: whether what is beside hallways is perceived as what it is.

use super::course::Course;
use crate::experiment::row_result::FailedRun;
use crate::experiment::statistics::Proportion;
use crate::terminal::page::Block;
use crate::terminal::table::{NOTHING, Table};
use rpl_lola::feature::Feature;
use rpl_lola::features::score::Confusion;
use serde::Serialize;

/// What came of the drives of a row.
#[derive(Clone, Debug, Serialize)]
pub struct FeatureRow {
    /// What the row is called.
    pub name: String,
    /// Drives.
    pub runs: usize,
    /// Features taken for what they are.
    pub right: Proportion,
    /// Percepts of nothing, and of something that was told of before, in 100 m.
    pub false_in_100_m: f64,
    /// `taken[feature][percept]`, wall, closed door, open door, hallway, foyer; the percept wall is a miss.
    pub taken: [[u32; 5]; 5],
    /// Percepts where there is but wall, by what was seen.
    pub false_alarms: [u32; 5],
    /// Percepts of something that was told of before.
    pub doubled: u32,
    /// The way driven.
    pub driven_m: f64,
    /// How far the axis of the hallway was off along the way; none if it never was registered.
    pub axis_off: Option<AxisOff>,
    /// Contacts the robot caused.
    pub contacts: u32,
    /// Drives that did not get to the end, with the reason.
    pub failures: Vec<FailedRun>,
}

/// How far the axis was off, over equal distances of all drives.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct AxisOff {
    /// The middle one.
    pub median_deg: f64,
    /// What 95 % do not exceed.
    pub most_deg: f64,
    /// The largest.
    pub largest_deg: f64,
    /// The share within 2°.
    pub within_2_deg: f64,
}

/// Registration is to be right by so much (lola.md).
const RIGHT_AXIS_DEG: f64 = 2.0;

impl AxisOff {
    fn of(mut off_deg: Vec<f64>) -> Option<Self> {
        off_deg.sort_by(f64::total_cmp);
        let at = |share: f64| off_deg.get((off_deg.len() as f64 * share) as usize).copied();
        Some(Self {
            median_deg: at(0.5)?,
            most_deg: at(0.95)?,
            largest_deg: *off_deg.last()?,
            within_2_deg: off_deg.iter().filter(|off| **off <= RIGHT_AXIS_DEG).count() as f64 / off_deg.len() as f64,
        })
    }
}

impl FeatureRow {
    /// The figures of some drives.
    pub fn of(name: &str, courses: &[Course]) -> Self {
        let failed = |course: &Course| Some(FailedRun { seed: course.seed, fault: course.fault.clone()? });
        let mut confusion = Confusion::default();
        courses.iter().for_each(|course| confusion.add(&course.confusion()));
        Self {
            name: name.to_string(),
            runs: courses.len(),
            right: Proportion::new(confusion.right() as usize, confusion.features() as usize),
            false_in_100_m: confusion.false_in_100_m(),
            axis_off: AxisOff::of(courses.iter().flat_map(|course| course.axis_off_deg.iter().copied()).collect()),
            contacts: courses.iter().map(|course| course.contacts).sum(),
            failures: courses.iter().filter_map(failed).collect(),
            taken: confusion.taken,
            false_alarms: confusion.false_alarms,
            doubled: confusion.doubled,
            driven_m: confusion.driven_m,
        }
    }

    /// What each feature was taken for: C(percept | feature) in the layout of DERVISH's table.
    fn matrix(&self) -> Table {
        let heads: Vec<&str> = Feature::ALL.into_iter().skip(1).map(Feature::name).collect();
        let mut table = Table::new(&[&["perceived as"][..], &heads, &["false in 100 m"]].concat());
        for percept in Feature::ALL {
            let shares = Feature::ALL.into_iter().skip(1).map(|feature| {
                let of: u32 = self.taken[feature as usize].iter().sum();
                let count = self.taken[feature as usize][percept as usize];
                if of == 0 { NOTHING.to_string() } else { format!("{:.3}", f64::from(count) / f64::from(of)) }
            });
            let name = if percept == Feature::Wall { "nothing" } else { percept.name() };
            let alarms = match percept {
                Feature::Wall => NOTHING.to_string(),
                _ => format!("{:.2}", f64::from(self.false_alarms[percept as usize]) * 100.0 / self.driven_m.max(1e-9)),
            };
            table.row([name.to_string()].into_iter().chain(shares).chain([alarms]));
        }
        table
    }
}

/// A line for each row, and the matrix of each.
pub fn blocks(rows: &[FeatureRow]) -> Vec<Block> {
    let heads =
        ["", "drives", "right", "95 % interval", "false in 100 m", "axis off: median", "95 %", "largest", "contacts"];
    let mut table = Table::new(&heads);
    for row in rows {
        let degrees = |of: fn(&AxisOff) -> f64| {
            row.axis_off.as_ref().map_or(NOTHING.to_string(), |off| format!("{:.2}°", of(off)))
        };
        table.row([
            row.name.clone(),
            row.runs.to_string(),
            row.right.fraction(),
            row.right.interval(),
            format!("{:.2}", row.false_in_100_m),
            degrees(|off| off.median_deg),
            degrees(|off| off.most_deg),
            degrees(|off| off.largest_deg),
            row.contacts.to_string(),
        ]);
    }
    let mut blocks = vec![Block::Table(table)];
    for row in rows {
        blocks.push(Block::Lines(format!("\n{}: what features were perceived as", row.name)));
        blocks.push(Block::Table(row.matrix()));
        let failed: Vec<String> = row.failures.iter().map(|run| format!("{} ({})", run.seed, run.fault)).collect();
        if !failed.is_empty() {
            blocks.push(Block::Lines(format!("did not get to the end with seed {}", failed.join(", "))));
        }
    }
    blocks
}

/// Every drive as a line of comma-separated values.
pub fn raw_rows(rows: &[(&str, Vec<Course>)]) -> String {
    let mut text =
        String::from("row,seed,features,right,false alarms,doubled,driven [m],axis off 95 % [deg],contacts,fault\n");
    for (name, courses) in rows {
        for course in courses {
            let found = course.confusion();
            let alarms: u32 = found.false_alarms.iter().sum();
            let off = AxisOff::of(course.axis_off_deg.clone()).map_or(String::new(), |off| off.most_deg.to_string());
            let fault = course.fault.as_deref().unwrap_or_default();
            text += &format!(
                "\"{name}\",{},{},{},{alarms},{},{:.2},{off},{},{fault}\n",
                course.seed,
                found.features(),
                found.right(),
                found.doubled,
                course.driven_m,
                course.contacts,
            );
        }
    }
    text
}
