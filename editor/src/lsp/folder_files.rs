//! The plans of the open folders with their definitions: each is read when somebody first asks, and again when it has
//! changed.

use crate::definitions::{Definition, definitions};
use crate::lines::Lines;
use crate::outline::Outline;
use crate::surroundings::{Surroundings, Version};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Files that are read while somebody waits. The others are read afterwards, when nobody asks for anything.
const MOST_READ: usize = 1_000;

/// Files that are read before it is looked whether somebody asks for something.
const MOST_READ_AT_ONCE: usize = 50;

/// The definitions in the files of the folders, as they were when somebody last asked.
#[derive(Default)]
pub(super) struct FolderFiles {
    known: BTreeMap<PathBuf, (Version, Vec<Definition>)>,
    /// Those that are new, or another version than is known, the last one first.
    unread: Vec<(PathBuf, Version)>,
}

impl FolderFiles {
    /// The files that were read, each with its definitions.
    pub(super) fn known(&self) -> impl Iterator<Item = (&Path, &[Definition])> {
        self.known.iter().map(|(path, (_, defined))| (path.as_path(), defined.as_slice()))
    }

    /// Finds out which files are there, and forgets those that are gone.
    pub(super) fn update(&mut self, surroundings: &dyn Surroundings, folders: &[PathBuf]) {
        let mut before = std::mem::take(&mut self.known);
        self.unread.clear();
        for (path, version) in folders.iter().flat_map(|folder| surroundings.plans_below(folder)) {
            match before.remove(&path).filter(|(known, _)| *known == version) {
                Some(known) => drop(self.known.insert(path, known)),
                // One folder may lie in another.
                None if self.known.contains_key(&path) => {}
                None => self.unread.push((path, version)),
            }
        }
        self.unread.reverse();
    }

    /// Reads up to `most` files; gives their number.
    fn read(&mut self, surroundings: &dyn Surroundings, most: usize) -> u64 {
        let next = self.unread.split_off(self.unread.len().saturating_sub(most));
        let read = next.len() as u64;
        for (path, version) in next.into_iter().rev() {
            let text = surroundings.text(&path).unwrap_or_default();
            let defined = definitions(&text, &Outline::of(&text), &Lines::of(&text));
            self.known.insert(path, (version, defined));
        }
        read
    }

    /// Reads as many as somebody waits for; gives their number.
    pub(super) fn read_first(&mut self, surroundings: &dyn Surroundings) -> u64 {
        self.read(surroundings, MOST_READ)
    }

    /// Whether files are still to be read.
    pub(super) fn waits(&self) -> bool {
        !self.unread.is_empty()
    }

    /// Reads some of those files; gives their number.
    pub(super) fn read_some(&mut self, surroundings: &dyn Surroundings) -> u64 {
        self.read(surroundings, MOST_READ_AT_ONCE)
    }
}
