use super::*;

#[test]
fn builtin_worlds_have_no_faults() {
    for name in World::builtin_names() {
        let text = World::builtin_text(name).unwrap();
        let world = World::parse(text, name).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(world.name, name);
    }
}
