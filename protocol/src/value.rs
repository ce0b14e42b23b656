//! Values in JSON: `null`, `true` and `false`, integers, numbers, texts, `{"symbol": "cup"}`, and lists of
//! values. The same as readings of a robot, which they become.

use rpl_lang::bars::{only_symbol, written_name};
use rpl_runtime::robot::reading::{MAX_NESTING, Reading, ReadingList};
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use serde::de::{self, MapAccess, SeqAccess, Visitor};
use serde::ser::{self, SerializeMap};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;

/// The one key of an object that is a symbol.
const SYMBOL: &str = "symbol";

/// An argument with more values in it, however deep, is not said.
const MOST_VALUES: usize = 100_000;

/// A value as it is said: a reading in JSON. A float in it is finite.
#[derive(Clone, Debug, PartialEq)]
pub struct Spoken(pub Reading);

impl Serialize for Spoken {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        said(&self.0, serializer)
    }
}

fn said<S: Serializer>(reading: &Reading, serializer: S) -> Result<S::Ok, S::Error> {
    match reading {
        Reading::Truth(truth) => serializer.serialize_bool(*truth),
        Reading::Int(number) => serializer.serialize_i64(*number),
        Reading::Float(number) if number.is_finite() => serializer.serialize_f64(*number),
        Reading::Float(number) => Err(ser::Error::custom(format!("{number} cannot be said in JSON"))),
        Reading::Text(text) => serializer.serialize_str(text),
        Reading::Symbol(name) => {
            let mut object = serializer.serialize_map(Some(1))?;
            object.serialize_entry(SYMBOL, &*written_name(name))?;
            object.end()
        }
        Reading::List(list) => serializer.collect_seq(list.items().iter().cloned().map(Spoken)),
    }
}

impl<'de> Deserialize<'de> for Spoken {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(SpokenVisitor).map(Spoken)
    }
}

struct SpokenVisitor;

impl<'de> Visitor<'de> for SpokenVisitor {
    type Value = Reading;

    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("null, true, false, a number, a text, a list, or {\"symbol\": \"name\"}")
    }

    fn visit_unit<E: de::Error>(self) -> Result<Reading, E> {
        Ok(Reading::Truth(false))
    }

    fn visit_bool<E: de::Error>(self, truth: bool) -> Result<Reading, E> {
        Ok(Reading::Truth(truth))
    }

    fn visit_i64<E: de::Error>(self, number: i64) -> Result<Reading, E> {
        Ok(Reading::Int(number))
    }

    /// What does not fit 64 bits is a float, like what does not fit 65.
    fn visit_u64<E: de::Error>(self, number: u64) -> Result<Reading, E> {
        Ok(i64::try_from(number).map_or(Reading::Float(number as f64), Reading::Int))
    }

    fn visit_f64<E: de::Error>(self, number: f64) -> Result<Reading, E> {
        if number.is_finite() { Ok(Reading::Float(number)) } else { Err(E::custom("a number must be finite")) }
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Reading, E> {
        Ok(Reading::Text(text.to_string()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Reading, A::Error> {
        let mut readings = Vec::new();
        while let Some(Spoken(reading)) = items.next_element()? {
            readings.push(reading);
        }
        ReadingList::new(readings).map(Reading::List).map_err(de::Error::custom)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Reading, A::Error> {
        let no_symbol = || de::Error::custom("an object is a value only as {\"symbol\": \"name\"}");
        if entries.next_key::<Cow<'de, str>>()?.as_deref() != Some(SYMBOL) {
            return Err(no_symbol());
        }
        let name: String = entries.next_value()?;
        if entries.next_key::<Cow<'de, str>>()?.is_some() {
            return Err(no_symbol());
        }
        symbol(&name).map_err(de::Error::custom)
    }
}

/// The reading that a symbol stands for, written as in plans: between bars, if it is not one word in lower case.
///
/// # Errors
/// It is not written so.
pub fn symbol(written: &str) -> Result<Reading, String> {
    match only_symbol(written).as_deref() {
        Some("nil") => Ok(Reading::Truth(false)),
        Some("t") => Ok(Reading::Truth(true)),
        Some(name) => Ok(Reading::Symbol(name.to_string())),
        None => Err(format!("{} is no name of a symbol", serde_json::Value::from(written))),
    }
}

/// Whether a name is one word: it is read as one symbol without bars, and as no number or keyword.
pub fn is_name(name: &str) -> bool {
    let is_apart = |c: char| c.is_whitespace() || c.is_control() || "()[]{}\"'`,;|#\\".contains(c);
    !name.is_empty()
        && name.chars().count() <= 255
        && !name.contains(is_apart)
        && !name.starts_with(':')
        && name != "."
        && name.parse::<f64>().is_err()
}

impl Spoken {
    /// A value of a plan as it is said.
    ///
    /// # Errors
    /// It cannot be said, as a clause: it is a function or the like, a list in a circle, nested too deep,
    /// not finite, or endless.
    pub fn of(machine: &Machine, value: Value) -> Result<Self, String> {
        let mut left = MOST_VALUES;
        reading(machine, value, MAX_NESTING, &mut left).map(Self)
    }
}

/// `deeper` is how many lists may still be inside one another, `left` how many values there may be.
fn reading(machine: &Machine, value: Value, deeper: usize, left: &mut usize) -> Result<Reading, String> {
    *left = left.checked_sub(1).ok_or_else(|| format!("it has more than {MOST_VALUES} values in it"))?;
    match value {
        Value::Nil => Ok(Reading::Truth(false)),
        Value::True => Ok(Reading::Truth(true)),
        Value::Int(number) => Ok(Reading::Int(number)),
        Value::Float(number) if number.is_finite() => Ok(Reading::Float(number)),
        Value::Float(_) => Err("it is a number that is not finite, and JSON has none".to_string()),
        Value::Symbol(name) => Ok(Reading::Symbol(machine.symbols.name(name).to_string())),
        Value::Str(text) => Ok(Reading::Text(machine.heap.strings[text].to_string())),
        Value::Cons(_) => {
            let deeper = deeper.checked_sub(1).ok_or_else(|| format!("its lists are more than {MAX_NESTING} deep"))?;
            let (mut readings, mut spine) = (Vec::new(), machine.heap.spine(value));
            for (_, item) in &mut spine {
                readings.push(reading(machine, item, deeper, left)?);
            }
            if spine.rest() != Value::Nil {
                return Err("it is no proper list".to_string());
            }
            ReadingList::new(readings).map(Reading::List).map_err(|fault| fault.to_string())
        }
        Value::Keyword(_)
        | Value::Cell(_)
        | Value::Function(_)
        | Value::Closure(_)
        | Value::Native(_)
        | Value::Fluent(_)
        | Value::Task(_)
        | Value::Valve(_)
        | Value::Failure(_)
        | Value::Table(_)
        | Value::Vector(_)
        | Value::Behaviour(_)
        | Value::Unbound => Err("only truths, numbers, symbols, texts and lists of these can be said".to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heard(text: &str) -> Result<Reading, String> {
        serde_json::from_str::<Spoken>(text).map(|spoken| spoken.0).map_err(|error| error.to_string())
    }

    #[test]
    fn what_is_said_is_heard_as_it_was() {
        for text in [
            "true",
            "false",
            "-3",
            "0.1",
            "1e300",
            "\"two words\"",
            "{\"symbol\":\"cup\"}",
            "{\"symbol\":\"|two words|\"}",
            "{\"symbol\":\"|Foo|\"}",
            "[1,[2.5,[]],\"x\"]",
        ] {
            let spoken: Spoken = serde_json::from_str(text).expect("it is a value");
            let again: Spoken =
                serde_json::from_str(&serde_json::to_string(&spoken).expect("it can be said")).expect("and heard");
            assert_eq!(again, spoken, "{text}");
        }
        assert_eq!(heard("null"), Ok(Reading::Truth(false)));
        assert_eq!(heard("{\"symbol\":\"NIL\"}"), Ok(Reading::Truth(false)));
        assert_eq!(heard("{\"symbol\":\"Cup\"}"), Ok(Reading::Symbol("cup".into())));
        assert_eq!(heard("{\"symbol\":\"|Two words|\"}"), Ok(Reading::Symbol("Two words".into())));
        assert_eq!(heard("9223372036854775808"), Ok(Reading::Float(9_223_372_036_854_775_808.0)));
    }

    #[test]
    fn what_is_no_value_is_refused() {
        let deep = format!("{}{}", "[".repeat(65), "]".repeat(65));
        for (text, reason) in [
            ("{}", "an object is a value only as"),
            ("{\"symbol\":\"a\",\"b\":1}", "an object is a value only as"),
            ("{\"name\":\"a\"}", "an object is a value only as"),
            ("{\"symbol\":\"a b\"}", "no name of a symbol"),
            ("{\"symbol\":\"12\"}", "no name of a symbol"),
            ("1e400", "number out of range"),
            ("NaN", "expected"),
            (&deep, "nested at most 64 deep"),
        ] {
            let fault = heard(text).expect_err(text);
            assert!(fault.contains(reason), "{text}: {fault}");
        }
    }
}
