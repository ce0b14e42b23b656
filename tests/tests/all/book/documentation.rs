//! The documents tell the truth: their code runs and prints what stands below it, their tables are
//! the code's, their links lead somewhere, and each clause of the reference has a label of its own.

use rpl_lang::check::{KnownPlaces, RULES};
use rpl_lang::compile::NoFiles;
use rpl_mission::site::Site;
use rpl_robot::description::RobotDescription;
use rpl_robot::office::{OfficeModel, OfficeSettings};
use rpl_robot::world::World;
use rpl_runtime::run::library::Library;
use rpl_runtime::state::failure::CLASSES;
use rpl_tests::mission::robot_library;
use rpl_tests::repository::{root, text_of};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;

/// A document by its path from the root.
struct Document {
    name: String,
    text: String,
}

/// A fenced block: what is said of it after the fence, its text, and the line of its first line.
struct Block {
    info: String,
    text: String,
    line: usize,
    /// Only blank lines stand between the block before and this one.
    follows: bool,
}

fn read(name: &str) -> Document {
    Document { name: name.to_string(), text: text_of(name) }
}

fn documents() -> Vec<Document> {
    let mut names: Vec<String> =
        ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(str::to_string).to_vec();
    let book = fs::read_dir(root().join("docs")).expect("the book is in docs/");
    let mut chapters: Vec<String> = book
        .map(|entry| entry.expect("a folder can be read").file_name().to_string_lossy().into_owned())
        .filter(|name| name.ends_with(".md"))
        .map(|name| format!("docs/{name}"))
        .collect();
    chapters.sort();
    names.extend(chapters);
    names.iter().map(|name| read(name)).collect()
}

fn blocks(document: &Document) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut open: Option<Block> = None;
    let mut only_blank = false;
    for (number, line) in document.text.lines().enumerate() {
        match (&mut open, line.strip_prefix("```")) {
            (None, Some(info)) => {
                open =
                    Some(Block { info: info.to_string(), text: String::new(), line: number + 2, follows: only_blank });
            }
            (Some(_), Some("")) => {
                blocks.extend(open.take());
                only_blank = true;
            }
            (Some(block), _) => {
                block.text.push_str(line);
                block.text.push('\n');
            }
            (None, None) => only_blank &= line.trim().is_empty(),
        }
    }
    assert!(open.is_none(), "{}: a block is not closed", document.name);
    blocks
}

/// Looks at every block of a kind, with the text block that follows it, and shows all faults at once.
fn each_block(infos: &[&str], mut fault: impl FnMut(&str, &Block, Option<&str>) -> Option<String>) {
    let mut faults = Vec::new();
    for document in documents() {
        let blocks = blocks(&document);
        for (at, block) in blocks.iter().enumerate() {
            let result = blocks.get(at + 1).filter(|next| next.follows && next.info == "text");
            let place = format!("{}:{}", document.name, block.line);
            if infos.contains(&block.info.as_str()) {
                let fault = fault(&place, block, result.map(|result| result.text.trim_end()));
                faults.extend(fault.map(|fault| format!("{place}: {fault}")));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n\n"));
}

/// Compares what is there with what the document shows.
fn differs(found: &str, shown: Option<&str>) -> Option<String> {
    match shown {
        Some(shown) if shown == found => None,
        Some(shown) => Some(format!("shown is\n{shown}\nand it is\n{found}")),
        None => Some(format!("it is not shown that it is\n{found}")),
    }
}

fn faults_of(library: &Library, place: &str, text: &str) -> Option<String> {
    library.load(place, text, &mut NoFiles).err().map(|rejected| rejected.render(false))
}

#[test]
fn plans_run_and_print_what_stands_below_them() {
    each_block(&["lisp"], |_, block, shown| {
        let transcript = rpl_tests::run(&block.text);
        let (printed, ending) = transcript.rsplit_once('\n').unwrap_or(("", &transcript));
        if !ending.starts_with("=> ") {
            return Some(transcript);
        }
        differs(printed, Some(shown?))
    });
}

#[test]
fn plans_with_an_error_show_it() {
    each_block(&["lisp error"], |_, block, shown| differs(rpl_tests::run(&block.text).trim_end(), shown));
}

#[test]
fn warnings_are_those_of_the_check() {
    let library = robot_library();
    let world = World::builtin("dept").expect("the world is there");
    let names = world.places.iter().map(|place| place.name.clone()).collect();
    let places = KnownPlaces { world: world.name, names };
    each_block(&["lisp check"], |_, block, shown| {
        let (findings, program) = library.check("plan.rpl", &block.text, Some(&places), &mut NoFiles);
        differs(rpl_lang::diagnostic::render(&findings, &program.sources, false).trim_end(), shown)
    });
}

#[test]
fn every_rule_of_the_check_has_its_example() {
    let chapter = read("docs/warnings.md").text;
    for rule in RULES {
        let section = chapter.split(&format!("\n## {rule}\n")).nth(1).unwrap_or_else(|| panic!("{rule} is missing"));
        let section = section.split("\n## ").next().unwrap_or_default();
        assert!(section.contains(&format!("\nwarning[{rule}]: ")), "{rule} has no example");
    }
    assert_eq!(chapter.matches("\n## ").count(), RULES.len(), "a section of docs/warnings.md is no rule");
}

#[test]
fn plans_for_the_robot_compile() {
    let library = robot_library();
    each_block(&["lisp robot"], |place, block, _| faults_of(&library, place, &block.text));
}

#[test]
fn scenarios_compile() {
    let library = Site::for_checking_scenarios().expect("the library compiles").library;
    each_block(&["lisp scenario"], |place, block, _| faults_of(&library, place, &block.text));
}

#[test]
fn worlds_are_read() {
    each_block(&["toml", "toml warning"], |_, block, _| {
        World::parse(&block.text, "lab.toml").err().map(|error| error.to_string())
    });
}

#[test]
fn robots_are_read() {
    each_block(&["toml robot"], |_, block, _| {
        RobotDescription::parse(&block.text, "robot.toml").err().map(|error| error.to_string())
    });
}

#[test]
fn settings_are_json() {
    each_block(&["json"], |_, block, _| {
        serde_json::from_str::<serde_json::Value>(&block.text).err().map(|error| error.to_string())
    });
}

#[test]
fn faults_of_worlds_are_shown() {
    each_block(&["toml error"], |_, block, shown| {
        let found = World::parse(&block.text, "lab.toml").map_or_else(|error| error.to_string(), |_| "no fault".into());
        differs(&found, shown)
    });
}

#[test]
fn warnings_of_worlds_are_shown() {
    each_block(&["toml warning"], |_, block, shown| {
        let world = Arc::new(World::parse(&block.text, "lab.toml").ok()?);
        let concerns = OfficeModel::survey(&world, &OfficeSettings::default());
        let told = concerns.iter().map(|concern| format!("warning: {}", concern.in_file("lab.toml", &block.text)));
        differs(&told.collect::<Vec<_>>().join("\n"), shown)
    });
}

#[test]
fn what_is_shown_of_a_file_stands_in_it() {
    let mut shown = 0;
    for document in documents() {
        for block in blocks(&document) {
            let Some((_, file)) = block.info.split_once(" from ") else { continue };
            let there = read(file).text;
            assert!(there.contains(&block.text), "{}:{} is not in {file}", document.name, block.line);
            shown += 1;
        }
    }
    assert!(shown > 0, "no document shows a part of a file");
}

#[test]
fn every_block_is_of_a_kind_that_is_checked() {
    // The sessions at the prompt and in the terminal are typed by the tests of the command.
    let known = [
        "lisp",
        "lisp error",
        "lisp check",
        "lisp robot",
        "lisp scenario",
        "session",
        "terminal",
        "toml",
        "toml error",
        "toml robot",
        "toml warning",
        "json",
        "text",
        "sh",
        "rust",
        "python",
    ];
    for document in documents() {
        for block in blocks(&document) {
            let kind = if block.info.starts_with("session ") { "session" } else { block.info.as_str() };
            let kind = kind.split_once(" from ").map_or(kind, |(language, _)| language);
            assert!(known.contains(&kind), "{}:{}: `{}`", document.name, block.line, block.info);
        }
    }
}

/// Labels of clauses, each with the lines it stands on.
fn labels(text: &str) -> BTreeMap<&str, Vec<usize>> {
    let mut labels: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (number, line) in text.lines().enumerate() {
        if let Some((label, _)) = line.strip_prefix("`r[").and_then(|rest| rest.split_once("]`")) {
            labels.entry(label).or_default().push(number + 1);
        }
    }
    labels
}

#[test]
fn every_clause_of_the_reference_has_a_label_of_its_own() {
    let reference = read("docs/language.md");
    let labels = labels(&reference.text);
    for (label, lines) in &labels {
        println!("{label}");
        assert_eq!(lines.len(), 1, "the label {label} stands on the lines {lines:?}");
        let is_well_formed = label.contains('.')
            && label.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || matches!(c, '.' | '-'));
        assert!(is_well_formed, "the label {label} is not of the form `topic.clause`");
    }
    let everywhere = reference.text.matches("`r[").count();
    assert_eq!(everywhere, labels.len(), "a label stands elsewhere than at the begin of its clause");
    assert!(labels.len() > 100, "the reference has {} clauses", labels.len());
}

#[test]
fn the_reference_names_every_failure_class() {
    let reference = read("docs/language.md").text;
    for (class, ..) in CLASSES {
        assert!(reference.contains(&format!("`{class}`")), "the class `{class}` is missing");
    }
}

#[test]
fn links_lead_somewhere() {
    for document in documents() {
        let folder = root().join(&document.name).parent().map(Path::to_path_buf).unwrap_or_default();
        for link in document.text.split("](").skip(1) {
            let target = link.split(')').next().unwrap_or_default();
            let (path, _) = target.split_once('#').unwrap_or((target, ""));
            if path.is_empty() || path.contains("://") {
                continue;
            }
            assert!(folder.join(path).exists(), "{}: there is no `{path}`", document.name);
        }
    }
}
