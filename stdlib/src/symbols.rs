//! Symbols and keywords from names and back.

use crate::arguments::{NativeResult, count, pure, text, value};
use rpl_lang::symbol::{Symbol, Symbols, fold_name, is_uninterned};
use rpl_lang::visible::quoted;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native};

fn symbol_name(call: &mut Call<'_, '_>) -> NativeResult {
    let name = match call.argument(0) {
        Value::Nil => "nil".to_string(),
        Value::True => "t".to_string(),
        Value::Symbol(name) | Value::Keyword(name) => call.machine.symbols.name(name).to_string(),
        _ => return Err(call.wrong_type(0)),
    };
    text(call, &name)
}

/// The symbol a reader would make of the name in the first argument.
fn folded(call: &mut Call<'_, '_>) -> Result<Symbol, Raise> {
    let name = call.name(0)?;
    let name = fold_name(&name);
    if is_uninterned(&name) {
        return Err(Raise::type_error(format!(
            "{} must be the name of a symbol, not of one that `gensym` has made, and it is {}",
            call.which(0),
            quoted(&name)
        )));
    }
    Ok(named(call, |symbols| symbols.intern(&name)))
}

/// A symbol that may be new: names count as what is made.
pub(super) fn named(call: &mut Call<'_, '_>, name: impl FnOnce(&mut Symbols) -> Symbol) -> Symbol {
    let before = call.machine.symbols.bytes();
    let symbol = name(&mut call.machine.symbols);
    call.machine.heap.allocated += call.machine.symbols.bytes() - before;
    symbol
}

fn intern(call: &mut Call<'_, '_>) -> NativeResult {
    if let Value::Nil | Value::True | Value::Symbol(_) = call.argument(0) {
        return value(call.argument(0));
    }
    let symbol = folded(call)?;
    value(match call.machine.symbols.name(symbol) {
        "nil" => Value::Nil,
        "t" => Value::True,
        _ => Value::Symbol(symbol),
    })
}

fn make_keyword(call: &mut Call<'_, '_>) -> NativeResult {
    value(Value::Keyword(folded(call)?))
}

fn gensym(call: &mut Call<'_, '_>) -> NativeResult {
    let stem = if count(call) > 0 { call.name(0)? } else { "g".to_string() };
    value(Value::Symbol(named(call, |symbols| symbols.uninterned(&stem))))
}

/// Symbols and keywords.
pub(super) const NATIVES: &[Native] = &[
    pure("symbol-name", "symbol", "The name of a symbol, or of a keyword without its colon.", symbol_name),
    pure("intern", "name", "The symbol of this name, in lower case.", intern),
    pure("make-keyword", "name", "The keyword of this name, in lower case.", make_keyword),
    pure("gensym", "&optional stem", "A new symbol that no text can name.", gensym),
];
