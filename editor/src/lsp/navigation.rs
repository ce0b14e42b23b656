//! From a name to where it is defined, and to where it is used.

use super::diagnostics::Places;
use super::library;
use super::session::{Answer, Session};
use lsp_types::{
    DocumentHighlight, DocumentHighlightKind, DocumentHighlightParams, GotoDefinitionParams, GotoDefinitionResponse,
    Location, ReferenceParams,
};
use rpl_lang::occurrences::Target;

pub(super) fn definition(
    session: &mut Session<'_>,
    params: GotoDefinitionParams,
) -> Answer<Option<GotoDefinitionResponse>> {
    let at = params.text_document_position_params;
    let analysis = session.analysis(&at.text_document.uri)?;
    let document = session.document(&at.text_document.uri)?;
    let byte = document.byte(at.position);
    let target = analysis.at(byte).map(|occurrence| occurrence.target);
    let place = match (target.and_then(|target| analysis.definition(target)), target) {
        (Some(span), _) => Places::of(&analysis).location_in(span, document),
        (None, Some(Target::Local(_))) => None,
        (None, _) => library::definition(session, document, &analysis, byte),
    };
    Ok(place.map(GotoDefinitionResponse::Scalar))
}

pub(super) fn references(session: &mut Session<'_>, params: ReferenceParams) -> Answer<Option<Vec<Location>>> {
    let at = params.text_document_position;
    let analysis = session.analysis(&at.text_document.uri)?;
    let document = session.document(&at.text_document.uri)?;
    let Some(occurrence) = analysis.at(document.byte(at.position)) else { return Ok(None) };
    let places = Places::of(&analysis);
    let wanted = analysis.of_target(occurrence.target);
    let wanted = wanted.filter(|one| params.context.include_declaration || !one.is_binding);
    Ok(Some(wanted.filter_map(|one| places.location_in(one.span, document)).collect()))
}

pub(super) fn highlights(
    session: &mut Session<'_>,
    params: DocumentHighlightParams,
) -> Answer<Option<Vec<DocumentHighlight>>> {
    let at = params.text_document_position_params;
    let analysis = session.analysis(&at.text_document.uri)?;
    let document = session.document(&at.text_document.uri)?;
    let Some(occurrence) = analysis.at(document.byte(at.position)) else { return Ok(None) };
    let here = analysis.of_target(occurrence.target).filter(|one| one.span.source == analysis.examined.source);
    let highlight = |one: &rpl_lang::occurrences::Occurrence| DocumentHighlight {
        range: document.range_of(one.span),
        kind: Some(if one.is_binding { DocumentHighlightKind::WRITE } else { DocumentHighlightKind::READ }),
    };
    Ok(Some(here.map(highlight).collect()))
}
