//! Lines being written, and comments at their ends.

use crate::layout::WIDTH;

/// The text so far.
#[derive(Default)]
pub(super) struct Lines {
    text: String,
    /// Characters on the present line.
    column: usize,
    /// The comment that will end this line; closers still go before it.
    trailing: Option<String>,
    /// The line is a comment: nothing can follow on it.
    is_comment: bool,
    /// Where the comments at the ends of lines begin.
    trailed: Vec<Trailed>,
    line: usize,
}

/// A line of code with a comment at its end.
struct Trailed {
    line: usize,
    /// Characters of code.
    column: usize,
    /// The byte after the code.
    end: usize,
    comment: String,
}

impl Lines {
    /// Characters on the present line, a comment at its end not counted.
    pub(super) fn column(&self) -> usize {
        self.column
    }

    /// Whether nothing but closers can follow on this line.
    pub(super) fn must_break(&self) -> bool {
        self.is_comment || self.trailing.is_some()
    }

    /// Whether not even closers can.
    pub(super) fn ends_in_comment(&self) -> bool {
        self.is_comment
    }

    /// Goes on with this text, which may have lines itself.
    pub(super) fn write(&mut self, text: &str) {
        self.text.push_str(text);
        match text.rfind('\n') {
            Some(newline) => {
                self.line += text.matches('\n').count();
                self.column = text[newline + 1..].chars().count();
            }
            None => self.column += text.chars().count(),
        }
    }

    /// One space, unless the line is empty.
    pub(super) fn space(&mut self) {
        if self.column > 0 {
            self.write(" ");
        }
    }

    /// A `;` comment: the line's own if it has nothing else, else it goes to the end of the line.
    pub(super) fn comment(&mut self, comment: &str) {
        if self.text[self.text.rfind('\n').map_or(0, |newline| newline + 1)..].trim().is_empty() {
            self.write(comment);
            self.is_comment = true;
        } else {
            // The space that was to separate it comes when it is written.
            let code = self.text.trim_end_matches(' ').len();
            self.column -= self.text.len() - code;
            self.text.truncate(code);
            self.trailing = Some(comment.to_string());
        }
    }

    /// Ends the line and indents the next one, with a blank line between if asked to.
    pub(super) fn new_line(&mut self, indent: usize, blank: bool) {
        self.end_line();
        if self.text.is_empty() {
            return;
        }
        let count = if blank { 2 } else { 1 };
        self.text.extend(std::iter::repeat_n('\n', count));
        self.text.extend(std::iter::repeat_n(' ', indent));
        self.line += count;
        self.column = indent;
    }

    fn end_line(&mut self) {
        if let Some(comment) = self.trailing.take() {
            let (line, column, end) = (self.line, self.column, self.text.len());
            self.trailed.push(Trailed { line, column, end, comment });
        }
        self.is_comment = false;
    }

    /// The whole text, comments at the ends of neighbouring lines below each other where they fit.
    pub(super) fn finish(mut self) -> String {
        self.end_line();
        if !self.text.is_empty() {
            self.text.push('\n');
        }
        let mut whole = String::with_capacity(self.text.len() + 64);
        let mut written = 0;
        for block in self.trailed.chunk_by(|above, below| above.line + 1 == below.line) {
            let widest = block.iter().map(|trailed| trailed.column).max().unwrap_or(0);
            let fit = block.iter().all(|trailed| widest + 1 + trailed.comment.chars().count() <= WIDTH);
            for trailed in block {
                whole.push_str(&self.text[written..trailed.end]);
                let gap = if fit { widest - trailed.column } else { 0 };
                whole.extend(std::iter::repeat_n(' ', gap + 1));
                whole.push_str(&trailed.comment);
                written = trailed.end;
            }
        }
        whole.push_str(&self.text[written..]);
        whole
    }
}
