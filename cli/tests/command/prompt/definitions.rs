//! What the session defines: documented, shown, edited, saved.

use super::{session, session_in};
use crate::folder::folder;
use std::path::Path;

#[test]
fn what_the_session_defines_is_documented() {
    let lines = "(def-plan greet (who &optional (how 'kindly)) \"Greets somebody.\" (list how who))\n\
                 (defun bare (x) x)\n(defvar cups 5 \"How many cups there are.\")\n(def-fluent level 3)\n\
                 (def-failure slipped (plan-failure) (object))\n\
                 :doc greet\n:doc BARE\n:doc cups\n:doc level\n:doc slipped\n:doc gret\n:doc no-such-name-at-all\n:doc :back\n(bare 1)\n";
    let shown = session(&["repl"], lines);
    for text in [
        "(greet who &optional (how 'kindly))\n  Greets somebody.\n  a plan, defined at <1>:1:1\n",
        "(bare x)\n  It has no documentation.\n  a function, defined at <2>:1:1\n",
        "cups\n  How many cups there are.\n  a variable, defined at <3>:1:1; its value is 5\n",
        "level\n  It has no documentation.\n  a fluent, defined at <4>:1:1; its value is 3\n",
        "  a class of failures, defined at <5>:1:1\n",
        "    :back 10s\n",
    ] {
        assert!(shown.out.contains(text), "{text}{}", shown.out);
    }
    assert!(shown.errors.contains("nothing is called `gret`; did you mean `greet`?"), "{}", shown.errors);
    assert!(shown.errors.contains("nothing is called `no-such-name-at-all`; `:doc` lists"), "{}", shown.errors);
    assert!(shown.out.ends_with("1\n"), "{}", shown.out);
}

#[test]
fn the_text_of_a_definition_is_shown_whoever_wrote_it() {
    let lines = "; Adds one.\n(defun more (x)\n  (+ x 1))\n:source more\n:source for-each\n:source car\n:source mroe\n:source\n";
    let shown = session(&["repl"], lines);
    assert!(shown.out.contains("; <1>:2:1\n; Adds one.\n(defun more (x)\n  (+ x 1))\n"), "{}", shown.out);
    assert!(shown.out.contains("(defun for-each (function elements &rest more)\n"), "{}", shown.out);
    for advice in [
        "`car` is a function that is built in, without a text; `:doc car` documents it",
        "nothing is called `mroe`; did you mean `more`?",
        "`:source NAME`: a name is expected",
    ] {
        assert!(shown.errors.contains(advice), "{advice}\n{}", shown.errors);
    }
}

#[test]
fn what_the_session_defines_is_saved_as_a_file_that_loads() {
    let folder = folder("saving");
    std::fs::write(folder.join("tea.rpl"), "; How it is made.\n(def-plan tea () (brew 'tea))\n(print 'loaded)\n")
        .expect("it can be written");
    let lines = "(defmacro brew (what) `(list 'old ,what))\n:load tea.rpl\n(defvar cups 1)\n(setf cups 7)\n(defvar cups 2)\n\
                 (defmacro brew (what) `(list 'fresh ,what))\n(deftest tea (assert t))\n\
                 :save mine.rpl\n(defun extra () 3)\n:save mine.rpl\n:save tea.rpl\n:save no/such/folder.rpl\n:save\n";
    let shown = session_in(&folder, "false", &["repl"], lines);
    assert!(
        shown.errors.contains("saved 4 definitions in `mine.rpl`; `:load mine.rpl` loads them\n"),
        "{}",
        shown.errors
    );
    assert!(shown.errors.contains("saved 5 definitions in `mine.rpl`"), "what it wrote itself: {}", shown.errors);
    assert!(shown.errors.contains("cannot save to `tea.rpl`: it is there already"), "{}", shown.errors);
    assert!(shown.errors.contains("cannot save to `no/such/folder.rpl`: there is no such folder"), "{}", shown.errors);
    let saved = std::fs::read_to_string(folder.join("mine.rpl")).expect("it is there");
    assert!(saved.contains("; How it is made.\n(def-plan tea () (brew 'tea))\n"), "{saved}");
    let again = session_in(&folder, "false", &["repl"], ":load mine.rpl\n(list (tea) cups (extra))\n");
    assert!(again.out.ends_with("((fresh tea) 2 3)\n"), "{}{}", again.out, again.errors);
    std::fs::write(folder.join("mine.rpl"), "; Changed by somebody.\n").expect("it can be written");
    let lines = "(defun f () 1)\n:save mine.rpl\n";
    let refused = session_in(&folder, "false", &["repl"], lines);
    assert!(refused.errors.contains("it is there already"), "{}", refused.errors);
    assert_eq!(std::fs::read_to_string(folder.join("mine.rpl")).expect("it is there"), "; Changed by somebody.\n");
}

#[test]
fn a_form_and_a_definition_go_through_the_editor_and_back() {
    let lines = "(defun tea () 'green)\n(list (tea) 1)\n:edit\n:edit tea\n(tea)\n";
    let shown = session_in(Path::new("."), "sed -i -e 's/1/2/' -e 's/green/black/'", &["repl"], lines);
    assert_eq!(shown.out, "tea\n(green 1)\n(green 2)\ntea\nblack\n", "{}", shown.errors);
    let lines = "(defun tea () 'green)\n:edit tea\n:edit no-such\n(tea)\n";
    for (editor, told) in [
        ("false", "the editor `false` ended with status 1; nothing is run"),
        ("no-such-editor", "there is no editor `no-such-editor`; set the variable EDITOR to yours"),
        ("true", "the text is as it was; nothing is run"),
        ("rm", "what the editor left cannot be read: there is no such file"),
        ("sh -c 'kill -9 $$' sh", "the editor `sh -c 'kill -9 $$' sh`"),
        ("truncate -s 0", "the text is empty; nothing is run"),
    ] {
        let shown = session_in(Path::new("."), editor, &["repl"], lines);
        assert!(shown.errors.contains(told), "{editor}: {}", shown.errors);
        assert_eq!(shown.out, "tea\ngreen\n", "{editor}");
    }
}

#[test]
fn a_text_that_the_editor_left_wrong_is_there_again() {
    let lines = "(list 'tea)\n:edit\n:edit\n";
    let editor = "sed -i -e 's/(list .tea)/(no-such-thing)/;t' -e 's/no-such-thing/list 1 2/'";
    let shown = session_in(Path::new("."), editor, &["repl"], lines);
    assert!(shown.out.ends_with("(1 2)\n"), "{}{}", shown.out, shown.errors);
}
