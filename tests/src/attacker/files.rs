//! Forged files and command lines: each is a process of its own with little memory and time.

use super::surface::{Judged, Surface};
use crate::forger::Case;
use crate::forger::judge::judge;
use crate::generated::Dice;
use std::path::{Path, PathBuf};

struct Files {
    command: PathBuf,
    folder: PathBuf,
}

pub(super) fn start(command: &Path, folder: &Path) -> Result<Box<dyn Surface>, String> {
    Ok(Box::new(Files { command: command.to_path_buf(), folder: folder.join("case") }))
}

impl Surface for Files {
    fn attack(&mut self, dice: &mut Dice) -> Judged {
        let seed = dice.below(usize::MAX) as u64;
        let case = Case::new(seed);
        match judge(&case, &self.command, &self.folder) {
            Ok(_) => Ok(case.kind),
            Err(finding) => Err(format!("case {seed}, {}: rpl {:?}: {finding}", case.kind, case.arguments)),
        }
    }

    fn end(&mut self) -> Result<(), String> {
        Ok(())
    }
}
