//! Projects that somebody planted above the folder in which the command is started.

use super::canary::{look_at_canary, put_canary};
use super::surface::{Judged, Surface};
use super::victim::Victim;
use crate::forger::mangle;
use crate::generated::Dice;
use std::fs::{self, Permissions};
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::time::Duration;

const ENDED: Duration = Duration::from_secs(20);

struct Projects {
    command: PathBuf,
    folder: PathBuf,
}

pub(super) fn start(command: &Path, folder: &Path) -> Result<Box<dyn Surface>, String> {
    Ok(Box::new(Projects { command: command.to_path_buf(), folder: folder.join("planted") }))
}

/// Why the module of a project must not be started.
#[derive(Clone, Copy)]
enum Because {
    /// Others may write the file or its folder.
    OthersMayWrite,
    /// What is asked for needs no module.
    NotAsked,
    /// A text of the project has an error.
    WrongText,
}

impl Surface for Projects {
    fn attack(&mut self, dice: &mut Dice) -> Judged {
        let wrong = |error: std::io::Error| format!("the project cannot be laid out: {error}");
        fs::remove_dir_all(&self.folder).ok();
        let depth = dice.below(4);
        let here = (0..depth).fold(self.folder.clone(), |folder, _| folder.join("below"));
        fs::create_dir_all(&here).map_err(wrong)?;
        let canary = self.folder.join("canary");
        put_canary(&canary)?;
        let project = "plan = \"plan.rpl\"\nworld = \"test-room\"\nmodules = [\"module.toml\"]\n";
        let manifest = format!(
            "name = \"m\"\ndoc = \"M.\"\ncommand = [\"sh\", \"-c\", \"echo ran > '{}'; cat > /dev/null\"]\n\n[[fluent]]\nname = \"f*\"\ndoc = \"F.\"\ntype = \"truth\"\n",
            canary.to_string_lossy()
        );
        let because = [Because::OthersMayWrite, Because::NotAsked, Because::WrongText][dice.below(3)];
        let plan = match because {
            Because::WrongText => "(wait-time",
            Because::OthersMayWrite | Because::NotAsked => "(print 'a)\n(deftest t () (wait-time 1))\n",
        };
        let mangled = dice.once_in(3);
        let project = if mangled { mangle::text(project, dice) } else { project.into() };
        fs::write(self.folder.join("plan.rpl"), plan).map_err(wrong)?;
        fs::write(self.folder.join("module.toml"), manifest).map_err(wrong)?;
        fs::write(here.join("own.rpl"), "(print 'own)\n").map_err(wrong)?;
        let file = self.folder.join("rpl.toml");
        fs::write(&file, project).map_err(wrong)?;
        let arguments: &[&str] = match because {
            Because::NotAsked => match dice.below(4) {
                0 => &["check"],
                1 => &["check", "own.rpl"],
                2 => &["fmt", "--check", "own.rpl"],
                _ => &["run", "own.rpl"],
            },
            Because::OthersMayWrite | Because::WrongText => match dice.below(3) {
                0 => &["run"],
                1 => &["test"],
                _ => &["experiment", "--runs", "1"],
            },
        };
        let kind = match because {
            Because::OthersMayWrite => {
                let (path, mode) = if dice.once_in(2) { (&file, 0o666) } else { (&self.folder, 0o777) };
                if dice.once_in(4) && *path == file {
                    // The link is one's own, and what it leads to is not.
                    let elsewhere = self.folder.join("elsewhere.toml");
                    fs::rename(&file, &elsewhere).map_err(wrong)?;
                    symlink(&elsewhere, &file).map_err(wrong)?;
                }
                fs::set_permissions(path, Permissions::from_mode(mode)).map_err(wrong)?;
                "a project that others may write"
            }
            Because::NotAsked => "a project that is not asked for",
            Because::WrongText => "a project whose text is wrong",
        };
        let mut victim = Victim::start(&self.command, &here, arguments)?;
        let status = victim.ends_within(ENDED).map_err(|finding| format!("{kind}: {finding}"))?;
        // A module that was started writes before it hears its greeting.
        look_at_canary(&canary).map_err(|finding| format!("{kind}, rpl {arguments:?}: a module ran: {finding}"))?;
        match (because, status.code()) {
            (Because::OthersMayWrite | Because::WrongText, Some(0)) if !mangled => {
                Err(format!("{kind}, rpl {arguments:?}: it is taken: {}", victim.errors()))
            }
            (_, Some(0..=3)) => Ok(kind),
            _ => Err(format!("{kind}, rpl {arguments:?}: it ended with {status}: {}", victim.errors())),
        }
    }

    fn end(&mut self) -> Result<(), String> {
        Ok(())
    }
}
