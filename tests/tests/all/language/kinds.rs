//! What native functions take: the word for a parameter says the kind, the run time refuses what is of
//! another, and `rpl check` what is written out and is.

use rpl_lang::compile::{foreign_words, special_forms};
use rpl_lang::kind::Kind;
use rpl_mission::libraries::base_natives;
use rpl_mission::modules;
use rpl_robot::office;
use rpl_runtime::run::library::Library;
use rpl_runtime::step::native::Native;
use rpl_tests::run;

/// The words for the parameters that must be given, and the one for any number of further arguments.
fn parameters(native: &Native) -> (Vec<&'static str>, Option<&'static str>) {
    let required = native.parameters.split_whitespace().take_while(|word| !word.starts_with('&')).collect();
    let rest = native.parameters.split_once("&rest ").map(|(_, word)| word);
    (required, rest)
}

#[test]
fn every_parameter_has_a_kind() {
    for native in [base_natives(), modules::natives(), office::oracle_natives()].concat() {
        for word in native.parameters.split_whitespace().filter(|word| !word.starts_with('&')) {
            assert!(Kind::of_parameter(word).is_some(), "`{word}` of `{}` names no kind", native.name);
        }
    }
}

/// A form whose value is of a kind.
fn fitting(word: &str, kind: Kind) -> &'static str {
    match kind {
        Kind::Any | Kind::ListOrEnd => "nil",
        Kind::Number | Kind::Integer | Kind::Seconds | Kind::Angle => "1",
        Kind::Text => "\"a\"",
        Kind::List if matches!(word, "alist") => "'((a . 1))",
        Kind::List | Kind::Elements | Kind::Sequence | Kind::ListOrText => "'(1 2)",
        Kind::Vector => "#(1 2)",
        Kind::Symbol | Kind::Name | Kind::Place => "'a",
        Kind::Class => "'timeout",
        Kind::Function => "car",
        Kind::Fluent => "(create-fluent 1)",
        Kind::Task => "(this-task)",
        Kind::Valve => "arm",
        Kind::Behaviour => "nil",
        Kind::Failure => "(with-failure-handling ((failure (f) f)) (fail \"a\"))",
        Kind::Table => "(make-hash-table)",
    }
}

/// What is written out and is not of a kind.
fn unfit(kind: Kind) -> &'static [&'static str] {
    match kind {
        Kind::Any | Kind::ListOrEnd => &[],
        Kind::Number | Kind::Integer | Kind::Seconds | Kind::Angle => &["\"x\"", "'x", "'(1)"],
        Kind::Text => &["5", "'x", "'(1)"],
        Kind::List => &["5", "'x", "\"x\"", "#(1)"],
        Kind::Vector => &["5", "'x", "\"x\"", "'(1)"],
        Kind::Elements => &["5", "'x", "\"x\""],
        Kind::Sequence => &["5", "'x"],
        Kind::ListOrText => &["5", "'x", "#(1)"],
        Kind::Symbol => &["5", "\"x\"", "'(1)"],
        Kind::Name | Kind::Place => &["5", "'(1)"],
        Kind::Class => &["5", "\"x\"", "'(1)"],
        Kind::Function | Kind::Fluent | Kind::Task | Kind::Valve | Kind::Behaviour | Kind::Failure | Kind::Table => {
            &["5", "\"x\"", "'x"]
        }
    }
}

/// The findings of a check that name the rule.
fn warned(library: &Library, text: &str) -> bool {
    let (findings, _) = library.check("test.rpl", text, None, &mut rpl_lang::compile::NoFiles);
    findings.iter().any(|finding| finding.code == "wrong-kind")
}

/// A call of a function with this argument at a position, and fitting ones elsewhere.
fn text_with(native: &Native, words: &[&str], at: usize, argument: &str) -> String {
    let kind = |word| Kind::of_parameter(word).expect("every word names a kind");
    let mut arguments: Vec<&str> = words.iter().map(|word| fitting(word, kind(word))).collect();
    arguments[at] = argument;
    format!("(def-valve arm)\n(print ({} {}))", native.name, arguments.join(" "))
}

/// r[type.kind]
#[test]
fn what_the_check_finds_the_run_time_refuses() {
    let library = rpl_tests::library();
    let (mut compared, mut wrong) = (0, Vec::new());
    for native in base_natives().iter().filter(|native| !native.name.starts_with('%')) {
        let (required, rest) = parameters(native);
        let words: Vec<&str> = required.into_iter().chain(rest).collect();
        for (at, word) in words.iter().enumerate() {
            let kind = Kind::of_parameter(word).expect("every word names a kind");
            for bad in unfit(kind) {
                let text = text_with(native, &words, at, bad);
                if !warned(library, &text) {
                    wrong.push(format!("{text} is no finding"));
                }
                let ended = run(&text);
                let refused =
                    ended.lines().any(|line| line.starts_with("failed: type-error: ") && line.contains(" must be "));
                if !refused {
                    wrong.push(format!("{text}\n{ended}"));
                }
                compared += 1;
            }
            assert!(
                !run(&text_with(native, &words, at, "5")).contains("must be a value"),
                "{} says nothing",
                native.name
            );
            let text = text_with(native, &words, at, fitting(word, kind));
            assert!(!warned(library, &text), "{text}");
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
    assert!(compared > 300, "{compared} calls");
}

/// r[type.message]
#[test]
fn a_type_error_names_the_argument_and_what_it_is() {
    for (form, message) in [
        ("(nth \"a\" '(1))", "argument 1 of `nth` must be an integer, and it is the string \"a\""),
        (
            "(length '(1 . 2))",
            "argument 1 of `length` must be a list, a vector or a string, and it is a list that ends in the integer 2 instead of nil",
        ),
        ("(let ((l (list 1 2))) (setf (cdr (cdr l)) l) (append l '(1)))", "it is a list that runs in a circle"),
        (
            "(wait-time +nan.0)",
            "argument 1 of `wait-time` must be a number of seconds, and it is +nan.0, which is no number",
        ),
        ("(wait-time \"5 min\")", "and it is the string \"5 min\"; write `5min`, without quotes"),
        (
            "(with-timeout 'soon nil)",
            "the time of `with-timeout` must be a number of seconds, and it is the symbol soon",
        ),
        (
            "(wait-for (create-fluent nil) :timeout \"2\")",
            "`:timeout` of `wait-for` must be a number of seconds, and it is the string \"2\"; write `2`",
        ),
        ("(with-priority 1.5 nil)", "the priority of `with-priority` must be an integer, and it is the float 1.5"),
        ("(evaporate 'worker)", "argument 1 of `evaporate` must be a task, and it is the symbol worker"),
        ("(random 0)", "argument 1 of `random` must be above 0 and finite, and it is the integer 0"),
        (
            "(let ((text (string-repeat \"x\" 100000))) (+ 1 text))",
            "and it is the string \"xxxxxxxxxxxxxxxxxxxxxxxx\"… (100000 characters)",
        ),
        ("(assert (equal (range 5000) nil))", "… (23891 characters)"),
    ] {
        let ended = run(form);
        assert!(ended.contains(message), "{form}\n{ended}");
        assert!(ended.len() < 600, "{form} is told at length");
    }
}

#[test]
fn no_foreign_word_is_a_word_of_the_language() {
    let library = rpl_tests::library();
    let is_known = |name: &str| {
        let (findings, _) = library.check("test.rpl", &format!("({name})"), None, &mut rpl_lang::compile::NoFiles);
        !findings.iter().any(|finding| finding.code == "unbound-name")
    };
    let special: Vec<&str> = special_forms().flat_map(|form| form.names.iter().copied()).collect();
    for (word, advice) in foreign_words() {
        assert!(!is_known(word), "`{word}` is a name of the language");
        for form in advice.split('`').skip(1).step_by(2).filter_map(|code| code.strip_prefix('(')) {
            let head = form.split([' ', ')']).next().unwrap_or_default();
            assert!(special.contains(&head) || is_known(head), "the advice on `{word}` names `{head}`");
        }
        let found = run(&format!("(print ({word} 1 2))"));
        assert!(found.contains(&format!("Help: {advice}")), "{found}");
    }
}
