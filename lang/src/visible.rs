//! Characters that are there and are not seen, or that act on a terminal: what is shown instead.
//!
//! Names, task paths and messages are made of what plans and files contain. Wherever they are shown
//! – but for what a plan prints itself – such characters stand there as `\u{…}`, so that no text
//! looks like another, and none moves the cursor or changes the colours.
//!
//! Names and reasons from outside the run (files and their names, hosts, modules, recordings) are made visible where
//! they enter a message.

use std::borrow::Cow;

/// Ranges of characters that leave no mark: control and format characters, spaces other than the
/// common one, variation selectors, fillers, tags. Unicode's classes Cc, Cf, Zl, Zp and Zs, and what
/// is ignorable by default; those of Cf that are drawn, as the Arabic number signs, are left out.
const INVISIBLE: &[(char, char)] = &[
    ('\0', '\u{1f}'),
    ('\u{7f}', '\u{a0}'),
    ('\u{ad}', '\u{ad}'),
    ('\u{34f}', '\u{34f}'),
    ('\u{61c}', '\u{61c}'),
    ('\u{115f}', '\u{1160}'),
    ('\u{1680}', '\u{1680}'),
    ('\u{17b4}', '\u{17b5}'),
    ('\u{180b}', '\u{180f}'),
    ('\u{2000}', '\u{200f}'),
    ('\u{2028}', '\u{202f}'),
    ('\u{205f}', '\u{206f}'),
    ('\u{3000}', '\u{3000}'),
    ('\u{3164}', '\u{3164}'),
    ('\u{fe00}', '\u{fe0f}'),
    ('\u{feff}', '\u{feff}'),
    ('\u{ffa0}', '\u{ffa0}'),
    ('\u{fff0}', '\u{fffb}'),
    ('\u{1bca0}', '\u{1bca3}'),
    ('\u{1d173}', '\u{1d17a}'),
    ('\u{e0000}', '\u{e0fff}'),
];

/// What a user is likely to meet, by name.
const NAMES: &[(char, &str)] = &[
    ('\0', "NUL"),
    ('\u{7}', "bell"),
    ('\u{8}', "backspace"),
    ('\u{b}', "vertical tab"),
    ('\u{c}', "form feed"),
    ('\u{1b}', "escape"),
    ('\u{7f}', "delete"),
    ('\u{85}', "next line"),
    ('\u{a0}', "no-break space"),
    ('\u{ad}', "soft hyphen"),
    ('\u{61c}', "Arabic letter mark"),
    ('\u{200b}', "zero-width space"),
    ('\u{200c}', "zero-width non-joiner"),
    ('\u{200d}', "zero-width joiner"),
    ('\u{200e}', "left-to-right mark"),
    ('\u{200f}', "right-to-left mark"),
    ('\u{2028}', "line separator"),
    ('\u{2029}', "paragraph separator"),
    ('\u{202a}', "left-to-right embedding"),
    ('\u{202b}', "right-to-left embedding"),
    ('\u{202c}', "end of an embedding"),
    ('\u{202d}', "left-to-right override"),
    ('\u{202e}', "right-to-left override"),
    ('\u{202f}', "narrow no-break space"),
    ('\u{2060}', "word joiner"),
    ('\u{2066}', "left-to-right isolate"),
    ('\u{2067}', "right-to-left isolate"),
    ('\u{2068}', "first-strong isolate"),
    ('\u{2069}', "end of an isolate"),
    ('\u{3000}', "ideographic space"),
    ('\u{feff}', "byte order mark"),
];

/// Whether a character leaves no mark where it is shown; the common space is not meant.
pub fn is_invisible(character: char) -> bool {
    // Nearly every character is one of these.
    if matches!(character, ' '..='~') {
        return false;
    }
    let after = INVISIBLE.partition_point(|&(first, _)| first <= character);
    after > 0 && character <= INVISIBLE[after - 1].1
}

/// Whether a character makes what follows it be shown in another order than it is read.
pub fn reorders(character: char) -> bool {
    matches!(character, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// A character by its code point, and by its name where it is a common one: `U+200B (zero-width
/// space)`.
pub fn named(character: char) -> String {
    let code = format!("U+{:04X}", character as u32);
    match NAMES.iter().find(|(known, _)| *known == character) {
        Some((_, name)) => format!("{code} ({name})"),
        None => code,
    }
}

/// The text on one line, with `\u{…}` for what is not seen and `\n`, `\t`, `\r` for the white space
/// that is no space. Cost: a look at each character if there is none.
pub fn visible(text: &str) -> Cow<'_, str> {
    // Nearly every name is one of these, and each event of a trace shows some.
    if text.bytes().all(|byte| matches!(byte, b' '..=b'~')) {
        return Cow::Borrowed(text);
    }
    escaped(text, |_| false)
}

/// The same, with line feeds and tabs left as they are.
pub fn visible_lines(text: &str) -> Cow<'_, str> {
    escaped(text, |character| matches!(character, '\n' | '\t'))
}

/// The same for text that this program has coloured itself: its colours stay too.
pub fn visible_coloured(text: &str) -> Cow<'_, str> {
    if !text.contains('\u{1b}') {
        return visible_lines(text);
    }
    let mut shown = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find("\u{1b}[") {
        let (before, sequence) = rest.split_at(at);
        shown += &visible_lines(before);
        let parameters = sequence[2..].bytes().take_while(|&byte| byte.is_ascii_digit() || byte == b';').count();
        // Only what ends in `m` sets colours.
        let length = if sequence[2 + parameters..].starts_with('m') { parameters + 3 } else { 0 };
        shown += &sequence[..length];
        let (escape, after) = sequence[length..].split_at(if length == 0 { 1 } else { 0 });
        shown += &visible_lines(escape);
        rest = after;
    }
    shown += &visible_lines(rest);
    Cow::Owned(shown)
}

fn escaped(text: &str, stays: impl Fn(char) -> bool) -> Cow<'_, str> {
    let is_shown = |character: char| !is_invisible(character) || stays(character);
    if text.chars().all(&is_shown) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        if is_shown(character) {
            shown.push(character);
        } else {
            push_escape(&mut shown, character);
        }
    }
    Cow::Owned(shown)
}

/// A name or number in a message: what is not seen is written out, and of very long ones the middle is
/// left out.
pub fn shortened(text: &str) -> String {
    let shown = visible(text);
    let length = shown.chars().count();
    if length <= LONGEST_SHOWN {
        return shown.into_owned();
    }
    let head: String = shown.chars().take(SHOWN_OF_LONG).collect();
    let tail: String = shown.chars().skip(length - SHOWN_OF_LONG).collect();
    format!("{head}… ({} characters) …{tail}", length - 2 * SHOWN_OF_LONG)
}

/// What somebody else has said, as a clause of a message: on one line, and the end of what nobody would read is
/// left out.
pub fn clause(text: &str) -> String {
    let text = text.trim();
    let most = text.char_indices().nth(LONGEST_CLAUSE).map(|(end, _)| end);
    match most {
        None => visible(text).into_owned(),
        Some(end) => format!("{}… ({} characters)", visible(&text[..end]), text.chars().count()),
    }
}

/// A string in a message, in quotes.
pub fn quoted(text: &str) -> String {
    // Of a string of megabytes no more is written out than is shown.
    match text.char_indices().nth(LONGEST_SHOWN) {
        None => quote_string(text),
        Some(_) => {
            let end = text.char_indices().nth(SHOWN_OF_LONG).map_or(text.len(), |(end, _)| end);
            format!("{}… ({} characters)", quote_string(&text[..end]), text.chars().count())
        }
    }
}

/// A message without words that nobody can read: the middle of each that is very long is left out.
pub fn with_short_words(message: String) -> String {
    let is_long = |word: &str| word.len() > LONGEST_WORD_BYTES;
    if message.len() <= LONGEST_WORD_BYTES || !message.split(char::is_whitespace).any(is_long) {
        return message;
    }
    let words = message.split_inclusive(char::is_whitespace);
    words.map(|word| if is_long(word) { Cow::Owned(shortened(word)) } else { Cow::Borrowed(word) }).collect()
}

/// A name, number or string of more characters than this is cut in messages.
const LONGEST_SHOWN: usize = 60;

/// Characters that are shown of each end then.
const SHOWN_OF_LONG: usize = 24;

/// No more characters are shown of what somebody else has said.
const LONGEST_CLAUSE: usize = 300;

/// Longer words of a message are cut, whatever they are.
const LONGEST_WORD_BYTES: usize = 240;

/// Writes a character as the escape a string literal has for it.
fn push_escape(text: &mut String, character: char) {
    match character {
        '\n' => text.push_str("\\n"),
        '\t' => text.push_str("\\t"),
        '\r' => text.push_str("\\r"),
        '\0' => text.push_str("\\0"),
        other => text.push_str(&format!("\\u{{{:x}}}", other as u32)),
    }
}

/// A text of the user as it is drawn, each character in its column: pictures stand for what is
/// invisible, but for line ends and tabs.
pub fn pictured(text: &str) -> String {
    text.chars().map(picture).collect()
}

fn picture(character: char) -> char {
    match character {
        '\n' | '\r' | '\t' => character,
        // The pictures of control characters stand in their order.
        '\0'..='\u{1f}' => char::from_u32(0x2400 + character as u32).unwrap_or(char::REPLACEMENT_CHARACTER),
        '\u{7f}' => '\u{2421}',
        other if !is_invisible(other) => other,
        space if space.is_whitespace() => '\u{2423}',
        _ => char::REPLACEMENT_CHARACTER,
    }
}

/// A string as it is written, with quotes and escapes.
pub fn quote_string(value: &str) -> String {
    delimited(value, '"')
}

/// A text between two delimiters, with a backslash before each of them in it, and escapes for what is not seen.
pub fn delimited(value: &str, delimiter: char) -> String {
    let mut text = String::with_capacity(value.len() + 2);
    text.push(delimiter);
    for character in value.chars() {
        match character {
            '\\' => text.push_str("\\\\"),
            c if c == delimiter => text.extend(['\\', c]),
            c if is_invisible(c) => push_escape(&mut text, c),
            c => text.push(c),
        }
    }
    text.push(delimiter);
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ranges_are_in_order() {
        for pair in INVISIBLE.windows(2) {
            assert!(pair[0].0 <= pair[0].1 && pair[0].1 < pair[1].0, "{pair:?}");
        }
        for &(character, name) in NAMES {
            assert!(is_invisible(character), "{name}");
        }
    }

    #[test]
    fn what_is_not_seen_is_written_out_and_all_else_stays() {
        for seen in ["wheels", "Küche", "食堂", "≤", "e\u{301}", "🤖"] {
            assert_eq!(visible(seen), seen);
        }
        assert_eq!(visible("a\u{1b}[31mb\0\n"), "a\\u{1b}[31mb\\0\\n");
        assert_eq!(visible("a\u{200b}b\u{a0}c\u{202e}"), "a\\u{200b}b\\u{a0}c\\u{202e}");
        assert_eq!(visible_lines("a\n\tb\r"), "a\n\tb\\r");
        // The standard library agrees about everything it takes for a control character or white space.
        for character in (0..0x11_0000).filter_map(char::from_u32) {
            if character.is_control() || (character.is_whitespace() && character != ' ') {
                assert!(is_invisible(character), "{:x}", character as u32);
            }
            if character.is_alphanumeric() && is_invisible(character) {
                // Hangul fillers count as letters and have no shape.
                assert!(matches!(character, '\u{115f}' | '\u{1160}' | '\u{3164}' | '\u{ffa0}'), "{character:?}");
            }
        }
    }

    #[test]
    fn what_is_long_is_cut_in_a_readable_way() {
        let digits = "1234567890".repeat(100_000);
        assert_eq!(shortened("wheels"), "wheels");
        assert_eq!(shortened(&digits), "123456789012345678901234… (999952 characters) …789012345678901234567890");
        assert_eq!(quoted("a\"b\u{1b}"), "\"a\\\"b\\u{1b}\"");
        assert_eq!(quoted(&digits), "\"123456789012345678901234\"… (1000000 characters)");
        let message = format!("`{digits}` is no number, and wheels is a name");
        let short = with_short_words(message);
        assert!(short.len() < 150 && short.ends_with("` is no number, and wheels is a name"), "{short}");
        assert_eq!(with_short_words("two words".repeat(1000)), "two words".repeat(1000));
    }

    #[test]
    fn what_others_say_is_a_clause_on_one_line() {
        assert_eq!(clause(" the battery is empty\n"), "the battery is empty");
        assert_eq!(clause("a\nerror: b\u{9b}2J\u{202e}"), "a\\nerror: b\\u{9b}2J\\u{202e}");
        let short = clause(&"no end ".repeat(100_000));
        assert!(short.chars().count() < 330 && short.ends_with("… (699999 characters)"), "{short}");
    }

    #[test]
    fn colours_stay_and_nothing_else_of_a_terminal() {
        assert_eq!(visible_coloured("\u{1b}[31mred\u{1b}[0m"), "\u{1b}[31mred\u{1b}[0m");
        assert_eq!(visible_coloured("\u{1b}[2J\u{1b}]0;x\u{7}\u{1b}[1;2"), "\\u{1b}[2J\\u{1b}]0;x\\u{7}\\u{1b}[1;2");
    }
}
