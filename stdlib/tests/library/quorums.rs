//! What a check says of numbers that can never be met.

use crate::evaluate::library;
use rpl_lang::compile::NoFiles;

fn warnings(text: &str) -> Vec<String> {
    let (found, _) = library().check("test", text, None, &mut NoFiles);
    found.iter().map(|warning| format!("{} {}", warning.code, warning.message)).collect()
}

/// r[quorum.counts]
#[test]
fn numbers_that_can_never_be_met_are_warned_of() {
    for (text, told) in [
        ("(quorum 3 1 (wait-time 1) (wait-time 2))", "`quorum` of 2 forms waits for 3 to succeed, which cannot be"),
        ("(quorum 1 2 (wait-time 1))", "`quorum` of 1 form waits for 2 to fail, which cannot be"),
        ("(quorum 0 1 (wait-time 1))", "`quorum` of 1 form waits for 0 to succeed, which cannot be"),
        ("(quorum 1 :all)", "`quorum` of 0 forms waits for 1 to succeed, which cannot be"),
        (
            "(defmacro all-of (n &rest forms) `(quorum ,n 1 ,@forms)) (all-of 2 (wait-time 1))",
            "`quorum` of 1 form waits for 2 to succeed, which cannot be",
        ),
    ] {
        assert_eq!(warnings(text), [format!("never-enough {told}")], "{text}");
    }
    for text in [
        "(quorum 2 1 (wait-time 1) (wait-time 2))",
        "(quorum :all :all (wait-time 1))",
        "(let ((n 3)) (quorum n 1 (wait-time 1)))",
        "(pursue-first-n 2 (wait-time 1) (wait-time 2))",
    ] {
        assert!(warnings(text).is_empty(), "{text}");
    }
}
