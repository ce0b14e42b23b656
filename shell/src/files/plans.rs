//! Plan texts: files in the working folder, the built-in examples, and what `load` may reach.

use super::inputs::{STANDARD_INPUT, read_text, reason, standard_input};
use anyhow::{Result, anyhow, bail};
use rpl_lang::compile::Loader;
use rpl_lang::suggest::suggest;
use rpl_lang::visible::visible;
use rpl_mission::examples;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::io;
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// A plan text and where it came from.
#[derive(Clone, Debug)]
pub struct PlanText {
    /// The name in errors.
    pub name: String,
    /// The text.
    pub text: String,
    /// What its `load` forms may reach.
    pub folder: Folder,
}

/// The folder tree of a main file.
#[derive(Clone, Debug)]
pub enum Folder {
    /// On the disk, below this path.
    Disk(PathBuf),
    /// Among the built-in examples.
    BuiltIn,
    /// No folder, but what was loaded from one, be it among the built-in examples.
    Kept {
        /// All that was loaded, in the order of [`KeptLoad::wanted`].
        loads: Arc<[KeptLoad]>,
        /// From where.
        is_built_in: bool,
    },
}

/// A text that a plan has loaded.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct KeptLoad {
    /// The text that loads it, by its name.
    from: String,
    /// What stands there.
    path: String,
    /// Whether it is a built-in example.
    is_built_in: bool,
    /// The name in errors.
    pub name: String,
    /// The text.
    pub text: String,
}

impl KeptLoad {
    /// What a plan asks for to be given this text.
    fn wanted(&self) -> (&str, &str, bool) {
        (&self.from, &self.path, self.is_built_in)
    }
}

impl Folder {
    /// What was loaded from a folder, be it among the built-in examples. Of two texts for one question the first counts.
    pub fn kept(mut loads: Vec<KeptLoad>, is_built_in: bool) -> Self {
        loads.sort_by(|one, other| one.wanted().cmp(&other.wanted()));
        Folder::Kept { loads: loads.into(), is_built_in }
    }
}

/// What this process has loaded, so that a journal can have it too.
static LOADED: Mutex<Loaded> = Mutex::new(Loaded { in_order: Vec::new(), known: BTreeSet::new() });

struct Loaded {
    in_order: Vec<Arc<KeptLoad>>,
    known: BTreeSet<Arc<KeptLoad>>,
}

/// The texts that the plans read so far have loaded, each once and in their order, without the first of them.
pub fn loaded_after(first: usize) -> Vec<KeptLoad> {
    let loaded = LOADED.lock().unwrap_or_else(PoisonError::into_inner);
    loaded.in_order.iter().skip(first).map(|load| (**load).clone()).collect()
}

/// The plan a user names: a file from the working folder, else a built-in example; `-` is standard
/// input, whose `load` forms reach the working folder.
///
/// # Errors
/// What stands in the way of reading it, and what to type instead.
pub fn plan(name: &str) -> Result<PlanText> {
    text_of(name, "plan")
}

/// The text of a plan or a scenario: `what` is what it is called.
fn text_of(name: &str, what: &str) -> Result<PlanText> {
    if name == STANDARD_INPUT {
        let text = standard_input()?;
        return Ok(PlanText { name: "<stdin>".to_string(), text, folder: Folder::Disk(".".into()) });
    }
    let path = Path::new(name);
    match path.metadata() {
        Ok(known) => {
            let folder = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
            if known.is_file() && path.extension().is_some_and(|extension| extension == "toml") {
                bail!(
                    "`{0}` is no {what}; a world is given by `--world {0}`, a robot by `--robot {0}`, a module by `--module {0}`",
                    visible(name)
                );
            }
            let text =
                read_text(path).map_err(|reason| anyhow!("cannot read the {what} `{}`: {reason}", visible(name)))?;
            Ok(PlanText { name: name.to_string(), text, folder: Folder::Disk(folder.to_path_buf()) })
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => match examples::find(name) {
            Some((name, text)) => {
                Ok(PlanText { name: name.to_string(), text: text.to_string(), folder: Folder::BuiltIn })
            }
            None => bail!("there is no {what} `{}`\n{}", visible(name), advice(name, what)),
        },
        Err(error) => bail!("cannot read the {what} `{}`: {}", visible(name), reason(&error)),
    }
}

/// The scenario a user names: like a plan, but among the built-in ones those in `scenarios/` too.
///
/// # Errors
/// As for a plan.
pub fn scenario(name: &str) -> Result<PlanText> {
    let built_in = examples::find(&format!("scenarios/{name}"));
    match built_in {
        Some((_, text)) if !Path::new(name).exists() => {
            Ok(PlanText { name: name.to_string(), text: text.to_string(), folder: Folder::BuiltIn })
        }
        _ => text_of(name, "scenario"),
    }
}

/// What to type instead of a name nothing has.
fn advice(name: &str, what: &str) -> String {
    let path = Path::new(name);
    let folder = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let beside = folder.read_dir().into_iter().flatten().flatten();
    let mut known: Vec<String> = beside
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "rpl"))
        .map(|path| path.strip_prefix("./").unwrap_or(&path).to_string_lossy().into_owned())
        .collect();
    known.sort();
    let own_names =
        examples::names().filter_map(|known| known.strip_prefix("scenarios/").filter(|_| what == "scenario"));
    known.extend(own_names.map(str::to_string));
    known.extend(examples::names().map(str::to_string));
    let meant = suggest(name, known.iter().map(String::as_str))
        .map(str::to_string)
        .or_else(|| known.iter().find(|known| **known == format!("{name}.rpl")).cloned());
    match meant {
        Some(meant) => {
            format!("did you mean `{meant}`? `rpl examples` lists the plans and scenarios this program brings along")
        }
        None => "`rpl examples` lists the plans and scenarios this program brings along".to_string(),
    }
}

impl Loader for Folder {
    fn load(&mut self, from: &str, path: &str) -> Result<(String, String), String> {
        let beside = Path::new(from).parent().unwrap_or(Path::new(""));
        let (name, text, is_built_in) = match self {
            Folder::Disk(root) => {
                let (name, text) = load_from_disk(root, beside, path)?;
                (name, text, false)
            }
            Folder::BuiltIn => {
                let wanted = normal(&beside.join(path)).ok_or(OUTSIDE)?;
                let wanted = wanted.to_string_lossy().replace('\\', "/");
                let (name, text) = examples::find_exactly(&wanted).ok_or("no built-in example has that name")?;
                (name.to_string(), text.to_string(), true)
            }
            Folder::Kept { loads, is_built_in } => {
                let wanted = (from, path, *is_built_in);
                let kept = loads.get(loads.partition_point(|kept| kept.wanted() < wanted));
                let kept = kept.filter(|kept| kept.wanted() == wanted).ok_or("the journal does not have it")?;
                (kept.name.clone(), kept.text.clone(), *is_built_in)
            }
        };
        let (from, path) = (from.to_string(), path.to_string());
        let load = KeptLoad { from, path, is_built_in, name: name.clone(), text: text.clone() };
        let (load, mut loaded) = (Arc::new(load), LOADED.lock().unwrap_or_else(PoisonError::into_inner));
        if loaded.known.insert(load.clone()) {
            loaded.in_order.push(load);
        }
        Ok((name, text))
    }
}

/// The files of a folder, for who looks at texts as long as they are written: what was loaded is not remembered.
pub struct OnDisk(pub PathBuf);

impl Loader for OnDisk {
    fn load(&mut self, from: &str, path: &str) -> Result<(String, String), String> {
        load_from_disk(&self.0, Path::new(from).parent().unwrap_or(Path::new("")), path)
    }
}

const OUTSIDE: &str = "it lies outside the folder of the main file; copy it into that folder";

fn load_from_disk(root: &Path, beside: &Path, path: &str) -> Result<(String, String), String> {
    if Path::new(path).is_absolute() {
        return Err(OUTSIDE.to_string());
    }
    let wanted = beside.join(path);
    let root = root.canonicalize().map_err(|error| reason(&error))?;
    let found = wanted.canonicalize().map_err(|error| match missing_within(&root, beside, path) {
        true => reason(&error),
        false => OUTSIDE.to_string(),
    })?;
    if !found.starts_with(&root) {
        return Err(OUTSIDE.to_string());
    }
    let name = normal(&wanted).unwrap_or(wanted).to_string_lossy().into_owned();
    if !found.is_file() {
        return Err("it is no file".to_string());
    }
    Ok((name, read_text(&found)?))
}

/// Whether a path that leads to no file would lie within the folder: what lies outside is none of
/// the plan's business, not even whether it exists.
fn missing_within(root: &Path, beside: &Path, path: &str) -> bool {
    let beside = if beside.as_os_str().is_empty() { Path::new(".") } else { beside };
    let Ok(beside) = beside.canonicalize() else { return false };
    beside.strip_prefix(root).is_ok_and(|inner| normal(&inner.join(path)).is_some())
}

/// The path without `.` and `..`; none if it climbs above its start.
fn normal(path: &Path) -> Option<PathBuf> {
    let mut parts = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir => {
                if !parts.pop() {
                    return None;
                }
            }
            other => parts.push(other),
        }
    }
    Some(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_brought_into_normal_form() {
        assert_eq!(normal(Path::new("a/./b/../c.rpl")), Some(PathBuf::from("a/c.rpl")));
        assert_eq!(normal(Path::new("a/../../c.rpl")), None);
    }
}
