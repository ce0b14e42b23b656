//! Files that somebody else may have written. One that can start programs, and that nobody named, is used only where
//! that is ruled out, as git and ssh do it.

use crate::files::shown::Shown;
use std::io;
use std::path::Path;

/// Why somebody else may have written a file, as a clause; none if only this user and the administrator can have. A
/// link is looked at with the file it leads to, and a file with the folder that it lies in.
///
/// # Errors
/// It is not there, or cannot be looked at.
#[cfg(unix)]
pub fn why_foreign(path: &Path) -> io::Result<Option<String>> {
    use super::accounts::Accounts;
    use rustix::process::geteuid;
    use std::os::unix::fs::MetadataExt;

    let folder_of = |path: &Path| match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
        Some(_) | None => Path::new(".").to_path_buf(),
    };
    let (accounts, me) = (Accounts::of_system(), geteuid().as_raw());
    let behind_sudo = std::env::var("SUDO_UID").ok().and_then(|uid| uid.parse().ok()).filter(|_| me == 0);
    let may_write = |uid: u32| uid == me || uid == 0 || Some(uid) == behind_sudo;
    let (link, there) = (path.symlink_metadata()?, path.canonicalize()?);
    if !may_write(link.uid()) {
        return Ok(Some(format!("`{}` belongs to {}", path.shown(), accounts.name_of(link.uid()))));
    }
    let mut places = vec![there.clone(), folder_of(path), folder_of(&there)];
    places.dedup();
    for place in places {
        let (known, shown) = (place.metadata()?, place.shown());
        let what = if known.is_dir() { "folder" } else { "file" };
        if !may_write(known.uid()) {
            return Ok(Some(format!("the {what} `{shown}` belongs to {}", accounts.name_of(known.uid()))));
        }
        if known.mode() & 0o002 != 0 {
            return Ok(Some(format!("everybody may write the {what} `{shown}`")));
        }
        if known.mode() & 0o020 != 0 && !accounts.is_private(known.gid(), known.uid()) {
            return Ok(Some(format!("the group {} may write the {what} `{shown}`", accounts.group_name(known.gid()))));
        }
    }
    Ok(None)
}

/// Elsewhere there is nothing to see it by.
///
/// # Errors
/// None.
#[cfg(not(unix))]
pub fn why_foreign(_: &Path) -> io::Result<Option<String>> {
    Ok(None)
}
