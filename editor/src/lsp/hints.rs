//! The names of parameters in front of arguments that do not say what they are: numbers, texts, `t` and `nil` in calls
//! of plans, of functions of the text, and of behaviours.

use super::session::{Answer, Session};
use super::signatures::{given, parts};
use crate::analysis::Analysis;
use crate::document::Document;
use crate::outline::{Lexeme, Outline};
use lsp_types::{InlayHint, InlayHintKind, InlayHintLabel, InlayHintParams};
use rpl_lang::bars::read_name;
use rpl_lang::code::{CodeKind, GlobalKind};
use rpl_lang::lexer::Token;
use rpl_lang::occurrences::Target;
use rpl_lang::symbol::base_name;
use rpl_mission::reference::NameKind;

/// The forms whose first argument is a behaviour, and whose others are those of the behaviour.
const OF_BEHAVIOURS: &[&str] = &["activate", "run-behaviour"];

pub(super) fn hints(session: &mut Session<'_>, params: InlayHintParams) -> Answer<Option<Vec<InlayHint>>> {
    let analysis = session.analysis(&params.text_document.uri)?;
    let document = session.document(&params.text_document.uri)?;
    let bytes = document.lines.bytes_of(&document.text, params.range);
    let outline = document.outline();
    let from = outline.lexemes.partition_point(|lexeme| lexeme.end < bytes.start);
    let calls = (from..outline.lexemes.len()).take_while(|&at| outline.lexemes[at].start <= bytes.end);
    let calls = calls.filter(|&at| outline.lexemes[at].token == Token::Open);
    Ok(Some(calls.flat_map(|opener| of_call(&analysis, document, &outline, opener)).collect()))
}

/// The hints for the arguments of a list, if it is a call.
fn of_call(analysis: &Analysis, document: &Document, outline: &Outline, opener: usize) -> Vec<InlayHint> {
    let arguments = given(outline, opener, usize::MAX);
    let word = |lexeme: Lexeme| &document.text[lexeme.start..lexeme.end];
    let is_literal = |at: usize| match outline.lexemes[at].token {
        Token::Int(_) | Token::Float(_) | Token::Str => true,
        Token::Symbol => matches!(&*read_name(word(outline.lexemes[at])), "t" | "nil"),
        _ => false,
    };
    // Most lists have none, and what they are need not be known.
    if !arguments.iter().any(|&at| is_literal(at)) {
        return Vec::new();
    }
    let Some(names) = parameters(analysis, document, outline, opener, &arguments) else { return Vec::new() };
    let is_keyword = |at: usize| outline.lexemes[at].token == Token::Keyword;
    let positional = arguments.into_iter().zip(names).take_while(|(at, _)| !is_keyword(*at));
    let told = positional.filter(|(at, name)| {
        let lexeme = outline.lexemes[*at];
        // Behind a mark, such as a quote, stands no value.
        let is_marked = matches!(outline.lexemes[at - 1].token, Token::Prefix(_));
        let is_same = word(lexeme).trim_matches('"').eq_ignore_ascii_case(name);
        is_literal(*at) && !is_marked && !is_same
    });
    let hint = |(at, name): (usize, String)| InlayHint {
        position: document.range(outline.lexemes[at].start..outline.lexemes[at].start).start,
        label: InlayHintLabel::String(format!("{name}:")),
        kind: Some(InlayHintKind::PARAMETER),
        text_edits: None,
        tooltip: None,
        padding_left: None,
        padding_right: Some(true),
        data: None,
    };
    told.map(hint).collect()
}

/// The names of the positional parameters for the arguments of a call, if it is one of those that have hints. That of a
/// behaviour is empty: it names itself.
fn parameters(
    analysis: &Analysis,
    document: &Document,
    outline: &Outline,
    opener: usize,
    arguments: &[usize],
) -> Option<Vec<String>> {
    let head = outline.lexemes[outline.items(opener).next()?];
    let head_word = &document.text[head.start..head.end];
    if head.token != Token::Symbol {
        return None;
    }
    if OF_BEHAVIOURS.contains(&base_name(&read_name(head_word))) {
        let behaviour = outline.lexemes[*arguments.first()?];
        let known = analysis.describe(&document.text[behaviour.start..behaviour.end])?;
        let is_behaviour = known.word == NameKind::Behaviour.word();
        // Its signature names it where a call does.
        return is_behaviour.then(|| positional(&known.signature));
    }
    let occurrence = analysis.at(head.start).filter(|one| one.is_certain && !one.is_binding)?;
    let Target::Global(number) = occurrence.target else { return None };
    let program = &analysis.examined.program;
    let global = &program.globals[number as usize];
    let GlobalKind::Function(code) = global.kind else { return None };
    let is_own = global.span.is_some_and(|span| span.source.0 >= program.library_sources);
    let is_plan = program.codes.get(code as usize)?.kind == CodeKind::Plan;
    (is_own || is_plan).then(|| analysis.describe(head_word)).flatten().map(|known| positional(&known.signature))
}

/// The parameters of a signature that are given by their places.
fn positional(signature: &str) -> Vec<String> {
    let ends = ["&rest", "&key", "&body"].iter().filter_map(|mark| signature.find(mark)).min();
    let parts = parts(signature).into_iter().take_while(|part| ends.is_none_or(|end| part.end <= end));
    let name =
        |part: &str| part.trim_matches(['(', '[', ']']).split_whitespace().next().unwrap_or_default().to_string();
    let names = parts.map(|part| name(&signature[part]));
    names.take_while(|name| !name.starts_with(':') && !name.ends_with("...")).map(|name| name.to_lowercase()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_end_where_they_have_no_places() {
        for (signature, names) in [
            ("(go-to place &key patience)", &["place"][..]),
            ("(f a &optional (b 2) &rest c)", &["a", "b"]),
            ("(activate pan X [Y] [:speed S])", &["pan", "x", "y"]),
            ("(now)", &[]),
        ] {
            assert_eq!(positional(signature), names, "{signature}");
        }
    }
}
