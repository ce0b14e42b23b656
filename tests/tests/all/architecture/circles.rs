//! No files of a crate, and no folders, name each other in a circle.
//!
//! An arrow leads from a file that names an item to the file that defines it. A folder has the arrows of the files in
//! it, and of the file beside it that has its name. Rooms, files or folders, are in a circle if each leads to each
//! other. What a folder's root file hands on makes no arrow; what it uses does, so that its files may use its items only
//! where it uses none of theirs. Tests do not count.

use crate::architecture::arrows::{Arrows, arrows};
use crate::architecture::modules::Modules;
use rayon::prelude::*;
use rpl_tests::repository::{root, text_of};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

/// Circles that are in the matter, and why. What is listed without need fails the test.
const EXCEPTIONS: &[(&[&str], &str)] = &[(
    &["cli/src/commands/doc.rs", "cli/src/commands/mod.rs"],
    "`rpl doc` documents, and completes, the command line that it is a part of",
)];

/// The rooms of each circle, and what ties them.
type Circles = BTreeMap<BTreeSet<String>, Vec<String>>;

#[test]
fn no_files_and_no_folders_name_each_other_in_a_circle() {
    let text = |file: &str| fs::read_to_string(root().join(file)).ok();
    let of_crate = |root: &String| circles(&Modules::of_crate(root, &text));
    let all: Circles = crate_roots().par_iter().flat_map_iter(of_crate).collect();
    let is_listed = |rooms: &BTreeSet<String>| EXCEPTIONS.iter().any(|(files, _)| rooms.iter().eq(files.iter()));
    let told: Vec<String> = all.iter().filter(|(rooms, _)| !is_listed(rooms)).map(told).collect();
    assert!(told.is_empty(), "circles:\n{}", told.join("\n"));
    let is_needless = |(files, _): &&(&[&str], &str)| !all.keys().any(|rooms| rooms.iter().eq(files.iter()));
    let needless: Vec<&(&[&str], &str)> = EXCEPTIONS.iter().filter(is_needless).collect();
    assert!(needless.is_empty(), "listed as exceptions, and there is no circle: {needless:?}");
}

#[test]
fn a_circle_is_found_however_its_names_are_taken() {
    let one = ("b/one.rs", "pub struct One(pub super::super::a::Two);");
    let handed_on = ("b/mod.rs", "mod one;\npub use one::One;");
    let circle = ["a.rs + b", "a.rs + b/one.rs"];
    assert_eq!(found(&[("a.rs", "use crate::b::One; pub struct Two;"), handed_on, one]), circle);
    assert_eq!(found(&[("a.rs", "pub struct Two; fn two(_: crate::b::One) {}"), handed_on, one]), circle);
    assert_eq!(found(&[("a.rs", "use crate::b; pub struct Two; fn two(_: b::One) {}"), handed_on, one]), circle);
    assert_eq!(found(&[("a.rs", "use super::b::*; pub struct Two; fn two(_: One) {}"), handed_on, one]), circle);
    let commented =
        "/* use crate::b::One; */ pub struct Two; const TEXT: &str = r#\"crate::b::One\"#; // crate::b::One";
    assert_eq!(found(&[("a.rs", commented), handed_on, one]), [""; 0]);
    let tested = "pub struct Two;\n#[cfg(test)]\nmod tests { use crate::b::One; }";
    assert_eq!(found(&[("a.rs", tested), handed_on, one]), [""; 0]);
}

#[test]
fn a_folder_is_a_room_and_its_root_file_one_of_its_rooms() {
    let (low, high) = (("b/low.rs", "pub struct Low;"), ("b/high.rs", "use crate::a::Two; pub struct High;"));
    let (a, root) = (("a.rs", "use crate::b::low::Low; pub struct Two;"), ("b/mod.rs", "pub mod low; pub mod high;"));
    assert_eq!(found(&[a, root, low, high]), ["a.rs + b"]);
    let (a, child) = (("a.rs", ""), ("b/child.rs", "use super::Parent; pub struct Child;"));
    let hands_on = ("b/mod.rs", "mod child; pub use child::Child; pub struct Parent;");
    assert_eq!(found(&[a, hands_on, child]), [""; 0]);
    let uses = ("b/mod.rs", "mod child; pub use child::Child; pub struct Parent; fn parent(_: Child) {}");
    assert_eq!(found(&[a, uses, child]), ["b/child.rs + b/mod.rs"]);
}

/// The circles of a crate with the modules `a` and `b` whose files have these texts.
fn found(files: &[(&str, &str)]) -> Vec<String> {
    let texts: BTreeMap<&str, &str> = files.iter().copied().chain([("lib.rs", "mod a; mod b;")]).collect();
    let text = |file: &str| texts.get(file.strip_prefix("sample/")?).map(|text| (*text).to_string());
    let circles = circles(&Modules::of_crate("sample/lib.rs", &text));
    let without_crate = |room: &String| room.strip_prefix("sample/").unwrap_or(room).to_string();
    circles.keys().map(|rooms| rooms.iter().map(without_crate).collect::<Vec<_>>().join(" + ")).collect()
}

/// The root files of the workspace's crates, from its root.
fn crate_roots() -> Vec<String> {
    let manifest = text_of("Cargo.toml");
    let members = manifest.split_once("\nmembers = [").and_then(|(_, rest)| rest.split_once(']'));
    let (members, _) = members.expect("the workspace lists its members");
    let members = members.split('"').skip(1).step_by(2);
    members
        .flat_map(|member| {
            let places = ["src/lib.rs", "src/main.rs", "lib.rs"].map(|place| format!("{member}/{place}"));
            let roots: Vec<String> = places.into_iter().filter(|place| root().join(place).is_file()).collect();
            assert!(!roots.is_empty(), "{member} has no root file");
            roots
        })
        .collect()
}

fn told((rooms, ties): (&BTreeSet<String>, &Vec<String>)) -> String {
    let rooms: Vec<&str> = rooms.iter().map(String::as_str).collect();
    format!("{}\n  {}", rooms.join(", "), ties.join("\n  "))
}

/// The circles between all files of a crate, and those between what each of its folders holds.
fn circles(modules: &Modules) -> Circles {
    let arrows = arrows(modules);
    let files: BTreeSet<&str> = modules.0.iter().map(|module| module.file.as_str()).collect();
    let folders: BTreeSet<&str> = files.iter().flat_map(|file| folders_of(file)).collect();
    let mut circles = circles_of_rooms(&arrows, |file| Some(file.to_string()));
    for folder in &folders {
        circles.extend(circles_of_rooms(&arrows, |file| {
            let (name, is_file) = match file.strip_prefix(folder)?.strip_prefix('/')?.split_once('/') {
                Some((name, _)) => (name, false),
                None => (&file[folder.len() + 1..], true),
            };
            let room = format!("{folder}/{name}");
            let beside = room.strip_suffix(".rs").filter(|beside| is_file && folders.contains(beside));
            Some(beside.map_or(room.clone(), str::to_string))
        }));
    }
    circles
}

/// The folders around a file.
fn folders_of(file: &str) -> impl Iterator<Item = &str> {
    file.match_indices('/').map(|(end, _)| &file[..end])
}

/// The circles between the rooms in which files lie; what lies in none does not count.
fn circles_of_rooms(arrows: &Arrows, room_of: impl Fn(&str) -> Option<String>) -> Circles {
    let mut passages: BTreeMap<(String, String), Vec<String>> = BTreeMap::new();
    for ((from, to), names) in arrows {
        let (Some(one), Some(other)) = (room_of(from), room_of(to)) else {
            continue;
        };
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let tie = format!("{from} -> {to}: {}", names.join(", "));
        passages.entry((one, other)).or_default().push(tie);
    }
    passages.retain(|(one, other), _| one != other);
    let mut circles = Circles::new();
    for rooms in components(passages.keys()) {
        let inside = passages.iter().filter(|((one, other), _)| rooms.contains(one) && rooms.contains(other));
        circles.insert(rooms.clone(), inside.flat_map(|(_, ties)| ties.clone()).collect());
    }
    circles
}

/// The sets of two rooms or more of which each leads to each.
fn components<'r>(passages: impl Iterator<Item = &'r (String, String)> + Clone) -> BTreeSet<BTreeSet<String>> {
    let mut onwards: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    let mut backwards: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (one, other) in passages {
        onwards.entry(one).or_default().push(other);
        backwards.entry(other).or_default().push(one);
    }
    let mut found: BTreeSet<BTreeSet<String>> = BTreeSet::new();
    for &room in onwards.keys() {
        if !found.iter().any(|rooms| rooms.contains(room)) {
            let (reached, reaching) = (reached(&onwards, room), reached(&backwards, room));
            let rooms: BTreeSet<String> = reached.intersection(&reaching).map(|room| (*room).to_string()).collect();
            found.extend((rooms.len() > 1).then_some(rooms));
        }
    }
    found
}

/// Where one comes from a room.
fn reached<'r>(passages: &BTreeMap<&'r str, Vec<&'r str>>, room: &'r str) -> BTreeSet<&'r str> {
    let (mut reached, mut open) = (BTreeSet::new(), vec![room]);
    while let Some(room) = open.pop() {
        open.extend(passages.get(room).into_iter().flatten().copied().filter(|next| reached.insert(*next)));
    }
    reached
}
