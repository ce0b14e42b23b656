//! An editor as a script: what it says to a session, and what it hears.

use rpl_editor::lsp::messages::{Heard, Notification, Request, RequestId, Response, Said};
use rpl_editor::lsp::session::Session;
use rpl_editor::surroundings::{Setting, Surroundings, Version};
use rpl_lang::check::KnownPlaces;
use rpl_lang::compile::{Loader, NoFiles};
use rpl_mission::reference::Reference;
use rpl_mission::site::Site;
use rpl_robot::world::World;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

/// The file that a session has open.
pub const FILE: &str = "file:///plans/plan.rpl";

/// Files in memory, and no project.
#[derive(Default)]
pub struct Files(pub BTreeMap<&'static str, &'static str>);

struct Beside(BTreeMap<&'static str, &'static str>);

impl Loader for Beside {
    fn load(&mut self, _: &str, path: &str) -> Result<(String, String), String> {
        let text = self.0.get(path).ok_or("there is no such file")?;
        Ok((format!("/plans/{path}"), text.to_string()))
    }
}

impl Surroundings for Files {
    fn setting(&self, _: &Path) -> Result<Arc<Setting>, String> {
        static SETTING: LazyLock<Arc<Setting>> = LazyLock::new(|| {
            let robotless = Site::without_robot().expect("the library compiles").library;
            let robot = Site::for_checking(Vec::new()).expect("the library compiles").library;
            let reference = Reference::of(&robot);
            Arc::new(Setting { libraries: vec![robotless, robot], reference, world: None, is_of_plans: true })
        });
        Ok(SETTING.clone())
    }

    fn loader(&self, path: &Path) -> Box<dyn Loader> {
        if path.as_os_str().is_empty() { Box::new(NoFiles) } else { Box::new(Beside(self.0.clone())) }
    }

    fn places(&self, _: &Path, world: Option<&str>) -> Option<KnownPlaces> {
        let world = World::builtin(world.unwrap_or("dept"))?;
        let names = world.places.iter().map(|place| place.name.clone()).collect();
        Some(KnownPlaces { names, world: world.name })
    }

    fn library_file(&self, name: &str, _: &str) -> Option<PathBuf> {
        Some(Path::new("/library").join(name))
    }

    fn is_library_file(&self, path: &Path) -> bool {
        path.starts_with("/library")
    }

    fn plans_below(&self, folder: &Path) -> Vec<(PathBuf, Version)> {
        let plans = self.0.iter().map(|(name, text)| (Path::new("/plans").join(name), (None, text.len() as u64)));
        plans.filter(|(path, _)| path.starts_with(folder)).collect()
    }

    fn text(&self, path: &Path) -> Option<String> {
        self.0.get(path.file_name()?.to_str()?).map(ToString::to_string)
    }

    fn files_changed(&self, files: &[PathBuf]) -> bool {
        files.iter().any(|file| file.extension().is_some_and(|extension| extension == "toml"))
    }
}

/// A session and its editor.
pub struct Client<'s> {
    pub session: Session<'s>,
    requests: i32,
    version: i32,
    /// The text as the editor has it.
    text: String,
    heard: Vec<Notification>,
    /// What the server has asked for.
    pub asked: Vec<Request>,
}

impl<'s> Client<'s> {
    /// An editor that has begun a session.
    pub fn new(files: &'s Files) -> Self {
        Self::saying(files, json!({ "capabilities": {} })).0
    }

    /// An editor that has begun a session with what it says of itself, and what the server says of itself.
    pub fn saying(files: &'s Files, says: Value) -> (Self, Value) {
        let session = Session::new(files);
        let (text, heard, asked) = (String::new(), Vec::new(), Vec::new());
        let mut client = Self { session, requests: 0, version: 0, text, heard, asked };
        let said = client.request("initialize", says).expect("it is answered");
        client.notify("initialized", json!({}));
        client.looked();
        (client, said)
    }

    /// An editor with a text open, in which `|` marks the place that [`Client::at_mark`] asks about.
    pub fn with(files: &'s Files, text: &str) -> Self {
        let mut client = Self::reading(files, &text.replacen('|', "", 1));
        client.text = text.to_string();
        client
    }

    /// An editor with a text open as it stands.
    pub fn reading(files: &'s Files, text: &str) -> Self {
        let mut client = Self::new(files);
        client.open(text);
        client
    }

    fn open(&mut self, text: &str) {
        self.open_at(FILE, text);
    }

    /// Opens one more text.
    pub fn open_at(&mut self, uri: &str, text: &str) {
        let document = json!({ "uri": uri, "languageId": "rpl", "version": 1, "text": text });
        self.notify("textDocument/didOpen", json!({ "textDocument": document }));
    }

    pub fn respond(&mut self, method: &str, params: Value) -> Response {
        self.requests += 1;
        let id = RequestId::Number(self.requests);
        self.session.hear(Heard::Request(Request { id: id.clone(), method: method.to_string(), params }));
        let mut response = None;
        for message in self.session.take_said() {
            match message {
                Said::Response(answer) => response = Some(answer),
                Said::Notification(notification) => self.heard.push(notification),
                Said::Request(request) => self.asked.push(request),
            }
        }
        let response = response.expect("every request is answered");
        assert_eq!(response.id, Some(id));
        response
    }

    pub fn request(&mut self, method: &str, params: Value) -> Result<Value, String> {
        self.respond(method, params).outcome.map_err(|refusal| refusal.reason)
    }

    pub fn notify(&mut self, method: &str, params: Value) {
        self.session.hear(Heard::Notification(Notification { method: method.to_string(), params }));
    }

    /// A request about the open text.
    pub fn ask(&mut self, method: &str, more: Value) -> Result<Value, String> {
        let mut params = json!({ "textDocument": { "uri": FILE } });
        let fields = params.as_object_mut().expect("it is an object");
        fields.extend(more.as_object().cloned().unwrap_or_default());
        self.request(method, params)
    }

    /// A request about the marked place.
    pub fn at_mark(&mut self, method: &str, more: Value) -> Result<Value, String> {
        let before = self.text.split('|').next().expect("it has a beginning");
        let line = before.matches('\n').count();
        let column = before.rsplit('\n').next().expect("it has a last line").encode_utf16().count();
        let mut params = json!({ "position": { "line": line, "character": column } });
        let fields = params.as_object_mut().expect("it is an object");
        fields.extend(more.as_object().cloned().unwrap_or_default());
        self.ask(method, params)
    }

    /// Replaces a range of the open text.
    pub fn change(&mut self, range: Value, text: &str) {
        self.changes(json!([{ "range": range, "text": text }]));
    }

    /// Several changes of the open text in one message.
    pub fn changes(&mut self, changes: Value) {
        self.version += 1;
        let document = json!({ "uri": FILE, "version": self.version + 1 });
        self.notify("textDocument/didChange", json!({ "textDocument": document, "contentChanges": changes }));
    }

    /// The server has time to look; the texts it tells findings of then, in their order.
    pub fn looked(&mut self) -> Vec<String> {
        while self.session.waits().is_some() {
            self.session.look();
        }
        let before = self.heard.len();
        for message in self.session.take_said() {
            match message {
                Said::Notification(notification) => self.heard.push(notification),
                Said::Request(request) => self.asked.push(request),
                Said::Response(_) => {}
            }
        }
        let told = self.heard[before..].iter().filter(|one| one.method == "textDocument/publishDiagnostics");
        told.map(|one| one.params["uri"].as_str().expect("it has a name").to_string()).collect()
    }

    /// The last thing that the server has told of its own accord.
    pub fn last_told(&mut self) -> Notification {
        self.looked();
        self.heard.last().expect("something was told").clone()
    }

    /// The findings in a file after the server has had time to look, the last ones told.
    pub fn findings(&mut self, uri: &str) -> Vec<Value> {
        self.looked();
        let told = self.heard.iter().rev().filter(|one| one.method == "textDocument/publishDiagnostics");
        let found = told.map(|one| &one.params).find(|params| params["uri"] == uri).expect("findings were told");
        found["diagnostics"].as_array().expect("it is a list").clone()
    }
}

/// A range as the protocol writes it.
pub fn range(start: (u32, u32), end: (u32, u32)) -> Value {
    let position = |(line, character): (u32, u32)| json!({ "line": line, "character": character });
    json!({ "start": position(start), "end": position(end) })
}

/// A text with changes, as an editor makes them: from the last to the first.
pub fn changed(text: &str, edits: &Value) -> String {
    let mut edits: Vec<Value> = edits.as_array().expect("a list of changes").clone();
    let place = |value: &Value| (value["line"].as_u64(), value["character"].as_u64());
    edits.sort_by_key(|edit| std::cmp::Reverse(place(&edit["range"]["start"])));
    let byte = |value: &Value| {
        let (line, column) = (value["line"].as_u64().expect("a line"), value["character"].as_u64().expect("a column"));
        let start: usize = text.split_inclusive('\n').take(line as usize).map(str::len).sum();
        let mut units = 0;
        let before = text[start..].chars().take_while(|c| {
            let is_before = units < column;
            units += c.len_utf16() as u64;
            is_before
        });
        start + before.map(char::len_utf8).sum::<usize>()
    };
    let mut changed = text.to_string();
    for edit in edits {
        let bytes = byte(&edit["range"]["start"])..byte(&edit["range"]["end"]);
        changed.replace_range(bytes, edit["newText"].as_str().expect("a text"));
    }
    changed
}
