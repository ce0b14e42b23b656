//! Worlds and maps as a user hands them in, and forged inputs, a few of each kind; `cargo run -p
//! rpl-tests --example forged` tries many.

use rpl_tests::forger::{Case, judge::judge};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A folder of a test's own.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).expect("the folder can be made");
    folder
}

/// Exit status, output and messages of a command line.
fn rpl(folder: &Path, line: &str) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_rpl"))
        .current_dir(folder)
        .args(line.split_whitespace())
        .output()
        .expect("the command runs");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

const LAB: &str = "name = \"lab\"\nsize = [6.0, 4.0]\nstart = [1.0, 2.0, 0]\n\
    [[wall]]\nline = [[0, 0], [6, 0], [6, 4], [0, 4], [0, 0]]\n\
    [[object]]\nname = \"stove\"\nrect = [3, 1, 4, 3]\n\
    [[place]]\nname = \"Stove\"\npose = [3.5, 2.0, 0]\n";

#[test]
fn what_is_wrong_with_a_place_is_told_in_its_line_and_when_it_is_gone_to() {
    let folder = folder("places");
    fs::write(folder.join("lab.toml"), LAB).expect("the world can be written");
    let (status, shown, told) = rpl(&folder, "worlds lab.toml");
    assert_eq!((status, shown.starts_with("lab: 6.0 m by 4.0 m")), (Some(0), true), "{told}");
    let why = "at (3.50, 2.00) the robot does not fit: that is inside the object `stove`";
    let place = "warning: lab.toml:11:8: the robot cannot get from the start to the place `Stove`: ";
    assert!(told.starts_with(&format!("{place}{why}\n  11 | pose = [3.5, 2.0, 0]\n")), "{told}");
    fs::write(folder.join("go.rpl"), "(go-to 'Stove)").expect("the plan can be written");
    let (status, _, told) = rpl(&folder, "run go.rpl --world lab.toml --grid coarse");
    assert!(status == Some(1) && told.contains(&format!("unreachable: no way to `Stove`: {why}")), "{told}");
    let (status, _, told) = rpl(&folder, "worlds flat");
    assert_eq!((status, told.as_str()), (Some(0), ""));
}

#[test]
fn a_world_that_is_too_large_says_so_with_what_it_takes() {
    let folder = folder("large");
    let sized = |size: &str| format!("name = \"field\"\nsize = [{size}, {size}]\nstart = [1.0, 1.0, 0]\n");
    fs::write(folder.join("large.toml"), sized("600")).expect("the world can be written");
    fs::write(folder.join("plan.rpl"), "(print 1)").expect("the plan can be written");
    let (status, shown, told) = rpl(&folder, "run plan.rpl --world large.toml");
    assert_eq!((status, shown.as_str()), (Some(2), ""));
    for part in ["of 600 m by 600 m is too large", " GiB of memory and 3 min", "crop it", "--grid coarse", "--map none"]
    {
        assert!(told.contains(part), "{told}\nshould say: {part}");
    }
    assert_eq!(rpl(&folder, "run plan.rpl --world large.toml --map none").1, "1\n");
    let (status, shown, told) = rpl(&folder, "worlds large.toml");
    assert!(status == Some(0) && shown.starts_with("field: 600.0 m") && told.contains("too large"), "{told}");
    let (status, _, told) = rpl(&folder, "worlds large.toml --png large.png");
    assert!(status == Some(2) && told.contains("144 million pixels"), "{told}");
}

#[test]
fn a_map_says_how_its_greys_are_read() {
    let folder = folder("greys");
    let pixel =
        |index: usize| if index % 100 < 2 || index < 200 || index % 100 > 97 || index > 7_799 { 100 } else { 254 };
    let image: Vec<u8> = b"P5 100 80 255\n".iter().copied().chain((0..8_000).map(pixel)).collect();
    fs::write(folder.join("map.pgm"), image).expect("the image can be written");
    let yaml =
        "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
    fs::write(folder.join("map.yaml"), yaml).expect("the map can be written");
    let (status, shown, told) = rpl(&folder, "worlds map.yaml");
    assert!(shown.contains("map     100 by 80 cells of 0.05 m: 91.2 % free, 0.0 % occupied, 8.8 % unknown"), "{shown}");
    assert!(status == Some(0) && told.contains("warning: map.yaml: nothing in the map is occupied"), "{told}");
    assert!(told.contains("write `occupied_thresh: 0.4` (91.2 % free"), "{told}");
    fs::write(folder.join("map.yaml"), yaml.replace("0.65", "0.4")).expect("the map can be written");
    assert_eq!(rpl(&folder, "worlds map.yaml").2, "");
}

#[test]
fn forged_inputs_are_refused_in_words_or_used() {
    let folder = folder("forged");
    let mut refused = 0;
    for seed in 0..50 {
        let case = Case::new(seed);
        match judge(&case, Path::new(env!("CARGO_BIN_EXE_rpl")), &folder) {
            Ok(output) => refused += usize::from(output.status.code() == Some(2)),
            Err(finding) => panic!("seed {seed}, {}: rpl {:?}\n{finding}", case.kind, case.arguments),
        }
    }
    assert!(refused > 20, "{refused} of 50 were refused");
}
