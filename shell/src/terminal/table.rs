//! Tables: as wide as what stands in them, and in several parts where a terminal is narrower.

use ::console::measure_text_width;
use rpl_lang::visible::visible_coloured;

/// Columns between two columns of a table.
const GAP: usize = 2;

/// A cell for what there is nothing of.
pub const NOTHING: &str = "–";

/// A table whose first column says what a row is about, at the left; the others stand at the right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// What the columns are called.
    head: Vec<String>,
    /// As many cells in each row as there are columns.
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    pub fn new(head: &[&str]) -> Self {
        Self { head: head.iter().map(|name| (*name).to_string()).collect(), rows: Vec::new() }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        let cells: Vec<String> = cells.into_iter().map(|cell| visible_coloured(&cell).into_owned()).collect();
        assert_eq!(cells.len(), self.head.len(), "a row has a cell for each column of its table");
        self.rows.push(cells);
    }

    /// The table as text. Where it is wider than `width`, it is cut between columns, and each part
    /// begins with the first column again; a single column is never cut.
    pub fn text(&self, width: Option<usize>) -> String {
        let widths: Vec<usize> = (0..self.head.len()).map(|column| self.width(column)).collect();
        let parts = parts(&widths, width.unwrap_or(usize::MAX));
        let texts: Vec<String> = parts.iter().map(|part| self.part(part, &widths)).collect();
        texts.join("\n\n")
    }

    /// The head by itself, of a table whose rows come one by one.
    pub fn head_text(&self) -> String {
        self.row_text(&self.head)
    }

    /// A row by itself, as wide as the head is.
    pub fn row_text(&self, cells: &[String]) -> String {
        let widths: Vec<usize> = self.head.iter().map(|name| measure_text_width(name)).collect();
        let all: Vec<usize> = (0..cells.len()).collect();
        line(cells, &all, &widths)
    }

    fn lines(&self) -> impl Iterator<Item = &Vec<String>> {
        std::iter::once(&self.head).chain(&self.rows)
    }

    fn width(&self, column: usize) -> usize {
        self.lines().map(|cells| measure_text_width(&cells[column])).max().unwrap_or(0)
    }

    fn part(&self, columns: &[usize], widths: &[usize]) -> String {
        self.lines().map(|cells| line(cells, columns, widths)).collect::<Vec<_>>().join("\n")
    }
}

/// Some cells of a row; one that is wider than its column pushes the others to the right.
fn line(cells: &[String], columns: &[usize], widths: &[usize]) -> String {
    let mut line = String::new();
    for &column in columns {
        let cell = &cells[column];
        let room = " ".repeat(widths[column].saturating_sub(measure_text_width(cell)));
        match column {
            0 => line += &format!("{cell}{room}"),
            _ => line += &format!("{:GAP$}{room}{cell}", ""),
        }
    }
    line.trim_end().to_string()
}

/// The columns of each part: the first one, and as many others as fit.
fn parts(widths: &[usize], room: usize) -> Vec<Vec<usize>> {
    let mut parts = vec![vec![0]];
    let first = widths.first().copied().unwrap_or(0);
    let mut taken = first;
    for (column, width) in widths.iter().enumerate().skip(1) {
        if taken.saturating_add(GAP + width) > room && taken > first {
            parts.push(vec![0]);
            taken = first;
        }
        taken += GAP + width;
        if let Some(part) = parts.last_mut() {
            part.push(column);
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let mut table = Table::new(&["", "runs", "95 % interval", "± 95 %"]);
        table.row(["no relocalization", "20", "13.9–24.1 %", "0.12"].map(str::to_string));
        table.row(["rotated", "100", "–", "10.00"].map(str::to_string));
        table
    }

    #[test]
    fn a_table_is_as_wide_as_what_stands_in_it() {
        assert_eq!(
            table().text(None),
            "                   runs  95 % interval  ± 95 %\n\
             no relocalization    20    13.9–24.1 %    0.12\n\
             rotated             100              –   10.00"
        );
    }

    #[test]
    fn a_table_that_is_too_wide_goes_on_below_with_its_first_column() {
        assert_eq!(
            table().text(Some(40)),
            "                   runs  95 % interval\n\
             no relocalization    20    13.9–24.1 %\n\
             rotated             100              –\n\n\
             \u{20}                  ± 95 %\n\
             no relocalization    0.12\n\
             rotated             10.00"
        );
    }

    #[test]
    fn no_cell_is_cut_and_none_is_lost_at_any_width() {
        for width in 1..60 {
            let text = table().text(Some(width));
            for cell in ["no relocalization", "13.9–24.1 %", "± 95 %", "10.00", "runs"] {
                assert!(text.contains(cell), "`{cell}` at {width}:\n{text}");
            }
            // The widest column fits beside the first one from here on.
            if width >= 17 + GAP + 13 {
                assert!(text.lines().all(|line| measure_text_width(line) <= width), "at {width}:\n{text}");
            }
        }
    }
}
