//! Rust as words and signs: all that it takes to see which names stand in a file.

/// A token. What is written in comments and literals says nothing about names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Token<'t> {
    /// A name or a keyword.
    Word(&'t str),
    /// A single sign of punctuation.
    Sign(char),
    /// A number, a character or a string.
    Literal,
}

/// The tokens of a text that a compiler takes.
pub fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut tokens = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let len = match first {
            '/' if rest.starts_with("//") => rest.find('\n').unwrap_or(rest.len()),
            '/' if rest.starts_with("/*") => block_comment_len(rest),
            _ => {
                let (token, len) = token(rest, first);
                tokens.push(token);
                len
            }
        };
        rest = rest[len..].trim_start();
    }
    tokens
}

/// The token that a text begins with, and its length.
fn token(text: &str, first: char) -> (Token<'_>, usize) {
    if let Some(len) = literal_len(text, first) {
        return (Token::Literal, len);
    }
    match word_len(text) {
        0 => (Token::Sign(first), first.len_utf8()),
        len => (Token::Word(&text[..len]), len),
    }
}

fn word_len(text: &str) -> usize {
    let is_of_word = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_' || !byte.is_ascii();
    text.as_bytes().iter().position(|byte| !is_of_word(byte)).unwrap_or(text.len())
}

fn block_comment_len(text: &str) -> usize {
    let (mut at, mut depth) = (0, 0);
    loop {
        match text.get(at..).and_then(|rest| rest.find("*/").map(|end| (rest.find("/*").unwrap_or(end), end))) {
            None => return text.len(),
            Some((begin, end)) if begin < end => (at, depth) = (at + begin + 2, depth + 1),
            Some((_, end)) => (at, depth) = (at + end + 2, depth - 1),
        }
        if depth == 0 {
            return at;
        }
    }
}

/// The length of the literal that a text begins with, if it does.
fn literal_len(text: &str, first: char) -> Option<usize> {
    match first {
        '0'..='9' => Some(word_len(text)),
        '"' => Some(1 + quoted_len(&text[1..], '"')),
        '\'' => character_len(text),
        'b' | 'c' | 'r' => {
            let body = text.find(|sign| !"bcr".contains(sign))?;
            let (prefix, rest) = text.split_at(body);
            let hashes = rest.len() - rest.trim_start_matches('#').len();
            match rest[hashes..].chars().next()? {
                '"' if prefix.contains('r') => {
                    let end = format!("\"{}", "#".repeat(hashes));
                    let begin = body + hashes + 1;
                    Some(begin + text[begin..].find(&end)? + end.len())
                }
                '"' if hashes == 0 => Some(body + 1 + quoted_len(&rest[1..], '"')),
                '\'' if prefix == "b" => Some(body + 1 + quoted_len(&rest[1..], '\'')),
                _ => None,
            }
        }
        _ => None,
    }
}

/// The length of a character; none for the sign that begins a lifetime.
fn character_len(text: &str) -> Option<usize> {
    let mut body = text[1..].chars();
    let first = body.next()?;
    (first == '\\' || body.next() == Some('\'')).then(|| 1 + quoted_len(&text[1..], '\''))
}

/// The length of what stands between quotes, with the second of them.
fn quoted_len(body: &str, quote: char) -> usize {
    let mut at = 0;
    while let Some(found) = body[at..].find([quote, '\\']) {
        at += found + 1;
        if body[..at].ends_with(quote) {
            return at;
        }
        at += body[at..].chars().next().map_or(0, char::len_utf8);
    }
    body.len()
}
