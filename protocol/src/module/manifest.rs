//! The manifest of a module: what it offers to plans, and the command that starts it. A TOML file, read
//! with all its faults at once.

use super::message::Pace;
use crate::value::is_name;
use rpl_lang::symbol::fold_name;
use rpl_robot::file_text::{FileFaults, Findings, Reader, TomlTable, TomlValue};
use rpl_robot::foresight::act_model::{ActModel, Effect};
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::robot::{BehaviourSpec, FluentSpec};
use std::collections::BTreeMap;
use std::ops::Range;
use toml::de::{DeTable, DeValue};

/// The keys at the top of a manifest.
const KEYS: [&str; 14] = [
    "name",
    "doc",
    "command",
    "connect",
    "restart",
    "answer_within",
    "start_within",
    "pace",
    "wants",
    "valves",
    "plans",
    "behaviour",
    "query",
    "fluent",
];

/// How long an answer may take, if nobody says.
const ANSWER_WITHIN_US: u64 = 1_000_000;

/// How long the greeting may take, if nobody says: programs load what they need first.
const START_WITHIN_US: u64 = 10_000_000;

/// Nobody waits longer for an answer: 10 min.
const LONGEST_WAIT_US: u64 = 600_000_000;

/// More valves, parameters of a behaviour, or words of a command are none.
const MOST_ENTRIES: usize = 200;

/// A module that is lost more often in a run is of no use.
const MOST_RESTARTS: u32 = 1_000;

/// What a module is, as its manifest says.
#[derive(Clone, Debug, PartialEq)]
pub struct Manifest {
    /// The file, as the user named it.
    pub file: String,
    /// Its name, in messages.
    pub name: String,
    /// What it is for.
    pub doc: String,
    /// Who speaks for it.
    pub spokesman: Spokesman,
    /// How often it is started again in a run, when it was lost.
    pub restart: u32,
    /// How long the answer to a tick may take.
    pub answer_within_us: u64,
    /// How long the answer to the greeting may take.
    pub start_within_us: u64,
    /// When its messages take effect.
    pub pace: Pace,
    /// Whether ticks carry where the robot believes itself to be.
    pub wants_position: bool,
    /// Whether ticks carry what the robot perceives.
    pub wants_percept: bool,
    /// Names of its valves.
    pub valves: Vec<String>,
    /// The file with its plans, from the folder of the manifest.
    pub plans: Option<String>,
    /// Its behaviours.
    pub behaviours: Vec<BehaviourSpec>,
    /// How they go in projections, by their places, as far as it is said.
    pub models: BTreeMap<usize, ActModel>,
    /// What plans can ask it.
    pub queries: Vec<QuerySpec>,
    /// Its fluents.
    pub fluents: Vec<ModuleFluent>,
    /// Where its names stand in the file, for faults that show only beside others.
    pub places: Places,
}

/// Who speaks for a module.
#[derive(Clone, Debug, PartialEq)]
pub enum Spokesman {
    /// A program that is started, with its arguments.
    Command(Vec<String>),
    /// One that waits at an address, as `host:port`.
    Address(String),
}

/// A question that plans can ask a module, as they see it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct QuerySpec {
    /// Its name, as that of a function.
    pub name: String,
    /// What the answer is.
    pub doc: String,
    /// The names of its arguments, by position.
    pub parameters: String,
}

/// Where the names of a manifest stand in its text.
#[derive(Clone, Debug, PartialEq)]
pub struct Places {
    text: String,
    spans: BTreeMap<String, Range<usize>>,
}

/// A fluent of a module.
#[derive(Clone, Debug, PartialEq)]
pub struct ModuleFluent {
    /// What plans see of it.
    pub spec: FluentSpec,
    /// What it holds.
    pub kind: FluentKind,
}

/// What a fluent of a module holds; `null` it may be whatever it holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FluentKind {
    /// `nil` or `t`
    Truth,
    /// An integer.
    Integer,
    /// An integer or a float.
    Number,
    /// A symbol; a text is taken for one.
    Symbol,
    /// A text.
    Text,
    /// A list.
    List,
}

impl FluentKind {
    const ALL: [(&'static str, Self); 6] = [
        ("truth", Self::Truth),
        ("integer", Self::Integer),
        ("number", Self::Number),
        ("symbol", Self::Symbol),
        ("text", Self::Text),
        ("list", Self::List),
    ];

    /// The word for it in a manifest.
    pub fn name(self) -> &'static str {
        match self {
            Self::Truth => "truth",
            Self::Integer => "integer",
            Self::Number => "number",
            Self::Symbol => "symbol",
            Self::Text => "text",
            Self::List => "list",
        }
    }

    /// A reading as such a fluent holds it; none if it cannot.
    pub fn held(self, reading: Reading) -> Option<Reading> {
        match (self, reading) {
            (_, Reading::Truth(false)) => Some(Reading::Truth(false)),
            (Self::Symbol, Reading::Text(name)) => crate::value::symbol(&name).ok(),
            (Self::Truth, reading @ Reading::Truth(_))
            | (Self::Integer | Self::Number, reading @ Reading::Int(_))
            | (Self::Number, reading @ Reading::Float(_))
            | (Self::Symbol, reading @ Reading::Symbol(_))
            | (Self::Text, reading @ Reading::Text(_))
            | (Self::List, reading @ Reading::List(_)) => Some(reading),
            (Self::Truth | Self::Integer | Self::Number | Self::Symbol | Self::Text | Self::List, _) => None,
        }
    }
}

impl Manifest {
    /// Reads the text of a manifest; `file` is for the messages only.
    ///
    /// # Errors
    /// All faults of the text at once: what is not TOML, unknown or missing keys, values of the wrong
    /// kind, names that are none or given twice.
    pub fn parse(text: &str, file: &str) -> Result<Self, FileFaults> {
        let mut reader = Reader {
            file,
            text,
            kind: "manifest",
            keys_above: &["command", "pace", "wants", "valves", "plans"],
            findings: Findings::default(),
        };
        let (document, errors) = DeTable::parse_recoverable(text);
        reader.syntax_errors(&errors);
        let top = TomlTable { values: document.get_ref(), span: 0..0, header: String::new() };
        let manifest = if errors.is_empty() { read_manifest(&mut reader, &top) } else { None };
        reader.findings.or_value(manifest)
    }

    /// All names that plans see of it.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let behaviours = self.behaviours.iter().map(|behaviour| &*behaviour.name);
        let fluents = self.fluents.iter().map(|fluent| &*fluent.spec.name);
        let queries = self.queries.iter().map(|query| &*query.name);
        behaviours.chain(fluents).chain(queries).chain(self.valves.iter().map(String::as_str))
    }

    /// Where a name of it stands: file, line and column.
    pub fn place(&self, name: &str) -> String {
        let start = self.places.spans.get(name).map_or(0, |span| span.start);
        let before = self.places.text.get(..start).unwrap_or_default();
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let (line, column) = (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1);
        format!("{}:{line}:{column}", self.file)
    }
}

fn read_manifest<'i>(reader: &mut Reader<'i>, top: &TomlTable<'_, 'i>) -> Option<Manifest> {
    reader.only_keys(top, &KEYS);
    let mut names = Names::default();
    let name = reader.text(top, "name", "\"camera\"");
    let doc = reader.text(top, "doc", "\"A camera that sees cups.\"");
    let spokesman = read_spokesman(reader, top);
    let restart = read_restart(reader, top);
    let answer_within_us = duration_us(reader, top, "answer_within", ANSWER_WITHIN_US);
    let start_within_us = duration_us(reader, top, "start_within", START_WITHIN_US);
    let paces = [("lock-step", Pace::LockStep), ("live", Pace::Live)];
    let pace = if top.values.contains_key("pace") { reader.choice(top, "pace", &paces) } else { Some(Pace::LockStep) };
    let wants = read_wants(reader, top);
    let valves = entries(reader, top, "valves", "[\"lamp\"]");
    let valves: Vec<String> = valves.into_iter().map(|valve| fold_name(&valve).into_owned()).collect();
    for valve in &valves {
        names.note(reader, valve, top.span_of("valves"), "valves");
    }
    let plans = if top.values.contains_key("plans") { reader.text(top, "plans", "\"camera.rpl\"") } else { None };
    let behaviours: Vec<_> = reader.tables(top, "behaviour").iter().map(|t| behaviour(reader, t, &mut names)).collect();
    let mut models: Vec<_> = reader.tables(top, "behaviour").iter().map(|t| act_model(reader, t)).collect();
    let fluents: Vec<_> = reader.tables(top, "fluent").iter().map(|t| fluent(reader, t, &mut names)).collect();
    let known: Vec<ModuleFluent> = fluents.iter().flatten().cloned().collect();
    hold_effects(reader, &mut models, &known, top.span_of("behaviour"));
    let queries: Vec<_> = reader.tables(top, "query").iter().map(|t| query(reader, t, &mut names)).collect();
    if behaviours.is_empty() && fluents.is_empty() && queries.is_empty() {
        let advice = "add a table [[behaviour]], [[fluent]] or [[query]] with `name` and `doc`";
        reader.note(0..0, "", "the module offers nothing: no behaviour, no fluent and no query", advice);
    }
    Some(Manifest {
        file: reader.file.to_string(),
        name: name?,
        doc: doc?,
        spokesman: spokesman?,
        restart: restart?,
        answer_within_us: answer_within_us?,
        start_within_us: start_within_us?,
        pace: pace?,
        wants_position: wants.0,
        wants_percept: wants.1,
        valves,
        plans,
        behaviours: behaviours.into_iter().collect::<Option<_>>()?,
        models: models.into_iter().enumerate().filter_map(|(place, model)| Some((place, model?))).collect(),
        queries: queries.into_iter().collect::<Option<_>>()?,
        fluents: fluents.into_iter().collect::<Option<_>>()?,
        places: Places { text: reader.text.to_string(), spans: names.spans },
    })
}

/// The names that were met, and where.
#[derive(Default)]
struct Names {
    spans: BTreeMap<String, Range<usize>>,
}

impl Names {
    /// Notes a name that plans are to see, and what is wrong with it.
    fn note(&mut self, reader: &mut Reader, name: &str, span: Range<usize>, key: &str) {
        if !is_name(name) || matches!(name, "nil" | "t") {
            let message = format!("\"{name}\" is no name that plans can write");
            reader.note(span.clone(), key, message, "a name is one word, like `switch-on` or `light*`, and no number");
        }
        if let Some(before) = self.spans.insert(name.to_string(), span.clone()) {
            let line = reader.text.get(..before.start).unwrap_or_default().matches('\n').count() + 1;
            reader.note(span, key, format!("`{name}` is there already, in line {line}"), "give it another name");
        }
    }
}

/// The texts of a list that is not endless.
fn entries<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>, key: &str, example: &str) -> Vec<String> {
    let mut texts = reader.texts(table, key, example);
    if texts.len() > MOST_ENTRIES {
        let message = format!("`{key}` has at most {MOST_ENTRIES} entries, found {}", texts.len());
        reader.note(table.span_of(key), key, message, "leave out what is not needed");
        texts.truncate(MOST_ENTRIES);
    }
    texts
}

/// The program that is started, or the address that is connected to.
fn read_spokesman<'i>(reader: &mut Reader<'i>, top: &TomlTable<'_, 'i>) -> Option<Spokesman> {
    if !top.values.contains_key("connect") {
        return read_command(reader, top).map(Spokesman::Command);
    }
    let address = reader.text(top, "connect", "\"127.0.0.1:7400\"")?;
    if top.values.contains_key("command") {
        let advice = "`command` starts a program, `connect` waits for none: leave one away";
        reader.note(top.span_of("command"), "command", "a module is started or connected to, not both", advice);
    }
    let port = address.rsplit_once(':').and_then(|(host, port)| port.parse::<u16>().ok().filter(|_| !host.is_empty()));
    if port.is_none() {
        let message = format!("\"{address}\" is no address");
        reader.note(top.span_of("connect"), "connect", message, "write a host and a port, like \"127.0.0.1:7400\"");
        return None;
    }
    Some(Spokesman::Address(address))
}

/// How often a lost module is started again.
fn read_restart<'i>(reader: &mut Reader<'i>, top: &TomlTable<'_, 'i>) -> Option<u32> {
    let Some(value) = top.values.get("restart") else { return Some(0) };
    let times = value.get_ref().as_integer().and_then(|number| number.as_str().parse::<u32>().ok());
    let times = times.filter(|times| *times <= MOST_RESTARTS);
    if times.is_none() {
        reader.expected(value, "restart", &format!("a whole number up to {MOST_RESTARTS}"), "3");
    }
    times
}

fn query<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>, names: &mut Names) -> Option<QuerySpec> {
    reader.only_keys(table, &["name", "doc", "parameters"]);
    let name = plan_name(reader, table, "\"distance\"", names);
    let doc = reader.text(table, "doc", "\"How far it is, in m.\"");
    let parameters = entries(reader, table, "parameters", "[\"from\", \"to\"]");
    for (at, parameter) in parameters.iter().enumerate() {
        if !is_name(parameter) || fold_name(parameter) != *parameter || parameter.starts_with([':', '&']) {
            let message = format!("\"{parameter}\" is no parameter of a query");
            reader.note(table.span_of("parameters"), "parameters", message, "write one word, like \"from\"");
        } else if parameters[..at].contains(parameter) {
            let message = format!("the parameter `{parameter}` is there twice");
            reader.note(table.span_of("parameters"), "parameters", message, "name each parameter once");
        }
    }
    Some(QuerySpec { name: name?, doc: doc?, parameters: parameters.join(" ") })
}

fn read_command<'i>(reader: &mut Reader<'i>, top: &TomlTable<'_, 'i>) -> Option<Vec<String>> {
    let example = "[\"python3\", \"camera.py\"]";
    reader.required(top, "command", example)?;
    let command = entries(reader, top, "command", example);
    if command.is_empty() {
        let advice = format!("write the program and its arguments, like `command = {example}`");
        reader.note(top.span_of("command"), "command", "`command` names no program", advice);
        return None;
    }
    Some(command)
}

fn duration_us<'i>(reader: &mut Reader<'i>, top: &TomlTable<'_, 'i>, key: &str, default: u64) -> Option<u64> {
    let Some(value) = top.values.get(key) else { return Some(default) };
    let duration = value.get_ref().as_str().and_then(parse_duration_us).filter(|us| (1..=LONGEST_WAIT_US).contains(us));
    if duration.is_none() {
        reader.expected(value, key, "a time above 0 and up to 10 minutes in quotes", "\"500ms\"");
    }
    duration
}

/// "500ms", "2s", "1.5s" or "1min" in microseconds.
fn parse_duration_us(text: &str) -> Option<u64> {
    let unit_at = text.find(|c: char| c.is_ascii_alphabetic())?;
    let (number, unit) = text.split_at(unit_at);
    let unit_us = match unit {
        "ms" => 1e3,
        "s" => 1e6,
        "min" => 60e6,
        _ => return None,
    };
    let microseconds = number.trim().parse::<f64>().ok()? * unit_us;
    // What is no number of microseconds becomes 0, which is refused like it.
    Some(microseconds as u64)
}

/// Whether the position is wanted, and the percept.
fn read_wants<'i>(reader: &mut Reader<'i>, top: &TomlTable<'_, 'i>) -> (bool, bool) {
    let mut wants = (false, false);
    for want in entries(reader, top, "wants", "[\"position\"]") {
        match &*want {
            "position" => wants.0 = true,
            "percept" => wants.1 = true,
            _ => {
                let message = format!("a module cannot want \"{want}\"");
                reader.note(top.span_of("wants"), "wants", message, "`wants` lists \"position\" and \"percept\"");
            }
        }
    }
    wants
}

fn behaviour<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>, names: &mut Names) -> Option<BehaviourSpec> {
    reader.only_keys(table, &["name", "doc", "parameters", "valve", "takes", "fails", "sets"]);
    let name = plan_name(reader, table, "\"sweep\"", names);
    let doc = reader.text(table, "doc", "\"Sweeps an area once.\"");
    let parameters = entries(reader, table, "parameters", "[\":area\"]");
    for (at, parameter) in parameters.iter().enumerate() {
        let Some(word) = parameter.strip_prefix(':').filter(|word| is_name(word) && fold_name(word) == *word) else {
            let message = format!("\"{parameter}\" is no parameter");
            reader.note(table.span_of("parameters"), "parameters", message, "write a parameter like \":area\"");
            continue;
        };
        if parameters[..at].contains(parameter) {
            let message = format!("the parameter `:{word}` is there twice");
            reader.note(table.span_of("parameters"), "parameters", message, "name each parameter once");
        }
    }
    let valve = match table.values.get("valve") {
        Some(_) => Some(fold_name(&reader.text(table, "valve", "\"wheels\"")?).into_owned().into()),
        None => None,
    };
    Some(BehaviourSpec { name: name?.into(), doc: doc?.into(), valve, parameters: parameters.join(" ").into() })
}

/// How a behaviour goes in projections; none if nothing is said of it, or something that is noted.
fn act_model<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Option<ActModel> {
    let (failures, sets) = (read_failures(reader, table), read_effects(reader, table));
    let Some(value) = table.values.get("takes") else {
        for key in ["fails", "sets"].into_iter().filter(|key| table.values.contains_key(*key)) {
            let message = format!("`{key}` is for projections, and these need to know how long it takes");
            reader.note(table.span_of(key), key, message, format!("add `takes = {TAKES}`"));
        }
        return None;
    };
    let takes: Vec<f64> = reader
        .texts(table, "takes", TAKES)
        .iter()
        .filter_map(|text| parse_duration_us(text))
        .filter(|us| (1..=LONGEST_WAIT_US).contains(us))
        .map(|us| us as f64 / 1e6)
        .collect();
    match takes[..] {
        [least_s, likely_s, most_s] if least_s <= likely_s && likely_s <= most_s => {
            Some(ActModel { takes_s: [least_s, likely_s, most_s], failures, sets })
        }
        _ => {
            reader.expected(value, "takes", "three times up to 10 minutes: at least, most likely, at most", TAKES);
            None
        }
    }
}

const TAKES: &str = "[\"2s\", \"3s\", \"5s\"]";
const SETS: &str = "{ \"lamp-on?*\" = true, \"area*\" = \":area\" }";
const FAILS: &str = "{ lamp-failure = 0.05 }";

/// The fluents that a behaviour sets, and to what.
fn read_effects<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Vec<(String, Effect)> {
    let Some(value) = table.values.get("sets") else { return Vec::new() };
    let Some(sets) = value.get_ref().as_table() else {
        reader.expected(value, "sets", "fluents with the value of each", SETS);
        return Vec::new();
    };
    let parameters = reader.texts(table, "parameters", "[\":area\"]");
    let mut effects = Vec::new();
    for (fluent, set) in sets {
        let effect = match set.get_ref() {
            DeValue::Boolean(truth) => Some(Effect::Value(Reading::Truth(*truth))),
            DeValue::Integer(number) => number.as_str().parse().ok().map(|number| Effect::Value(Reading::Int(number))),
            DeValue::Float(number) => number.as_str().parse().ok().map(|number| Effect::Value(Reading::Float(number))),
            DeValue::String(text) => match text.strip_prefix(':') {
                Some(word) if parameters.iter().any(|known| known.strip_prefix(':') == Some(word)) => {
                    Some(Effect::Argument(word.to_string()))
                }
                Some(_) => None,
                None => Some(Effect::Value(Reading::Text(text.to_string()))),
            },
            DeValue::Datetime(_) | DeValue::Array(_) | DeValue::Table(_) => None,
        };
        match effect {
            Some(effect) => effects.push((fold_name(fluent.get_ref()).into_owned(), effect)),
            None => reader.expected(set, "sets", "a truth, a number, a text or a parameter of the behaviour", SETS),
        }
    }
    effects
}

/// What behaviours set is held by fluents of the module as they are; what is wrong is noted.
fn hold_effects(reader: &mut Reader, models: &mut [Option<ActModel>], fluents: &[ModuleFluent], span: Range<usize>) {
    for (name, effect) in models.iter_mut().flatten().flat_map(|model| &mut model.sets) {
        let Some(fluent) = fluents.iter().find(|fluent| fluent.spec.name == *name) else {
            let message = format!("`sets` names `{name}`, and the module has no such fluent");
            reader.note(span.clone(), "sets", message, "add a table [[fluent]] for it, or leave it away");
            continue;
        };
        let Effect::Value(reading) = effect else { continue };
        match fluent.kind.held(reading.clone()) {
            Some(held) => *reading = held,
            None => {
                let message = format!("`sets` gives `{name}` another value than a {}", fluent.kind.name());
                reader.note(span.clone(), "sets", message, format!("write a {}", fluent.kind.name()));
            }
        }
    }
}

/// The classes of failures and the probability of each.
fn read_failures<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Vec<(String, f64)> {
    let Some(value) = table.values.get("fails") else { return Vec::new() };
    let Some(fails) = value.get_ref().as_table() else {
        reader.expected(value, "fails", "classes of failures with the probability of each", FAILS);
        return Vec::new();
    };
    let mut failures = Vec::new();
    for (class, probability) in fails {
        let class = fold_name(class.get_ref()).into_owned();
        if !is_name(&class) {
            let message = format!("\"{class}\" is no class of failures");
            reader.note(value.span(), "fails", message, format!("write `fails = {FAILS}`"));
        }
        failures.extend(reader.size_value(probability, "fails", true, FAILS).map(|probability| (class, probability)));
    }
    if failures.iter().map(|(_, probability)| probability).sum::<f64>() > 1.0 + 1e-9 {
        let message = "the probabilities of `fails` are more than 1 together";
        reader.note(value.span(), "fails", message, "0.05 is one time in twenty");
    }
    failures
}

fn fluent<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>, names: &mut Names) -> Option<ModuleFluent> {
    reader.only_keys(table, &["name", "doc", "type", "unit", "continuous"]);
    let name = plan_name(reader, table, "\"light*\"", names);
    let doc = reader.text(table, "doc", "\"How bright it is.\"");
    let kind = reader.choice(table, "type", &FluentKind::ALL);
    let unit = if table.values.contains_key("unit") { reader.text(table, "unit", "\"m\"") } else { None };
    let continuous = reader.flag(table, "continuous", false);
    let (name, doc, kind) = (name?, doc?, kind?);
    let doc = match (unit, kind) {
        (None, _) => doc,
        (Some(unit), FluentKind::Integer | FluentKind::Number | FluentKind::List) => format!("{doc} In {unit}."),
        (Some(_), FluentKind::Truth | FluentKind::Symbol | FluentKind::Text) => {
            let message = format!("a fluent that is a {} has no unit", kind.name());
            reader.note(table.span_of("unit"), "unit", message, "leave `unit` away");
            doc
        }
    };
    Some(ModuleFluent { spec: FluentSpec { name: name.into(), doc: doc.into(), continuous, first: None }, kind })
}

/// The name of a behaviour or a fluent, as plans write it.
fn plan_name<'i>(
    reader: &mut Reader<'i>,
    table: &TomlTable<'_, 'i>,
    example: &str,
    names: &mut Names,
) -> Option<String> {
    let name = fold_name(&reader.text(table, "name", example)?).into_owned();
    let span = table.values.get("name").map_or(table.span.clone(), TomlValue::span);
    names.note(reader, &name, span, "name");
    Some(name)
}
