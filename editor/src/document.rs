//! A text that is open in an editor.

use crate::analysis::Analysis;
use crate::lines::Lines;
use crate::outline::Outline;
use lsp_types::{Position, Range, TextDocumentContentChangeEvent, Uri};
use rpl_lang::source::Span;
use std::cell::OnceCell;
use std::path::PathBuf;
use std::rc::Rc;

/// A text, and what is known of it.
pub struct Document {
    /// How the editor names it.
    pub uri: Uri,
    /// Its file; empty if it has none.
    pub path: PathBuf,
    /// The editor's count of its changes.
    pub version: i32,
    /// The text.
    pub text: String,
    /// Where its lines begin.
    pub lines: Lines,
    outline: OnceCell<Rc<Outline>>,
    /// What was found when the text was last looked at.
    pub analysis: Option<Rc<Analysis>>,
    /// Whether that was this very text.
    pub is_analysed: bool,
    /// Whether what was found in this very text was told.
    pub is_told: bool,
}

impl Document {
    /// A text that has just been opened.
    pub fn new(uri: Uri, version: i32, text: String) -> Self {
        let path = file_of(&uri).unwrap_or_default();
        let lines = Lines::of(&text);
        let outline = OnceCell::new();
        Self { uri, path, version, text, lines, outline, analysis: None, is_analysed: false, is_told: false }
    }

    /// The name that findings and programs have for it.
    pub fn name(&self) -> String {
        match self.path.as_os_str().is_empty() {
            true => self.uri.as_str().to_string(),
            false => self.path.display().to_string(),
        }
    }

    /// Takes a change: a stretch that is replaced, or a whole new text. Cost: linear in the text, without reading it.
    pub fn change(&mut self, change: TextDocumentContentChangeEvent) {
        match change.range {
            Some(range) => {
                let bytes = self.lines.bytes_of(&self.text, range);
                self.text.replace_range(bytes, &change.text);
            }
            None => self.text = change.text,
        }
        self.lines = Lines::of(&self.text);
        self.outline = OnceCell::new();
        self.look_again();
    }

    /// What was found may not hold any more.
    pub fn look_again(&mut self) {
        (self.is_analysed, self.is_told) = (false, false);
    }

    /// The shape of the text as it is now.
    pub fn outline(&self) -> Rc<Outline> {
        self.outline.get_or_init(|| Rc::new(Outline::of(&self.text))).clone()
    }

    /// The byte at a position.
    pub fn byte(&self, position: Position) -> usize {
        self.lines.byte(&self.text, position)
    }

    /// Where bytes stand.
    pub fn range(&self, bytes: std::ops::Range<usize>) -> Range {
        self.lines.range(&self.text, bytes)
    }

    /// Where a span of this text stands.
    pub fn range_of(&self, span: Span) -> Range {
        self.range(span.start as usize..span.end as usize)
    }
}

/// The file that a URI names.
pub fn file_of(uri: &Uri) -> Option<PathBuf> {
    url::Url::parse(uri.as_str()).ok()?.to_file_path().ok()
}

/// The URI of a file, by its absolute path.
pub fn uri_of(name: &str) -> Option<Uri> {
    url::Url::from_file_path(name).ok()?.as_str().parse().ok()
}
