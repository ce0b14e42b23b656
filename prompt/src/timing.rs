//! `:time`: what a form costs.

use super::Prompt;
use anyhow::Result;
use rpl_drive::stopping::halt::Until;
use std::time::Instant;

impl Prompt<'_> {
    pub(super) fn time(&mut self, form: &str) -> Result<()> {
        if form.is_empty() {
            return self.wrong("`:time FORM`: a form is expected, such as `:time (sort (list 3 1 2) #'<)`");
        }
        let counted = |prompt: &Self| {
            let machine = &prompt.session.branch.system.machine;
            (machine.steps, machine.heap.made_bytes(), machine.now_us)
        };
        let (began, before) = (Instant::now(), counted(self));
        self.forms(form, &Until::End)?;
        let (computing_s, after) = (began.elapsed().as_secs_f64(), counted(self));
        let so_far = if self.session.branch.is_running { " so far" } else { "" };
        let plan_s = after.2.saturating_sub(before.2) as f64 / 1e6;
        self.console.note(&format!(
            "{computing_s:.3} s of computing, {} steps, {} made, {plan_s:.3} s of the plan{so_far}",
            after.0.saturating_sub(before.0),
            bytes(after.1.saturating_sub(before.1)),
        ));
        Ok(())
    }
}

/// A number of bytes, in the unit in which they are a small number.
fn bytes(count: u64) -> String {
    const UNITS: [&str; 4] = ["kB", "MB", "GB", "TB"];
    let mut shown = count as f64;
    let mut unit = "bytes";
    for larger in UNITS {
        if shown < 1000.0 {
            break;
        }
        (shown, unit) = (shown / 1000.0, larger);
    }
    if unit == "bytes" { format!("{count} bytes") } else { format!("{shown:.1} {unit}") }
}

#[cfg(test)]
mod tests {
    use super::bytes;

    #[test]
    fn memory_is_told_in_the_fitting_unit() {
        let told = [0, 999, 1000, 1_234_567, 5_000_000_000].map(bytes);
        assert_eq!(told, ["0 bytes", "999 bytes", "1.0 kB", "1.2 MB", "5.0 GB"]);
    }
}
