//! Lists the example plans, so that the command carries them in itself.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

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
    fs::write(Path::new(&variable("OUT_DIR")?).join("examples.rs"), list)
}

fn collect(folder: &Path, plans: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
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
