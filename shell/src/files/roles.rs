//! What a text is for: a plan, a scenario, or the plans of a module. Plans that lie beside each other say it of each
//! other, and a project says it of all.

use super::module_files;
use super::plans::PlanText;
use super::project_file::ProjectFile;
use rpl_lang::reader::read;
use rpl_lang::source::SourceId;
use rpl_lang::symbol::Symbols;
use rpl_lang::syntax::{NodeKind, Tree};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// What a text is for.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// It is run, or has what is run.
    Plan,
    /// It disturbs the world.
    Scenario,
    /// It belongs to a module, by the module's manifest.
    OfModule(String),
}

/// The files that are no plans, by where they really lie.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Roles {
    scenarios: BTreeSet<PathBuf>,
    of_modules: BTreeMap<PathBuf, String>,
}

impl Roles {
    /// What a project says, and what plans say in their tests: `:scenario "night.rpl"`. Cost: that of reading them.
    pub fn of<'p>(project: Option<&ProjectFile>, plans: impl Iterator<Item = &'p PlanText>) -> Self {
        Self::with(project, plans.flat_map(|plan| scenarios_of(&plan.name, &plan.text)))
    }

    /// What a project says, and the scenarios that its plans name.
    pub fn with(project: Option<&ProjectFile>, tested: impl Iterator<Item = String>) -> Self {
        let said = project.into_iter().flat_map(|says| says.scenarios.iter().chain(&says.scenario).cloned());
        let of_module = |manifest: &String| {
            let plans = module_files::plans_of(manifest)?;
            Some((Path::new(manifest).with_file_name(plans).canonicalize().ok()?, manifest.clone()))
        };
        Self {
            scenarios: said.chain(tested).filter_map(|name| Path::new(&name).canonicalize().ok()).collect(),
            of_modules: project.into_iter().flat_map(|says| says.modules.iter().filter_map(of_module)).collect(),
        }
    }

    /// What a file is for.
    pub fn role(&self, file: &str) -> Role {
        let Ok(path) = Path::new(file).canonicalize() else { return Role::Plan };
        match self.of_modules.get(&path) {
            Some(manifest) => Role::OfModule(manifest.clone()),
            None if self.scenarios.contains(&path) => Role::Scenario,
            None => Role::Plan,
        }
    }
}

/// The scenarios that the tests in a file name. Cost: that of reading its text, if it names any.
pub fn scenarios_of(file: &str, text: &str) -> Vec<String> {
    tested_with(text).iter().map(|scenario| beside(file, scenario)).collect()
}

/// The scenario that a test in a file names: a file beside that one if there is one, else the name itself.
pub fn beside(file: &str, scenario: &str) -> String {
    let there = Path::new(file).with_file_name(scenario);
    if there.is_file() { there.to_string_lossy().into_owned() } else { scenario.to_string() }
}

/// The scenarios that the tests in a text name.
fn tested_with(text: &str) -> Vec<String> {
    if !text.contains(":scenario") {
        return Vec::new();
    }
    let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
    // What is wrong with the text is told when it is compiled.
    let (roots, _) = read(text, SourceId(0), &mut symbols, &mut tree);
    let is_test = |root| tree.head(root).is_some_and(|head| symbols.name(head) == "deftest");
    let tests = roots.iter().filter(|&&root| is_test(root)).map(|&root| tree.items(root));
    let named = tests.flat_map(|items| items.windows(2)).filter_map(|pair| {
        match [pair[0], pair[1]].map(|id| &tree.get(id).kind) {
            [NodeKind::Keyword(key), NodeKind::Str(name)] if symbols.name(*key) == "scenario" => Some(name.to_string()),
            _ => None,
        }
    });
    named.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scenarios_of_tests_are_found() {
        let text = "(deftest a :world \"dept\" :scenario \"night.rpl\" (go)) (defun f (x) :scenario \"no.rpl\")";
        assert_eq!(tested_with(text), ["night.rpl"]);
    }
}
