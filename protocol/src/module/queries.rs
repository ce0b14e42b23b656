//! Queries: functions of plans that a module in another process answers, at once and in the middle of an instant.

use super::manifest::{Manifest, QuerySpec};
use super::message::MOST_BYTES;
use crate::value::Spoken;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::step::native::{Call, Effect, Native, NativeCode, Reply};
use std::sync::Arc;

/// What asks a module of a name, in a call of a plan.
pub(super) type Ask = fn(&mut Call<'_, '_>, &str) -> Result<Reply, Raise>;

/// The queries of a manifest, as functions of plans.
pub(super) fn natives(manifest: &Manifest, ask: Ask) -> Vec<Native> {
    let native = |query: &QuerySpec| {
        let module = manifest.name.clone();
        Native {
            name: kept(&query.name),
            parameters: kept(&query.parameters),
            doc: kept(&query.doc),
            effect: Effect::None,
            code: NativeCode::Capturing(Arc::new(move |call| ask(call, &module))),
        }
    };
    manifest.queries.iter().map(native).collect()
}

/// A text for as long as the program runs. A manifest is read once for each site, however many runs it has.
fn kept(text: &str) -> &'static str {
    Box::leak(text.into())
}

/// The arguments of a call as they are said.
///
/// # Errors
/// An argument cannot be said, or they are too long together.
pub(super) fn said(call: &Call<'_, '_>) -> Result<Vec<Spoken>, Raise> {
    let mut said = Vec::new();
    for (at, &value) in call.arguments.iter().enumerate() {
        said.push(Spoken::of(call.machine, value).map_err(|reason| {
            Raise::type_error(format!("{} cannot be told to its module: {reason}", call.which(at)))
        })?);
    }
    let bytes = serde_json::to_vec(&said).map_or(usize::MAX, |text| text.len());
    if bytes > MOST_BYTES / 2 {
        let name = call.native.name;
        return Err(Raise::type_error(format!("the arguments of `{name}` are too long for its module: {bytes} bytes")));
    }
    Ok(said)
}
