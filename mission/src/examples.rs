//! The example plans, which a program carries in itself.

const EXAMPLES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/examples.rs"));

/// The names of all examples, such as `delivery.rpl`.
pub fn names() -> impl Iterator<Item = &'static str> {
    EXAMPLES.iter().map(|&(name, _)| name)
}

/// All examples, each with what it shows.
pub fn all() -> impl Iterator<Item = (&'static str, &'static str)> {
    EXAMPLES.iter().map(|&(name, text)| (name, purpose(text)))
}

/// Name and text of an example, by its name with or without `.rpl`.
pub fn find(name: &str) -> Option<(&'static str, &'static str)> {
    find_exactly(name).or_else(|| find_exactly(&format!("{name}.rpl")))
}

/// Name and text of an example, by its whole name.
pub fn find_exactly(name: &str) -> Option<(&'static str, &'static str)> {
    EXAMPLES.iter().find(|&&(known, _)| known == name).copied()
}

/// What an example shows: the first line of its first comment.
fn purpose(text: &'static str) -> &'static str {
    let comment = text.lines().find(|line| line.starts_with(';')).unwrap_or_default();
    comment.trim_start_matches(';').trim()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_example_says_what_it_shows() {
        assert!(!EXAMPLES.is_empty());
        for (name, text) in EXAMPLES {
            assert!(!purpose(text).is_empty(), "{name} begins without a comment that says what it shows");
        }
    }

    #[test]
    fn an_example_is_found_without_its_extension() {
        assert_eq!(find("first-steps"), find_exactly("first-steps.rpl"));
        assert!(find("first-steps").is_some());
    }
}
