//! The forms of a generated text, to take it apart.

use std::fmt;

/// A datum as generated texts have it: no comments, no strings with parentheses in them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Form {
    /// A word, a number, a string, with its quote if it has one.
    Atom(String),
    /// A list.
    List(Vec<Form>),
    /// `'` before a list.
    Quoted(Box<Form>),
}

impl fmt::Display for Form {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Form::Atom(word) => write!(out, "{word}"),
            Form::Quoted(form) => write!(out, "'{form}"),
            Form::List(items) => {
                write!(out, "(")?;
                for (at, item) in items.iter().enumerate() {
                    write!(out, "{}{item}", if at == 0 { "" } else { " " })?;
                }
                write!(out, ")")
            }
        }
    }
}

/// The top-level forms of a text.
pub fn parse(text: &str) -> Vec<Form> {
    let mut at = 0;
    let mut forms = Vec::new();
    while let Some(form) = next(text.as_bytes(), &mut at) {
        forms.push(form);
    }
    forms
}

/// The text of top-level forms.
pub fn print(forms: &[Form]) -> String {
    forms.iter().map(|form| format!("{form}\n")).collect()
}

fn next(text: &[u8], at: &mut usize) -> Option<Form> {
    while text.get(*at).is_some_and(u8::is_ascii_whitespace) {
        *at += 1;
    }
    match *text.get(*at)? {
        b'(' => {
            *at += 1;
            let mut items = Vec::new();
            while let Some(item) = next(text, at) {
                items.push(item);
            }
            *at += 1;
            Some(Form::List(items))
        }
        b')' => None,
        b'\'' if text.get(*at + 1) == Some(&b'(') => {
            *at += 1;
            next(text, at).map(|form| Form::Quoted(Box::new(form)))
        }
        _ => {
            let start = *at;
            let mut in_string = false;
            while let Some(&byte) = text.get(*at) {
                in_string ^= byte == b'"';
                if !in_string && (byte.is_ascii_whitespace() || byte == b'(' || byte == b')') {
                    break;
                }
                *at += 1;
            }
            Some(Form::Atom(String::from_utf8_lossy(&text[start..*at]).into_owned()))
        }
    }
}
