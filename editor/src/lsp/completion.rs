//! The words that can stand where one is typed.

use super::hover::{markdown, world_of};
use super::session::{Answer, Session};
use crate::analysis::Analysis;
use crate::document::Document;
use crate::outline::Outline;
use lsp_types::{
    CompletionItem, CompletionItemKind, CompletionList, CompletionParams, CompletionResponse, CompletionTextEdit,
    Documentation, MarkupContent, MarkupKind, TextEdit,
};
use rpl_lang::bars::{read_name, written_name};
use rpl_lang::code::{CodeKind, GlobalKind};
use rpl_lang::compile::DefinedKind;
use rpl_lang::lexer::{Prefix, Token};
use rpl_lang::symbol::{Qualifier, base_name};
use rpl_mission::reference::NameKind;
use std::collections::BTreeMap;

/// What can be typed, by its word.
type Words = BTreeMap<String, (CompletionItemKind, String)>;

pub(super) fn complete(session: &mut Session<'_>, params: CompletionParams) -> Answer<Option<CompletionResponse>> {
    let at = params.text_document_position;
    // The text is being typed: what was known of it before says what it defines.
    let analysis = session.last_analysis(&at.text_document.uri)?;
    let document = session.document(&at.text_document.uri)?;
    let byte = document.byte(at.position);
    let outline = document.outline();
    let token = outline.at(byte).filter(|&token| outline.lexemes[token].start < byte);
    let lexeme = token.map(|token| outline.lexemes[token]);
    let typed = match lexeme {
        Some(lexeme) => match lexeme.token {
            Token::Str | Token::Unterminated => return Ok(None),
            Token::LineComment => return Ok(None),
            Token::BlockComment if byte < lexeme.end => return Ok(None),
            Token::Symbol | Token::Keyword | Token::Error => lexeme.start..byte,
            _ => byte..byte,
        },
        None => byte..byte,
    };
    let before = outline.lexemes.iter().rev().find(|lexeme| lexeme.end <= typed.start);
    let is_quoted = before.is_some_and(|one| one.token == Token::Prefix(Prefix::Quote) && one.end == typed.start);
    let is_keyword = document.text[typed.clone()].starts_with(':');
    let mut words = Words::new();
    let typed_name = read_name(&document.text[typed.clone()]).into_owned();
    // What is typed may be the qualifier only.
    let qualifiers = [Qualifier::Library, Qualifier::Global];
    let qualifier = qualifiers.into_iter().find(|qualifier| typed_name.starts_with(qualifier.prefix()));
    if let Some(qualifier) = qualifier {
        qualified(&analysis, qualifier, &mut words);
    } else if is_keyword {
        keywords(document, &outline, &analysis, typed.start, &mut words);
    } else {
        if is_quoted && let Some(world) = world_of(session.surroundings(), document, &analysis) {
            let detail = format!("a place in the world {}", world.world);
            words.extend(world.names.into_iter().map(|name| (name, (CompletionItemKind::ENUM_MEMBER, detail.clone()))));
        }
        names(document, &outline, &analysis, typed.clone(), &mut words);
    }
    let wanted = wanted(document, &outline, typed.start);
    let range = document.range(typed);
    let items = words.into_iter().map(|(label, (kind, detail))| {
        let is_first =
            wanted.is_some_and(|wanted| wanted == kind) || is_quoted && kind == CompletionItemKind::ENUM_MEMBER;
        CompletionItem {
            sort_text: Some(format!("{}{label}", if is_first { '0' } else { '1' })),
            kind: Some(kind),
            detail: Some(detail),
            text_edit: Some(CompletionTextEdit::Edit(TextEdit::new(range, label.clone()))),
            data: Some(at.text_document.uri.as_str().into()),
            label,
            ..CompletionItem::default()
        }
    });
    Ok(Some(CompletionResponse::List(CompletionList { is_incomplete: false, items: items.collect() })))
}

/// The documentation of what was offered, when it is looked at.
pub(super) fn resolve(session: &mut Session<'_>, mut item: CompletionItem) -> Answer<CompletionItem> {
    let uri = item.data.as_ref().and_then(|uri| uri.as_str()).and_then(|uri| uri.parse().ok());
    let Some(uri) = uri else { return Ok(item) };
    if let Some(known) = session.last_analysis(&uri)?.describe(&item.label) {
        let value = markdown(&known);
        item.documentation = Some(Documentation::MarkupContent(MarkupContent { kind: MarkupKind::Markdown, value }));
    }
    Ok(item)
}

/// Names of the language, of the texts, and those that stand in the form around.
fn names(
    document: &Document,
    outline: &Outline,
    analysis: &Analysis,
    typed: std::ops::Range<usize>,
    words: &mut Words,
) {
    // What is bound around the place is a name of the form; so may others be that are typed for the first time.
    if let Some(form) = outline.form(typed.start) {
        let from = outline.lexemes.partition_point(|lexeme| lexeme.start < form.start);
        let inside = outline.lexemes[from..].iter().take_while(|lexeme| lexeme.end <= form.end);
        for lexeme in inside.filter(|lexeme| lexeme.token == Token::Symbol && lexeme.start != typed.start) {
            let name = read_name(&document.text[lexeme.start..lexeme.end]);
            words.insert(written_name(&name).into_owned(), (CompletionItemKind::VARIABLE, String::new()));
        }
    }
    names_of_language(analysis, words);
    names_of_texts(analysis, words);
}

/// The names that a qualifier may stand in front of, with it.
fn qualified(analysis: &Analysis, qualifier: Qualifier, words: &mut Words) {
    let mut names = Words::new();
    names_of_language(analysis, &mut names);
    if qualifier == Qualifier::Global {
        names_of_texts(analysis, &mut names);
    }
    // Classes of failures are no values.
    names.retain(|_, (kind, _)| *kind != CompletionItemKind::CLASS);
    let with_qualifier =
        |name: String| written_name(&format!("{}{}", qualifier.prefix(), read_name(&name))).into_owned();
    words.extend(names.into_iter().map(|(name, known)| (with_qualifier(name), known)));
}

fn names_of_language(analysis: &Analysis, words: &mut Words) {
    for entry in analysis.setting.reference.names() {
        words.insert(entry.name.clone(), (kind_of(entry.kind), one_line(&entry.signature)));
    }
}

fn names_of_texts(analysis: &Analysis, words: &mut Words) {
    for (name, _, kind) in analysis.defined() {
        if name.starts_with(['%', '#']) {
            continue;
        }
        let kind = match kind {
            DefinedKind::Function(CodeKind::Plan) => CompletionItemKind::METHOD,
            DefinedKind::Function(_) => CompletionItemKind::FUNCTION,
            DefinedKind::Macro => CompletionItemKind::KEYWORD,
            DefinedKind::Failure => CompletionItemKind::CLASS,
            DefinedKind::Value => match analysis.global(name) {
                Some(GlobalKind::Fluent) => CompletionItemKind::PROPERTY,
                Some(GlobalKind::Valve { .. }) => CompletionItemKind::INTERFACE,
                _ => CompletionItemKind::VARIABLE,
            },
        };
        let signature = analysis.describe(name).map_or(String::new(), |known| one_line(&known.signature));
        words.insert(written_name(name).into_owned(), (kind, signature));
    }
}

/// The keywords that the form around takes: its own, and for a behaviour those of the behaviour.
fn keywords(document: &Document, outline: &Outline, analysis: &Analysis, byte: usize, words: &mut Words) {
    let Some(opener) = outline.opener(byte) else { return };
    let heads = outline.items(opener).take(2).map(|at| outline.lexemes[at]);
    let heads = heads.filter(|lexeme| lexeme.token == Token::Symbol && lexeme.end < byte);
    for lexeme in heads {
        let Some(known) = analysis.describe(&document.text[lexeme.start..lexeme.end]) else { continue };
        let detail = one_line(&known.signature);
        words.extend(keywords_of(&known.signature).map(|word| (word, (CompletionItemKind::FIELD, detail.clone()))));
    }
    if outline.head(&document.text, opener).is_none() {
        words.insert(":tag".into(), (CompletionItemKind::KEYWORD, "(:tag NAME FORM...)".into()));
    }
}

/// The keywords a signature names: those behind `&key`, and those it writes out.
pub(super) fn keywords_of(signature: &str) -> impl Iterator<Item = String> {
    let bare = |word: &str| word.trim_matches(|c: char| "()[].".contains(c)).to_string();
    let mut is_behind_key = false;
    let words: Vec<String> = signature.split_whitespace().map(bare).collect();
    words.into_iter().filter_map(move |word| {
        if word.starts_with('&') {
            is_behind_key = word == "&key";
            return None;
        }
        match word.starts_with(':') {
            true => Some(word).filter(|word| word.len() > 1),
            false => is_behind_key.then(|| format!(":{word}")),
        }
    })
}

/// The kind of name that is most likely meant behind some heads.
fn wanted(document: &Document, outline: &Outline, byte: usize) -> Option<CompletionItemKind> {
    let opener = outline.opener(byte)?;
    let head = outline.head(&document.text, opener)?;
    let is_first = outline.items(opener).nth(1).is_none_or(|at| outline.lexemes[at].start >= byte);
    match base_name(&read_name(head)) {
        "activate" | "deactivate" | "run-behaviour" | "await-signal" if is_first => Some(CompletionItemKind::MODULE),
        "with-valve" | "request-valve" | "release-valve" | "holds-valve?" if is_first => {
            Some(CompletionItemKind::INTERFACE)
        }
        "fail" | "ignore-failures" if is_first => Some(CompletionItemKind::CLASS),
        "wait-for" | "whenever" | "pulse" | "value" if is_first => Some(CompletionItemKind::PROPERTY),
        _ => None,
    }
}

fn kind_of(kind: NameKind) -> CompletionItemKind {
    match kind {
        NameKind::SpecialForm | NameKind::Macro | NameKind::Command => CompletionItemKind::KEYWORD,
        NameKind::Function => CompletionItemKind::FUNCTION,
        NameKind::Plan => CompletionItemKind::METHOD,
        NameKind::Fluent => CompletionItemKind::PROPERTY,
        NameKind::Behaviour => CompletionItemKind::MODULE,
        NameKind::Valve => CompletionItemKind::INTERFACE,
        NameKind::FailureClass => CompletionItemKind::CLASS,
        NameKind::Variable => CompletionItemKind::VARIABLE,
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
