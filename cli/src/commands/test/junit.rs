//! The report of `rpl test` as JUnit XML, which services that build and test understand.

use super::report::{FaultyFile, TestRecord, TestReport};
use ::console::strip_ansi_codes;
use std::fmt::Write;

/// The report: a suite for each file, a case for each test. The time of a case is that of the clock
/// on the wall; the plan's own stands among its properties.
pub fn xml(report: &TestReport) -> String {
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let totals = counts(report.tests.len(), report.failed, report.faulty_files.len());
    put(&mut text, 0, &format!("<testsuites name=\"rpl test\" {totals} time=\"{:.3}\">", report.wall_s));
    for tests in report.tests.chunk_by(|a, b| a.file == b.file) {
        suite(&mut text, tests);
    }
    for file in &report.faulty_files {
        faulty(&mut text, file);
    }
    put(&mut text, 0, "</testsuites>");
    text
}

fn put(text: &mut String, depth: usize, line: &str) {
    // Writing into a string cannot fail.
    writeln!(text, "{:1$}{line}", "", 2 * depth).ok();
}

/// A file whose text is wrong is a case that could not run, and no test of it did.
fn counts(tests: usize, failures: usize, errors: usize) -> String {
    format!("tests=\"{}\" failures=\"{failures}\" errors=\"{errors}\"", tests + errors)
}

fn suite(text: &mut String, tests: &[TestRecord]) {
    let Some(first) = tests.first() else { return };
    let failed = tests.iter().filter(|test| !test.has_succeeded()).count();
    let wall_s: f64 = tests.iter().map(|test| test.wall_s).sum();
    let (name, counts) = (escaped(&first.file), counts(tests.len(), failed, 0));
    put(text, 1, &format!("<testsuite name=\"{name}\" {counts} time=\"{wall_s:.3}\">"));
    tests.iter().for_each(|test| case(text, test));
    put(text, 1, "</testsuite>");
}

fn case(text: &mut String, test: &TestRecord) {
    let (name, file) = (escaped(&test.name), escaped(&test.file));
    let place = format!("classname=\"{file}\" file=\"{file}\" line=\"{}\"", test.line);
    put(text, 2, &format!("<testcase name=\"{name}\" {place} time=\"{:.3}\">", test.wall_s));
    put(text, 3, "<properties>");
    let world = test.world.as_deref().map(|world| ("world", world.to_string()));
    let plain = [("seed", test.seed.to_string()), ("time_s", test.time_s.to_string())];
    for (name, value) in plain.into_iter().chain(world) {
        put(text, 4, &format!("<property name=\"{name}\" value=\"{}\"/>", escaped(&value)));
    }
    put(text, 3, "</properties>");
    if !test.has_succeeded() {
        let class = test.failure.as_ref().map_or(test.outcome, |failure| failure.class.as_str());
        // On a terminal it has colours.
        let reason = strip_ansi_codes(&test.reason);
        let message = test.failure.as_ref().map_or(reason.as_ref(), |failure| failure.message.as_str());
        let (class, message, reason) = (escaped(class), escaped(message), escaped(&reason));
        put(text, 3, &format!("<failure type=\"{class}\" message=\"{message}\">{reason}</failure>"));
    }
    if !test.output.is_empty() {
        put(text, 3, &format!("<system-out>{}</system-out>", escaped(&test.output.join("\n"))));
    }
    put(text, 2, "</testcase>");
}

fn faulty(text: &mut String, file: &FaultyFile) {
    let (name, reason) = (escaped(&file.file), escaped(&file.reason));
    put(text, 1, &format!("<testsuite name=\"{name}\" {} time=\"0.000\">", counts(0, 0, 1)));
    put(text, 2, &format!("<testcase name=\"the text\" classname=\"{name}\" file=\"{name}\" time=\"0.000\">"));
    put(text, 3, &format!("<error message=\"it cannot be compiled\">{reason}</error>"));
    put(text, 2, "</testcase>");
    put(text, 1, "</testsuite>");
}

/// A text as XML has it, in attributes and between tags alike; what XML cannot have at all is
/// written as in a string of the language.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\t' | '\n' | '\r' => escaped.push_str(&format!("&#{};", u32::from(c))),
            '\0'..'\u{20}' | '\u{7f}' | '\u{fffe}' | '\u{ffff}' => {
                escaped.push_str(&format!("\\u{{{:x}}}", u32::from(c)));
            }
            c => escaped.push(c),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_xml_takes_for_its_own_is_escaped() {
        assert_eq!(escaped("a < b && \"c\" > 'd'"), "a &lt; b &amp;&amp; &quot;c&quot; &gt; 'd'");
        assert_eq!(escaped("\u{1b}[31mred\0\n\u{ffff}ü"), "\\u{1b}[31mred\\u{0}&#10;\\u{ffff}ü");
        assert_eq!(escaped("]]>"), "]]&gt;");
    }
}
