//! Reading values out of a TOML table, noting every fault on the way instead of stopping at it.

use super::finding::{Finding, Findings, nearest};
use super::syntax_fault::syntax_fault;
use crate::geometry::{Point, Pose};
use rpl_lang::visible::is_invisible;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// More rooms, walls, objects and so on, of each kind, are no building.
const MOST_TABLES: usize = 5_000;

/// A name may not be longer.
const LONGEST_NAME: usize = 255;

/// A full turn, and as much as it may be rounded up by.
const MOST_RADIANS: f64 = std::f64::consts::TAU + 1e-4;

/// No coordinate, length or speed is larger: 100 km.
const LARGEST_NUMBER: f64 = 1e5;

/// Keys that other tables have, or that are called otherwise, by the kind of file: what is to be written.
const ELSEWHERE: &[(&str, &[&str], &str)] = &[
    (
        "world",
        &["charger", "chargers", "dock", "docks", "charging_station", "charges"],
        "the robot charges at a place: `charges = true` in a [[place]]",
    ),
    ("world", &["robot", "robots"], "the robot begins at `start`, a key above the first table"),
    (
        "world",
        &["pedestrian", "pedestrians", "human", "humans", "agent"],
        "people are [[person]] tables, with `path` and `speed`",
    ),
    (
        "world",
        &["obstacle", "obstacles", "furniture", "box", "table"],
        "things that stand in rooms are [[object]] tables",
    ),
    (
        "world",
        &["goal", "goals", "target", "targets", "location", "locations", "waypoint"],
        "goals of plans are [[place]] tables, with `name`, `pose` and `room`",
    ),
];

/// A value of the file, and where it stands.
pub type TomlValue<'i> = Spanned<DeValue<'i>>;

/// The text being read, and what was found wrong with it so far.
pub struct Reader<'i> {
    /// What the file describes: "world".
    pub kind: &'static str,
    /// The keys that a file of this kind has above its tables, and that no table has.
    pub keys_above: &'static [&'static str],
    /// The file, for messages.
    pub file: &'i str,
    /// What is read.
    pub text: &'i str,
    /// What was found so far.
    pub findings: Findings,
}

/// One table of the file, such as one `[[door]]`.
#[derive(Clone)]
pub struct TomlTable<'t, 'i> {
    /// Its keys and values.
    pub values: &'t DeTable<'i>,
    /// Where the table is, for faults that have no key to point at.
    pub span: Range<usize>,
    /// How the table is written: "[[door]]"; empty for the top of the file.
    pub header: String,
}

/// Something read, and the table it stands in.
pub struct Placed<'t, 'i, T> {
    /// What was read.
    pub value: T,
    /// The table.
    pub table: TomlTable<'t, 'i>,
}

impl<'t, 'i> TomlTable<'t, 'i> {
    /// Where a key's value is; where the table is, if it has no such key.
    pub fn span_of(&self, key: &str) -> Range<usize> {
        self.values.get(key).map_or(self.span.clone(), Spanned::span)
    }
}

impl<'i> Reader<'i> {
    /// Notes a fault.
    pub fn note(&mut self, span: Range<usize>, key: &str, message: impl Into<String>, help: impl Into<String>) {
        let (file, text) = (self.file, self.text);
        self.findings.add(|| Finding::new(file, text, span, key, message, help));
    }

    /// Notes that a value is not what it must be.
    pub fn expected(&mut self, value: &TomlValue, key: &str, what: &str, example: &str) {
        let found = describe(value.get_ref());
        self.note(value.span(), key, format!("`{key}` must be {what}, found {found}"), example_help(key, example));
    }

    /// What a table is called: "[[door]]", or "the world" for the top of its file.
    fn owner(&self, table: &TomlTable, article: &str) -> String {
        if table.header.is_empty() { format!("{article} {}", self.kind) } else { table.header.clone() }
    }

    /// Reports what makes the text no TOML: of each line the first fault.
    pub fn syntax_errors(&mut self, errors: &[toml::de::Error]) {
        let (mut line, mut counted_to, mut told) = (0, 0, None);
        for error in errors {
            let span = error.span().unwrap_or(0..0);
            let start = self.text.floor_char_boundary(span.start).max(counted_to);
            line += self.text[counted_to..start].matches('\n').count();
            counted_to = start;
            if told == Some(line) {
                continue;
            }
            told = Some(line);
            let (message, help) = syntax_fault(self.text, &span, error.message())
                .unwrap_or_else(|| (error.message().to_string(), format!("{} files are TOML, see toml.io", self.kind)));
            self.note(span, "", message, help);
        }
    }

    /// Reports every key that is not one of `known`.
    pub fn only_keys(&mut self, table: &TomlTable, known: &[&str]) {
        for key in table.values.keys() {
            let name: &str = key.get_ref();
            if known.contains(&name) {
                continue;
            }
            let is_of_tables = table.values[key]
                .get_ref()
                .as_array()
                .is_some_and(|array| array.iter().any(|each| each.get_ref().is_table()));
            let message = match nearest(name, known.iter().copied()) {
                Some(suggestion) if is_of_tables => format!("unknown key `{name}`, did you mean `[[{suggestion}]]`?"),
                Some(suggestion) => format!("unknown key `{name}`, did you mean `{suggestion}`?"),
                None => format!("unknown key `{name}`"),
            };
            let owner = self.owner(table, "a");
            // In the table that is advised the key is missing for another reason.
            let is_advised = |advice: &str| !table.header.is_empty() && advice.contains(table.header.as_str());
            let elsewhere = ELSEWHERE
                .iter()
                .find(|&&(kind, names, advice)| kind == self.kind && names.contains(&name) && !is_advised(advice));
            let help = match elsewhere {
                Some((_, _, advice)) => advice.to_string(),
                None if self.keys_above.contains(&name) => {
                    format!("`{name}` belongs to the {} as a whole: write it above the first table", self.kind)
                }
                None => format!("the keys of {owner} are {}", known.join(", ")),
            };
            self.note(key.span(), name, message, help);
        }
    }

    /// The tables of a `[[key]]`.
    pub fn tables<'t>(&mut self, table: &TomlTable<'t, 'i>, key: &str) -> Vec<TomlTable<'t, 'i>> {
        let Some(value) = table.values.get(key) else { return Vec::new() };
        let header = format!("[[{key}]]");
        let Some(array) = value.get_ref().as_array() else {
            let found = describe(value.get_ref());
            let message = format!("`{key}` must be written as {header}, found {found}");
            self.note(value.span(), key, message, format!("write {header} above its keys"));
            return Vec::new();
        };
        if array.len() > MOST_TABLES {
            let message = format!("a {} has at most {MOST_TABLES} {header}, found {}", self.kind, array.len());
            self.note(value.span(), key, message, "split the building, or join what belongs together");
            return Vec::new();
        }
        let mut tables = Vec::new();
        for element in array.iter() {
            match element.get_ref().as_table() {
                Some(values) => tables.push(TomlTable { values, span: element.span(), header: header.clone() }),
                None => self.expected(element, key, "a table", &format!("write {header} above its keys")),
            }
        }
        tables
    }

    /// The table of a `[key]` that must be there.
    pub fn required_table<'t>(&mut self, table: &TomlTable<'t, 'i>, key: &str) -> Option<TomlTable<'t, 'i>> {
        let header = format!("[{key}]");
        let Some(value) = table.values.get(key) else {
            let owner = self.owner(table, "the");
            let help = format!("write {header} above its keys");
            self.note(table.span.clone(), key, format!("{owner} has no {header}"), help);
            return None;
        };
        let Some(values) = value.get_ref().as_table() else {
            let found = describe(value.get_ref());
            let message = format!("`{key}` must be written as {header}, found {found}");
            self.note(value.span(), key, message, format!("write {header} above its keys"));
            return None;
        };
        Some(TomlTable { values, span: value.span(), header })
    }

    /// The value of a key that must be there.
    pub fn required<'t>(&mut self, table: &TomlTable<'t, 'i>, key: &str, example: &str) -> Option<&'t TomlValue<'i>> {
        let value = table.values.get(key);
        if value.is_none() {
            let owner = self.owner(table, "the");
            self.note(table.span.clone(), key, format!("{owner} has no `{key}`"), example_help(key, example));
        }
        value
    }

    /// A name or another short line of text.
    pub fn text(&mut self, table: &TomlTable<'_, 'i>, key: &str, example: &str) -> Option<String> {
        let value = self.required(table, key, example)?;
        self.text_value(value, key, example)
    }

    /// The texts of a list; none where the key is not there.
    pub fn texts(&mut self, table: &TomlTable<'_, 'i>, key: &str, example: &str) -> Vec<String> {
        let Some(value) = table.values.get(key) else { return Vec::new() };
        let Some(elements) = value.get_ref().as_array() else {
            self.expected(value, key, "a list", example);
            return Vec::new();
        };
        elements.iter().filter_map(|element| self.text_value(element, key, example)).collect()
    }

    fn text_value(&mut self, value: &TomlValue, key: &str, example: &str) -> Option<String> {
        let text = value.get_ref().as_str();
        if text.is_none() || text == Some("") {
            self.expected(value, key, "a name in quotes", example);
            return None;
        }
        if let Some(text) = text.filter(|text| text.chars().count() > LONGEST_NAME || text.contains(is_invisible)) {
            let length = text.chars().count();
            let message = format!("`{key}` is no name: it has {length} characters, or some that cannot be seen");
            let help =
                format!("a name is one line of at most {LONGEST_NAME} characters; {}", example_help(key, example));
            self.note(value.span(), key, message, help);
            return None;
        }
        text.map(str::to_owned)
    }

    /// A truth, or what it is where nothing is said.
    pub fn flag(&mut self, table: &TomlTable<'_, 'i>, key: &str, default: bool) -> bool {
        let Some(value) = table.values.get(key) else { return default };
        let flag = value.get_ref().as_bool();
        if flag.is_none() {
            self.expected(value, key, "true or false", "true");
        }
        flag.unwrap_or(default)
    }

    /// A whole number from 0 to `most`; 0 where nothing is said.
    pub fn count(&mut self, table: &TomlTable<'_, 'i>, key: &str, most: usize) -> usize {
        let Some(value) = table.values.get(key) else { return 0 };
        let number = value.get_ref().as_integer().and_then(|digits| digits.to_string().parse::<usize>().ok());
        match number {
            Some(count) if count <= most => count,
            _ => {
                self.expected(value, key, &format!("a whole number from 0 to {most}"), "12");
                0
            }
        }
    }

    /// A length or speed above 0, or not below 0 if `zero_is_fine`.
    pub fn size(&mut self, table: &TomlTable<'_, 'i>, key: &str, zero_is_fine: bool, example: &str) -> Option<f64> {
        let value = self.required(table, key, example)?;
        self.size_value(value, key, zero_is_fine, example)
    }

    /// The same of a value that was found.
    pub fn size_value(&mut self, value: &TomlValue, key: &str, zero_is_fine: bool, example: &str) -> Option<f64> {
        let size = self.number_value(value, key, example)?;
        if size > 0.0 || zero_is_fine && size == 0.0 {
            return Some(size);
        }
        let bound = if zero_is_fine { "0 or more" } else { "more than 0" };
        self.note(value.span(), key, format!("`{key}` must be {bound}, found {size}"), example_help(key, example));
        None
    }

    /// A finite number that was found.
    pub fn number_value(&mut self, value: &TomlValue, key: &str, example: &str) -> Option<f64> {
        let number = match value.get_ref() {
            DeValue::Integer(digits) => i64::from_str_radix(digits.as_str(), digits.radix()).ok().map(|n| n as f64),
            DeValue::Float(digits) => digits.as_str().parse::<f64>().ok(),
            _ => None,
        };
        match number {
            Some(fine) if fine.abs() <= LARGEST_NUMBER => return Some(fine),
            Some(number) => {
                let what = if number.is_finite() { "a number up to 100,000" } else { "a finite number" };
                let message = format!("`{key}` must be {what}");
                self.note(value.span(), key, message, example_help(key, example));
            }
            None => self.expected(value, key, "a number", example),
        }
        None
    }

    /// An angle: "90deg", or a number of radians.
    pub fn angle_value(&mut self, value: &TomlValue, key: &str) -> Option<f64> {
        let Some(text) = value.get_ref().as_str() else {
            let radians = self.number_value(value, key, "\"90deg\"")?;
            // Nobody turns more than once around to look somewhere: these are degrees.
            if radians.abs() > MOST_RADIANS {
                let message = format!("{radians} is more than a full turn in radians");
                self.note(value.span(), key, message, format!("write degrees as \"{radians}deg\""));
                return None;
            }
            return Some(radians);
        };
        let degrees = text.trim().strip_suffix("deg").and_then(|number| number.trim().parse::<f64>().ok());
        match degrees {
            Some(degrees) if degrees.abs() <= LARGEST_NUMBER => Some(degrees.to_radians()),
            _ => {
                let message = format!("\"{text}\" is not an angle");
                self.note(value.span(), key, message, "write degrees as \"90deg\", or radians as a plain number");
                None
            }
        }
    }

    /// An array of exactly `count` values.
    pub fn elements<'t>(
        &mut self,
        value: &'t TomlValue<'i>,
        key: &str,
        count: usize,
        example: &str,
    ) -> Option<&'t [Spanned<DeValue<'i>>]> {
        let elements = value.get_ref().as_array().map(|array| array.as_ref());
        match elements {
            Some(elements) if elements.len() == count => Some(elements),
            Some(elements) => {
                let message = format!("`{key}` must have {count} values, found {}", elements.len());
                self.note(value.span(), key, message, example_help(key, example));
                None
            }
            None => {
                self.expected(value, key, "an array", example);
                None
            }
        }
    }

    /// The numbers of a list with `COUNT` of them.
    pub fn numbers<const COUNT: usize>(
        &mut self,
        value: &TomlValue<'i>,
        key: &str,
        example: &str,
    ) -> Option<[f64; COUNT]> {
        let elements = self.elements(value, key, COUNT, example)?;
        let mut numbers = [0.0; COUNT];
        for (number, element) in numbers.iter_mut().zip(elements) {
            *number = self.number_value(element, key, example)?;
        }
        Some(numbers)
    }

    /// Middle and radius.
    pub fn circle(&mut self, table: &TomlTable<'_, 'i>, key: &str, example: &str) -> Option<[f64; 3]> {
        let value = self.required(table, key, example)?;
        self.numbers(value, key, example)
    }

    /// A point.
    pub fn point(&mut self, table: &TomlTable<'_, 'i>, key: &str, example: &str) -> Option<Point> {
        let value = self.required(table, key, example)?;
        self.numbers(value, key, example).map(|[x, y]| Point::new(x, y))
    }

    /// A line or polygon of at least `fewest` points.
    pub fn points(&mut self, table: &TomlTable<'_, 'i>, key: &str, fewest: usize, example: &str) -> Option<Vec<Point>> {
        let value = self.required(table, key, example)?;
        let Some(elements) = value.get_ref().as_array() else {
            self.expected(value, key, "an array of points", example);
            return None;
        };
        if elements.len() < fewest {
            let message = format!("`{key}` must have at least {fewest} points, found {}", elements.len());
            self.note(value.span(), key, message, example_help(key, example));
            return None;
        }
        let points: Vec<Option<Point>> =
            elements.iter().map(|element| self.numbers(element, key, example).map(|[x, y]| Point::new(x, y))).collect();
        points.into_iter().collect()
    }

    /// A pose.
    pub fn pose(&mut self, table: &TomlTable<'_, 'i>, key: &str, example: &str) -> Option<Pose> {
        let value = self.required(table, key, example)?;
        let elements = self.elements(value, key, 3, example)?;
        let x_m = self.number_value(&elements[0], key, example);
        let y_m = self.number_value(&elements[1], key, example);
        let heading_rad = self.angle_value(&elements[2], key);
        Some(Pose::new(x_m?, y_m?, heading_rad?))
    }

    /// A word out of a fixed list.
    pub fn choice<T: Copy>(&mut self, table: &TomlTable<'_, 'i>, key: &str, choices: &[(&str, T)]) -> Option<T> {
        let value = self.required(table, key, &format!("\"{}\"", choices[0].0))?;
        self.choice_value(value, key, choices)
    }

    /// One of some words that was found.
    pub fn choice_value<T: Copy>(&mut self, value: &TomlValue, key: &str, choices: &[(&str, T)]) -> Option<T> {
        let word = value.get_ref().as_str();
        let chosen = choices.iter().find(|(name, _)| word == Some(*name)).map(|(_, choice)| *choice);
        if chosen.is_none() {
            let names: Vec<_> = choices.iter().map(|(name, _)| format!("\"{name}\"")).collect();
            let meant = word.and_then(|word| nearest(word, choices.iter().map(|(name, _)| *name)));
            match meant {
                Some(meant) => {
                    let message = format!("{} is no `{key}`, did you mean \"{meant}\"?", describe(value.get_ref()));
                    self.note(value.span(), key, message, format!("`{key}` is {}", names.join(" or ")));
                }
                None => self.expected(value, key, &names.join(" or "), &names[0]),
            }
        }
        chosen
    }
}

/// What to type: a key with an example.
pub fn example_help(key: &str, example: &str) -> String {
    format!("write it like `{key} = {example}`")
}

fn describe(value: &DeValue) -> String {
    match value {
        DeValue::String(text) => format!("\"{text}\""),
        DeValue::Integer(digits) => digits.to_string(),
        DeValue::Float(digits) => digits.to_string(),
        DeValue::Boolean(flag) => flag.to_string(),
        DeValue::Datetime(_) => "a date".to_owned(),
        DeValue::Array(_) => "an array".to_owned(),
        DeValue::Table(_) => "a table".to_owned(),
    }
}
