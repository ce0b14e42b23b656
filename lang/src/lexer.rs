//! Text to tokens.
//!
//! Every byte but white space lies in some token, comments included, so that a highlighter can use
//! the same tokens; [`crate::reader`] skips the comments.

use crate::diagnostic::Diagnostic;
use crate::number::{NumberLiteral, begins_like_number, parse_number};
use crate::source::{BYTE_ORDER_MARK, LINE_ENDS, SourceId, Span, holds_code};
use crate::symbol::is_uninterned;
use crate::visible::{is_invisible, named, reorders, visible};
use logos::{FilterResult, Logos};

/// What stands on both sides of a name of any characters.
pub const BAR: char = '|';

/// The marks that stand before a datum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prefix {
    /// `'`
    Quote,
    /// `` ` ``
    Quasiquote,
    /// `,`
    Unquote,
    /// `,@`
    UnquoteSplicing,
    /// `#'`, which changes nothing: there is one namespace.
    Function,
    /// `#` right before a `(`: the list is a vector.
    Vector,
}

/// The kinds of token; what a token says is the text of its span.
#[derive(Logos, Clone, Copy, Debug, PartialEq)]
#[logos(extras = LexerState)]
#[logos(skip r"[\t\n\x0b\x0c\r ]+")]
pub enum Token {
    /// `(`
    #[token("(")]
    Open,
    /// `)`
    #[token(")")]
    Close,
    /// A mark before a datum.
    #[token("'", |_| Prefix::Quote)]
    #[token("`", |_| Prefix::Quasiquote)]
    #[token(",", |_| Prefix::Unquote)]
    #[token(",@", |_| Prefix::UnquoteSplicing)]
    #[token("#'", |_| Prefix::Function)]
    Prefix(Prefix),
    /// `#;`, which comments out the next datum.
    #[token("#;")]
    DatumComment,
    /// A string with its quotes; see [`unescape`].
    #[token("\"", string)]
    Str,
    /// A name; see [`crate::bars::read_name`].
    // Every atom is one regular expression, told apart afterwards; with one for each kind the
    // automaton would read `1+` as two atoms.
    #[regex(r##"[^\p{White_Space}\x00-\x1f\x7f()'`,";\[\]{}|#][^\p{White_Space}\x00-\x1f\x7f()'`,";\[\]{}|]*"##, atom)]
    #[token("|", |lexer| between_bars(lexer, Token::Symbol))]
    Symbol,
    /// A name after a colon.
    Keyword,
    /// A 64-bit integer.
    Int(i64),
    /// A float, or any number with a unit, in SI.
    Float(f64),
    /// `.` alone, the dot of a dotted pair.
    Dot,
    /// `; …` up to the end of the line.
    #[regex(r";[^\n\r]*", allow_greedy = true)]
    LineComment,
    /// `#| … |#`, nested.
    #[token("#|", block_comment)]
    BlockComment,
    /// A string or block comment without an end: it takes the rest of the text.
    Unterminated,
    /// Something already reported.
    #[regex(r"#<[^>\n\r]*>", unknown_hash)]
    #[regex(r##"#[^\p{White_Space}\x00-\x1f\x7f()'`,";\[\]{}|]*"##, unknown_hash)]
    Error,
}

impl Token {
    /// Whether the reader skips it.
    pub fn is_comment(self) -> bool {
        matches!(self, Token::LineComment | Token::BlockComment)
    }
}

/// What the callbacks write to.
#[doc(hidden)]
#[derive(Debug)]
pub struct LexerState {
    source: SourceId,
    found: Vec<Diagnostic>,
    /// The first string that holds a line beginning with `(`: when the text ends within a string,
    /// this is where a quote is likely to be missing.
    suspect: Option<Span>,
}

type Lexer<'s> = logos::Lexer<'s, Token>;

/// Texts longer than this are refused; spans count bytes in 32 bits.
pub const MAX_TEXT_BYTES: usize = 256 << 20;

/// Cuts a text into tokens, in order, without gaps but white space, and tells what is no token.
/// A byte order mark at the start is skipped. Cost: linear.
pub fn lex(text: &str, source: SourceId) -> (Vec<(Token, Span)>, Vec<Diagnostic>) {
    if let Some(refusal) = refuse(text, source) {
        return (Vec::new(), vec![refusal]);
    }
    let mut lexer = Lexer::with_extras(text, LexerState { source, found: Vec::new(), suspect: None });
    if text.starts_with(BYTE_ORDER_MARK) {
        lexer.bump(BYTE_ORDER_MARK.len_utf8());
    }
    // A guess that spares most of the growing: a token and its space are rarely below four bytes.
    let mut tokens = Vec::with_capacity(text.len() / 4);
    let mut invalid: Option<Span> = None;
    while let Some(token) = lexer.next() {
        let span = span_of(&lexer);
        match token {
            Ok(token) => tokens.push((token, span)),
            Err(()) => {
                match &mut invalid {
                    Some(run) if run.end == span.start => run.end = span.end,
                    _ => {
                        lexer.extras.found.extend(invalid.take().map(|run| invalid_characters(text, run)));
                        invalid = Some(span);
                    }
                }
                tokens.push((Token::Error, span));
            }
        }
    }
    let mut found = lexer.extras.found;
    found.extend(invalid.map(|run| invalid_characters(text, run)));
    found.extend(reordered(text, &tokens));
    found.extend(joined(text, &tokens));
    found.extend(called_from_outside(text, &tokens));
    found.sort_by_key(|diagnostic| diagnostic.span.start);
    (tokens, found)
}

fn refuse(text: &str, source: SourceId) -> Option<Diagnostic> {
    let at = |start: usize, end: usize| Span { source, start: start as u32, end: end as u32 };
    if text.len() > MAX_TEXT_BYTES {
        let message = format!("the text has {} bytes, more than {MAX_TEXT_BYTES}", text.len());
        return Some(
            Diagnostic::error("text-too-long", at(0, 0), message, "refused")
                .help("split the text, and `load` its parts"),
        );
    }
    let nul = text.find('\0')?;
    Some(
        Diagnostic::error(
            "not-text",
            at(nul, nul + 1),
            "this is not a plan text: it holds a NUL byte",
            "the first NUL byte",
        )
        .help("plans are UTF-8 text; this looks like a binary file"),
    )
}

fn span_of(lexer: &Lexer<'_>) -> Span {
    let range = lexer.span();
    Span { source: lexer.extras.source, start: range.start as u32, end: range.end as u32 }
}

fn invalid_characters(text: &str, run: Span) -> Diagnostic {
    let run_text = &text[run.start as usize..run.end as usize];
    let first = run_text.chars().next().unwrap_or(' ');
    match first {
        '[' | ']' | '{' | '}' => Diagnostic::error(
            "invalid-character",
            run,
            format!("`{first}` has no meaning here"),
            "not part of the language",
        )
        .help("lists are written with `(` and `)`"),
        _ => invisible_character(first, run),
    }
}

/// A character nobody sees, where it would make one name look like another, or a name like a space.
fn invisible_character(character: char, place: Span) -> Diagnostic {
    let message = format!("here stands {}, which cannot be seen", named(character));
    let help = match character.is_whitespace() {
        true => "put a common space in its place",
        false => "remove it; in a string it may stand, or be written `\\u{…}`",
    };
    Diagnostic::error("invisible-character", place, message, "it has no meaning outside of strings and comments")
        .help(help)
}

/// Strings and comments that are shown in another order than they are read, so that code can look
/// like a part of them.
fn reordered(text: &str, tokens: &[(Token, Span)]) -> Vec<Diagnostic> {
    // All these characters begin with this byte, and most texts have none.
    if !text.as_bytes().contains(&0xe2) {
        return Vec::new();
    }
    let mut found = Vec::new();
    for &(token, span) in tokens.iter().filter(|(token, _)| token.is_comment() || *token == Token::Str) {
        let written = &text[span.start as usize..span.end as usize];
        let Some((at, character)) = written.char_indices().find(|&(_, character)| reorders(character)) else {
            continue;
        };
        let start = span.start + at as u32;
        let place = Span { start, end: start + character.len_utf8() as u32, ..span };
        let message = format!("{} makes what follows look different from what it says", named(character));
        let help = match token {
            Token::Str => format!("remove it, or write `\\u{{{:x}}}`", character as u32),
            _ => "remove it".to_string(),
        };
        let label = "changes the order in which the text is shown";
        found.push(Diagnostic::error("invisible-character", place, message, label).help(help));
    }
    found
}

/// Words and names between bars that touch: elsewhere a bar in the midst of a name is a part of it.
fn joined(text: &str, tokens: &[(Token, Span)]) -> Vec<Diagnostic> {
    if !text.contains(BAR) {
        return Vec::new();
    }
    let is_word =
        |token| matches!(token, Token::Symbol | Token::Keyword | Token::Int(_) | Token::Float(_) | Token::Dot);
    let touching = tokens.windows(2).filter_map(|pair| match *pair {
        [(left, before), (right, span)] if before.end == span.start && is_word(left) && is_word(right) => Some(span),
        _ => None,
    });
    let told = touching.map(|span| {
        let end = text.ceil_char_boundary(span.start as usize + 1) as u32;
        let place = Span { end, ..span };
        Diagnostic::error("joined-name", place, "two names touch", "the second one begins here")
            .help("put one name wholly between bars: `|two words|`; or put a space between two names")
    });
    told.collect()
}

/// Calls as other languages write them: a name, and the parenthesis directly behind it.
fn called_from_outside(text: &str, tokens: &[(Token, Span)]) -> Vec<Diagnostic> {
    let written = |span: Span| &text[span.start as usize..span.end as usize];
    let touching = tokens.windows(2).enumerate().filter_map(|(at, pair)| match *pair {
        [(Token::Symbol, name), (next, behind)] if name.end == behind.start => {
            let is_head = at.checked_sub(1).is_some_and(|before| tokens[before].0 == Token::Open);
            match next {
                Token::Open if !is_head => Some((name, behind, true)),
                Token::Str if written(name) == "f" => Some((name, behind, false)),
                _ => None,
            }
        }
        _ => None,
    });
    let told = touching.map(|(name, behind, is_call)| {
        let word = written(name);
        let (code, message, help) = match is_call {
            true => (
                "call-outside",
                format!("the parenthesis stands behind `{word}`"),
                format!("the name of a call stands inside the parentheses: `({word} …)`"),
            ),
            false => (
                "format-prefix",
                "a text has no prefix".to_string(),
                "values are put into a text by `(format \"going to ~a\" PLACE)`".to_string(),
            ),
        };
        Diagnostic::error(code, name.to(behind), message, "written as one").help(help)
    });
    told.collect()
}

fn atom(lexer: &mut Lexer<'_>) -> FilterResult<Token, ()> {
    let text = lexer.slice();
    if let Some((at, character)) = text.char_indices().find(|&(_, character)| is_invisible(character)) {
        let all = span_of(lexer);
        let start = all.start + at as u32;
        let place = Span { start, end: start + character.len_utf8() as u32, ..all };
        lexer.extras.found.push(invisible_character(character, place));
        return FilterResult::Emit(Token::Error);
    }
    let token = match text {
        "." => Token::Dot,
        ":" if lexer.remainder().starts_with(BAR) => {
            lexer.bump(BAR.len_utf8());
            return between_bars(lexer, Token::Keyword);
        }
        ":" => {
            let error = Diagnostic::error("lone-colon", span_of(lexer), "a colon without a name", "no keyword")
                .help("a keyword is written `:name`, without a space");
            lexer.extras.found.push(error);
            Token::Error
        }
        _ if text.starts_with(':') => Token::Keyword,
        _ if begins_like_number(text) => number(lexer),
        _ => Token::Symbol,
    };
    FilterResult::Emit(token)
}

fn number(lexer: &mut Lexer<'_>) -> Token {
    match parse_number(lexer.slice()) {
        Ok(NumberLiteral::Int(value)) => Token::Int(value),
        Ok(NumberLiteral::Float(value)) => Token::Float(value),
        Err(error) => {
            let error = Diagnostic::error("bad-number", span_of(lexer), error.message, "not a number").help(error.help);
            lexer.extras.found.push(error);
            Token::Error
        }
    }
}

fn unknown_hash(lexer: &mut Lexer<'_>) -> FilterResult<Token, ()> {
    let text = lexer.slice();
    if text == "#" && lexer.remainder().starts_with('(') {
        return FilterResult::Emit(Token::Prefix(Prefix::Vector));
    }
    let (message, help) = if text.starts_with("#<") {
        (
            "a run-time object cannot be read".to_string(),
            "`#<…>` is how objects are printed; there is no way to write them",
        )
    } else if text.starts_with("#:") {
        ("a name made by `gensym` cannot be read".to_string(), "no text can name it; give it a name of your own")
    } else if text == "#" && lexer.remainder().starts_with([' ', '\t', '!', '#', '\n']) {
        // What is meant as a comment is passed over, and told of once.
        let line = lexer.remainder().find('\n').unwrap_or(lexer.remainder().len());
        lexer.bump(line);
        ("`#` begins no comment".to_string(), "a comment begins with `;`")
    } else {
        (
            format!("`{}` has no meaning", visible(text)),
            "after `#` stands `'`, `(`, `;` or `|`: `#'function`, `#(vector)`, `#;datum`, `#| comment |#`",
        )
    };
    let error = Diagnostic::error("unknown-hash", span_of(lexer), message, "unknown").help(help);
    lexer.extras.found.push(error);
    FilterResult::Emit(Token::Error)
}

fn string(lexer: &mut Lexer<'_>) -> FilterResult<Token, ()> {
    let quote = '"';
    let Some(body_len) = body_len(lexer.remainder(), quote) else {
        return FilterResult::Emit(unterminated_string(lexer));
    };
    let body = &lexer.remainder()[..body_len];
    tell_bad_escapes(lexer, body, quote);
    lexer.bump(body_len + quote.len_utf8());
    if holds_code(body) && lexer.extras.suspect.is_none() {
        lexer.extras.suspect = Some(span_of(lexer));
    }
    FilterResult::Emit(Token::Str)
}

/// Tells the escapes that are none in a body that begins where the lexer stands.
fn tell_bad_escapes(lexer: &mut Lexer<'_>, body: &str, delimiter: char) {
    if !body.contains('\\') {
        return;
    }
    let start = lexer.span().end;
    let help =
        format!("the escapes are \\n \\t \\r \\0 \\\\ \\{delimiter} and \\u{{…}} with up to six hexadecimal digits");
    for (from, to, message) in unescape(body, delimiter).1 {
        let span = part_of(lexer, start + from, start + to);
        lexer.extras.found.push(Diagnostic::error("bad-escape", span, message, "unknown escape").help(help.as_str()));
    }
}

fn part_of(lexer: &Lexer<'_>, start: usize, end: usize) -> Span {
    Span { source: lexer.extras.source, start: start as u32, end: end as u32 }
}

/// Bytes before the closing delimiter.
fn body_len(body: &str, delimiter: char) -> Option<usize> {
    let bytes = body.as_bytes();
    let mut at = 0;
    loop {
        match *bytes.get(at)? {
            b'\\' => at += 2,
            byte if char::from(byte) == delimiter => return Some(at),
            _ => at += 1,
        }
    }
}

/// A name between bars, the first of which is taken. It ends in its line, so that a bar that is missing spoils no more.
fn between_bars(lexer: &mut Lexer<'_>, token: Token) -> FilterResult<Token, ()> {
    let rest = lexer.remainder();
    let line = rest.split(LINE_ENDS).next().unwrap_or(rest);
    let Some(body_len) = body_len(line, BAR) else { return FilterResult::Emit(unterminated_name(lexer)) };
    let body = &rest[..body_len];
    let faults_before = lexer.extras.found.len();
    tell_bad_escapes(lexer, body, BAR);
    let start = lexer.span().end;
    if let Some((at, character)) = body.char_indices().find(|&(_, character)| is_invisible(character)) {
        let place = part_of(lexer, start + at, start + at + character.len_utf8());
        let message = format!("here stands {}, which cannot be seen", named(character));
        let error = Diagnostic::error("invisible-character", place, message, "not seen in the name")
            .help(format!("write `{}`, or leave it out", visible(character.encode_utf8(&mut [0; 4]))));
        lexer.extras.found.push(error);
    }
    if token == Token::Symbol && is_uninterned(&unescape(body, BAR).0) {
        let message = "a name that begins with `#:` is one made by `gensym`, which cannot be read";
        let error = Diagnostic::error("unknown-hash", part_of(lexer, start, start + body_len), message, "no name")
            .help("no text can name it; give it a name of your own");
        lexer.extras.found.push(error);
    }
    lexer.bump(body_len + BAR.len_utf8());
    let is_right = lexer.extras.found.len() == faults_before;
    FilterResult::Emit(if is_right { token } else { Token::Error })
}

/// Takes no more than the word that stands behind the bar.
fn unterminated_name(lexer: &mut Lexer<'_>) -> Token {
    let place = span_of(lexer);
    let error = Diagnostic::error("unterminated-name", place, "this name is never closed", "the name begins here")
        .help(
            "close it with `|` in the same line; inside a name write `\\|`, and `\\n` for the end of a line. \
         A block comment is written `#| … |#`",
        );
    lexer.extras.found.push(error);
    let rest = lexer.remainder();
    let word = rest.find(|character| !is_of_word(character)).unwrap_or(rest.len());
    lexer.bump(word);
    Token::Error
}

/// Whether a character may stand in a bare name.
pub(crate) fn is_of_word(character: char) -> bool {
    !is_invisible(character) && !character.is_whitespace() && !"()[]{}'`,\";|".contains(character)
}

fn unterminated_string(lexer: &mut Lexer<'_>) -> Token {
    let mut error = Diagnostic::error(
        "unterminated-string",
        span_of(lexer),
        "this string is never closed",
        "the string begins here",
    )
    .help("close it with `\"`; inside a string write `\\\"`");
    if let Some(Span { source, start, .. }) = lexer.extras.suspect {
        error = error.related(
            Span { source, start, end: start + 1 },
            "the quote that is missing may belong to this string, which holds what looks like code",
        );
    }
    lexer.extras.found.push(error);
    lexer.bump(lexer.remainder().len());
    Token::Unterminated
}

fn block_comment(lexer: &mut Lexer<'_>) -> FilterResult<Token, ()> {
    let rest = lexer.remainder().as_bytes();
    let mut depth = 1;
    let mut at = 0;
    while depth > 0 {
        match rest.get(at..at + 2) {
            Some(b"|#") => (depth, at) = (depth - 1, at + 2),
            Some(b"#|") => (depth, at) = (depth + 1, at + 2),
            Some(_) => at += 1,
            None => return FilterResult::Emit(unterminated_comment(lexer, depth)),
        }
    }
    lexer.bump(at);
    FilterResult::Emit(Token::BlockComment)
}

fn unterminated_comment(lexer: &mut Lexer<'_>, depth: usize) -> Token {
    let help = match depth {
        1 => "close it with `|#`".to_string(),
        _ => format!("block comments nest: {depth} `|#` are missing"),
    };
    let span = span_of(lexer);
    let error =
        Diagnostic::error("unterminated-comment", span, "this comment is never closed", "the comment begins here");
    lexer.extras.found.push(error.help(help));
    lexer.bump(lexer.remainder().len());
    Token::Unterminated
}

/// An escape that is none: its bytes `start..end` in the body, and what is wrong.
pub type EscapeFault = (usize, usize, String);

/// The string that a body stands for, the text between the quotes of a string or the bars of a name: a line end of any
/// kind is a line feed, so that a plan does not depend on how its file was copied. An unknown escape stands for itself
/// and is told beside.
pub fn unescape(body: &str, delimiter: char) -> (String, Vec<EscapeFault>) {
    let mut value = String::with_capacity(body.len());
    let mut faults = Vec::new();
    let mut rest = body;
    while let Some(at) = rest.find('\\') {
        push_with_line_feeds(&mut value, &rest[..at]);
        let escape = &rest[at..];
        let (character, len) = match unescape_one(escape, delimiter) {
            Ok((character, len)) => (character, len),
            Err((len, what)) => {
                let start = body.len() - escape.len();
                faults.push((start, start + len, what));
                value.push_str(&escape[..len]);
                (None, len)
            }
        };
        value.extend(character);
        rest = &escape[len..];
    }
    push_with_line_feeds(&mut value, rest);
    (value, faults)
}

fn push_with_line_feeds(value: &mut String, text: &str) {
    let mut rest = text;
    while let Some((line, after)) = rest.split_once('\r') {
        value.push_str(line);
        value.push('\n');
        rest = after.strip_prefix('\n').unwrap_or(after);
    }
    value.push_str(rest);
}

/// The character of an escape and its length in bytes; a line's end after a backslash stands for
/// nothing, so that a long string can be broken.
fn unescape_one(escape: &str, delimiter: char) -> Result<(Option<char>, usize), (usize, String)> {
    let character = match escape[1..].chars().next() {
        Some('n') => '\n',
        Some('t') => '\t',
        Some('r') => '\r',
        Some('0') => '\0',
        Some('\\') => '\\',
        Some(character) if character == delimiter => character,
        Some('\r') if escape[2..].starts_with('\n') => return Ok((None, 3)),
        Some('\n' | '\r') => return Ok((None, 2)),
        Some('u') => return unescape_unicode(escape),
        Some(other) => return Err((1 + other.len_utf8(), format!("`\\{}` is no escape", visible(&other.to_string())))),
        None => return Err((1, "a backslash at the end of a string".to_string())),
    };
    Ok((Some(character), 2))
}

fn unescape_unicode(escape: &str) -> Result<(Option<char>, usize), (usize, String)> {
    let wrong = |len| (len, "`\\u` is followed by `{`, digits and `}`".to_string());
    let Some(rest) = escape[2..].strip_prefix('{') else { return Err(wrong(2)) };
    let digits = &rest[..rest.bytes().take_while(u8::is_ascii_hexdigit).count()];
    if !rest[digits.len()..].starts_with('}') {
        return Err(wrong(3 + digits.len()));
    }
    let len = digits.len() + 4;
    let well_formed = (1..=6).contains(&digits.len());
    let code = well_formed.then(|| u32::from_str_radix(digits, 16).ok()).flatten();
    match code.and_then(char::from_u32) {
        Some(character) => Ok((Some(character), len)),
        None => Err((len, format!("`\\u{{{digits}}}` is no character"))),
    }
}
