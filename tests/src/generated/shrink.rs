//! Makes a finding small: forms are left out or replaced by their parts as long as it stays one.

use super::form::{Form, parse, print};

/// The smallest text found by leaving out forms for which `still_fails` holds.
pub fn shrink(text: &str, mut still_fails: impl FnMut(&str) -> bool) -> String {
    let mut best = parse(text);
    loop {
        let paths = paths_of(&best);
        let smaller = paths
            .iter()
            .flat_map(|path| candidates(&best, path))
            .find(|candidate| candidate.iter().all(tells_the_truth) && still_fails(&print(candidate)));
        match smaller {
            Some(smaller) => best = smaller,
            None => return print(&best),
        }
    }
}

/// Whether what a text tells of its clean-ups is still what happens: a part that says it is entered
/// has a clean-up that says it runs.
fn tells_the_truth(form: &Form) -> bool {
    let text = form.to_string();
    let is_part = text.strip_prefix("(let ((e").is_some_and(|rest| {
        rest.trim_start_matches(|letter: char| letter.is_ascii_digit()).starts_with(" (note-enter)")
    });
    if !is_part {
        let is_note =
            text.starts_with("(%note-enter") || text.starts_with("(note-enter") || text.starts_with("(note-clean");
        let is_helper = text.starts_with("(defun note-enter");
        return if is_helper { text == NOTE_ENTER } else { !is_note && items_of(form).iter().all(tells_the_truth) };
    }
    let Some([_, Form::List(bindings), Form::List(protected)]) = items_of(form).first_chunk::<3>() else {
        return false;
    };
    let Some(Form::List(binding)) = bindings.first() else { return false };
    let [Form::Atom(head), part, clean, rest @ ..] = &protected[..] else { return false };
    let (before, pass) = match (head.as_str(), part) {
        ("unwind-protect", part) => (part.clone(), true),
        ("evap-protect", Form::List(items)) => match &items[..] {
            [_, Form::List(value), pass, _] if items.len() == 4 => {
                let Some(Form::List(value)) = value.first() else { return false };
                (
                    value.get(1).cloned().unwrap_or(Form::Atom("nil".into())),
                    pass.to_string() == format!("(note-pass {})", binding[0]),
                )
            }
            _ => return false,
        },
        _ => return false,
    };
    pass && binding.len() == 2
        && items_of(form).len() == 3
        && clean.to_string() == format!("(note-clean {})", binding[0])
        && tells_the_truth(&before)
        && rest.iter().all(tells_the_truth)
}

/// How every program counts the parts it enters.
const NOTE_ENTER: &str = "(defun note-enter () (setq entries (+ entries 1)) (%note-enter entries))";

/// The places of all forms, outermost first.
fn paths_of(forms: &[Form]) -> Vec<Vec<usize>> {
    let mut paths = Vec::new();
    let mut waiting: std::collections::VecDeque<(Vec<usize>, &Form)> =
        forms.iter().enumerate().map(|(at, form)| (vec![at], form)).collect();
    while let Some((path, form)) = waiting.pop_front() {
        for (at, item) in items_of(form).iter().enumerate() {
            let mut below = path.clone();
            below.push(at);
            waiting.push_back((below, item));
        }
        paths.push(path);
    }
    paths
}

fn items_of(form: &Form) -> &[Form] {
    match form {
        Form::List(items) => items,
        Form::Quoted(inner) => items_of(inner),
        Form::Atom(_) => &[],
    }
}

/// The text without the form at a place, or with a part of it or nil in its stead.
fn candidates(forms: &[Form], path: &[usize]) -> Vec<Vec<Form>> {
    let Some(form) = at(forms, path) else { return Vec::new() };
    let mut all = vec![edited(forms, path, None)];
    for item in items_of(form) {
        if matches!(item, Form::List(_)) {
            all.push(edited(forms, path, Some(item.clone())));
        }
    }
    if let Form::List(items) = form
        && items.first() == Some(&Form::Atom("let".into()))
    {
        for part in items.iter().skip(2).flat_map(items_of) {
            all.push(edited(forms, path, Some(part.clone())));
        }
    }
    let nil = Form::Atom("nil".into());
    if matches!(form, Form::List(_)) {
        all.push(edited(forms, path, Some(nil)));
    }
    all
}

fn at<'a>(forms: &'a [Form], path: &[usize]) -> Option<&'a Form> {
    let (&first, rest) = path.split_first()?;
    let form = forms.get(first)?;
    if rest.is_empty() { Some(form) } else { at(items_of(form), rest) }
}

fn edited(forms: &[Form], path: &[usize], with: Option<Form>) -> Vec<Form> {
    let mut forms = forms.to_vec();
    let mut items = &mut forms;
    for &step in &path[..path.len() - 1] {
        items = match &mut items[step] {
            Form::List(items) => items,
            Form::Quoted(inner) => match &mut **inner {
                Form::List(items) => items,
                Form::Atom(_) | Form::Quoted(_) => unreachable!("a path leads through lists"),
            },
            Form::Atom(_) => unreachable!("a path leads through lists"),
        };
    }
    let last = path[path.len() - 1];
    match with {
        Some(form) => items[last] = form,
        None => drop(items.remove(last)),
    }
    forms
}
