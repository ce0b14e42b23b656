//! Plan texts: files in the working folder, the built-in examples, and what `load` may reach.

use crate::examples;
use anyhow::{Context, Result, anyhow, bail};
use rpl_lang::compile::Loader;
use rpl_lang::suggest::suggest;
use rpl_robot::occupancy::OccupancyGrid;
use rpl_robot::world::{GreyImage, Greys, RosMap};
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// A longer text is refused: places in a text are counted in 32 bits, and no plan is that long.
const MAX_BYTES: u64 = 64 << 20;

/// A world file may not be longer; the department of the papers takes 8 KiB.
const WORLD_BYTES: u64 = 2 << 20;

/// Nor a file with seven keys, or with the parameters of the filter.
const SHORT_BYTES: u64 = 64 << 10;

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
}

/// The name of standard input among files.
pub const STANDARD_INPUT: &str = "-";

/// The plan a user names: a file from the working folder, else a built-in example; `-` is standard
/// input, whose `load` forms reach the working folder.
///
/// # Errors
/// What stands in the way of reading it, and what to type instead.
pub fn plan(name: &str) -> Result<PlanText> {
    if name == STANDARD_INPUT {
        let text = standard_input()?;
        return Ok(PlanText { name: "<stdin>".to_string(), text, folder: Folder::Disk(".".into()) });
    }
    let path = Path::new(name);
    match path.metadata() {
        Ok(_) => {
            let folder = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
            let text = read_text(path).map_err(|reason| anyhow!("cannot read the plan `{name}`: {reason}"))?;
            Ok(PlanText { name: name.to_string(), text, folder: Folder::Disk(folder.to_path_buf()) })
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => match examples::find(name) {
            Some((name, text)) => {
                Ok(PlanText { name: name.to_string(), text: text.to_string(), folder: Folder::BuiltIn })
            }
            None => bail!("there is no plan `{name}`\n{}", advice(name)),
        },
        Err(error) => bail!("cannot read the plan `{name}`: {}", reason(&error)),
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
        _ => plan(name),
    }
}

/// What to type instead of a name nothing has.
fn advice(name: &str) -> String {
    let path = Path::new(name);
    let folder = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let beside = folder.read_dir().into_iter().flatten().flatten();
    let mut known: Vec<String> = beside
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "rpl"))
        .map(|path| path.strip_prefix("./").unwrap_or(&path).display().to_string())
        .collect();
    known.sort();
    known.extend(examples::names().map(str::to_string));
    let meant = suggest(name, known.iter().map(String::as_str))
        .map(str::to_string)
        .or_else(|| known.iter().find(|known| **known == format!("{name}.rpl")).cloned());
    match meant {
        Some(meant) => format!("did you mean `{meant}`? `rpl examples` lists the plans this program brings along"),
        None => "`rpl examples` lists the plans this program brings along".to_string(),
    }
}

/// A map that was read, and what may not be meant as it is written.
#[derive(Clone, Debug)]
pub struct MapFile {
    /// The map.
    pub grid: OccupancyGrid,
    /// To be shown to the user.
    pub warnings: Vec<String>,
}

/// The map in a folder that is named instead of its file.
pub const MAP_FILE: &str = "map.yaml";

/// A file as text.
///
/// # Errors
/// One clause that says why not.
pub fn read_text(path: &Path) -> Result<String, String> {
    text_of(read_bytes(path, MAX_BYTES)?)
}

/// What makes a file the same under whatever name.
#[cfg(unix)]
pub type Identity = (u64, u64);

/// What makes a file the same under whatever name.
#[cfg(not(unix))]
pub type Identity = PathBuf;

/// The identity of a file; none of what is not there, or is a pipe or a device.
pub fn identity(path: &Path) -> Option<Identity> {
    let known = path.metadata().ok().filter(std::fs::Metadata::is_file)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        Some((known.dev(), known.ino()))
    }
    #[cfg(not(unix))]
    {
        drop(known);
        path.canonicalize().ok()
    }
}

/// The files this process has read.
static INPUTS: Mutex<Vec<(Identity, PathBuf)>> = Mutex::new(Vec::new());

/// The name under which this process has read the file that is at a path, if it has.
pub fn input_at(path: &Path) -> Option<PathBuf> {
    let identity = identity(path)?;
    let inputs = INPUTS.lock().ok()?;
    inputs.iter().find(|(known, _)| *known == identity).map(|(_, input)| input.clone())
}

/// The text of a world file.
///
/// # Errors
/// One clause that says why not.
pub fn world_text(path: &Path) -> Result<String, String> {
    text_of(read_bytes(path, WORLD_BYTES)?)
}

/// The text of a file that is short by its nature.
///
/// # Errors
/// One clause that says why not.
pub fn short_text(path: &Path) -> Result<String, String> {
    text_of(read_bytes(path, SHORT_BYTES)?)
}

/// A file or a pipe to read from, remembered as read.
///
/// # Errors
/// One clause that says why not.
pub fn open(path: &Path) -> Result<File, String> {
    let file = File::open(path).map_err(|error| reason(&error))?;
    if let Some(identity) = identity(path)
        && let Ok(mut inputs) = INPUTS.lock()
    {
        inputs.push((identity, path.to_path_buf()));
    }
    if file.metadata().is_ok_and(|known| known.is_dir()) {
        return Err("it is a folder; name a file in it".to_string());
    }
    Ok(file)
}

/// What is read may be a pipe or a device without an end.
fn read_bytes(path: &Path, most: u64) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    open(path)?.take(most + 1).read_to_end(&mut bytes).map_err(|error| reason(&error))?;
    within_limit(bytes, most)
}

fn within_limit(bytes: Vec<u8>, most: u64) -> Result<Vec<u8>, String> {
    if bytes.len() as u64 > most {
        let most = if most < 1 << 20 { format!("{} KiB", most >> 10) } else { format!("{} MiB", most >> 20) };
        return Err(format!("it is longer than {most}"));
    }
    Ok(bytes)
}

/// A map of the ROS map_server, by its YAML file or the folder it is in.
///
/// # Errors
/// A file that is missing or has faults.
pub fn ros_map(name: &Path) -> Result<MapFile> {
    let path = if name.is_dir() { name.join(MAP_FILE) } else { name.to_path_buf() };
    let shown = path.display();
    let text = short_text(&path).map_err(|reason| anyhow!("cannot read the map `{shown}`: {reason}"))?;
    let map =
        RosMap::parse(&text, &shown.to_string()).map_err(|error| anyhow!("the map `{shown}` has faults\n{error}"))?;
    let image_path = path.parent().unwrap_or(Path::new(".")).join(&map.image);
    let image_name = image_path.display();
    let bytes = read_bytes(&image_path, MAX_BYTES)
        .map_err(|reason| anyhow!("cannot read `{image_name}`, the image of the map `{shown}`: {reason}"))?;
    let image = GreyImage::decode(&bytes).map_err(|error| anyhow!("cannot use `{image_name}`: {error}"))?;
    map.check_size(&image).map_err(|error| anyhow!("the map `{shown}` cannot be used: {error}"))?;
    let warnings = Greys::of(&map, &image).warnings();
    let warnings = warnings.into_iter().map(|warning| format!("warning: {shown}: {warning}")).collect();
    Ok(MapFile { grid: map.grid(&image), warnings })
}

/// Whether somebody has read standard input.
static IS_READ: AtomicBool = AtomicBool::new(false);

/// All of standard input as text.
///
/// # Errors
/// Why it cannot be read, also that it has been read: who names it twice would get nothing.
pub fn standard_input() -> Result<String> {
    if IS_READ.swap(true, Ordering::Relaxed) {
        bail!("standard input can be read once only; `-` stands for it in two places");
    }
    let mut bytes = Vec::new();
    io::stdin().take(MAX_BYTES + 1).read_to_end(&mut bytes).context("cannot read standard input")?;
    within_limit(bytes, MAX_BYTES).and_then(text_of).map_err(|reason| anyhow!("cannot read standard input: {reason}"))
}

/// Bytes as text.
///
/// # Errors
/// One clause that says why not.
pub fn text_of(bytes: Vec<u8>) -> Result<String, String> {
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..at].iter().filter(|&&byte| byte == b'\n').count() + 1;
        format!("it is not a text in UTF-8 (byte {at}, line {line}); a plan is a text file")
    })
}

/// Writes a text to a file that is not there yet, or that may be written anew.
///
/// # Errors
/// One clause that says why not; a file that is there is as it was.
pub fn write_new(path: &Path, text: &str, may_overwrite: bool) -> Result<(), String> {
    let mut options = OpenOptions::new();
    options.write(true);
    match may_overwrite {
        true => options.truncate(true),
        false => options.create_new(true),
    };
    let mut file = options.open(path).map_err(|error| match error.kind() {
        io::ErrorKind::AlreadyExists => "it is there already; another name is needed".to_string(),
        io::ErrorKind::NotFound => "there is no such folder".to_string(),
        _ => reason(&error),
    })?;
    file.write_all(text.as_bytes()).map_err(|error| reason(&error))
}

/// Why a file cannot be read or written, as a clause.
pub fn reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file".to_string(),
        io::ErrorKind::PermissionDenied => "permission denied".to_string(),
        io::ErrorKind::IsADirectory => "it is a folder; name a file in it".to_string(),
        _ => error.to_string(),
    }
}

impl Loader for Folder {
    fn load(&mut self, from: &str, path: &str) -> Result<(String, String), String> {
        let beside = Path::new(from).parent().unwrap_or(Path::new(""));
        match self {
            Folder::Disk(root) => load_from_disk(root, beside, path),
            Folder::BuiltIn => {
                let wanted = normal(&beside.join(path)).ok_or(OUTSIDE)?;
                let wanted = wanted.display().to_string().replace('\\', "/");
                let (name, text) = examples::find_exactly(&wanted).ok_or("no built-in example has that name")?;
                Ok((name.to_string(), text.to_string()))
            }
        }
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
    let name = normal(&wanted).unwrap_or(wanted).display().to_string();
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

    #[test]
    fn a_binary_text_is_refused_with_its_place() {
        let found = text_of(b"(print 1)\n\xff".to_vec());
        assert_eq!(found, Err("it is not a text in UTF-8 (byte 10, line 2); a plan is a text file".to_string()));
    }
}
