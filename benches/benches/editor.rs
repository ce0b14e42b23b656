//! Typing in a long plan, and the first findings in one: what the language server computes, in processor time.

use rpl_benches::{Question, Report, median_ms};
use rpl_editor::lsp::messages::{Heard, Notification, Request, RequestId};
use rpl_editor::lsp::session::Session;
use rpl_editor::surroundings::{Setting, Surroundings, Version};
use rpl_lang::check::KnownPlaces;
use rpl_lang::compile::{Loader, NoFiles};
use rpl_mission::reference::Reference;
use rpl_mission::site::Site;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

const URI: &str = "file:///plan.rpl";

/// Keystrokes; the median counts.
const KEYSTROKES: usize = 21;

struct Files(Arc<Setting>);

impl Files {
    /// What the server puts together when it starts.
    fn new() -> Self {
        let libraries = [Site::without_robot(), Site::for_checking(Vec::new())];
        let libraries = libraries.map(|site| site.unwrap_or_else(|error| panic!("{error}")).library).to_vec();
        let reference = Reference::of(&libraries[1]);
        Self(Arc::new(Setting { libraries, reference, world: None, is_of_plans: true }))
    }
}

impl Surroundings for Files {
    fn setting(&self, _: &Path) -> Result<Arc<Setting>, String> {
        Ok(self.0.clone())
    }

    fn loader(&self, _: &Path) -> Box<dyn Loader> {
        Box::new(NoFiles)
    }

    fn places(&self, _: &Path, _: Option<&str>) -> Option<KnownPlaces> {
        None
    }

    fn library_file(&self, _: &str, _: &str) -> Option<PathBuf> {
        None
    }

    fn is_library_file(&self, _: &Path) -> bool {
        false
    }

    fn plans_below(&self, _: &Path) -> Vec<(PathBuf, Version)> {
        Vec::new()
    }

    fn text(&self, _: &Path) -> Option<String> {
        None
    }

    fn files_changed(&self, _: &[PathBuf]) -> bool {
        false
    }
}

/// A plan of `lines` lines: plans with variables, handlers, loops and the robot.
fn plan(lines: usize) -> String {
    let mut text = String::new();
    let mut number = 0;
    while text.lines().count() < lines {
        // Counting lines is quick for as many as are asked for here.
        for _ in 0..50 {
            write!(
                text,
                "(def-plan deliver-{number} (from to)
  \"Brings what is at `from` to `to`.\"
  (let ((tries 0)
        (limit {number}))
    (with-failure-handling ((navigation-failure (f) (incf tries) (when (< tries limit) (retry))))
      (go-to from)
      (unless (< (value pos-certainty*) 0.5)
        (dolist (x (list 1 2 3))
          (print (format \"~a ~a\" x tries))))
      (go-to to))))\n\n"
            )
            .unwrap_or_else(|error| panic!("{error}"));
            number += 1;
        }
    }
    text + "(deliver-0 'a 'b)\n"
}

fn notify(session: &mut Session<'_>, method: &str, params: Value) {
    session.hear(Heard::Notification(Notification { method: method.to_string(), params }));
}

fn ask(session: &mut Session<'_>, method: &str, params: Value) {
    session.hear(Heard::Request(Request { id: RequestId::Number(1), method: method.to_string(), params }));
    // What is said is written.
    session.take_said().iter().for_each(|said| drop(serde_json::to_string(said)));
}

fn opened<'s>(files: &'s Files, text: &str) -> Session<'s> {
    let mut session = Session::new(files);
    ask(&mut session, "initialize", json!({ "capabilities": {} }));
    let document = json!({ "uri": URI, "languageId": "rpl", "version": 1, "text": text });
    notify(&mut session, "textDocument/didOpen", json!({ "textDocument": document }));
    session
}

fn look(session: &mut Session<'_>) {
    while session.waits().is_some() {
        session.look();
    }
    session.take_said().iter().for_each(|said| drop(serde_json::to_string(said)));
}

/// Milliseconds of processor time, the median of several rounds.
fn ms(rounds: usize, mut round: impl FnMut()) -> f64 {
    median_ms(rounds, || (), |()| round())
}

fn key(session: &mut Session<'_>, version: &mut i64) {
    *version += 1;
    let place = json!({ "line": 4_000, "character": 3 });
    let change = json!({ "range": { "start": place, "end": place }, "text": "x" });
    let document = json!({ "uri": URI, "version": *version });
    notify(session, "textDocument/didChange", json!({ "textDocument": document, "contentChanges": [change] }));
}

fn main() {
    let report = Report::from_arguments();
    let question = |name, what, target| Question::new(name, what, "ms", target, "–");
    let (short, long) = (plan(2_000), plan(10_000));
    report.row(question("first", "from the start of the server to the findings of 2,000 lines", 100.0), || {
        ms(5, || look(&mut opened(&Files::new(), &short)))
    });
    let files = Files::new();
    let mut version = 1;
    report.row(question("key", "a keystroke in 10,000 lines: its completion, signature and colours", 50.0), || {
        let mut session = opened(&files, &long);
        look(&mut session);
        ms(KEYSTROKES, || {
            key(&mut session, &mut version);
            let at = json!({ "textDocument": { "uri": URI }, "position": { "line": 4_000, "character": 4 } });
            let seen = json!({ "textDocument": { "uri": URI }, "range": { "start": { "line": 3_970, "character": 0 }, "end": { "line": 4_030, "character": 0 } } });
            ask(&mut session, "textDocument/completion", at.clone());
            ask(&mut session, "textDocument/signatureHelp", at);
            ask(&mut session, "textDocument/semanticTokens/range", seen);
            ask(&mut session, "textDocument/foldingRange", json!({ "textDocument": { "uri": URI } }));
        })
    });
    report.row(question("pause", "the findings of 10,000 lines, when typing pauses", 200.0), || {
        let mut session = opened(&files, &long);
        look(&mut session);
        ms(KEYSTROKES, || {
            key(&mut session, &mut version);
            look(&mut session);
        })
    });
    report.row(question("key-short", "a keystroke in 2,000 lines and its findings", 50.0), || {
        let mut session = opened(&files, &short);
        look(&mut session);
        ms(KEYSTROKES, || {
            version += 1;
            let place = json!({ "line": 1_000, "character": 0 });
            let change = json!({ "range": { "start": place, "end": place }, "text": " " });
            let document = json!({ "uri": URI, "version": version });
            let params = json!({ "textDocument": document, "contentChanges": [change] });
            notify(&mut session, "textDocument/didChange", params);
            look(&mut session);
        })
    });
    report.row(question("names", "where the names of 10,000 lines stand and what they mean", 200.0), || {
        let mut session = opened(&files, &long);
        look(&mut session);
        ms(5, || {
            key(&mut session, &mut version);
            let at = json!({ "textDocument": { "uri": URI }, "position": { "line": 1, "character": 12 }, "context": { "includeDeclaration": true } });
            ask(&mut session, "textDocument/references", at);
        })
    });
}
