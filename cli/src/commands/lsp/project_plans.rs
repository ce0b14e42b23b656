//! The purpose of each text of a project, as long as they are written: a plan that has changed is read again, and no
//! other.

use rpl_shell::arguments::plan_files;
use rpl_shell::files::inputs::read_text;
use rpl_shell::files::project_file::ProjectFile;
use rpl_shell::files::roles::{Role, Roles, scenarios_of};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The plans of a project.
pub struct ProjectPlans {
    /// The file of the project.
    file: PathBuf,
    /// For each plan whose tests name scenarios, which ones.
    scenarios: BTreeMap<PathBuf, Vec<String>>,
    roles: Roles,
}

impl ProjectPlans {
    /// Of a project by its file. Cost: that of reading its plans.
    pub fn of(file: &Path) -> Self {
        let mut known = Self { file: file.to_path_buf(), scenarios: BTreeMap::new(), roles: Roles::default() };
        let folder = known.folder().to_string_lossy().into_owned();
        for plan in plan_files::named(&[folder]).iter().flatten() {
            known.read(Path::new(plan));
        }
        known.roles = known.said();
        known
    }

    /// The purpose of one of its texts.
    pub fn role(&self, path: &Path) -> Role {
        self.roles.role(&path.to_string_lossy())
    }

    /// Plans, of this project or not, have changed; whether a text is for something else now. Cost: that of reading those
    /// plans, and more only if they name other scenarios than before.
    pub fn plans_changed(&mut self, plans: &[&PathBuf]) -> bool {
        let mut name_others = false;
        for plan in plans {
            name_others |= plan_files::is_of(self.folder(), plan) && self.read(plan);
        }
        name_others && self.project_changed()
    }

    /// The file of the project may say another thing now; whether a text is for something else.
    pub fn project_changed(&mut self) -> bool {
        let said = self.said();
        std::mem::replace(&mut self.roles, said.clone()) != said
    }

    fn folder(&self) -> &Path {
        self.file.parent().unwrap_or(&self.file)
    }

    /// Reads a plan; whether its tests name other scenarios than before.
    fn read(&mut self, plan: &Path) -> bool {
        let text = read_text(plan).unwrap_or_default();
        let scenarios = scenarios_of(&plan.to_string_lossy(), &text);
        let before = match scenarios.is_empty() {
            true => self.scenarios.remove(plan),
            false => self.scenarios.insert(plan.to_path_buf(), scenarios.clone()),
        };
        before.unwrap_or_default() != scenarios
    }

    fn said(&self) -> Roles {
        let named: BTreeSet<String> = self.scenarios.values().flatten().cloned().collect();
        Roles::with(ProjectFile::read(&self.file).ok().as_ref(), named.into_iter())
    }
}
