//! Where the stepper stands: the form a task stands before, in its text.

use super::listings::value_text;
use rpl_drive::show::whereabouts::path_end;
use rpl_lang::source::{self, Sources, Span, count_line_ends};
use rpl_lang::visible::pictured;
use rpl_mission::robot::Robot;
use rpl_runtime::run::stepping::Stop;
use rpl_runtime::run::system::System;

/// Lines of text shown around a form.
const LINES_AROUND: usize = 2;

/// Time, task, the form in its text, and the variables around it. Lines
/// of the text are cut at a width.
pub fn standpoint(system: &System<Robot>, stop: &Stop, colour: bool, width: usize) -> Vec<String> {
    let machine = &system.machine;
    let Some(task) = machine.tasks.find_alive(stop.task) else { return Vec::new() };
    let place = system.program.sources.place(stop.span);
    let (time, place) = (format!("{:.3} s", machine.now_s()), place.to_string());
    let room = width.saturating_sub(time.chars().count() + place.chars().count() + 4);
    let mut lines = vec![format!("{time}  {}  {place}", path_end(&machine.path(task), room))];
    lines.extend(marked(&system.program.sources, stop.span, colour, width));
    if let Some((_, variables)) = machine.variables(&system.program, task).first()
        && !variables.is_empty()
    {
        let shown = variables
            .iter()
            .map(|&(name, value)| format!("{} = {}", machine.symbols.name(name), value_text(system, value)));
        lines.push(format!("    {}", shown.collect::<Vec<_>>().join(", ")));
    }
    lines
}

/// Columns before the text of a line.
const MARGIN: usize = 8;

/// As much of a line as fits.
fn cut(line: &str, width: usize) -> &str {
    line.char_indices().nth(width).map_or(line, |(end, _)| &line[..end])
}

/// The lines around a form, with the form marked: in reverse with colours, else underlined.
fn marked(sources: &Sources, span: Span, colour: bool, width: usize) -> Vec<String> {
    let text = &sources.get(span.source).text;
    let (first, _) = sources.line_column(Span { end: span.start, ..span });
    let (start, end) = (span.start as usize, span.end as usize);
    let last = first + text.get(start..end).map_or(0, count_line_ends).min(LINES_AROUND);
    let mut lines = Vec::new();
    for (index, (line_start, line)) in source::lines(text).enumerate() {
        let number = index + 1;
        if number + LINES_AROUND < first || number > last + LINES_AROUND {
            continue;
        }
        let line = cut(line, width.saturating_sub(MARGIN));
        let clamp = |at: usize| at.clamp(line_start, line_start + line.len()) - line_start;
        let (from, to) = (line.floor_char_boundary(clamp(start)), line.floor_char_boundary(clamp(end)));
        let has_mark = from < to;
        let arrow = if has_mark && number == first { '▶' } else { ' ' };
        if has_mark && colour {
            let (before, form, after) = (pictured(&line[..from]), pictured(&line[from..to]), pictured(&line[to..]));
            lines.push(format!("{number:>5} {arrow} {before}\x1b[7m{form}\x1b[0m{after}"));
            continue;
        }
        lines.push(format!("{number:>5} {arrow} {}", pictured(line)));
        if has_mark && number == first {
            let indent = line[..from].chars().count();
            lines.push(format!("        {}{}", " ".repeat(indent), "^".repeat(line[from..to].chars().count())));
        }
    }
    lines
}
