//! The findings of `rpl check`, as editors show them.

use super::library;
use super::session::Session;
use crate::analysis::Analysis;
use crate::document::{Document, uri_of};
use crate::lines::Lines;
use lsp_types::{
    Diagnostic as Shown, DiagnosticRelatedInformation, DiagnosticSeverity, DiagnosticTag, Location, NumberOrString,
    PublishDiagnosticsParams, Uri,
};
use rpl_lang::diagnostic::{Diagnostic, Severity};
use rpl_lang::source::{SourceId, Span};
use std::collections::{BTreeMap, BTreeSet};

/// Who says so, in the lists of editors.
const SOURCE: &str = "rpl";

/// What is found in a text is shown there, and what is found in a text it loads in that one, unless that is open and
/// has findings of its own.
pub(super) fn published(session: &mut Session<'_>, uri: &str, analysis: &Analysis) -> Vec<PublishDiagnosticsParams> {
    let Ok(own) = uri.parse::<Uri>() else { return Vec::new() };
    let Ok(document) = session.document(&own) else { return Vec::new() };
    if library::is_of_library(session, document) {
        return Vec::new();
    }
    let places = Places::of(analysis);
    let mut found: BTreeMap<SourceId, Vec<Shown>> = BTreeMap::new();
    for finding in &analysis.examined.diagnostics {
        found.entry(finding.span.source).or_default().push(shown(finding, &places));
    }
    let own_findings = found.remove(&analysis.examined.source).unwrap_or_default();
    let mut said = vec![PublishDiagnosticsParams::new(own, own_findings, Some(document.version))];
    let mut others = BTreeSet::new();
    for (source, findings) in found {
        let name = &analysis.examined.program.sources.get(source).name;
        if session.open.named(name).is_none()
            && let Some(other) = places.uri(source)
        {
            others.insert(other.clone());
            said.push(PublishDiagnosticsParams::new(other, findings, None));
        }
    }
    let before = session.told.insert(uri.to_string(), others.clone()).unwrap_or_default();
    // One that was opened meanwhile has findings of its own.
    let gone = before.difference(&others).filter(|other| session.open.get(other.as_str()).is_none());
    said.extend(gone.map(|gone| PublishDiagnosticsParams::new(gone.clone(), Vec::new(), None)));
    said
}

/// The findings of an open text that touch some bytes of it, each as it is shown.
pub(super) fn touching(
    analysis: &Analysis,
    bytes: std::ops::Range<usize>,
) -> impl Iterator<Item = (&Diagnostic, Shown)> {
    let places = Places::of(analysis);
    let source = analysis.examined.source;
    let touches =
        move |span: Span| span.source == source && span.start as usize <= bytes.end && bytes.start <= span.end as usize;
    let touching = analysis.examined.diagnostics.iter().filter(move |finding| touches(finding.span));
    touching.map(move |finding| (finding, shown(finding, &places)))
}

fn shown(finding: &Diagnostic, places: &Places<'_>) -> Shown {
    let help = finding.help.as_ref().map_or(String::new(), |help| format!("\n{help}"));
    let related = finding.related.iter().filter_map(|(span, note)| {
        let location = places.location(*span)?;
        Some(DiagnosticRelatedInformation { location, message: note.clone() })
    });
    let related: Vec<_> = related.collect();
    Shown {
        range: places.range(finding.span),
        severity: Some(match finding.severity {
            Severity::Error => DiagnosticSeverity::ERROR,
            Severity::Warning => DiagnosticSeverity::WARNING,
        }),
        code: Some(NumberOrString::String(finding.code.to_string())),
        source: Some(SOURCE.to_string()),
        message: format!("{}: {}{help}", finding.message, finding.label),
        related_information: Some(related).filter(|related| !related.is_empty()),
        tags: match finding.code {
            "unused-binding" | "unreachable-code" => Some(vec![DiagnosticTag::UNNECESSARY]),
            _ => None,
        },
        ..Shown::default()
    }
}

/// Where the texts of an analysis stand in files.
pub(super) struct Places<'a> {
    analysis: &'a Analysis,
    lines: BTreeMap<SourceId, Lines>,
}

impl<'a> Places<'a> {
    pub(super) fn of(analysis: &'a Analysis) -> Self {
        let sources = &analysis.examined.program.sources;
        let lines = analysis.sources().map(|source| (source, Lines::of(&sources.get(source).text))).collect();
        Self { analysis, lines }
    }

    /// The file of one of the texts; the library has none.
    pub(super) fn uri(&self, source: SourceId) -> Option<Uri> {
        let name = &self.analysis.examined.program.sources.get(source).name;
        self.lines.get(&source).and_then(|_| uri_of(name).or_else(|| name.parse().ok()))
    }

    pub(super) fn range(&self, span: Span) -> lsp_types::Range {
        let text = &self.analysis.examined.program.sources.get(span.source).text;
        let bytes = span.start as usize..span.end as usize;
        self.lines.get(&span.source).map_or_else(lsp_types::Range::default, |lines| lines.range(text, bytes))
    }

    pub(super) fn location(&self, span: Span) -> Option<Location> {
        Some(Location::new(self.uri(span.source)?, self.range(span)))
    }

    /// The same, in an open text under the name that the editor has for it.
    pub(super) fn location_in(&self, span: Span, open: &Document) -> Option<Location> {
        match span.source == self.analysis.examined.source {
            true => Some(Location::new(open.uri.clone(), self.range(span))),
            false => self.location(span),
        }
    }
}
