//! Lists the example plans, so that programs carry them in themselves.

#![expect(clippy::disallowed_methods, reason = "Cargo and the compiler read the paths, and no terminal")]

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

fn main() -> io::Result<()> {
    let folder = Path::new(&variable("CARGO_MANIFEST_DIR")?).join("../examples");
    println!("cargo::rerun-if-changed={}", folder.display());
    let mut plans = Vec::new();
    collect(&folder, &mut plans)?;
    let mut list = String::from("&[\n");
    for plan in &plans {
        let name = plan.strip_prefix(&folder).map_err(io::Error::other)?;
        let name = name.to_string_lossy().replace('\\', "/");
        list += &format!("    ({name:?}, include_str!({:?})),\n", plan.display().to_string());
    }
    list += "]\n";
    fs::write(Path::new(&variable("OUT_DIR")?).join("examples.rs"), list)
}

/// The plans of a folder, and of those in it; plans beside a manifest of a module or of a crate need what that
/// brings.
fn collect(folder: &Path, plans: &mut Vec<PathBuf>) -> io::Result<()> {
    let paths = paths_in(folder)?;
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

/// What is in a folder, in the order of the names.
fn paths_in(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut paths = fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<PathBuf>>>()?;
    paths.sort();
    Ok(paths)
}

fn variable(name: &str) -> io::Result<String> {
    std::env::var(name).map_err(io::Error::other)
}
