//! Variants: the ways in which the missions of an experiment of one's own differ.

use crate::experiment_file::{ExperimentFile, FileVariant};
use crate::request::ExperimentRequest;
use anyhow::{Result, bail};
use rpl_robot::description::RobotDescription;
use rpl_shell::files::robot_files;
use std::sync::Arc;

/// More variants than this are a table that nobody reads.
const MOST_VARIANTS: usize = 1_000;

/// A mission with one setting of everything that is varied.
#[derive(Clone, Debug)]
pub struct Variant {
    /// What its row is called.
    pub name: String,
    /// The plan.
    pub plan: String,
    /// Where.
    pub world: Option<String>,
    /// The robot.
    pub robot: Arc<RobotDescription>,
    /// What happens on the way.
    pub scenario: Option<String>,
    /// Manifests of modules in other processes.
    pub modules: Vec<String>,
    /// `NAME=EXPR`: first values of variables of the plan.
    pub set: Vec<String>,
}

impl Variant {
    /// All that are asked for: those of an experiment file, or the plan that is named, each with every combination of
    /// what `--vary` says.
    ///
    /// # Errors
    /// No variant has the name of the row, two have the same, or there are too many.
    pub fn all(request: &ExperimentRequest) -> Result<Vec<Self>> {
        let mut all = match &request.file {
            Some(file) => Self::of_file(request, file)?,
            None => vec![Self {
                name: request.name.clone(),
                plan: request.name.clone(),
                world: request.world.clone(),
                robot: request.robot.clone(),
                scenario: request.scenario.clone(),
                modules: request.modules.clone(),
                set: request.set.clone(),
            }],
        };
        for varied in &request.vary {
            all = Self::varied(all, varied)?;
        }
        if all.len() > MOST_VARIANTS {
            bail!(
                "there are {} variants, and at most {MOST_VARIANTS} are compared; write fewer into a file",
                all.len()
            );
        }
        if let Some(twice) = all.iter().enumerate().find(|(at, one)| all[..*at].iter().any(|it| it.name == one.name)) {
            bail!("two variants are called `{}`; give each a name of its own", twice.1.name);
        }
        let Some(wanted) = &request.row else { return Ok(all) };
        if all.len() == 1 {
            bail!(
                "`--row {wanted}` is for experiments of several rows; a plan of your own has one row, unless it is varied"
            );
        }
        let names: Vec<&str> = all.iter().map(|variant| variant.name.as_str()).collect();
        let unknown = request.no_row(wanted, &names);
        all.retain(|variant| variant.name == *wanted);
        if all.is_empty() {
            bail!(unknown);
        }
        Ok(all)
    }

    fn of_file(request: &ExperimentRequest, file: &ExperimentFile) -> Result<Vec<Self>> {
        let variants = file.variants()?;
        let of_file = |variant: FileVariant| {
            let robot = match variant.robot.filter(|_| request.robot_name.is_none()) {
                Some(robot) => robot_files::named(Some(&robot))?,
                None => request.robot.clone(),
            };
            Ok(Self {
                name: variant.name,
                plan: variant.plan,
                world: request.world.clone().or(variant.world),
                robot,
                scenario: request.scenario.clone().or(variant.scenario),
                modules: if request.modules.is_empty() { variant.modules } else { request.modules.clone() },
                set: [variant.set, request.set.clone()].concat(),
            })
        };
        variants.into_iter().map(of_file).collect()
    }

    /// Each of some variants with each of the values that a `NAME=A,B` has.
    fn varied(all: Vec<Self>, varied: &str) -> Result<Vec<Self>> {
        let Some((name, values)) = varied.split_once('=') else {
            bail!("`--vary {varied}` has no values; write `--vary {varied}=A,B`");
        };
        let values = parts(values);
        if values.iter().any(|value| value.trim().is_empty()) {
            bail!("a value of `--vary {varied}` is empty; write `--vary {name}=A,B`");
        }
        if all.len() * values.len() > MOST_VARIANTS {
            bail!("`--vary` makes more than {MOST_VARIANTS} variants; vary less at a time");
        }
        let is_one = all.len() == 1;
        let with = |variant: &Self, value: &str| {
            let setting = format!("{name}={}", value.trim());
            let row = if is_one { setting.clone() } else { format!("{}, {setting}", variant.name) };
            let set = variant.set.iter().cloned().chain([setting]).collect();
            Self { name: row, set, ..variant.clone() }
        };
        Ok(all.iter().flat_map(|variant| values.iter().map(move |value| with(variant, value))).collect())
    }
}

/// What stands between commas, which in parentheses and strings part nothing.
fn parts(text: &str) -> Vec<&str> {
    let (mut depth, mut in_string, mut is_escaped, mut from) = (0_usize, false, false, 0);
    let mut parts = Vec::new();
    for (at, letter) in text.char_indices() {
        match letter {
            _ if is_escaped => is_escaped = false,
            '\\' if in_string => is_escaped = true,
            '"' => in_string = !in_string,
            _ if in_string => {}
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => {
                parts.push(&text[from..at]);
                from = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[from..]);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commas_within_a_value_part_nothing() {
        assert_eq!(parts("'a,(list 1, 2),\"x,\\\",y\""), ["'a", "(list 1, 2)", "\"x,\\\",y\""]);
        assert_eq!(parts("1"), ["1"]);
        assert_eq!(parts("1,"), ["1", ""]);
    }
}
