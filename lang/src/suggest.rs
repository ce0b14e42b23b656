//! "Did you mean …?"

/// The known name nearest to a mistyped one, if one is near: at most one edit (an exchange of
/// neighbours counts as one) for every three characters, and at least one. Among equally near ones
/// the first. Cost: O(known · length²).
pub fn suggest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let length = name.chars().count();
    let bound = (length / 3).clamp(1, 4);
    known
        .filter(|candidate| *candidate != name && candidate.chars().count().abs_diff(length) <= bound)
        .map(|candidate| (strsim::osa_distance(name, candidate), candidate))
        // A distance as long as the name shares nothing with it; `x*` is no `*`.
        .filter(|&(distance, near)| distance <= bound && distance < length.min(near.chars().count()))
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_names_are_found_and_far_ones_are_not() {
        let known = ["with-policy", "with-policies", "whenever", "wait-for", "seq", "par", "if"];
        let near = |name| suggest(name, known.into_iter());
        assert_eq!(near("with-polcy"), Some("with-policy"));
        assert_eq!(near("whenver"), Some("whenever"));
        assert_eq!(near("wiat-for"), Some("wait-for"));
        assert_eq!(near("sqe"), Some("seq"));
        assert_eq!(near("navigate"), None);
        assert_eq!(near("x"), None);
        assert_eq!(suggest("x*", ["*"].into_iter()), None);
        assert_eq!(near(""), None);
    }
}
