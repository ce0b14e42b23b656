//! Case files: what a robot remembers, read before it begins and written when it has ended.
//!
//! A file is never changed in place: what is written stands beside it until all of it is there.

use super::inputs;
use crate::files::shown::Shown;
use anyhow::{Context, Result, anyhow, bail};
use rpl_robot::description::RobotDescription;
use rpl_robot::file_text::FileFaults;
use rpl_robot::world::World;
use rpl_rupart::beginning::no_cases;
use rpl_rupart::file::{memory_text, read_memory};
use rpl_rupart::memory::CaseMemory;
use rpl_rupart::places::Places;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Where cases are of: the places of a world for a robot.
pub struct CaseGround<'w> {
    world: &'w World,
    robot: &'w RobotDescription,
    /// The places; a memory of behaviours needs none.
    pub places: Option<Places>,
}

impl<'w> CaseGround<'w> {
    /// Cost: that of [`Places::new`].
    pub fn new(world: &'w World, robot: &'w RobotDescription) -> Self {
        Self { world, robot, places: Places::new(world, robot.radius_m).ok() }
    }

    /// The memory in the text of a file.
    ///
    /// # Errors
    /// All its faults.
    pub fn memory(&self, text: &str, path: &Path) -> Result<CaseMemory> {
        let name = path.to_string_lossy().into_owned();
        let similarity = no_cases(self.world, &self.robot.range_sensors()).similarity().clone();
        read_memory(text, &name, self.places.as_ref(), similarity).map_err(|faults| faulty(path, &faults))
    }

    /// The memory in a file.
    ///
    /// # Errors
    /// It cannot be read, or has faults.
    pub fn read(&self, path: &Path) -> Result<CaseMemory> {
        self.memory(&read(path)?, path)
    }
}

/// That a case file has faults, and which.
pub fn faulty(path: &Path, faults: &FileFaults) -> anyhow::Error {
    anyhow!("the case file `{}` has faults\n{faults}", path.shown())
}

/// The text of a case file.
///
/// # Errors
/// It cannot be read.
pub fn read(path: &Path) -> Result<String> {
    inputs::read_text(path).map_err(|reason| anyhow!("cannot read the cases `{}`: {reason}", path.shown()))
}

/// A case file that a run reads at its start and writes at its end. What it held stays until then, and for good
/// if nothing is written.
pub struct KeptCases {
    path: PathBuf,
    /// What it held; none if it was not there.
    before: Option<String>,
    world: String,
    places: Option<Places>,
    beside: Beside,
}

impl KeptCases {
    /// Opens a file, which may be new, for a run; with the memory that the run begins with, if it held one.
    ///
    /// # Errors
    /// It cannot be read or written, or has faults.
    pub fn open(path: &Path, world: &World, robot: &RobotDescription) -> Result<(Self, Option<CaseMemory>)> {
        let shown = path.shown();
        // Who names a link means the file behind it.
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        let before = match fs::metadata(&path) {
            Ok(known) if !known.is_file() => bail!("cases are kept in a file, and `{shown}` is none; name a file"),
            Ok(_) => Some(read(&path)?),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => bail!("cannot read the cases `{shown}`: {}", inputs::reason(&error)),
        };
        let ground = CaseGround::new(world, robot);
        let memory = before.as_deref().map(|text| ground.memory(text, &path)).transpose()?;
        let beside = Beside::of(&path)?;
        Ok((Self { path, before, world: world.name.clone(), places: ground.places, beside }, memory))
    }

    /// Writes what the robot remembers now.
    ///
    /// # Errors
    /// It cannot be written, or somebody else has written the file since the run began; then what was learned
    /// lies beside it.
    pub fn write(mut self, memory: &CaseMemory) -> Result<()> {
        let text = memory_text(memory, &self.world, self.places.as_ref());
        self.beside.write(&text).with_context(|| format!("cannot write the cases `{}`", self.path.shown()))?;
        if fs::read_to_string(&self.path).ok() != self.before {
            let learned = self.beside.keep();
            bail!(
                "the cases `{}` were changed by somebody else while the run went on, and are left as they are; what \
                 this run has learned is in `{}`",
                self.path.shown(),
                learned.shown()
            );
        }
        self.beside.replace(&self.path).with_context(|| format!("cannot write the cases `{}`", self.path.shown()))
    }
}

/// A file beside another, to take its place; gone again if it does not.
struct Beside {
    path: PathBuf,
    file: File,
    is_kept: bool,
}

impl Beside {
    fn of(path: &Path) -> Result<Self> {
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let beside = path.with_file_name(format!("{name}.{}.learned", std::process::id()));
        let file = File::create_new(&beside).map_err(|error| {
            let reason = match error.kind() {
                io::ErrorKind::NotFound => "there is no such folder".to_string(),
                _ => inputs::reason(&error),
            };
            anyhow!("cannot write the cases `{}`: {reason}", path.shown())
        })?;
        if let Ok(known) = fs::metadata(path) {
            let cannot = || format!("cannot write the cases `{}`", path.shown());
            if known.permissions().readonly() {
                fs::remove_file(&beside).with_context(cannot)?;
                bail!("cannot write the cases `{}`: nobody may write it", path.shown());
            }
            file.set_permissions(known.permissions()).with_context(cannot)?;
        }
        Ok(Self { path: beside, file, is_kept: false })
    }

    /// All of it is on the disk afterwards.
    fn write(&mut self, text: &str) -> io::Result<()> {
        self.file.write_all(text.as_bytes())?;
        self.file.sync_all()
    }

    fn replace(&mut self, path: &Path) -> io::Result<()> {
        fs::rename(&self.path, path)?;
        self.is_kept = true;
        Ok(())
    }

    fn keep(&mut self) -> PathBuf {
        self.is_kept = true;
        self.path.clone()
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        if !self.is_kept {
            fs::remove_file(&self.path).ok();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_somebody_else_has_changed_is_left_alone_and_what_was_learned_lies_beside_it() {
        let folder = std::env::temp_dir().join(format!("rpl-cases-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder for the test");
        let path = folder.join("robot.cases");
        let head = |next: u32| format!("{{\"rpl_cases\":1,\"world\":\"test-room\",\"next\":{next}}}\n");
        fs::write(&path, head(3)).expect("it is written");
        let world = World::builtin("test-room").expect("it is built in");
        let robot = RobotDescription::builtin("pioneer-2dx").expect("it is built in");
        let open = || KeptCases::open(&path, &world, &robot).expect("it can be opened");
        let files = || fs::read_dir(&folder).expect("it is there").count();
        let (kept, memory) = open();
        drop(kept);
        assert_eq!(files(), 1, "who learned nothing leaves nothing");
        let memory = memory.expect("the file held one");
        let (kept, _) = open();
        fs::write(&path, head(7)).expect("it is written");
        let refused = kept.write(&memory).expect_err("it was changed").to_string();
        assert!(refused.contains("were changed by somebody else"), "{refused}");
        assert_eq!((fs::read_to_string(&path).expect("it is there"), files()), (head(7), 2));
        fs::remove_dir_all(&folder).expect("it is there");
    }
}
