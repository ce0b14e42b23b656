//! What percepts are judged by.

use super::matrix::Matrix;
use serde::{Deserialize, Serialize};

/// How percepts become a place in an instruction: the same for all instructions of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Inference {
    /// How likely each percept is for each feature.
    pub matrix: Matrix,
    /// By which rule.
    pub method: Method,
}

impl Inference {
    /// State-set progression with the matrix of the sonars alone, or, where a camera sees the markers of the
    /// doors, with that of both.
    #[must_use]
    pub fn of_robot(with_markers: bool) -> Self {
        let matrix = if with_markers { Matrix::MARKED } else { Matrix::SONAR };
        Self { matrix, method: Method::StateSet }
    }
}

/// A rule by which the wanted opening is found among percepts. All but the first are there to be compared
/// with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Method {
    /// State-set progression.
    StateSet,
    /// State-set progression by Eqs. (1) and (3) as they are printed.
    LiteralEquations,
    /// The nth percept on the side, whatever it is.
    PlainCounter,
    /// The first percept of the right kind that is at least the nth opening on the side.
    CounterWithClass,
}

impl Method {
    /// All of them, in the order of tables.
    pub const ALL: [Method; 4] =
        [Method::StateSet, Method::CounterWithClass, Method::PlainCounter, Method::LiteralEquations];

    /// As tables call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::StateSet => "state set",
            Self::LiteralEquations => "literal equations",
            Self::PlainCounter => "plain counter",
            Self::CounterWithClass => "counter with class",
        }
    }
}
