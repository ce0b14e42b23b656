//! Errors and warnings about plan text, as values.

use crate::source::{BYTE_ORDER_MARK, LINE_ENDS, SourceId, Sources, Span};
use crate::visible::{is_invisible, pictured, visible, visible_lines, with_short_words};
use ariadne::{Color, Config, Fmt, IndexType, Label, Report, ReportKind};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// How a message begins that says of what form something is to be.
pub const NOT_OF_THE_FORM: &str = "this is not of the form ";

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The text cannot run.
    Error,
    /// The text can run, and probably should not.
    Warning,
}

/// One finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Short name of the rule, such as `unclosed-list`.
    pub code: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// What was found, one sentence without a full stop.
    pub message: String,
    /// The place.
    pub span: Span,
    /// What stands beside the marked place.
    pub label: String,
    /// Other places that matter, each with its sentence.
    pub related: Vec<(Span, String)>,
    /// What to type instead.
    pub help: Option<String>,
}

impl Diagnostic {
    /// An error at a place.
    pub fn error(code: &'static str, span: Span, message: impl Into<String>, label: impl Into<String>) -> Self {
        Self {
            code,
            severity: Severity::Error,
            message: with_short_words(message.into()),
            span,
            label: with_short_words(label.into()),
            related: Vec::new(),
            help: None,
        }
    }

    /// A warning at a place.
    pub fn warning(code: &'static str, span: Span, message: impl Into<String>, label: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(code, span, message, label) }
    }

    /// The same with advice.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(with_short_words(help.into()));
        self
    }

    /// The same with one more place.
    pub fn related(mut self, span: Span, note: impl Into<String>) -> Self {
        self.related.push((span, with_short_words(note.into())));
        self
    }
}

/// A line longer than this is cut around the marked place: a plan printed by a machine may be one
/// line of a megabyte.
const MAX_LINE_BYTES: usize = 240;

/// Places further apart than this many lines are not drawn together: the drawing library looks at all lines between.
const MAX_LINES_BETWEEN: usize = 1_000;

/// The findings as text, in order of place, each with its line and the place marked; with `colour`,
/// in the colours of a terminal.
pub fn render(diagnostics: &[Diagnostic], sources: &Sources, colour: bool) -> String {
    let mut ordered: Vec<_> = diagnostics.iter().collect();
    ordered.sort_by_key(|diagnostic| diagnostic.span);
    let mut texts = Texts { sources, drawn: BTreeMap::new() };
    ordered.into_iter().map(|diagnostic| render_one(diagnostic, sources, &mut texts, colour)).collect()
}

fn render_one(diagnostic: &Diagnostic, sources: &Sources, texts: &mut Texts<'_>, colour: bool) -> String {
    let (kind, main_colour) = match diagnostic.severity {
        Severity::Error => ("error", Color::Red),
        Severity::Warning => ("warning", Color::Yellow),
    };
    let head = format!("{kind}[{}]:", diagnostic.code);
    let head = if colour { head.fg(main_colour).to_string() } else { head };
    let drawn = if is_drawable(diagnostic, sources) { draw(diagnostic, main_colour, texts, colour) } else { None };
    let body = drawn.unwrap_or_else(|| excerpts(diagnostic, sources));
    format!("{head} {}\n{body}", shown(&diagnostic.message))
}

/// The marked lines and the help; None if the drawing library gives up.
fn draw(diagnostic: &Diagnostic, main_colour: Color, texts: &mut Texts<'_>, colour: bool) -> Option<String> {
    let config = Config::new().with_index_type(IndexType::Char).with_compact(true).with_color(colour);
    let sources = texts.sources;
    let mut marks = vec![(diagnostic.span, &diagnostic.label, main_colour)];
    marks.extend(diagnostic.related.iter().map(|(span, note)| (*span, note, Color::Cyan)));
    // The library draws neighbouring lines together only if they come in order.
    marks.sort_by_key(|&(span, ..)| (span.source != diagnostic.span.source, span));
    let labels = marks
        .into_iter()
        .map(|(span, note, colour)| Label::new(drawn_span(span, sources)).with_message(shown(note)).with_color(colour));
    let mut report =
        Report::build(ReportKind::Error, drawn_span(diagnostic.span, sources)).with_config(config).with_labels(labels);
    if let Some(help) = &diagnostic.help {
        report = report.with_help(shown(help));
    }
    let mut drawn = Vec::new();
    report.finish().write(texts, &mut drawn).ok()?;
    let drawn = String::from_utf8_lossy(&drawn);
    // The library's own heading knows no code in the form the command line promises.
    let (_, body) = drawn.split_once('\n')?;
    Some(body.lines().fold(String::with_capacity(body.len()), |text, line| text + line.trim_end() + "\n"))
}

/// A sentence as it is shown.
fn shown(text: &str) -> String {
    with_short_words(visible_lines(text).into_owned())
}

/// Whether the places are drawn as they stand: lines of a length a terminal can show, those of one text near each other.
fn is_drawable(diagnostic: &Diagnostic, sources: &Sources) -> bool {
    let others = diagnostic.related.iter().map(|&(span, _)| span);
    let mut places = std::iter::once(diagnostic.span).chain(others.clone());
    let line = |span: Span| sources.line_column(span).0;
    let is_near = |span: Span| {
        span.source != diagnostic.span.source || line(span).abs_diff(line(diagnostic.span)) <= MAX_LINES_BETWEEN
    };
    places.all(|span| are_lines_short(span, sources)) && others.into_iter().all(is_near)
}

/// Whether no line that a span touches is too long.
fn are_lines_short(span: Span, sources: &Sources) -> bool {
    let source = sources.get(span.source);
    let text = &source.text;
    let start = text.floor_char_boundary(span.start as usize);
    let end = text.floor_char_boundary((span.end as usize).max(start));
    let mut at = start;
    loop {
        let line = source.line(at).1;
        if text[line.clone()].trim_end_matches(LINE_ENDS).len() > MAX_LINE_BYTES {
            return false;
        }
        if line.end > end || line.end == text.len() {
            return true;
        }
        at = line.end;
    }
}

/// The characters of a span in the drawn text. The drawing library wants a span that does not end
/// behind a line.
fn drawn_span(span: Span, sources: &Sources) -> (SourceId, Range<usize>) {
    let source = sources.get(span.source);
    let mark = usize::from(source.text.starts_with(BYTE_ORDER_MARK));
    let start = source.text.floor_char_boundary(span.start as usize);
    let covered = sources.text_of(span).trim_end_matches([' ', '\t', '\n', '\r']).len();
    let characters_before = |at| source.characters_before(at).saturating_sub(mark);
    (span.source, characters_before(start)..characters_before(start + covered))
}

/// A text as it is drawn, without a mark at its start. The drawing library takes more characters for
/// line ends than there are, and has none of them left then.
fn drawn_text(text: &Arc<str>) -> Arc<str> {
    if text.chars().all(|character| !is_invisible(character) || LINE_ENDS.contains(&character)) {
        return text.clone();
    }
    pictured(text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text)).into()
}

/// The place without its whole line, in the drawing library's manner.
fn excerpts(diagnostic: &Diagnostic, sources: &Sources) -> String {
    let mut text = String::new();
    let places = std::iter::once((diagnostic.span, &diagnostic.label));
    for (span, label) in places.chain(diagnostic.related.iter().map(|(span, note)| (*span, note))) {
        let (excerpt, column) = excerpt(span, sources);
        text += &format!("   ╭─[ {} ]\n   │{excerpt}\n   │{:column$}╰─ {}\n", sources.place(span), "", shown(label));
    }
    if let Some(help) = &diagnostic.help {
        text += &format!("   │Help: {}\n", shown(help));
    }
    text
}

/// Some characters around the start of the span, on one line, and how many of them come before it.
fn excerpt(span: Span, sources: &Sources) -> (String, usize) {
    const AROUND: usize = 40;
    let source = sources.get(span.source);
    let text = &source.text;
    let start = text.floor_char_boundary(span.start as usize);
    let line = &text[source.line(start).1.start..start];
    let before: Vec<char> = line.chars().rev().take(AROUND).collect();
    let cut = if before.len() == AROUND { "… " } else { "" };
    let after = text[start..].chars().take_while(|c| !LINE_ENDS.contains(c)).take(AROUND);
    let column = cut.chars().count() + before.len();
    let shown: String = before.into_iter().rev().chain(after).map(|c| if c == '\t' { ' ' } else { c }).collect();
    (format!("{cut}{}", pictured(&shown)), column)
}

/// The texts in the form of the drawing library, each cut into lines once.
struct Texts<'a> {
    sources: &'a Sources,
    drawn: BTreeMap<SourceId, ariadne::Source<Arc<str>>>,
}

impl ariadne::Cache<SourceId> for &mut Texts<'_> {
    type Storage = Arc<str>;

    fn fetch(&mut self, id: &SourceId) -> Result<&ariadne::Source<Arc<str>>, impl std::fmt::Debug> {
        let sources = self.sources;
        let source = self.drawn.entry(*id).or_insert_with(|| ariadne::Source::from(drawn_text(&sources.get(*id).text)));
        Ok::<_, std::convert::Infallible>(source)
    }

    fn display<'a>(&self, id: &'a SourceId) -> Option<impl std::fmt::Display + 'a> {
        Some(visible(&self.sources.get(*id).name).into_owned())
    }
}
