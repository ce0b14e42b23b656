//! Queries: functions of plans that a module in another process answers, at once and in the middle of an instant.

use super::manifest::{Manifest, QuerySpec};
use super::message::MOST_BYTES;
use super::process_modules::ProcessModules;
use crate::value::Spoken;
use rpl_runtime::robot::Ending;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::step::native::{Call, Effect, Native, NativeCode, Reply};
use std::sync::Arc;

/// The queries of a manifest, as functions of plans.
pub(super) fn natives(manifest: &Manifest) -> Vec<Native> {
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

fn ask(call: &mut Call<'_, '_>, module: &str) -> Result<Reply, Raise> {
    let query = call.native.name;
    let arguments = said(call)?;
    let time_us = call.machine.now_us;
    match call.part::<ProcessModules>()?.ask(module, query, arguments, time_us) {
        Ok(reading) => Ok(Reply::Value(call.value_of(&reading))),
        Err(Ending::Failure { class, message, slots }) => Err(call.failure(class, message, slots)),
        Err(Ending::Success(_)) => unreachable!("a success is no failure"),
    }
}

/// # Errors
/// An argument cannot be said, or they are too long together.
fn said(call: &Call<'_, '_>) -> Result<Vec<Spoken>, Raise> {
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
