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
    /// What was found when the text was last looked at, if that is kept.
    pub analysis: Option<Rc<Analysis>>,
    /// Whether that was this very text, with all that it loads.
    pub is_analysed: bool,
    /// The number of the library that had all it names then.
    pub library: usize,
}

impl Document {
    /// A text that has just been opened.
    pub fn new(uri: Uri, version: i32, text: String) -> Self {
        let path = file_of(&uri).unwrap_or_default();
        let lines = Lines::of(&text);
        let outline = OnceCell::new();
        Self { uri, path, version, text, lines, outline, analysis: None, is_analysed: false, library: 0 }
    }

    /// The name that findings and programs have for it.
    pub fn name(&self) -> String {
        match self.path.as_os_str().is_empty() {
            true => self.uri.as_str().to_string(),
            false => self.path.to_string_lossy().into_owned(),
        }
    }

    /// Takes changes in their order: stretches that are replaced, or a whole new text. Cost: linear in the text for each
    /// change, and for all of them together if each stands before the last one, as editors with many cursors say them.
    pub fn change(&mut self, changes: Vec<TextDocumentContentChangeEvent>) {
        // Of the text as it stands, from the last to the first.
        let mut edits: Vec<Edit> = Vec::new();
        for change in changes {
            let Some(range) = change.range else {
                edits.clear();
                self.set_text(change.text);
                continue;
            };
            let mut edit = Edit::of(self, range, &change.text);
            if edits.last().is_some_and(|later| edit.bytes.end >= later.bytes.start) {
                self.apply(&edits);
                edits.clear();
                edit = Edit::of(self, range, &change.text);
            }
            edits.push(edit);
        }
        self.apply(&edits);
    }

    /// Replaces stretches of the text, from the last to the first.
    fn apply(&mut self, edits: &[Edit]) {
        let mut text = String::with_capacity(self.text.len());
        let mut at = 0;
        for Edit { bytes, text: new } in edits.iter().rev() {
            text.push_str(&self.text[at..bytes.start]);
            text.push_str(new);
            at = bytes.end;
        }
        text.push_str(&self.text[at..]);
        self.set_text(text);
    }

    fn set_text(&mut self, text: String) {
        self.text = text;
        self.lines = Lines::of(&self.text);
        self.outline = OnceCell::new();
        self.is_analysed = false;
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

/// A stretch of a text, and what stands there instead.
struct Edit {
    bytes: std::ops::Range<usize>,
    text: String,
}

impl Edit {
    /// What an editor means. One that counts in UTF-16 may cut a character in two: the half that stays is U+FFFD here,
    /// which has one unit as well, so that what follows stays where the editor has it.
    fn of(document: &Document, range: Range, text: &str) -> Self {
        let Document { lines, text: old, .. } = document;
        let (first, second) = (lines.place(old, range.start), lines.place(old, range.end));
        let (start, end) = (first.min(second), first.max(second));
        let half = |is_cut: bool| if is_cut { "\u{fffd}" } else { "" };
        let end_byte = if end.is_within { old.ceil_char_boundary(end.byte + 1) } else { end.byte };
        let text = [half(start.is_within), text, half(end.is_within)].concat();
        Self { bytes: start.byte..end_byte, text }
    }
}

/// The file that a URI names; other schemes have paths as well, which are none of files.
pub fn file_of(uri: &Uri) -> Option<PathBuf> {
    url::Url::parse(uri.as_str()).ok().filter(|url| url.scheme() == "file")?.to_file_path().ok()
}

/// The URI of a file, by its absolute path.
pub fn uri_of(name: &str) -> Option<Uri> {
    url::Url::from_file_path(name).ok()?.as_str().parse().ok()
}
