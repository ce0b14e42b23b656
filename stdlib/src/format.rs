//! `format`: text with directives that stand for arguments.

use crate::arguments::{NativeResult, drafted, pure, room_for_text};
use rpl_lang::kind::Kind;
use rpl_lang::number::format_float;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native};

/// Wider columns and more decimals are taken for a mistake.
const MAX_WIDTH: usize = 1_000;

/// What stands between `~` and the letter: `~WIDTH,DECIMALSf`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Directive {
    width: usize,
    decimals: Option<usize>,
    letter: char,
}

fn malformed(message: impl Into<String>) -> Raise {
    Raise::type_error(message)
}

/// Reads a directive behind its `~`, and takes it off the template.
fn directive(rest: &mut &str) -> Result<Directive, Raise> {
    let width = digits(rest)?.unwrap_or(0);
    let mut decimals = None;
    if let Some(behind) = rest.strip_prefix(',') {
        *rest = behind;
        decimals = digits(rest)?;
    }
    let mut characters = rest.chars();
    let Some(letter) = characters.next() else {
        return Err(malformed("the format ends in the middle of a directive; write `~~` for a tilde"));
    };
    *rest = characters.as_str();
    Ok(Directive { width, decimals, letter: letter.to_ascii_lowercase() })
}

fn digits(rest: &mut &str) -> Result<Option<usize>, Raise> {
    let mut number = None;
    while let Some(&digit @ b'0'..=b'9') = rest.as_bytes().first() {
        *rest = &rest[1..];
        let digit = digit - b'0';
        let so_far = number.unwrap_or(0usize) * 10 + usize::from(digit);
        if so_far > MAX_WIDTH {
            return Err(malformed(format!("a width or number of decimals in a format is at most {MAX_WIDTH}")));
        }
        number = Some(so_far);
    }
    Ok(number)
}

/// An argument as a directive shows it.
fn shown(call: &Call<'_, '_>, directive: Directive, at: usize) -> Result<String, Raise> {
    let argument = call.argument(at);
    let program = call.around.program;
    Ok(match (directive.letter, argument) {
        ('a', _) => call.machine.show(program, argument),
        ('s', _) => call.machine.write(program, argument),
        ('d', Value::Int(integer)) => integer.to_string(),
        ('d', Value::Float(float)) => format_float(float),
        ('f', Value::Int(_) | Value::Float(_)) => {
            let float = call.number(at)?;
            match directive.decimals {
                Some(decimals) if float.is_finite() => format!("{float:.decimals$}"),
                _ => format_float(float),
            }
        }
        (letter @ ('d' | 'f'), _) => {
            let name = format!("the argument of `~{letter}`");
            return Err(call.machine.wrong_type(&name, Kind::Number.noun(), argument));
        }
        (letter, _) => {
            return Err(malformed(format!(
                "`~{letter}` is no directive of a format; there are ~a ~s ~d ~f ~,2f ~% ~~"
            )));
        }
    })
}

/// Words are filled up on the right, numbers on the left.
fn pad(out: &mut String, shown: &str, directive: Directive) {
    let missing = directive.width.saturating_sub(shown.chars().count());
    let blanks = std::iter::repeat_n(' ', missing);
    if matches!(directive.letter, 'd' | 'f') {
        out.extend(blanks);
        out.push_str(shown);
    } else {
        out.push_str(shown);
        out.extend(blanks);
    }
}

fn format(call: &mut Call<'_, '_>) -> NativeResult {
    let template = call.text(0)?;
    let mut rest = &*template;
    let mut out = call.draft();
    let mut next = 1;
    while let Some(at) = rest.bytes().position(|byte| byte == b'~') {
        out.push_str(&rest[..at]);
        rest = &rest[at + 1..];
        let directive = directive(&mut rest)?;
        match directive.letter {
            '%' => out.extend(std::iter::repeat_n('\n', directive.width.max(1))),
            '~' => out.extend(std::iter::repeat_n('~', directive.width.max(1))),
            // A `~` at the end of a line joins it to the next one, without its indentation.
            '\n' => rest = rest.trim_start(),
            letter => {
                if next >= call.arguments.len() && matches!(letter, 'a' | 's' | 'd' | 'f') {
                    return Err(malformed(format!("directive {next} of the format, `~{letter}`, has no argument")));
                }
                if letter == 'a' && directive.width == 0 {
                    call.machine.show_into(call.around.program, call.argument(next), &mut out);
                } else {
                    let shown = shown(call, directive, next)?;
                    pad(&mut out, &shown, directive);
                }
                next += 1;
            }
        }
        room_for_text(call, out.len())?;
    }
    out.push_str(rest);
    if next < call.arguments.len() {
        let (given, used) = (call.arguments.len() - 1, next - 1);
        return Err(malformed(format!("the format has {used} directives, and there are {given} values for them")));
    }
    drafted(call, out)
}

/// Formatting; `%format` is the same for expansions of macros.
pub(super) const NATIVES: &[Native] = &[
    pure(
        "format",
        "template &rest values",
        "The template with the values in place of ~a (as printed), ~s (as read), ~d, ~f and ~,2f (numbers); ~% is a new line, ~~ a tilde.",
        format,
    ),
    pure("%format", "template &rest values", "The same as `format`.", format),
];
