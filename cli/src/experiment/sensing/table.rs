//! The table of the experiment, and its runs as lines.

use super::Rows;
use super::course::{CERTAIN_WITHIN_S, Course, HELD_S};
use crate::experiment::statistics::{Spread, wilson_95};

/// Times at which the error is told.
const AT_S: [f64; 4] = [100.0, 200.0, 400.0, 600.0];

/// A line for each row.
pub fn table(rows: &Rows) -> String {
    let mut lines = vec![format!(
        "{:16} {:>7} {:>13} {:>18} {:>27} {:>8} {:>8}",
        "", "certain", "95 % interval", "after [s]", "error [m] at 100 200 400 600", "there", "mirrored"
    )];
    lines.extend(rows.iter().map(|(setting, courses)| line(setting.name, courses)));
    lines.push(format!(
        "certain: at least 0.9 within 0.4 m of the true position, from at most {CERTAIN_WITHIN_S:.0} s on and for {HELD_S:.0} s;"
    ));
    lines.push(
        "after: median, least and greatest, of all runs that ever were; error: L1, weighted by the belief, mean;"
            .into(),
    );
    lines.push(
        "there, mirrored: probability at the end within 0.4 m of the true and of the mirrored position, medians".into(),
    );
    lines.join("\n")
}

fn line(name: &str, courses: &[Course]) -> String {
    let certain = courses.iter().filter(|course| course.succeeded()).count();
    let (low, high) = wilson_95(certain, courses.len());
    let after: Vec<f64> = courses.iter().filter_map(Course::certain_after_s).collect();
    let median =
        |numbers: &[f64]| Spread::of(numbers).map_or("–".to_string(), |spread| format!("{:.2}", spread.median));
    let after = Spread::of(&after)
        .map_or("–".to_string(), |after| format!("{:.0} ({:.0}–{:.0})", after.median, after.min, after.max));
    let errors: Vec<String> = AT_S.iter().map(|&at_s| error_at(courses, at_s)).collect();
    let near: Vec<f64> = courses.iter().filter_map(|course| course.moments.last()).map(|moment| moment.near).collect();
    let mirrored: Vec<f64> = courses.iter().map(|course| course.mirrored).collect();
    format!(
        "{name:16} {:>7} {:>13} {after:>18} {:>28} {:>8} {:>8}",
        format!("{certain}/{}", courses.len()),
        format!("{:.0}–{:.0} %", 100.0 * low, 100.0 * high),
        errors.join(" "),
        median(&near),
        median(&mirrored),
    )
}

/// Mean over the runs.
fn error_at(courses: &[Course], at_s: f64) -> String {
    let at = |course: &Course| course.moments.iter().find(|moment| moment.time_s >= at_s).map(|moment| moment.error_m);
    let errors: Vec<f64> = courses.iter().filter_map(at).collect();
    Spread::of(&errors).map_or("–".to_string(), |spread| format!("{:>6.2}", spread.mean))
}

/// Every run as a line of comma-separated values.
pub fn raw_rows(rows: &Rows) -> String {
    let mut lines = vec!["row,seed,certain after [s],error at the end [m],at the position,at the mirrored".to_string()];
    for (setting, courses) in rows {
        for course in courses {
            let after = course.certain_after_s().map_or(String::new(), |time_s| time_s.to_string());
            let (error_m, near) = course.moments.last().map_or((0.0, 0.0), |moment| (moment.error_m, moment.near));
            lines.push(format!("\"{}\",{},{after},{error_m},{near},{}", setting.name, course.seed, course.mirrored));
        }
    }
    lines.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::sensing::SETTINGS;
    use crate::experiment::sensing::course::Moment;

    fn course(near: impl Fn(usize) -> f64) -> Course {
        let moment = |second: usize| Moment { time_s: second as f64, error_m: 0.5, near: near(second) };
        Course { seed: 1, moments: (1..=600).map(moment).collect(), readings: vec![], mirrored: 0.1 }
    }

    #[test]
    fn certain_is_who_stays_certain_for_a_while_and_soon_enough() {
        let late = course(|second| if second > 450 { 0.95 } else { 0.5 });
        let soon = course(|second| if (100..200).contains(&second) || second > 250 { 0.95 } else { 0.5 });
        let glimpse = course(|second| if second % 60 > 5 { 0.95 } else { 0.5 });
        assert_eq!(late.certain_after_s(), Some(451.0));
        assert_eq!(soon.certain_after_s(), Some(100.0));
        assert_eq!(glimpse.certain_after_s(), None);
        let text = table(&vec![(&SETTINGS[0], vec![late, soon, glimpse])]);
        assert!(text.contains("1/3") && text.contains("276 (100–451)") && text.contains("0.50   0.50"), "{text}");
    }
}
