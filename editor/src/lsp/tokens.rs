//! What each word is, for editors that colour by meaning: by its token and by the tables of names.

use super::session::{Answer, Session};
use crate::analysis::Analysis;
use crate::definitions::is_definition;
use crate::document::Document;
use lsp_types::{
    SemanticToken, SemanticTokenModifier, SemanticTokenType, SemanticTokens, SemanticTokensLegend,
    SemanticTokensParams, SemanticTokensRangeParams, SemanticTokensRangeResult, SemanticTokensResult,
};
use rpl_lang::bars::read_name;
use rpl_lang::code::{CodeKind, GlobalKind};
use rpl_lang::compile::DefinedKind;
use rpl_lang::lexer::{Prefix, Token};
use rpl_lang::symbol::Qualifier;
use rpl_mission::reference::NameKind;
use std::collections::BTreeMap;
use std::ops::Range;

/// The types, in the order of their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Type {
    Comment,
    Text,
    Number,
    Form,
    Macro,
    Function,
    Plan,
    Fluent,
    Variable,
    Robot,
    Class,
    Keyword,
    Quoted,
}

const TYPES: &[(Type, SemanticTokenType)] = &[
    (Type::Comment, SemanticTokenType::COMMENT),
    (Type::Text, SemanticTokenType::STRING),
    (Type::Number, SemanticTokenType::NUMBER),
    (Type::Form, SemanticTokenType::KEYWORD),
    (Type::Macro, SemanticTokenType::MACRO),
    (Type::Function, SemanticTokenType::FUNCTION),
    (Type::Plan, SemanticTokenType::METHOD),
    (Type::Fluent, SemanticTokenType::PROPERTY),
    (Type::Variable, SemanticTokenType::VARIABLE),
    (Type::Robot, SemanticTokenType::NAMESPACE),
    (Type::Class, SemanticTokenType::CLASS),
    (Type::Keyword, SemanticTokenType::PARAMETER),
    (Type::Quoted, SemanticTokenType::ENUM_MEMBER),
];

/// The bit of a name where it is defined, and of a name that comes with the language.
const DEFINITION: u32 = 1;
const LIBRARY: u32 = 2;

pub(super) fn legend() -> SemanticTokensLegend {
    SemanticTokensLegend {
        token_types: TYPES.iter().map(|(_, name)| name.clone()).collect(),
        token_modifiers: vec![SemanticTokenModifier::DEFINITION, SemanticTokenModifier::DEFAULT_LIBRARY],
    }
}

pub(super) fn full(session: &mut Session<'_>, params: SemanticTokensParams) -> Answer<Option<SemanticTokensResult>> {
    let analysis = session.last_analysis(&params.text_document.uri)?;
    let document = session.document(&params.text_document.uri)?;
    let data = tokens(document, &analysis, 0..document.text.len());
    Ok(Some(SemanticTokensResult::Tokens(SemanticTokens { result_id: None, data })))
}

pub(super) fn range(
    session: &mut Session<'_>,
    params: SemanticTokensRangeParams,
) -> Answer<Option<SemanticTokensRangeResult>> {
    let analysis = session.last_analysis(&params.text_document.uri)?;
    let document = session.document(&params.text_document.uri)?;
    let bytes = document.lines.bytes_of(&document.text, params.range);
    let data = tokens(document, &analysis, bytes);
    Ok(Some(SemanticTokensRangeResult::Tokens(SemanticTokens { result_id: None, data })))
}

/// The tokens that touch some bytes. What names mean was found when the text was last looked at; where they stand is
/// where they stand now.
fn tokens(document: &Document, analysis: &Analysis, within: Range<usize>) -> Vec<SemanticToken> {
    let outline = document.outline();
    let names = Names::of(analysis);
    let from = outline.lexemes.partition_point(|lexeme| lexeme.end < within.start);
    let mut encoder = Encoder { document, line: 0, column: 0, tokens: Vec::new() };
    for at in from..outline.lexemes.len() {
        let lexeme = outline.lexemes[at];
        if lexeme.start > within.end {
            break;
        }
        let before = at.checked_sub(1).map(|before| outline.lexemes[before].token);
        let found = match lexeme.token {
            Token::LineComment | Token::BlockComment => Some((Type::Comment, 0)),
            Token::Str => Some((Type::Text, 0)),
            Token::Int(_) | Token::Float(_) => Some((Type::Number, 0)),
            Token::Keyword => Some((Type::Keyword, 0)),
            Token::Symbol if before == Some(Token::Prefix(Prefix::Quote)) => Some((Type::Quoted, 0)),
            Token::Symbol => {
                let name = read_name(&document.text[lexeme.start..lexeme.end]);
                let is_head = before == Some(Token::Open) || before == Some(Token::Prefix(Prefix::Function));
                names.meaning(&name, is_head).map(|(kind, library)| (kind, if library { LIBRARY } else { 0 }))
            }
            _ => None,
        };
        if let Some((kind, modifiers)) = found {
            let is_defined = modifiers & LIBRARY == 0 && at >= 2 && {
                let head = outline.lexemes[at - 1];
                outline.lexemes[at - 2].token == Token::Open
                    && head.token == Token::Symbol
                    && is_definition(&document.text[head.start..head.end])
            };
            encoder.add(lexeme.start..lexeme.end, kind, if is_defined { modifiers | DEFINITION } else { modifiers });
        }
    }
    encoder.tokens
}

/// What the names of the language and of the texts are.
struct Names<'a> {
    analysis: &'a Analysis,
    own: BTreeMap<&'a str, Type>,
}

impl<'a> Names<'a> {
    fn of(analysis: &'a Analysis) -> Self {
        let own = analysis.defined().map(|(name, _, kind)| {
            let kind = match kind {
                DefinedKind::Function(CodeKind::Plan) => Type::Plan,
                DefinedKind::Function(_) => Type::Function,
                DefinedKind::Macro => Type::Macro,
                DefinedKind::Failure => Type::Class,
                DefinedKind::Value => match analysis.global(name) {
                    Some(GlobalKind::Fluent) => Type::Fluent,
                    Some(GlobalKind::Valve { .. }) => Type::Robot,
                    _ => Type::Variable,
                },
            };
            (name, kind)
        });
        Self { analysis, own: own.collect() }
    }

    /// What a name is, and whether it comes with the language. A word that is a form only at the head of a list is
    /// elsewhere a name like others.
    fn meaning(&self, name: &str, is_head: bool) -> Option<(Type, bool)> {
        let (qualifier, name) =
            Qualifier::split(name).map_or((None, name), |(qualifier, base)| (Some(qualifier), base));
        if let Some(&kind) = self.own.get(name)
            && qualifier != Some(Qualifier::Library)
        {
            return Some((kind, false));
        }
        let entry = self.analysis.setting.reference.find(name)?;
        let kind = match entry.kind {
            NameKind::SpecialForm | NameKind::Macro if !is_head => return None,
            NameKind::SpecialForm | NameKind::Macro => Type::Form,
            NameKind::Plan => Type::Plan,
            NameKind::Function => Type::Function,
            NameKind::Fluent => Type::Fluent,
            NameKind::Variable => Type::Variable,
            NameKind::Behaviour | NameKind::Valve => Type::Robot,
            NameKind::FailureClass => Type::Class,
            NameKind::Command => return None,
        };
        Some((kind, true))
    }
}

/// Tokens as the protocol writes them: each from the one before, none over the end of a line.
struct Encoder<'d> {
    document: &'d Document,
    line: u32,
    column: u32,
    tokens: Vec<SemanticToken>,
}

impl Encoder<'_> {
    fn add(&mut self, bytes: Range<usize>, kind: Type, token_modifiers_bitset: u32) {
        let text = &self.document.text[bytes.clone()];
        for (at, line) in rpl_lang::source::lines(text) {
            let start = self.document.lines.position(&self.document.text, bytes.start + at);
            let length = line.chars().map(char::len_utf16).sum::<usize>() as u32;
            if length == 0 {
                continue;
            }
            let delta_line = start.line - self.line;
            let delta_start = if delta_line == 0 { start.character - self.column } else { start.character };
            (self.line, self.column) = (start.line, start.character);
            let token_type = kind as u32;
            self.tokens.push(SemanticToken { delta_line, delta_start, length, token_type, token_modifiers_bitset });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_of_the_types_are_their_places_in_the_legend() {
        for (number, (kind, _)) in TYPES.iter().enumerate() {
            assert_eq!(*kind as usize, number);
        }
    }
}
