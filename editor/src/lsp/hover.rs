//! What is said of the name under the pointer.

use super::session::{Answer, Session};
use crate::analysis::{Analysis, Description};
use crate::document::Document;
use crate::surroundings::Surroundings;
use lsp_types::{Hover, HoverContents, HoverParams, MarkupContent, MarkupKind};
use rpl_lang::bars::read_name;
use rpl_lang::lexer::{Prefix, Token};
use rpl_lang::occurrences::Target;

pub(super) fn hover(session: &mut Session<'_>, params: HoverParams) -> Answer<Option<Hover>> {
    let at = params.text_document_position_params;
    let analysis = session.analysis(&at.text_document.uri)?;
    let document = session.document(&at.text_document.uri)?;
    let byte = document.byte(at.position);
    let outline = document.outline();
    let Some(token) = outline.at(byte) else { return Ok(None) };
    let lexeme = outline.lexemes[token];
    if !matches!(lexeme.token, Token::Symbol | Token::Keyword) {
        return Ok(None);
    }
    let written = &document.text[lexeme.start..lexeme.end];
    let name = read_name(written);
    let is_quoted = token > 0 && outline.lexemes[token - 1].token == Token::Prefix(Prefix::Quote);
    let place = || is_quoted.then(|| place(session.surroundings(), document, &analysis, &name)).flatten();
    let said =
        local(&analysis, byte).or_else(place).or_else(|| analysis.describe(written).map(|known| markdown(&known)));
    Ok(said.map(|value| Hover {
        contents: HoverContents::Markup(MarkupContent { kind: MarkupKind::Markdown, value }),
        range: Some(document.range(lexeme.start..lexeme.end)),
    }))
}

/// A variable or tag, which hides whatever else has its name.
fn local(analysis: &Analysis, byte: usize) -> Option<String> {
    let Target::Local(number) = analysis.at(byte)?.target else { return None };
    let (name, _) = analysis.examined.resolved.variable(number)?;
    let place = analysis.definition(Target::Local(number))?;
    let sources = &analysis.examined.program.sources;
    let name = analysis.examined.symbols.name(name);
    Some(format!("`{name}` – bound in line {}", sources.line_column(place).0))
}

/// A place of the world.
fn place(surroundings: &dyn Surroundings, document: &Document, analysis: &Analysis, name: &str) -> Option<String> {
    let known = world_of(surroundings, document, analysis)?;
    known.names.iter().any(|place| place == name).then(|| format!("`{name}` – a place in the world `{}`", known.world))
}

/// The places of the world that a text is for: the project's, the one its tests name, or the one plans are tried in.
pub(super) fn world_of(
    surroundings: &dyn Surroundings,
    document: &Document,
    analysis: &Analysis,
) -> Option<rpl_lang::check::KnownPlaces> {
    if let Some(world) = &analysis.setting.world {
        return Some(world.clone());
    }
    let named = analysis.examined.tests.iter().find_map(|test| test.options.world.as_deref());
    surroundings.places(&document.path, named)
}

/// A description as it is shown.
pub(super) fn markdown(known: &Description) -> String {
    let example = match known.example {
        "" => String::new(),
        example => format!("\n\n```rpl\n{example}\n```"),
    };
    format!("```rpl\n{}\n```\n\n{}{example}\n\n*a {}*", known.signature, known.doc, known.word)
}
