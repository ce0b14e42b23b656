//! The shape of a text by its tokens alone: which list a place is in, how far lists reach, where the forms stand. It is
//! there while the text is typed and cannot be read.

use rpl_lang::bars::begins_definition;
use rpl_lang::lexer::{Token, lex};
use rpl_lang::source::{LINE_ENDS, SourceId};
use std::ops::Range;

/// A token and its bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lexeme {
    /// Its kind.
    pub token: Token,
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

/// The tokens of a text, and which parentheses belong together.
#[derive(Clone, Debug, Default)]
pub struct Outline {
    /// In order, comments included.
    pub lexemes: Vec<Lexeme>,
    /// For each token the one that opens the list around it.
    pub around: Vec<Option<u32>>,
    /// For each token that opens a list the one that closes it, or the last one in it.
    pub closers: Vec<u32>,
}

impl Outline {
    /// Of a text. A `(` that begins a line ends what is open, as it does for the reader, if it begins a definition.
    /// Cost: linear.
    pub fn of(text: &str) -> Self {
        let (tokens, _) = lex(text, SourceId(0));
        let lexemes: Vec<Lexeme> = tokens
            .into_iter()
            .map(|(token, span)| Lexeme { token, start: span.start as usize, end: span.end as usize })
            .collect();
        let mut around = vec![None; lexemes.len()];
        let mut closers: Vec<u32> = (0..lexemes.len() as u32).collect();
        let mut open: Vec<u32> = Vec::new();
        for (at, lexeme) in lexemes.iter().enumerate() {
            let begins_line = lexeme.start == 0 || text[..lexeme.start].ends_with(LINE_ENDS);
            if lexeme.token == Token::Open && begins_line && is_definition(text, lexemes.get(at + 1)) {
                open.drain(..).for_each(|opener| closers[opener as usize] = at as u32 - 1);
            }
            match lexeme.token {
                Token::Close => {
                    if let Some(opener) = open.pop() {
                        closers[opener as usize] = at as u32;
                        around[at] = Some(opener);
                    }
                }
                Token::Open => {
                    around[at] = open.last().copied();
                    open.push(at as u32);
                }
                _ => around[at] = open.last().copied(),
            }
        }
        let last = lexemes.len().saturating_sub(1) as u32;
        open.into_iter().for_each(|opener| closers[opener as usize] = last);
        Self { lexemes, around, closers }
    }

    /// The token that a byte lies in, or that ends there.
    pub fn at(&self, byte: usize) -> Option<usize> {
        let next = self.lexemes.partition_point(|lexeme| lexeme.start <= byte);
        let before = next.checked_sub(1)?;
        let lexeme = &self.lexemes[before];
        // Between two tokens that touch, the name is meant and not the parenthesis.
        if lexeme.start == byte && !is_word(lexeme.token) && before > 0 {
            let left = &self.lexemes[before - 1];
            if left.end == byte && is_word(left.token) {
                return Some(before - 1);
            }
        }
        (byte <= lexeme.end).then_some(before)
    }

    /// The token that opens the innermost list around a byte.
    pub fn opener(&self, byte: usize) -> Option<usize> {
        let before = self.lexemes.partition_point(|lexeme| lexeme.end <= byte).checked_sub(1)?;
        let mut at = match self.lexemes[before].token {
            Token::Open => Some(before),
            // Behind a list one is in the list around it.
            Token::Close => self.around[before].and_then(|opener| self.around[opener as usize]).map(|at| at as usize),
            _ => self.around[before].map(|at| at as usize),
        };
        while let Some(opener) = at {
            if self.closer(opener).is_none_or(|closer| self.lexemes[closer].end > byte) {
                return Some(opener);
            }
            at = self.around[opener].map(|at| at as usize);
        }
        None
    }

    /// The parenthesis that closes a list, if one does.
    fn closer(&self, opener: usize) -> Option<usize> {
        let last = self.closers[opener] as usize;
        (self.lexemes[last].token == Token::Close && self.around[last] == Some(opener as u32)).then_some(last)
    }

    /// The bytes of a list by the token that opens it.
    pub fn list(&self, opener: usize) -> Range<usize> {
        self.lexemes[opener].start..self.lexemes[self.closers[opener] as usize].end
    }

    /// The top-level form a byte lies in.
    pub fn form(&self, byte: usize) -> Option<Range<usize>> {
        let mut at = self.opener(byte)?;
        while let Some(outer) = self.around[at] {
            at = outer as usize;
        }
        Some(self.list(at))
    }

    /// The tokens that stand directly in a list, comments left out; of an inner list its first token.
    pub fn items(&self, opener: usize) -> impl Iterator<Item = usize> {
        let end = self.closer(opener).unwrap_or(self.closers[opener] as usize + 1);
        let mut at = opener + 1;
        std::iter::from_fn(move || {
            loop {
                let here = at;
                if here >= end {
                    return None;
                }
                at = if self.lexemes[here].token == Token::Open { self.closers[here] as usize + 1 } else { here + 1 };
                if !self.lexemes[here].token.is_comment() {
                    return Some(here);
                }
            }
        })
    }

    /// The lists that stand by themselves, by the tokens that open them.
    pub fn forms(&self) -> impl Iterator<Item = usize> {
        let mut at = 0;
        std::iter::from_fn(move || {
            loop {
                let opener = (at..self.lexemes.len()).find(|&at| self.lexemes[at].token == Token::Open)?;
                at = self.closers[opener] as usize + 1;
                // A list that is quoted or commented out is no form.
                let before = opener.checked_sub(1).map(|before| self.lexemes[before].token);
                if !matches!(before, Some(Token::Prefix(_) | Token::DatumComment)) {
                    return Some(opener);
                }
            }
        })
    }

    /// The symbol or list behind the head of a list: in a definition the name, or the goal.
    pub fn named(&self, opener: usize) -> Option<Range<usize>> {
        let at = self.items(opener).nth(1)?;
        match self.lexemes[at].token {
            Token::Symbol => Some(self.lexemes[at].start..self.lexemes[at].end),
            Token::Open => Some(self.list(at)),
            _ => None,
        }
    }

    /// The text of the symbol a list begins with.
    pub fn head<'t>(&self, text: &'t str, opener: usize) -> Option<&'t str> {
        let head = &self.lexemes[self.items(opener).next()?];
        (head.token == Token::Symbol || head.token == Token::Keyword).then(|| &text[head.start..head.end])
    }
}

fn is_word(token: Token) -> bool {
    matches!(token, Token::Symbol | Token::Keyword | Token::Int(_) | Token::Float(_) | Token::Str | Token::Error)
}

fn is_definition(text: &str, head: Option<&Lexeme>) -> bool {
    let Some(head) = head.filter(|head| head.token == Token::Symbol) else { return false };
    begins_definition(&text[head.start..head.end])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn head_at(text: &str) -> Option<String> {
        let byte = text.find('|').expect("a place is marked");
        let text = text.replacen('|', "", 1);
        let outline = Outline::of(&text);
        outline.opener(byte).and_then(|opener| outline.head(&text, opener).map(str::to_string))
    }

    #[test]
    fn a_place_is_in_the_innermost_list_around_it() {
        assert_eq!(head_at("(a (b |c) d)").as_deref(), Some("b"));
        assert_eq!(head_at("(a (b c)| d)").as_deref(), Some("a"));
        assert_eq!(head_at("(a (b c) d)|").as_deref(), None);
        assert_eq!(head_at("(a (b c) |").as_deref(), Some("a"), "while it is typed");
        assert_eq!(head_at("(a (b \n(def-plan x () |)").as_deref(), Some("def-plan"), "a definition ends what is open");
        assert_eq!(head_at("(a ; (b\n |").as_deref(), Some("a"));
    }

    #[test]
    fn forms_stand_by_themselves_and_have_names() {
        let text = "x (def-plan a () (b)) 'y\n(deftest 7 (e)) ; (f)\n(g (h i)) (";
        let outline = Outline::of(text);
        let names: Vec<_> = outline.forms().map(|form| outline.named(form).map(|bytes| &text[bytes])).collect();
        assert_eq!(names, [Some("a"), None, Some("(h i)"), None]);
    }

    #[test]
    fn items_are_what_stands_directly_in_a_list() {
        let text = "(a (b c) ; (d)\n 'e)";
        let outline = Outline::of(text);
        let items: Vec<&str> =
            outline.items(0).map(|at| &text[outline.lexemes[at].start..outline.lexemes[at].end]).collect();
        assert_eq!(items, ["a", "(", "'", "e"]);
        assert_eq!(outline.list(0), 0..text.len());
    }
}
