//! What a module declares of its behaviours, so that plans with them can be projected: how long they take, and how
//! they may fail.

use rpl_lang::symbol::Symbol;
use rpl_random::Stream;
use rpl_runtime::robot::RobotTables;
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;

/// How one behaviour usually goes.
#[derive(Clone, Debug, PartialEq)]
pub struct ActModel {
    /// How long it takes, in seconds: at least, most likely and at most, as a triangular distribution.
    pub takes_s: [f64; 3],
    /// Classes of failures in which it may end, each with its probability; together at most 1.
    pub failures: Vec<(String, f64)>,
    /// What it sets when it succeeds: names of fluents, each with its new value.
    pub sets: Vec<(String, Effect)>,
}

/// The value that a behaviour gives to a fluent.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect {
    /// Always this one.
    Value(Reading),
    /// That of the argument for a parameter, named without its colon; nil if there is none.
    Argument(String),
}

impl ActModel {
    /// Whether it always goes alike.
    pub fn is_certain(&self) -> bool {
        let [least_s, _, most_s] = self.takes_s;
        least_s == most_s && self.failures.iter().all(|&(_, probability)| probability == 0.0 || probability == 1.0)
    }

    /// What it sets when it succeeds after it was started with some arguments, by the places of fluents. A list as an
    /// argument, or anything else that is no symbol, number, text or truth, leaves its fluent as it is.
    pub fn effects(
        &self,
        tables: &RobotTables,
        machine: &Machine,
        arguments: &[(Symbol, Value)],
    ) -> Vec<(usize, Reading)> {
        let value = |effect: &Effect| match effect {
            Effect::Value(reading) => Some(reading.clone()),
            Effect::Argument(parameter) => {
                let named = |(key, _): &&(Symbol, Value)| machine.symbols.name(*key) == parameter;
                arguments.iter().find(named).map_or(Some(Reading::Truth(false)), |&(_, value)| reading(machine, value))
            }
        };
        let place = |name: &str| tables.fluents.iter().position(|fluent| fluent.name == name);
        self.sets.iter().filter_map(|(name, effect)| Some((place(name)?, value(effect)?))).collect()
    }

    /// How long it takes once, and the class of its failure, if it fails. Two numbers are drawn, whatever comes of
    /// them.
    pub fn drawn(&self, stream: &mut Stream) -> (f64, Option<&str>) {
        let (time, mut left) = (stream.uniform(), stream.uniform());
        let failure = self.failures.iter().find(|(_, probability)| {
            left -= probability;
            left < 0.0
        });
        (self.takes_s(time), failure.map(|(class, _)| class.as_str()))
    }

    /// The time below which a share of all lie: the distribution function, inverted.
    fn takes_s(&self, share: f64) -> f64 {
        let [least_s, likely_s, most_s] = self.takes_s;
        let whole_s = most_s - least_s;
        let rising_s = likely_s - least_s;
        if share * whole_s < rising_s {
            least_s + libm::sqrt(share * whole_s * rising_s)
        } else {
            most_s - libm::sqrt((1.0 - share) * whole_s * (most_s - likely_s))
        }
    }
}

/// A value that is no list, as a robot says it.
fn reading(machine: &Machine, value: Value) -> Option<Reading> {
    match value {
        Value::Nil => Some(Reading::Truth(false)),
        Value::True => Some(Reading::Truth(true)),
        Value::Int(number) => Some(Reading::Int(number)),
        Value::Float(number) => Some(Reading::Float(number)),
        Value::Symbol(symbol) => Some(Reading::Symbol(machine.symbols.name(symbol).to_string())),
        Value::Str(index) => Some(Reading::Text(machine.heap.strings[index].to_string())),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn acts_take_as_long_and_fail_as_often_as_is_declared() {
        let failures = vec![("lamp-failure".to_string(), 0.1), ("blocked".to_string(), 0.2)];
        let model = ActModel { takes_s: [2.0, 3.0, 7.0], failures, sets: Vec::new() };
        let mut stream = Stream::new(1, "acts");
        let drawn: Vec<(f64, Option<&str>)> = (0..20_000).map(|_| model.drawn(&mut stream)).collect();
        assert!(drawn.iter().all(|(takes_s, _)| (2.0..=7.0).contains(takes_s)));
        let mean_s = drawn.iter().map(|(takes_s, _)| takes_s).sum::<f64>() / 20_000.0;
        assert!((mean_s - 4.0).abs() < 0.05, "the mean of three corners, not {mean_s}");
        let share = |class| drawn.iter().filter(|(_, failure)| *failure == class).count() as f64 / 20_000.0;
        assert!((share(Some("lamp-failure")) - 0.1).abs() < 0.01 && (share(Some("blocked")) - 0.2).abs() < 0.01);
        let always = ActModel { takes_s: [4.0; 3], failures: Vec::new(), sets: Vec::new() };
        assert!(always.is_certain() && always.drawn(&mut stream) == (4.0, None));
    }
}
