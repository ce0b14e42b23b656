//! Reading a case file: all its faults at once, each with its place and what to type.

use super::lines::{Head, LARGEST_NUMBER, Line, LineContent, LineRoute, LineStop, MOST_CASES, VERSION};
use crate::case::{Case, Content, Kind};
use crate::control::BehaviourParameters;
use crate::memory::{CaseMemory, CaseNumber};
use crate::places::Places;
use crate::route::{Route, Stop};
use crate::similarity::{Comparison, Scales, Similarity};
use crate::situation::{Feature, Situation, Value};
use rpl_lang::suggest::suggest;
use rpl_robot::file_text::{FileFaults, Finding, Findings};
use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

/// The first line of a file, as it is to be typed.
const HEAD: &str = "the first line of a case file is like {\"rpl_cases\":1,\"world\":\"dept\",\"next\":0}";

/// Another line, as it is to be typed.
const LINE: &str = "a case is a line like {\"case\":0,\"index\":{\"place_in_map\":[1.0,2.0],\"long_term_goal_in_map\":\
                    [8.0,2.0]},\"content\":{\"route\":{\"stops\":[\"lab\",\"hall\"]}}}";

/// A memory from the text of a file; `file` is for messages only. Without places, routes over known places
/// cannot be read.
///
/// # Errors
/// All faults: another version, too many cases, a line that is no case, a number used twice or too large, a place there
/// is not, a feature or parameter that is no number or outside its domain, an index that its kind is not compared by, a
/// route that leads nowhere.
pub fn read_memory(
    text: &str,
    file: &str,
    places: Option<&Places>,
    similarity: Similarity,
) -> Result<CaseMemory, FileFaults> {
    let mut reader = CaseReader { file, text, places, similarity: &similarity, findings: Findings::default() };
    let lines = spans(text);
    let next = reader.first_line(&lines).map(|head| head.next);
    if lines.len() > MOST_CASES + 1 {
        let found = lines.len() - 1;
        let span = lines[MOST_CASES + 1].clone();
        reader.note(
            span,
            format!("a case memory has at most {MOST_CASES} cases, found {found}"),
            "keep the best of them",
        );
    }
    let mut cases: Vec<(CaseNumber, Arc<Case>)> = Vec::new();
    let mut numbers = BTreeSet::new();
    // A file of another version would be nothing but faults.
    let cases_at = if next.is_some() { lines.get(1..).unwrap_or(&[]) } else { &[] };
    for span in cases_at.iter().take(MOST_CASES) {
        let Some((number, case)) = reader.case(span.clone()) else { continue };
        if !numbers.insert(number) {
            reader.note(span.clone(), format!("there is another case {number} before"), "give it a number of its own");
        }
        cases.push((number, Arc::new(case)));
    }
    cases.sort_by_key(|(number, _)| *number);
    let findings = reader.findings;
    findings.or_value(next.map(|next| CaseMemory::with_cases(similarity, CaseNumber(next), cases)))
}

/// The world that the first line of a case file names; `file` is for messages only.
///
/// # Errors
/// The text is empty, of another version, or no case file.
pub fn world_of(text: &str, file: &str) -> Result<String, FileFaults> {
    let mut reader = CaseReader {
        file,
        text,
        places: None,
        similarity: &Similarity::new(Scales::default()),
        findings: Findings::default(),
    };
    let head = reader.first_line(&spans(text));
    reader.findings.or_value(head.map(|head| head.world))
}

/// A situation from the text of a JSON object, such as a user types.
///
/// # Errors
/// What is wrong with it.
pub fn read_situation(text: &str, file: &str) -> Result<Situation, FileFaults> {
    let help = "write a situation like {\"place_in_map\":[1.0,2.0],\"long_term_goal_in_map\":[8.0,2.0]}";
    let mut findings = Findings::default();
    let situation = match serde_json::from_str::<Situation>(text) {
        Ok(situation) => Some(situation),
        Err(error) => {
            let span = span_of(&error, text, 0..text.len());
            let message = message(&error, &text[span.start..]);
            findings.add(|| Finding::new(file, text, span, "", message, help));
            None
        }
    };
    for feature in situation.iter().flat_map(Situation::unusable_features) {
        findings.add(|| Finding::new(file, text, 0..0, feature.key(), unusable(feature), help));
    }
    findings.or_value(situation)
}

/// Where the lines of a text are that are not blank.
fn spans(text: &str) -> Vec<Range<usize>> {
    let mut start = 0;
    let lines = text.split_inclusive('\n').map(|line| {
        let span = start..start + line.trim_end().len();
        start += line.len();
        span
    });
    lines.filter(|span| !span.is_empty()).collect()
}

struct CaseReader<'t> {
    file: &'t str,
    text: &'t str,
    places: Option<&'t Places>,
    similarity: &'t Similarity,
    findings: Findings,
}

impl CaseReader<'_> {
    fn note(&mut self, span: Range<usize>, message: impl Into<String>, help: impl Into<String>) {
        let (file, text) = (self.file, self.text);
        self.findings.add(|| Finding::new(file, text, span, "", message, help));
    }

    /// What the first of these lines says, if there is one.
    fn first_line(&mut self, lines: &[Range<usize>]) -> Option<Head> {
        let Some(span) = lines.first().cloned() else {
            self.note(0..0, "the file is empty", HEAD);
            return None;
        };
        let version = serde_json::from_str::<serde_json::Value>(&self.text[span.clone()]).ok();
        let Some(version) = version.as_ref().and_then(|head| head.get("rpl_cases")) else {
            self.note(span, "this is no case file", HEAD);
            return None;
        };
        if let Some(version) = version.as_u64().filter(|&version| version != u64::from(VERSION)) {
            let message = format!("the file is of version {version}, and this reads version {VERSION}");
            self.note(span, message, "learn the cases anew, or use the program that wrote the file");
            return None;
        }
        let head: Head = self.parsed(span.clone(), HEAD)?;
        self.number("next", head.next, span).map(|()| head)
    }

    fn parsed<T: serde::de::DeserializeOwned>(&mut self, span: Range<usize>, help: &str) -> Option<T> {
        match serde_json::from_str(&self.text[span.clone()]) {
            Ok(read) => Some(read),
            Err(error) => {
                let span = span_of(&error, self.text, span);
                self.note(span.clone(), message(&error, &self.text[span.start..]), help);
                None
            }
        }
    }

    /// Whether there are numbers left for the cases that a robot learns.
    fn number(&mut self, key: &str, number: u32, span: Range<usize>) -> Option<()> {
        let is_left = number <= LARGEST_NUMBER;
        if !is_left {
            let message = format!("`{key}` is at most {LARGEST_NUMBER}, found {number}");
            self.note(span, message, "number the cases from 0 on");
        }
        is_left.then_some(())
    }

    fn case(&mut self, span: Range<usize>) -> Option<(CaseNumber, Case)> {
        let line: Line = self.parsed(span.clone(), LINE)?;
        self.number("case", line.case, span.clone())?;
        let content = match line.content {
            LineContent::Behaviour(parameters) => self.behaviour(parameters, line.case, span.clone())?,
            LineContent::Route(route) => Content::Route(self.route(route, span.clone())?),
            LineContent::Goal(goal) => Content::Goal(goal),
            LineContent::MetaPlan(plan) => Content::MetaPlan(plan),
        };
        self.index(&line.index, content.kind(), line.case, span)?;
        let number = CaseNumber(line.case);
        Some((number, Case { index: line.index, content, counts: line.counts }))
    }

    /// Whether the index is one that cases of the kind are compared by.
    fn index(&mut self, index: &Situation, kind: Kind, number: u32, span: Range<usize>) -> Option<()> {
        let unusable_features = index.unusable_features();
        for &feature in &unusable_features {
            self.note(span.clone(), format!("case {number}: {}", unusable(feature)), "correct it, or leave it away");
        }
        let compared = Feature::ALL.into_iter().filter(|&feature| {
            // Only that a short-term goal is missing tells nothing of a route.
            self.similarity.comparison(kind, feature) == Comparison::Distance
        });
        let keys: Vec<&str> = compared.clone().map(Feature::key).collect();
        let is_indexed = compared.into_iter().any(|feature| index.value(feature) != Value::Missing);
        // A meta-plan may be for when everything is missing.
        if !is_indexed && kind != Kind::MetaPlan {
            let message = format!("case {number}: its index has no feature that a {} is retrieved by", kind.name());
            self.note(span, message, format!("give it one of `{}`", keys.join("`, `")));
            return None;
        }
        unusable_features.is_empty().then_some(())
    }

    fn behaviour(&mut self, parameters: BehaviourParameters, number: u32, span: Range<usize>) -> Option<Content> {
        let faults = parameters.faults();
        for (name, domain) in &faults {
            let message = format!("case {number}: the parameter `{name}` must be {domain}");
            self.note(span.clone(), message, "correct it, or leave the case away");
        }
        faults.is_empty().then_some(Content::Behaviour(parameters))
    }

    fn route(&mut self, route: LineRoute, span: Range<usize>) -> Option<Route> {
        let count = route.stops.len();
        if count < 2 {
            self.note(span, format!("a route has a start and a goal, found {count} stops"), LINE);
            return None;
        }
        if !route.times_s.is_empty() && route.times_s.len() != count - 1 {
            let message = format!("a route of {count} stops has {} times, found {}", count - 1, route.times_s.len());
            self.note(span, message, "write one for each step, null where there is none, or leave `times_s` away");
            return None;
        }
        if route.times_s.iter().flatten().any(|time_s| !(*time_s >= 0.0 && time_s.is_finite())) {
            self.note(span, "a step of a route takes no negative time", "write seconds, or null");
            return None;
        }
        let stops: Vec<Option<Stop>> = route.stops.iter().map(|stop| self.stop(stop, span.clone())).collect();
        let mut read = Route::new(stops.into_iter().collect::<Option<Vec<Stop>>>()?);
        if !route.times_s.is_empty() {
            read.times_s = route.times_s;
        }
        Some(read)
    }

    fn stop(&mut self, stop: &LineStop, span: Range<usize>) -> Option<Stop> {
        match stop {
            LineStop::At(point) if point.iter().all(|metres| metres.is_finite()) => Some(Stop::At(*point)),
            LineStop::At(_) => {
                self.note(span, "a stop of a route is at numbers that are not finite", "write it like [1.0, 2.0]");
                None
            }
            LineStop::Known(name) => self.place(name, span),
        }
    }

    fn place(&mut self, name: &str, line: Range<usize>) -> Option<Stop> {
        let quoted = serde_json::Value::from(name).to_string();
        let at = self.text[line.clone()].find(&quoted);
        let span = at.map_or(line.clone(), |at| line.start + at..line.start + at + quoted.len());
        let Some(places) = self.places else {
            self.note(
                span,
                format!("there is no place `{name}`: the world has no places"),
                "add [[place]] to the world",
            );
            return None;
        };
        let found = places.named(name);
        if found.is_none() {
            let meant = suggest(name, places.all.iter().map(|place| place.name.as_str()));
            let help = meant.map_or("`rpl worlds NAME` lists the places of a world".to_string(), |meant| {
                format!("did you mean `{meant}`?")
            });
            self.note(span, format!("there is no place `{name}` in this world"), help);
        }
        found.map(Stop::Known)
    }
}

/// Where an error in a line is.
fn span_of(error: &serde_json::Error, text: &str, line: Range<usize>) -> Range<usize> {
    let before: usize =
        text[line.clone()].split_inclusive('\n').take(error.line().saturating_sub(1)).map(str::len).sum();
    let at = (line.start + before + error.column().saturating_sub(1)).min(line.end);
    at..at + 1
}

/// What an error says, without its place; `rest` is the text from there on.
fn message(error: &serde_json::Error, rest: &str) -> String {
    if let Some(word) =
        ["NaN", "nan", "Infinity", "-Infinity", "inf", "-inf"].iter().find(|word| rest.starts_with(**word))
    {
        return format!("`{word}` is no number; leave away what is not known");
    }
    let whole = error.to_string();
    whole.rfind(" at line ").map_or(whole.clone(), |end| whole[..end].to_string())
}

fn unusable(feature: Feature) -> String {
    let domain = match feature {
        Feature::Sonars | Feature::MeanSonars => "ranges that are finite and not negative",
        Feature::Priority => "a number from 0 to 1",
        Feature::ShortTermGoalDistance => "a finite number of metres, not negative",
        Feature::Translation
        | Feature::Rotation
        | Feature::Place
        | Feature::ShortTermGoal
        | Feature::LongTermGoal
        | Feature::ShortTermGoalBearing
        | Feature::Time => "finite",
    };
    format!("the feature `{}` must be {domain}", feature.key())
}
