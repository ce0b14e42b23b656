//! Says which version the command is, and of which sources.

#![expect(clippy::disallowed_methods, reason = "Cargo and the compiler read the paths, and no terminal")]

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

fn main() -> io::Result<()> {
    println!("cargo::rustc-env=RPL_VERSION={}", version()?);
    println!("cargo::rustc-env=RPL_SOURCES={:08x}", sources()?);
    Ok(())
}

/// Crates that are no part of the command.
const OUTSIDE: [&str; 3] = ["tests", "benches", "fuzz"];

/// The checksum of the crates' sources, of the plans that are built in, of the lock file, and of what the compiler and
/// the target are called: two builds that have it in common give the same run, wherever they were built. How far they
/// are optimized is left out, since it changes no result; that another target gives the same bits nobody has tried.
fn sources() -> io::Result<u32> {
    let root = Path::new(&variable("CARGO_MANIFEST_DIR")?).join("..");
    let mut parts = vec![root.join("Cargo.lock"), root.join("Cargo.toml"), root.join("examples")];
    let mut crates = paths_in(&root)?;
    crates.retain(|folder| folder.join("Cargo.toml").exists() && !OUTSIDE.iter().any(|name| folder.ends_with(name)));
    for folder in crates {
        parts.extend(paths_in(&folder)?.into_iter().filter(|part| !part.ends_with("tests")));
    }
    let mut files = Vec::new();
    for part in parts {
        println!("cargo::rerun-if-changed={}", part.display());
        files_of(part, &mut files)?;
    }
    let mut hasher = crc32fast::Hasher::new();
    for file in files {
        let name = file.strip_prefix(&root).map_err(io::Error::other)?;
        hasher.update(name.to_string_lossy().replace('\\', "/").as_bytes());
        hasher.update(&fs::read(&file)?);
    }
    let compiler = Command::new(variable("RUSTC")?).arg("-vV").output()?;
    hasher.update(&compiler.stdout);
    hasher.update(variable("TARGET")?.as_bytes());
    Ok(hasher.finalize())
}

/// A file, or the files of a folder and of those in it.
fn files_of(path: PathBuf, files: &mut Vec<PathBuf>) -> io::Result<()> {
    if !path.is_dir() {
        files.push(path);
        return Ok(());
    }
    paths_in(&path)?.into_iter().try_for_each(|inner| files_of(inner, files))
}

/// What is in a folder, in the order of the names.
fn paths_in(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut paths = fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<PathBuf>>>()?;
    paths.sort();
    Ok(paths)
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

fn variable(name: &str) -> io::Result<String> {
    std::env::var(name).map_err(io::Error::other)
}
