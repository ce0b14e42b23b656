//! What is known only when the whole text is: which names it defines, which classes of failure, and
//! what the functions it calls take.

use super::compilation::TextKind;
use super::compiler::{Compiler, Unknown};
use super::foreign;
use super::forms::special_names;
use super::goals::GOAL_PREFIX;
use super::locals::Surrounding;
use super::out_of_scope::BoundElsewhere;
use crate::code::GlobalKind;
use crate::diagnostic::Diagnostic;
use crate::infix::{beginning, infix_in};
use crate::name_places::{NamePlaces, find_name};
use crate::number::begins_like_number;
use crate::number::unit_names;
use crate::source::{Span, lies_in};
use crate::suggest::suggest;
use crate::symbol::{Qualifier, Symbol};
use crate::syntax::{self, NodeId};
use std::collections::BTreeSet;

/// Unknown names that are told of one text; the rest is counted.
const MOST_UNKNOWN: usize = 1_000;

/// Names that unknown ones are compared with in all: behind that nothing is suggested, and whoever mends what
/// was told first is told more.
const MOST_COMPARED: usize = 500_000;

/// The names of a text and of what it is compiled with.
struct KnownNames {
    /// Of what has a value.
    values: Vec<Symbol>,
    /// Of special forms and macros.
    forms: Vec<Symbol>,
}

/// What unknown names are looked for in.
struct Search<'s> {
    known: &'s KnownNames,
    places: &'s mut NamePlaces,
    bound: &'s mut BoundElsewhere,
    /// Names that may still be compared.
    work: &'s mut usize,
}

impl Compiler<'_> {
    pub(super) fn check_undefined(&mut self) {
        let undefined = std::mem::take(&mut self.undefined);
        let names: Vec<Symbol> = undefined.keys().map(|&global| self.program.globals[global as usize].name).collect();
        for name in &names {
            self.program.names.remove(name);
        }
        if names.is_empty() || self.expansion.is_over {
            // What was not expanded may define them.
            return;
        }
        let known = self.known_names();
        let (mut places, mut work) = (NamePlaces::default(), MOST_COMPARED);
        let goals = std::mem::take(&mut self.undefined_goals);
        // Of a goal that nothing defines nobody knows which elements are words.
        let of_goals = names.iter().filter_map(|name| goals.get(name)).flat_map(|goal| &goal.elements);
        let of_goals: BTreeSet<Span> = of_goals.copied().collect();
        let unknown = names.into_iter().zip(undefined.into_values());
        let unknown: Vec<_> =
            unknown.filter(|(_, unknown)| !of_goals.contains(&unknown.span) && !unknown.is_told).collect();
        let mut told_lists = BTreeSet::new();
        let mut bound = self.bound_elsewhere(&unknown.iter().map(|&(name, _)| name).collect::<Vec<_>>());
        let all_unknown: BTreeSet<Symbol> = unknown.iter().map(|&(name, _)| name).collect();
        let count = unknown.len();
        for (number, (name, unknown)) in unknown.into_iter().enumerate() {
            if number == MOST_UNKNOWN {
                let more = count - number;
                let message = format!("and {more} more names are not defined anywhere");
                self.error("more-errors", unknown.span, message, "the next one is here");
                return;
            }
            match goals.get(&name).filter(|_| !self.would_be_defined(name)) {
                Some(goal) => self.tell_undefined_goal(goal),
                None => {
                    let (sources, text) = (&self.program.sources, self.symbols.name(name));
                    let place = places.find(sources, unknown.span, text).unwrap_or(unknown.span);
                    let list = self.list_around(place);
                    if list.is_some_and(|list| told_lists.contains(&list)) {
                        continue;
                    }
                    let data = self.unquoted_list(place, &all_unknown);
                    if foreign::advice(self.symbols.name(name)).is_some() || data.is_some() {
                        told_lists.extend(list);
                    }
                    let mut search = Search { known: &known, places: &mut places, bound: &mut bound, work: &mut work };
                    self.undefined_name(name, unknown, data, &mut search);
                }
            }
        }
    }

    /// `data` is the list that begins with the name, if that looks like one of names that nobody has quoted.
    fn undefined_name(&mut self, name: Symbol, unknown: Unknown, data: Option<Span>, search: &mut Search<'_>) {
        let Search { known, places, bound, work } = search;
        if self.would_be_defined(name) {
            return;
        }
        let text = self.symbols.name(name).to_string();
        // With a qualifier or without; else the form.
        let sources = &self.program.sources;
        let found = places.find(sources, unknown.span, &text);
        let of_program = || places.find(sources, unknown.span, &format!("{}{text}", Qualifier::Global.prefix()));
        let span = found.or_else(of_program).unwrap_or(unknown.span);
        let behind = self.program.sources.get(span.source).text.as_bytes().get(span.end as usize);
        if behind == Some(&b'(') && self.is_argument(span) {
            // The call from outside is told of.
            return;
        }
        if let Some((Qualifier::Library, missing)) = Qualifier::split(&text) {
            self.not_in_library(span, missing);
        } else if matches!(text.as_str(), "unquote" | "unquote-splicing") {
            self.error("comma-outside", span, "a comma has a meaning only behind a backquote", "not here").help =
                Some("arguments are separated by spaces: leave the comma out; a list that is partly filled in begins with a backquote: `` `(go-to ,place) ``".into());
        } else if self.program.macros.contains_key(&name) {
            self.error(
                "macro-before-definition",
                span,
                format!("the macro `{text}` is used above its definition"),
                "not known yet here",
            )
            .help = Some("move the defmacro above its first use".into());
        } else if let Some(accessor) = text.strip_prefix("%set-") {
            self.not_a_place(span, format!("`({accessor} …)` is not a place that can be assigned"));
        } else if self.robot_names.contains(&text) {
            self.needs_a_world(span, &text);
        } else if self.names_elsewhere.names.contains(&text) {
            let (code, message, label, help) = match self.names_elsewhere.kind {
                TextKind::Scenario => (
                    "needs-a-scenario",
                    format!("`{text}` belongs to scenarios, and this text is read as a plan"),
                    "only a scenario has it",
                    "a project says it by `scenarios = [\"FILE\"]` in `rpl.toml`; `rpl check --scenario FILE` checks a scenario, `rpl run PLAN --world W --scenario FILE` runs it beside a plan",
                ),
                TextKind::Plan => (
                    "needs-a-plan",
                    format!("`{text}` belongs to plans of the robot, and this text is read as a scenario"),
                    "only a plan has it",
                    "a scenario does what the experimenter does: `(rotate-robot! 180deg)`, `(close-door! 'ROOM)`; what the robot is to do stands in the plan",
                ),
            };
            self.error(code, span, message, label).help = Some(help.into());
        } else if !self.is_out_of_scope(name, span, bound) {
            let goal = text
                .strip_prefix(GOAL_PREFIX)
                .map(|goal| format!("if it is a goal, say how to achieve it: `(def-goal (achieve ({goal} …)) …)`"));
            let foreign = foreign::advice(&text).map(str::to_string);
            let unit = self.unit_apart(span, &text);
            let is_argument = self.is_argument(span);
            let quoted = is_argument.then(|| format!("if the name itself is meant, quote it: `'{text}`"));
            // Signs that are near each other have nothing to do with each other.
            let is_word = text.contains(char::is_alphabetic);
            let suggestion =
                is_word.then(|| self.suggestion(&text, unknown.around, is_argument, known, work)).flatten();
            let suggestion = suggestion.map(|near| format!("did you mean `{near}`?"));
            let elsewhere = self.suggestion_elsewhere(&text, work);
            let spelling = self.spelling_advice(&text).or_else(|| self.method_advice(&text, unknown.around));
            let shape = self.shape_of_list_advice(span, &text);
            let by_place = self.place_advice(span, &text);
            let data = data
                .filter(|_| suggestion.is_none())
                .map(|list| format!("if this list is data, quote it: `'{}`", self.program.sources.text_of(list)));
            let help = foreign.or(unit).or(spelling).or(shape).or(suggestion).or(elsewhere).or(data).or(goal);
            let help = help.or(by_place).or(quoted);
            self.error("unbound-name", span, format!("`{text}` is not defined anywhere"), "unknown name").help = help;
        }
    }

    /// The names that something could be called by instead.
    fn known_names(&self) -> KnownNames {
        let is_written = |&name: &Symbol| !self.symbols.name(name).starts_with(['%', '#']);
        // Of equally near names the text's own come first.
        let (library, own): (Vec<_>, Vec<_>) =
            self.program.names.iter().partition(|&(_, &global)| self.is_library(global));
        let globals = own.into_iter().chain(library).map(|(&name, _)| name);
        let natives = self.natives.iter().filter_map(|native| self.symbols.find(&native.name));
        let specials = special_names().filter_map(|(name, _)| self.symbols.find(name));
        let macros = self.program.macros.keys().copied();
        KnownNames {
            values: globals.chain(natives).filter(is_written).collect(),
            forms: specials.chain(macros).filter(is_written).collect(),
        }
    }

    /// Whether a macro that could not be expanded may have defined the name: some words of it name what that was
    /// called with.
    fn would_be_defined(&self, name: Symbol) -> bool {
        if self.unexpanded.is_empty() {
            return false;
        }
        let text = self.symbols.name(name);
        let begins = std::iter::once(0).chain(text.match_indices('-').map(|(at, _)| at + 1));
        let is_unexpanded = |part: &str| self.symbols.find(part).is_some_and(|name| self.unexpanded.contains(&name));
        begins.into_iter().any(|begin| {
            let rest = &text[begin..];
            let ends = rest.match_indices('-').map(|(at, _)| at).chain([rest.len()]);
            ends.into_iter().any(|end| is_unexpanded(&rest[..end]))
        })
    }

    fn needs_a_world(&mut self, span: Span, text: &str) {
        let message = format!("`{text}` belongs to the robot, and there is none");
        self.error("needs-a-world", span, message, "needs a world").help =
            Some("add `--world dept` to the command".into());
    }

    /// A name with the qualifier of the library that the library does not have.
    fn not_in_library(&mut self, span: Span, text: &str) {
        if self.robot_names.iter().any(|known| known == text) {
            return self.needs_a_world(span, text);
        }
        let own = self
            .symbols
            .find(text)
            .filter(|name| self.program.names.contains_key(name) || self.program.macros.contains_key(name));
        let library = self.library.unwrap_or(self.program);
        let known = library.names.keys().chain(library.macros.keys()).map(|&name| self.symbols.name(name));
        let natives = self.natives.iter().map(|native| native.name.as_str());
        let known = known.chain(natives).chain(special_names().map(|(name, _)| name));
        let near = suggest(text, known.filter(|name| !name.starts_with(['%', '#'])));
        let help = match (own, near) {
            (Some(_), _) => Some(format!("the program's own is `global:{text}`")),
            (None, Some(near)) => Some(format!("did you mean `library:{near}`?")),
            (None, None) => None,
        };
        self.error("unbound-name", span, format!("the library has no `{text}`"), "unknown name").help = help;
    }

    /// Notes that a class of failure is handled or raised.
    pub(super) fn note_class(&mut self, name: Symbol, span: Span) {
        if !self.program.failure_classes.contains_key(&name) {
            let is_variable = self.locals.find(name).is_some();
            self.classes.push((name, span, is_variable));
        }
    }

    pub(super) fn check_classes(&mut self) {
        let known = &self.program.failure_classes;
        let mut unknown = std::mem::take(&mut self.classes);
        unknown.retain(|(name, ..)| !known.contains_key(name));
        let count = unknown.len();
        for (number, (name, span, is_variable)) in unknown.into_iter().enumerate() {
            if number == MOST_UNKNOWN {
                let message = format!("and {} more classes of failure are not defined", count - number);
                self.error("more-errors", span, message, "the next one is here");
                return;
            }
            self.unknown_class(name, span, is_variable);
        }
    }

    pub(super) fn unknown_class(&mut self, name: Symbol, span: Span, is_variable: bool) {
        let text = self.symbols.name(name).to_string();
        let span = find_name(&self.program.sources, span, &text).unwrap_or(span);
        let known = &self.program.failure_classes;
        self.unknown_classes += 1;
        let is_compared = self.unknown_classes * known.len() <= MOST_COMPARED;
        let compared = if is_compared { known.len() } else { 0 };
        let names = known.keys().take(compared).map(|&class| self.symbols.name(class));
        let near = suggest(&text, names).map(str::to_string);
        let help = match near {
            _ if self.is_form(name) => {
                format!(
                    "`{text}` is no class of failures; its place is before this form: `plan-failure`, or `failure` for all"
                )
            }
            _ if is_variable => format!(
                "`{text}` is a variable here, and `fail` takes the bare name of a class; to pass a failure on, write `(refail)`"
            ),
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("define it: `(def-failure {text} (failure) ())`"),
        };
        self.error("unknown-failure-class", span, format!("there is no failure class `{text}`"), "unknown class")
            .help = Some(help);
    }

    /// Whether a name stands for something that is called.
    pub(super) fn is_form(&self, name: Symbol) -> bool {
        let text = self.symbols.name(name);
        self.program.macros.contains_key(&name)
            || special_names().any(|(special, _)| special == text)
            || self.natives.iter().any(|native| native.name == text)
    }

    /// Advice on a unit that stands apart from its number.
    fn unit_apart(&self, span: Span, text: &str) -> Option<String> {
        if !unit_names().any(|unit| unit == text) {
            return None;
        }
        let before = self.program.sources.get(span.source).text.get(..span.start as usize)?.trim_end();
        let number = before.rsplit(|c: char| c.is_whitespace() || c == '(').next()?;
        let is_number = begins_like_number(number) && number.ends_with(|c: char| c.is_ascii_digit());
        is_number.then(|| one_word(number, text))
    }

    /// Whether a name stands where its value is asked for, not at the head of a form.
    fn is_argument(&self, span: Span) -> bool {
        let before = self.program.sources.get(span.source).text.get(..span.start as usize);
        before.is_some_and(|before| !before.ends_with(['(', '\'']))
    }

    /// Tells, and gives true, if a time has one of these units, and it stands apart from its number.
    pub(super) fn refuse_unit_apart(&mut self, forms: &[NodeId], units: &[&str]) -> bool {
        let [number, unit, ..] = *forms else { return false };
        let is_number = matches!(self.tree.get(number).kind, syntax::NodeKind::Int(_) | syntax::NodeKind::Float(_));
        let Some(name) = self.tree.symbol(unit).filter(|_| is_number) else { return false };
        let text = self.symbols.name(name).to_string();
        if !units.contains(&text.as_str()) || self.lexical(name).is_some() {
            return false;
        }
        let span = self.tree.span(number).to(self.tree.span(unit));
        let written = self.program.sources.text_of(self.tree.span(number)).to_string();
        self.error("unit-apart", span, "a number, and a unit apart from it", "two words").help =
            Some(one_word(&written, &text));
        true
    }

    /// The nearest name a user could have meant; with a value, if one is needed. None if too many names
    /// were compared already.
    fn suggestion(
        &self,
        text: &str,
        around: Surrounding,
        has_value: bool,
        known: &KnownNames,
        work: &mut usize,
    ) -> Option<String> {
        let mut locals: Vec<Symbol> = self.locals.around(around).take(*work).collect();
        locals.reverse();
        let forms: &[Symbol] = if has_value { &[] } else { &known.forms };
        let compared = locals.len() + known.values.len() + forms.len();
        *work = work.checked_sub(compared)?;
        let all = locals.iter().chain(&known.values).chain(forms).map(|&name| self.symbols.name(name));
        suggest(text, all.filter(|&name| name != text)).map(str::to_string)
    }

    /// A name of the robot's or of scenarios' that was probably meant, and what has it.
    fn suggestion_elsewhere(&self, text: &str, work: &mut usize) -> Option<String> {
        *work = work.checked_sub(self.robot_names.len() + self.names_elsewhere.names.len())?;
        let of_robot = suggest(text, self.robot_names.iter().map(String::as_str))
            .map(|near| format!("did you mean `{near}`? A robot has it: add `--world dept`"));
        of_robot.or_else(|| {
            let near = suggest(text, self.names_elsewhere.names.iter().map(String::as_str))?;
            Some(match self.names_elsewhere.kind {
                TextKind::Scenario => {
                    format!("did you mean `{near}`? A scenario has it, and this text is read as a plan")
                }
                TextKind::Plan => format!("did you mean `{near}`? A plan has it, and this text is read as a scenario"),
            })
        })
    }

    pub(super) fn check_calls(&mut self) {
        // What a definition takes cannot be read off it if its list of parameters has an error.
        let told = self.diagnostics.iter().filter(|told| told.code == "parameter-list");
        let mut faulty_lists: Vec<Span> = told.map(|told| told.span).collect();
        faulty_lists.sort();
        let is_list_faulty = |definition: Span| {
            let first =
                faulty_lists.partition_point(|list| (list.source, list.start) < (definition.source, definition.start));
            faulty_lists.get(first).is_some_and(|&list| lies_in(list, definition))
        };
        for (global, count, span) in std::mem::take(&mut self.calls) {
            let GlobalKind::Function(code) = self.program.globals[global as usize].kind else { continue };
            let Some(code) = self.program.codes.get(code as usize) else { continue };
            if !code.parameters.accepts(count) && !is_list_faulty(code.span) && !self.has_hole(code.span) {
                let name = self.symbols.name(self.program.globals[global as usize].name).to_string();
                let expected = code.parameters.describe();
                let definition = code.span;
                // What is written is the place, and the value to assign is no argument of it.
                let error = match name.strip_prefix("%set-") {
                    Some(accessor) => self.arity_error(accessor, count - 1, "1 argument", span),
                    None => self.arity_error(&name, count, &expected, span),
                };
                error.related.push((definition, "defined here".into()));
            }
        }
    }

    pub(super) fn arity_error(&mut self, name: &str, count: usize, expected: &str, span: Span) -> &mut Diagnostic {
        let given = if count == 1 { "1 is given".to_string() } else { format!("{count} are given") };
        let help = infix_in(&self.program.sources, span, 2).map(|infix| infix.advice());
        let help = help.or_else(|| self.keywords_for_places(expected, span));
        let error =
            self.error("arity", span, format!("`{name}` takes {expected}, and {given}"), format!("takes {expected}"));
        error.help = help;
        error
    }
}

impl Compiler<'_> {
    /// Advice on a call that names its arguments, of something that takes them by their places.
    fn keywords_for_places(&self, expected: &str, call: Span) -> Option<String> {
        let text = beginning(&self.program.sources, call);
        let is_named = text.contains(" :") && !expected.contains(':');
        is_named.then(|| "its parameters have no keywords: the values stand alone, in their order".to_string())
    }
}

fn one_word(number: &str, unit: &str) -> String {
    format!("a number and its unit are one word: write `{number}{unit}`")
}
