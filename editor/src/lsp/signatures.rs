//! How the form that is being typed is written, and which part of it comes now.

use super::completion::keywords_of;
use super::session::{Answer, Session};
use crate::outline::Outline;
use lsp_types::{
    Documentation, MarkupContent, MarkupKind, ParameterInformation, ParameterLabel, SignatureHelp, SignatureHelpParams,
    SignatureInformation,
};
use rpl_lang::bars::read_name;
use rpl_lang::lexer::Token;
use std::ops::Range;

pub(super) fn help(session: &mut Session<'_>, params: SignatureHelpParams) -> Answer<Option<SignatureHelp>> {
    let at = params.text_document_position_params;
    let analysis = session.last_analysis(&at.text_document.uri)?;
    let document = session.document(&at.text_document.uri)?;
    let byte = document.byte(at.position);
    let outline = document.outline();
    let Some(opener) = outline.opener(byte) else { return Ok(None) };
    let Some(known) = outline.head(&document.text, opener).and_then(|head| analysis.describe(head)) else {
        return Ok(None);
    };
    let given = given(&outline, opener, byte);
    let keyword = given.last().map(|&at| outline.lexemes[at]).filter(|lexeme| lexeme.token == Token::Keyword);
    let keyword = keyword.map(|lexeme| read_name(&document.text[lexeme.start..lexeme.end]).into_owned());
    let parts = parts(&known.signature);
    let active = active(&known.signature, &parts, given.len(), keyword.as_deref());
    let offset = |at: usize| known.signature[..at].encode_utf16().count() as u32;
    let parameters = parts.iter().map(|part| ParameterInformation {
        label: ParameterLabel::LabelOffsets([offset(part.start), offset(part.end)]),
        documentation: None,
    });
    let signature = SignatureInformation {
        parameters: Some(parameters.collect()),
        documentation: Some(Documentation::MarkupContent(MarkupContent {
            kind: MarkupKind::Markdown,
            value: known.doc.clone(),
        })),
        active_parameter: active.map(|active| active as u32),
        label: known.signature.clone(),
    };
    let active_parameter = signature.active_parameter;
    Ok(Some(SignatureHelp { signatures: vec![signature], active_signature: Some(0), active_parameter }))
}

/// What has been given to the form of a list before a place. A mark such as a quote is part of what stands behind it.
pub(super) fn given(outline: &Outline, opener: usize, byte: usize) -> Vec<usize> {
    let is_mark = |&at: &usize| matches!(outline.lexemes[at].token, Token::Prefix(_));
    outline.items(opener).skip(1).filter(|at| !is_mark(at) && end(outline, *at) < byte).collect()
}

fn end(outline: &Outline, at: usize) -> usize {
    match outline.lexemes[at].token {
        Token::Open => outline.list(at).end,
        _ => outline.lexemes[at].end,
    }
}

/// The parts of a signature behind its head, the marks of parameter lists left out.
pub(super) fn parts(signature: &str) -> Vec<Range<usize>> {
    let mut parts = Vec::new();
    let (mut depth, mut start) = (0usize, None);
    for (at, c) in signature.char_indices() {
        let is_border = depth == 1 && (c.is_whitespace() || c == ')');
        if is_border && let Some(start) = start.take() {
            parts.push(start..at);
        } else if depth == 1 && start.is_none() && !is_border {
            start = Some(at);
        }
        match c {
            '(' | '[' => depth += 1,
            ')' | ']' => depth = depth.saturating_sub(1),
            _ => {}
        }
    }
    let behind_head = parts.into_iter().skip(1);
    behind_head.filter(|part| !signature[part.clone()].starts_with('&')).collect()
}

/// The part that comes after `given` have been given, the last of which may be a keyword.
fn active(signature: &str, parts: &[Range<usize>], given: usize, keyword: Option<&str>) -> Option<usize> {
    let word = |part: &Range<usize>| signature[part.clone()].trim_matches(|c: char| "()[].".contains(c));
    if let Some(keyword) = keyword {
        let is_known = keywords_of(signature).any(|known| known == keyword);
        let at = parts
            .iter()
            .position(|part| word(part) == &keyword[1..] || word(part).split_whitespace().next() == Some(keyword));
        return at.filter(|_| is_known);
    }
    let last = parts.len().checked_sub(1)?;
    let goes_on =
        signature[parts[last].clone()].ends_with("...") || signature.contains("&rest") || signature.contains("&body");
    match given {
        given if given <= last => Some(given),
        _ => goes_on.then_some(last),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_a_signature_are_what_is_given() {
        let signature = "(wait-for FLUENT [:timeout SECONDS])";
        let parts = parts(signature);
        let words: Vec<&str> = parts.iter().map(|part| &signature[part.clone()]).collect();
        assert_eq!(words, ["FLUENT", "[:timeout SECONDS]"]);
        assert_eq!(active(signature, &parts, 0, None), Some(0));
        assert_eq!(active(signature, &parts, 2, Some(":timeout")), Some(1));
        assert_eq!(active(signature, &parts, 3, None), None);
    }

    #[test]
    fn what_is_quoted_is_given_once() {
        let text = "(deliver 'mail '(a b) #'car ";
        assert_eq!(given(&Outline::of(text), 0, text.len()).len(), 3);
    }

    #[test]
    fn what_may_be_repeated_is_the_last_part() {
        let signature = "(let ((NAME VALUE)...) FORM...)";
        let parts = parts(signature);
        assert_eq!(parts.len(), 2);
        assert_eq!(active(signature, &parts, 5, None), Some(1));
        assert_eq!(super::parts("(now)"), []);
    }
}
