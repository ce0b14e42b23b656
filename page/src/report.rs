//! A run as one file: the page with the run in it, compressed, which opens without a server and without a network.

use crate::html::{self, Source};
use crate::series::{Series, VERSION};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use serde::Deserialize;
use std::io::{self, Read, Write};
use thiserror::Error;

/// What stands before and behind a run in the page.
const BEFORE: &str = "<script type=\"application/x-rpl-run\">";
const BEHIND: &str = "</script>";

/// A run in a report is no longer than this when it is inflated.
const MOST_BYTES: u64 = 2 << 30;

/// A file has no run in it.
#[derive(Debug, Error)]
pub enum ReportError {
    /// There is none.
    #[error("it has no run in it")]
    NoRun,
    /// It was changed or cut off.
    #[error("the run in it is damaged: {0}")]
    Damaged(String),
    /// Its run is written in another layout.
    #[error("it was written by rpl {0}, which writes runs in another way; a browser opens it by itself")]
    Layout(String),
}

/// The part of a head that says how the run is written.
#[derive(Deserialize)]
struct Layout {
    series: u32,
    rpl: String,
}

/// The page with runs in it, next to each other. Cost: compressing them.
///
/// # Errors
/// Never: what is written lies in memory.
pub fn report(title: &str, runs: &[&Series]) -> io::Result<String> {
    let mut data = String::new();
    for run in runs {
        let mut deflated = ZlibEncoder::new(Vec::new(), Compression::new(7));
        deflated.write_all(run.head().as_bytes())?;
        deflated.write_all(b"\n")?;
        deflated.write_all(run.lines())?;
        data.push_str(BEFORE);
        data.push_str(&STANDARD.encode(deflated.finish()?));
        data.push_str(BEHIND);
        data.push('\n');
    }
    Ok(html::page(title, Source::Itself, &data))
}

/// The first run of a report.
///
/// # Errors
/// There is none, or it is damaged.
pub fn run_in(report: &str) -> Result<Series, ReportError> {
    let (_, from) = report.split_once(BEFORE).ok_or(ReportError::NoRun)?;
    let (encoded, _) = from.split_once(BEHIND).ok_or_else(|| ReportError::Damaged("it is cut off".into()))?;
    let damaged = |why: &dyn std::fmt::Display| ReportError::Damaged(why.to_string());
    let deflated = STANDARD.decode(encoded.trim()).map_err(|why| damaged(&why))?;
    let mut bytes = Vec::new();
    ZlibDecoder::new(deflated.as_slice()).take(MOST_BYTES).read_to_end(&mut bytes).map_err(|why| damaged(&why))?;
    let end = bytes.iter().position(|&byte| byte == b'\n').ok_or_else(|| damaged(&"it has no head"))?;
    let lines = bytes.split_off(end + 1);
    bytes.pop();
    let head = String::from_utf8(bytes).map_err(|why| damaged(&why))?;
    let layout: Layout = serde_json::from_str(&head).map_err(|why| damaged(&why))?;
    if layout.series != VERSION {
        return Err(ReportError::Layout(layout.rpl));
    }
    Ok(Series::written(head, lines))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::{Head, Seen, SeriesWriter};

    fn run() -> Series {
        let mut run = Series::new(&Head { series: VERSION, plan: "</script> \"q\"".into(), ..Head::default() });
        let mut writer = SeriesWriter::default();
        (0..1000).for_each(|at| run.add(&writer.lines(at * 1000, [Seen::Targets(vec![[at as i32, 0]])])));
        run
    }

    #[test]
    fn a_run_comes_out_of_its_report_as_it_went_in() {
        let run = run();
        let report = report("a <title>", &[&run, &run]).expect("it is written");
        assert!(report.contains("<title>a &lt;title&gt;</title>"));
        let read = run_in(&report).expect("there is a run");
        assert_eq!((read.head(), read.lines()), (run.head(), run.lines()));
    }

    #[test]
    fn a_report_asks_no_host_for_anything() {
        let report = report("a run", &[&run()]).expect("it is written");
        assert!(report.contains("connect-src 'none'"));
        for outside in ["http://", "https://", "src=\"", "@import", "url("] {
            let found = report.find(outside).map(|at| &report[at..(at + 60).min(report.len())]);
            assert!(found.is_none_or(|text| text.starts_with("http://www.w3.org/")), "{found:?}");
        }
    }

    #[test]
    fn a_report_of_another_layout_says_which_rpl_has_written_it() {
        let older = Series::new(&Head { series: VERSION - 1, rpl: "0.1.0".into(), ..Head::default() });
        let report = report("an older run", &[&older]).expect("it is written");
        assert!(matches!(run_in(&report), Err(ReportError::Layout(rpl)) if rpl == "0.1.0"));
    }

    #[test]
    fn what_is_no_report_is_told() {
        assert!(matches!(run_in("<html></html>"), Err(ReportError::NoRun)));
        let cut = format!("{BEFORE}AAAA{BEHIND}");
        assert!(matches!(run_in(&cut), Err(ReportError::Damaged(_))));
        assert!(matches!(run_in(BEFORE), Err(ReportError::Damaged(_))));
    }
}
