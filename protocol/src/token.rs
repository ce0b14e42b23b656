//! Tokens: what a mission and a host both know, and nobody else is told.

use std::fmt;
use subtle::ConstantTimeEq;

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Characters of a token: fewer are guessed, and more are none that somebody has made.
const LENGTHS: std::ops::RangeInclusive<usize> = 16..=1024;

/// A secret that a mission tells a host in its greeting. It is not shown, not even to who debugs this program.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(transparent)]
pub struct Token(String);

impl Token {
    /// The token of a file's text: its only line.
    ///
    /// # Errors
    /// One clause that says what is wrong with it, and does not repeat it.
    pub fn new(text: &str) -> Result<Self, String> {
        let token = text.trim_ascii_end();
        if !LENGTHS.contains(&token.len()) {
            let (least, most) = (LENGTHS.start(), LENGTHS.end());
            return Err(format!("has {} characters, and {least} to {most} are expected", token.len()));
        }
        if !token.bytes().all(|byte| byte.is_ascii_graphic()) {
            return Err("has other characters than ASCII letters, digits and signs, or more than a line".to_string());
        }
        Ok(Self(token.to_string()))
    }

    /// Whether this is the other one; how long that takes tells nothing but whether both are equally long.
    pub fn is(&self, other: &Self) -> bool {
        self.0.as_bytes().ct_eq(other.0.as_bytes()).into()
    }
}

impl fmt::Debug for Token {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("Token")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_a_line_that_nobody_guesses_and_is_never_shown() {
        let token = Token::new("0123456789abcdef\n").expect("a token");
        assert!(token.is(&Token::new("0123456789abcdef").expect("a token")));
        for other in ["0123456789abcdeF", "0123456789abcdef0", "1123456789abcdef"] {
            assert!(!token.is(&Token::new(other).expect("a token")), "{other}");
        }
        assert!(!format!("{token:?}").contains("0123"));
        for wrong in ["", "\n", "short", "two words are none", "0123456789abcdef\n0123456789abcdef", "0123456789abcdeß"]
        {
            let why = Token::new(wrong).expect_err("it is none");
            assert!(wrong.trim().is_empty() || !why.contains(wrong.trim()), "{why}");
        }
        assert!(Token::new(&"x".repeat(1025)).is_err());
    }
}
