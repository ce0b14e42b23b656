//! What the texts of a project are for, as long as they are written: a plan that has changed is read again, and no other.

use rpl_shell::arguments::plan_files;
use rpl_shell::files::inputs::read_text;
use rpl_shell::files::project_file::ProjectFile;
use rpl_shell::files::roles::{Role, Roles, scenarios_of};
use std::collections::BTreeMap;
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

    /// What one of its texts is for.
    pub fn role(&self, path: &Path) -> Role {
        self.roles.role(&path.to_string_lossy())
    }

    /// Plans, of this project or not, or the project itself have changed; whether a text is for something else now.
    /// Cost: that of reading those plans.
    pub fn changed(&mut self, plans: &[&PathBuf]) -> bool {
        for plan in plans {
            if plan_files::is_of(self.folder(), plan) {
                self.read(plan);
            }
        }
        let before = std::mem::take(&mut self.roles);
        self.roles = self.said();
        self.roles != before
    }

    fn folder(&self) -> &Path {
        self.file.parent().unwrap_or(&self.file)
    }

    fn read(&mut self, plan: &Path) {
        let text = read_text(plan).unwrap_or_default();
        match scenarios_of(&plan.to_string_lossy(), &text) {
            none if none.is_empty() => self.scenarios.remove(plan),
            scenarios => self.scenarios.insert(plan.to_path_buf(), scenarios),
        };
    }

    fn said(&self) -> Roles {
        Roles::with(ProjectFile::read(&self.file).ok().as_ref(), self.scenarios.values().flatten().cloned())
    }
}
