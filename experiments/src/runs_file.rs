//! `runs.csv`: every run as a line of comma-separated values, with columns that come up as the runs have them.

use super::any_kind::{AnyKind, AnyRecord};
use super::kind::Run;
use anyhow::{Context, Result};
use rpl_shell::files::outputs::OutputFolder;
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Write};

/// The file of all runs in the folder for results.
const RUNS: &str = "runs.csv";
/// Where the lines are while the file gets further columns.
const WIDER: &str = ".runs.csv.new";
const CANNOT: &str = "cannot write `runs.csv`";

/// The file, which is begun with the first line.
#[derive(Default)]
pub struct RunsFile {
    file: Option<BufWriter<File>>,
    /// The first columns, which every line has.
    head: String,
    /// The others, in the order in which they came up.
    further: Vec<String>,
    /// How many of them the first line of the file has.
    in_head: usize,
}

impl RunsFile {
    /// Writes a run, if it has lines.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add(
        &mut self,
        folder: &OutputFolder,
        kind: &dyn AnyKind,
        series: &str,
        run: Run,
        record: &AnyRecord,
    ) -> Result<()> {
        let lines = kind.lines(series, run, record);
        if lines.is_empty() {
            return Ok(());
        }
        let further = kind.further(record);
        for (name, _) in &further {
            if !self.further.contains(name) {
                self.further.push(name.clone());
            }
        }
        let file = match &mut self.file {
            Some(file) => file,
            none => {
                let mut file = BufWriter::new(folder.begin(RUNS)?);
                (self.head, self.in_head) = (kind.head(record), self.further.len());
                writeln!(file, "{}", wide_head(&self.head, &self.further)).context(CANNOT)?;
                none.insert(file)
            }
        };
        if self.further.is_empty() {
            return file.write_all(lines.as_bytes()).context(CANNOT);
        }
        let value = |name: &String| further.iter().find(|(known, _)| known == name).map_or("", |(_, value)| value);
        let values: Vec<&str> = self.further.iter().map(value).collect();
        writeln!(file, "{},{}", lines.trim_end(), values.join(",")).context(CANNOT)
    }

    /// Writes what is still to be written. Where columns came up behind the first run, the lines before them get empty
    /// values there. Cost: that of the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn end(self, folder: &OutputFolder) -> Result<()> {
        let Self { file: Some(mut file), head, further, in_head } = self else { return Ok(()) };
        file.flush().context(CANNOT)?;
        if further.len() == in_head {
            return Ok(());
        }
        let columns = columns(&head) + further.len();
        let mut wider = BufWriter::new(folder.begin(WIDER)?);
        writeln!(wider, "{}", wide_head(&head, &further)).context(CANNOT)?;
        for line in BufReader::new(folder.read(RUNS)?).lines().skip(1) {
            let line = line.context(CANNOT)?;
            let lacking = ",".repeat(columns - self::columns(&line));
            writeln!(wider, "{line}{lacking}").context(CANNOT)?;
        }
        wider.flush().context(CANNOT)?;
        folder.replace(WIDER, RUNS)
    }
}

fn wide_head(head: &str, further: &[String]) -> String {
    further.iter().fold(head.to_string(), |head, name| head + "," + &column(name))
}

/// The name of a column as the first line has it.
fn column(name: &str) -> String {
    if name.contains(['"', ',', '\n', '\r']) { quoted(name) } else { name.to_string() }
}

/// A text as a value in one line.
pub fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\"").replace(['\n', '\r'], " "))
}

/// How many values a line has. Commas in quotes part nothing; a quote in them stands twice, which ends and begins them.
fn columns(line: &str) -> usize {
    let mut is_quoted = false;
    let commas = line.bytes().filter(|byte| {
        is_quoted ^= *byte == b'"';
        *byte == b',' && !is_quoted
    });
    1 + commas.count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commas_and_quotes_in_a_value_make_no_column() {
        let line = format!("{},2,{}", quoted("say \"a, b\",\nc"), quoted(""));
        assert_eq!(line, "\"say \"\"a, b\"\", c\",2,\"\"");
        assert_eq!(columns(&line), 3);
        assert_eq!((column("rooms"), column("a,b")), ("rooms".to_string(), "\"a,b\"".to_string()));
    }
}
