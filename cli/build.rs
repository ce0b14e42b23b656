//! Lists the example plans, so that the command carries them in itself, and says which version it is.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

fn main() -> io::Result<()> {
    let folder = Path::new(&variable("CARGO_MANIFEST_DIR")?).join("../examples");
    println!("cargo::rerun-if-changed={}", folder.display());
    let mut plans = Vec::new();
    collect(&folder, &mut plans)?;
    plans.sort();
    let mut list = String::from("&[\n");
    for plan in &plans {
        let name = plan.strip_prefix(&folder).map_err(io::Error::other)?;
        let name = name.to_string_lossy().replace('\\', "/");
        list += &format!("    ({name:?}, include_str!({:?})),\n", plan.display().to_string());
    }
    list += "]\n";
    fs::write(Path::new(&variable("OUT_DIR")?).join("examples.rs"), list)?;
    println!("cargo::rustc-env=RPL_VERSION={}", version()?);
    Ok(())
}

/// The version; with the commit if it is built for use, and from a copy of the repository. While the
/// program is worked on, a commit would only be that of the last build, and every new one would
/// build it again.
fn version() -> io::Result<String> {
    let version = variable("CARGO_PKG_VERSION")?;
    if variable("PROFILE")? != "release" {
        return Ok(version);
    }
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"]) {
        println!("cargo::rerun-if-changed={log}");
    }
    let commit = git(&["log", "-1", "--format=%h %cs"]);
    Ok(commit.map_or(version.clone(), |commit| format!("{version} ({commit})")))
}

/// What git answers; without git, or without a repository, there is no answer.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let answer = String::from_utf8(output.stdout).ok()?.trim().to_string();
    (output.status.success() && !answer.is_empty()).then_some(answer)
}

/// The plans of a folder, and of those in it; plans beside a manifest of a module or of a crate need what that
/// brings.
fn collect(folder: &Path, plans: &mut Vec<PathBuf>) -> io::Result<()> {
    let paths = fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<PathBuf>>>()?;
    if paths.iter().any(|path| path.extension().is_some_and(|extension| extension == "toml")) {
        return Ok(());
    }
    for path in paths {
        if path.is_dir() {
            collect(&path, plans)?;
        } else if path.extension().is_some_and(|extension| extension == "rpl") {
            plans.push(path);
        }
    }
    Ok(())
}

fn variable(name: &str) -> io::Result<String> {
    std::env::var(name).map_err(io::Error::other)
}
