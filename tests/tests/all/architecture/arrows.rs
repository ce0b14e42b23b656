//! Which files name items of which: the paths of a crate's modules, followed to where the items are defined.

use crate::architecture::modules::{Import, Module, Modules};
use std::collections::{BTreeMap, BTreeSet};

/// By a file that names items and the file that defines them, the names.
pub type Arrows = BTreeMap<(String, String), BTreeSet<String>>;

/// Names that are being looked up, by modules.
type Open = BTreeSet<(usize, String)>;

/// What a path leads to.
enum Found {
    Module(usize),
    /// By the module that defines it.
    Item(usize, String),
}

/// The arrows between the files of a crate. An arrow leads to where an item is defined, whatever hands it on. Methods
/// and fields make none.
pub fn arrows(modules: &Modules) -> Arrows {
    let mut arrows = Arrows::new();
    for (number, module) in modules.0.iter().enumerate() {
        let imports = module.imports.iter().filter(|import| !modules.only_hands_on(number, import));
        let imported = imports.flat_map(|import| modules.imported(number, import));
        let named = module.paths.iter().filter_map(|path| modules.follow(number, path, &mut Open::new()));
        for found in imported.chain(named) {
            let Found::Item(owner, name) = found else {
                continue;
            };
            let (from, to) = (&module.file, &modules.0[owner].file);
            if from != to {
                arrows.entry((from.clone(), to.clone())).or_default().insert(name);
            }
        }
    }
    arrows
}

impl Modules {
    /// Whether a module imports something that lies below it for others alone.
    fn only_hands_on(&self, number: usize, import: &Import) -> bool {
        let module = &self.0[number];
        let owner = match self.follow(number, &import.path, &mut Open::new()) {
            Some(Found::Module(owner) | Found::Item(owner, _)) => owner,
            None => return false,
        };
        let is_below = owner != number && self.0[owner].path.starts_with(&module.path);
        is_below && import.is_public && !module.words.contains(&import.name)
    }

    /// What an import brings in: one thing, or of all that a module has what is named.
    fn imported(&self, number: usize, import: &Import) -> Vec<Found> {
        match self.follow(number, &import.path, &mut Open::new()) {
            Some(Found::Module(owner)) if import.name == "*" => {
                let words = self.0[number].words.iter();
                words.filter_map(|word| self.look_up(owner, word, true, &mut Open::new())).collect()
            }
            found => found.into_iter().collect(),
        }
    }

    /// What a path leads to that is written in a module; none in other crates.
    fn follow(&self, number: usize, path: &[String], open: &mut Open) -> Option<Found> {
        let mut found = Found::Module(number);
        for (at, name) in path.iter().enumerate() {
            let Found::Module(module) = found else { break };
            found = match name.as_str() {
                "crate" => Found::Module(0),
                "self" => Found::Module(module),
                "super" => Found::Module(self.0[module].parent?),
                name => match self.look_up(module, name, at + 1 == path.len(), open) {
                    Some(found) => found,
                    None if at == 0 || self.0[module].imports.iter().any(|import| import.name == name) => {
                        return None;
                    }
                    None => Found::Item(module, name.into()), // A macro has made it.
                },
            };
        }
        Some(found)
    }

    /// What a name means in a module: at the end of a path rather an item, before it rather a module.
    fn look_up(&self, number: usize, name: &str, is_last: bool, open: &mut Open) -> Option<Found> {
        let Module { children, definitions, imports, .. } = &self.0[number];
        let child = children.get(name).copied();
        if let Some(child) = child.filter(|_| !is_last) {
            return Some(Found::Module(child));
        }
        if definitions.contains(name) {
            return Some(Found::Item(number, name.into()));
        }
        let place = (number, name.to_string());
        if !open.insert(place.clone()) {
            return None;
        }
        let named = imports.iter().filter(|import| import.name == name);
        let named = named.filter_map(|import| self.follow(number, &import.path, open)).next();
        let found = named.or_else(|| child.map(Found::Module)).or_else(|| {
            let all = imports.iter().filter(|import| import.name == "*");
            let owners: Vec<Found> = all.filter_map(|import| self.follow(number, &import.path, open)).collect();
            owners.into_iter().find_map(|owner| match owner {
                Found::Module(owner) => self.look_up(owner, name, is_last, open),
                Found::Item(..) => None,
            })
        });
        open.remove(&place);
        found
    }
}
