use super::*;
use crate::case::{Case, Content, Goal, MetaPlan};
use crate::control::BehaviourParameters;
use crate::memory::{CaseMemory, CaseNumber};
use crate::places::Places;
use crate::places::tests::random_places;
use crate::route::{Route, Stop};
use crate::similarity::{Scales, Similarity};
use crate::situation::Situation;
use rpl_random::Stream;
use rpl_robot::geometry::Point;

fn places() -> Places {
    random_places(&mut Stream::new(1, "places"))
}

fn similarity() -> Similarity {
    Similarity::new(Scales::default())
}

fn memory(places: &Places) -> CaseMemory {
    let mut memory = CaseMemory::new(similarity());
    let at = Point::new(1.5, 2.25);
    let mut ids = places.ids();
    let mut known = || Stop::Known(ids.next().expect("there are some"));
    let mut route = Route::new(vec![Stop::At(at), known(), known()]);
    route.times_s = vec![None, Some(16.125)];
    memory.retain(Case::new(Situation::of_route(at, Point::origin()), Content::Route(route)));
    memory.retain(Case::new(Situation::default(), Content::MetaPlan(MetaPlan::LocalizeFirst)));
    let hears = Situation { sonars_m: Some(vec![0.1, 5.0]), rotation_radps: Some(-0.3), ..Situation::default() };
    let number = memory.retain(Case::new(hears, Content::Behaviour(BehaviourParameters::default())));
    memory.change(number, |case| case.counts.note(true));
    let urgent = Situation { priority: Some(1.0), time_s: Some(60.0), ..Situation::default() };
    memory.retain(Case::new(urgent, Content::Goal(Goal { place_in_map: at })));
    memory.forget(CaseNumber(1));
    memory.retain(Case::new(Situation::default(), Content::MetaPlan(MetaPlan::TrainBehaviour)));
    memory
}

#[test]
fn what_is_written_is_read_again() {
    let places = places();
    let memory = memory(&places);
    let text = memory_text(&memory, "dept", Some(&places));
    assert_eq!(world_of(&text, "m.cases").ok().as_deref(), Some("dept"));
    assert!(!text.contains("null,\"place"), "what is missing is left out: {text}");
    assert!(text.contains("\"stops\":[[1.5,2.25],\"p0\",\"p1\"],\"times_s\":[null,16.125]"), "{text}");
    let read = read_memory(&text, "m.cases", Some(&places), similarity()).expect("no faults");
    assert_eq!(read, memory);
    assert_eq!(read.next_number(), CaseNumber(5));
}

/// What is said of a file with these lines below its head.
fn said(lines: &[&str]) -> String {
    let places = places();
    let text = format!("{{\"rpl_cases\":1,\"world\":\"dept\",\"next\":0}}\n{}", lines.join("\n"));
    match read_memory(&text, "m.cases", Some(&places), similarity()) {
        Ok(memory) => panic!("{} cases were read", memory.len()),
        Err(faults) => faults.to_string(),
    }
}

#[test]
fn each_fault_is_told_with_its_place() {
    let route = |stops: &str| {
        let index = "{\"place_in_map\":[1,2],\"long_term_goal_in_map\":[8,2]}";
        format!("{{\"case\":0,\"index\":{index},\"content\":{{\"route\":{{\"stops\":{stops}}}}}}}")
    };
    let wrong = route("[\"p1\",\"p00\"]");
    let column = 1 + wrong.find("\"p00\"").expect("it is there");
    let told = said(&[&wrong, &route("[\"p1\",\"p2\"]"), &route("[\"p1\"]")]);
    assert!(told.contains(&format!("m.cases:2:{column}: there is no place `p00` in this world")), "{told}");
    assert!(told.contains("did you mean `p0`?"), "{told}");
    assert!(told.contains("a route has a start and a goal, found 1 stops"), "{told}");
    let told = said(&["{\"case\":0,\"index\":{\"place_in_map\":[NaN,2]},\"content\":{\"meta-plan\":\"make-route\"}}"]);
    assert!(told.contains("m.cases:2:36: `NaN` is no number; leave away what is not known"), "{told}");
    let told = said(&["{\"case\":0,\"index\":{\"priority\":2},\"content\":{\"goal\":{\"place_in_map\":[1,2]}}}"]);
    assert!(told.contains("case 0: the feature `priority` must be a number from 0 to 1"), "{told}");
    let slow = "{\"behaviour\":{\"translation_mps\":-0.5,\"rotation_radps\":0.8,\"avoid_distance_m\":0.5,\"gap_distance_m\":1,\
                \"avoid_weight\":0.6,\"escape_weight\":4,\"to_goal_weight\":0.8}}";
    let told = said(&[&format!("{{\"case\":2,\"index\":{{\"sonars_m\":[1]}},\"content\":{slow}}}")]);
    assert!(told.contains("case 2: the parameter `translation_mps` must be finite and not negative"), "{told}");
    assert!(told.contains("case 2: the parameter `escape_weight` must be a number from 0 to 1"), "{told}");
    let told = said(&["{\"case\":4294967295,\"index\":{},\"content\":{\"meta-plan\":\"make-route\"}}"]);
    assert!(told.contains("m.cases:2:1: `case` is at most 2147483647, found 4294967295"), "{told}");
    let told = said(&["{\"case\":3,\"index\":{},\"content\":{\"goal\":{\"place_in_map\":[1,2]}}}"]);
    assert!(told.contains("case 3: its index has no feature that a goal is retrieved by"), "{told}");
    assert!(told.contains("`place_in_map`, `priority`, `time_s`"), "what to type: {told}");
    let told = said(&["{\"case\":3,\"content\":{\"meta-plan\":\"make-route\"}}"]);
    assert!(told.contains("missing field `index`"), "{told}");
    let told = said(&["{\"case\":0,\"index\":{\"sonar\":[1]},\"content\":{\"meta-plan\":\"make-route\"}}"]);
    assert!(told.contains("unknown field `sonar`, expected one of `sonars_m`"), "{told}");
    let twice = "{\"case\":0,\"index\":{},\"content\":{\"meta-plan\":\"make-route\"}}";
    assert!(said(&[twice, twice]).contains("m.cases:3:1: there is another case 0 before"));
}

#[test]
fn files_of_other_versions_sizes_and_worlds_are_refused() {
    let places = places();
    let read = |text: &str, places: Option<&Places>| {
        read_memory(text, "m.cases", places, similarity()).expect_err("it is wrong").to_string()
    };
    let told = read("{\"rpl_cases\":7,\"world\":\"dept\",\"next\":0}\nrubbish", Some(&places));
    assert!(told.starts_with("m.cases:1:1: the file is of version 7, and this reads version 1"), "{told}");
    assert!(!told.contains("m.cases:2"), "{told}");
    assert!(read("", None).contains("the file is empty"));
    for (text, fault) in
        [("", "the file is empty"), ("hello", "this is no case file"), ("{\"rpl_cases\":2}", "is of version 2")]
    {
        let told = world_of(text, "m.cases").expect_err("it names no world").to_string();
        assert!(told.contains(fault) && told.contains("m.cases:1:1"), "{told}");
    }
    let told = read("{\"rpl_cases\":1,\"world\":\"dept\",\"next\":4294967295}", None);
    assert!(told.contains("`next` is at most 2147483647"), "{told}");
    assert!(read("[1]", None).contains("the first line of a case file is like"));
    let case = "{\"case\":0,\"index\":{},\"content\":{\"meta-plan\":\"make-route\"}}\n";
    let many = format!("{{\"rpl_cases\":1,\"world\":\"dept\",\"next\":0}}\n{}", case.repeat(MOST_CASES + 5));
    assert!(read(&many, None).contains("a case memory has at most 100000 cases, found 100005"));
    let text = memory_text(&memory(&places), "dept", Some(&places));
    assert!(read(&text, None).contains("there is no place `p0`: the world has no places"));
}

#[test]
fn a_situation_is_read_as_users_type_it() {
    let read = read_situation("{\"place_in_map\":[1,2]}", "--explain").expect("no faults");
    assert_eq!(read.place_in_map, Some(Point::new(1.0, 2.0)));
    let told = read_situation("{\"place\":[1,2]}", "--explain").expect_err("it is wrong").to_string();
    assert!(told.contains("unknown field `place`") && told.contains("write a situation like"), "{told}");
    let told = read_situation("{\"sonars_m\":[-1]}", "--explain").expect_err("it is wrong").to_string();
    assert!(told.contains("the feature `sonars_m` must be ranges"), "{told}");
}
