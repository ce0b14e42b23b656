//! Texts of plans: what is read of one, printed and read again, is the same data.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rpl_fuzz::forms::Forms;

fuzz_target!(|text: &str| {
    let Some(forms) = Forms::of(text) else { return };
    if forms.has_unsayable_name() {
        return;
    }
    let printed = forms.printed();
    let again = Forms::of(&printed).unwrap_or_else(|| panic!("what is printed cannot be read:\n{printed}"));
    assert!(again.is_same(&forms), "what is printed is something else:\n{printed}");
});
