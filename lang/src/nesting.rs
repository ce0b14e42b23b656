//! How deep a token lies, without a parser: lists, and marks that still wait for their datum.

use crate::lexer::Token;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    List,
    Prefix,
    DatumComment,
}

/// What is open after the tokens so far. Its depth is the depth at which the reader's grammar
/// recurses.
#[derive(Debug, Default)]
pub(crate) struct Nesting {
    frames: Vec<Level>,
    lists: usize,
    strays: usize,
}

impl Nesting {
    /// All tokens of a text.
    pub(crate) fn of(tokens: impl Iterator<Item = Token>) -> Self {
        let mut nesting = Self::default();
        tokens.for_each(|token| nesting.step(token));
        nesting
    }

    /// One more token.
    pub(crate) fn step(&mut self, token: Token) {
        match token {
            Token::Open => self.open_list(),
            Token::Close => self.close_list(),
            Token::Prefix(_) => self.frames.push(Level::Prefix),
            Token::DatumComment => self.frames.push(Level::DatumComment),
            Token::Dot => self.drop_marks(),
            Token::Str | Token::Symbol | Token::Keyword | Token::Int(_) | Token::Float(_) | Token::Error => {
                self.end_datum();
            }
            Token::LineComment | Token::BlockComment | Token::Unterminated => {}
        }
    }

    /// Open lists and waiting marks.
    pub(crate) fn depth(&self) -> usize {
        self.frames.len()
    }

    /// Whether a list is open.
    pub(crate) fn in_list(&self) -> bool {
        self.lists > 0
    }

    /// Whether every `(` has its `)` and every `)` its `(`.
    pub(crate) fn is_balanced(&self) -> bool {
        self.lists == 0 && self.strays == 0
    }

    /// Whether a `)` came that closes nothing, which no further text can mend.
    pub(crate) fn has_stray(&self) -> bool {
        self.strays > 0
    }

    /// Gives up all that is open.
    pub(crate) fn clear(&mut self) {
        self.frames.clear();
        self.lists = 0;
    }

    fn open_list(&mut self) {
        self.frames.push(Level::List);
        self.lists += 1;
    }

    fn close_list(&mut self) {
        self.drop_marks();
        match self.frames.pop() {
            Some(_) => {
                self.lists -= 1;
                self.end_datum();
            }
            None => self.strays += 1,
        }
    }

    /// A datum ends: it completes the marks before it, up to one that comments it out.
    fn end_datum(&mut self) {
        while let Some(frame) = self.frames.pop() {
            match frame {
                Level::Prefix => {}
                Level::DatumComment => break,
                Level::List => {
                    self.frames.push(frame);
                    break;
                }
            }
        }
    }

    /// Marks that wait in vain.
    fn drop_marks(&mut self) {
        while self.frames.last().is_some_and(|&frame| frame != Level::List) {
            self.frames.pop();
        }
    }
}
