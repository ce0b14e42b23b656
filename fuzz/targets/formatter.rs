//! Texts of plans laid out: doing it twice is doing it once, and what is read stays what it was.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rpl_fuzz::forms::Forms;
use rpl_lang::formatter::format;
use rpl_lang::source::SourceId;

fuzz_target!(|text: &str| {
    let forms = Forms::of(text);
    let Ok(laid_out) = format(text, SourceId(0)) else {
        assert!(forms.is_none(), "a text without faults is not laid out");
        return;
    };
    let forms = forms.unwrap_or_else(|| panic!("a text with faults is laid out"));
    let again = format(&laid_out, SourceId(0)).unwrap_or_else(|_| panic!("not laid out again:\n{laid_out}"));
    assert_eq!(laid_out, again, "laying it out again changes it");
    let now = Forms::of(&laid_out).unwrap_or_else(|| panic!("what is laid out cannot be read:\n{laid_out}"));
    assert!(now.is_same(&forms), "what is laid out is something else:\n{laid_out}");
});
