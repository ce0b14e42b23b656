//! Questions that are thought about while the world goes on: the answer takes effect when it has come, and the run
//! stays a value.

use rpl_lang::compile::NoFiles;
use rpl_mission::modules::own_modules;
use rpl_mission::robot::Robot;
use rpl_mission::site::Site;
use rpl_protocol::host::{
    CommandsMessage, GripperMotionMessage, HostAnswer, PerceptMessage, PoseMessage, SensorMessage,
};
use rpl_protocol::line::{Line, LineFault};
use rpl_protocol::remote_host::RemoteHost;
use rpl_protocol::thinking::{AnsweredQuestion, MOST_UNDER_WAY, ThinkingAnswer, ThinkingWords};
use rpl_runtime::robot::thinking::Thought;
use rpl_runtime::run::system::{Outcome, Progress, System};
use rpl_tests::mission::{lines, robot_library, test_room};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

const SEED: u64 = 3;
const PERIOD_US: u64 = 50_000;

/// A host whose robot stands still, whatever it is told.
#[derive(Debug)]
struct Still;

impl Line<CommandsMessage, HostAnswer> for Still {
    fn exchange(&self, turn: u64, _: &CommandsMessage) -> Result<HostAnswer, LineFault> {
        let percept = PerceptMessage {
            number: turn,
            time_us: (turn + 1) * PERIOD_US,
            commands: Some(turn),
            odometry_in_odom: PoseMessage { x_m: 0.0, y_m: 0.0, heading_rad: 0.0 },
            translation_mps: 0.0,
            rotation_radps: 0.0,
            sonar_m: None,
            laser_m: None,
            camera: None,
            failed: vec![SensorMessage::Sonars],
            bumped: false,
            gripper: GripperMotionMessage::Open,
            holding: None,
            battery: 1.0,
            messages: Vec::new(),
            others: BTreeMap::new(),
        };
        Ok(HostAnswer { percept, late_s: None, missing: 0, decided_in_s: None })
    }
}

/// Answers each question a number of turns after it was asked, and remembers all that was said.
#[derive(Debug)]
struct Patient {
    turns: u64,
    said: Mutex<Said>,
}

#[derive(Debug, Default)]
struct Said {
    past: Vec<(ThinkingWords, ThinkingAnswer)>,
    under_way: BTreeMap<u64, (u64, Arc<dyn Thought>)>,
}

impl Patient {
    fn new(turns: u64) -> Arc<Self> {
        Arc::new(Self { turns, said: Mutex::default() })
    }

    fn past(&self) -> Vec<(ThinkingWords, ThinkingAnswer)> {
        self.said.lock().expect("nobody panicked").past.clone()
    }

    /// Numbers of questions in what was said.
    fn dropped(&self) -> Vec<u64> {
        self.past().iter().flat_map(|(words, _)| words.dropped.clone()).collect()
    }

    fn asked(&self) -> Vec<u64> {
        self.past().iter().flat_map(|(words, _)| words.asked.iter().map(|asked| asked.number)).collect()
    }
}

impl Line<ThinkingWords, ThinkingAnswer> for Patient {
    fn exchange(&self, turn: u64, words: &ThinkingWords) -> Result<ThinkingAnswer, LineFault> {
        let mut said = self.said.lock().expect("nobody panicked");
        if let Some((then, answer)) = said.past.get(turn as usize) {
            assert_eq!(then, words, "turn {turn}");
            return Ok(answer.clone());
        }
        let mut answer = ThinkingAnswer::default();
        for asked in &words.asked {
            match asked.thought.as_ref().and_then(std::sync::Weak::upgrade) {
                Some(thought) => drop(said.under_way.insert(asked.number, (turn + self.turns, thought))),
                None => answer.unknown.push(asked.number),
            }
        }
        said.under_way.retain(|number, _| !words.dropped.contains(number));
        for (number, (_, thought)) in said.under_way.extract_if(.., |_, (due, _)| *due <= turn) {
            let insight = thought.think(&|| false).expect("it is not given up");
            answer.answered.push(AnsweredQuestion { number, question: thought.checksum(), insight });
        }
        said.past.push((words.clone(), answer.clone()));
        Ok(answer)
    }
}

/// What was said once, heard again.
#[derive(Debug)]
struct Heard(Vec<(ThinkingWords, ThinkingAnswer)>);

impl Line<ThinkingWords, ThinkingAnswer> for Heard {
    fn exchange(&self, turn: u64, words: &ThinkingWords) -> Result<ThinkingAnswer, LineFault> {
        let (then, answer) =
            self.0.get(turn as usize).ok_or_else(|| LineFault(format!("`thinking` ends after {turn} turns")))?;
        // As a recording has it.
        let read = |value: &ThinkingAnswer| serde_json::from_str(&serde_json::to_string(value).expect("JSON"));
        assert_eq!(then, words, "turn {turn}");
        Ok(read(answer).expect("it was written"))
    }
}

type Run = System<Robot>;

fn site() -> Site {
    Site::of(robot_library(), test_room(), own_modules().clone())
}

fn robot(thinking: Arc<dyn Line<ThinkingWords, ThinkingAnswer>>) -> Robot {
    let host = RemoteHost::new("still", Arc::new(Still), thinking, test_room().settings.robot.clone());
    site().robot_of(host, true, SEED).expect("there is a world")
}

fn start(thinking: Arc<dyn Line<ThinkingWords, ThinkingAnswer>>, plan: &str) -> Run {
    let loaded = site().compile("plan.rpl", plan, &mut NoFiles).unwrap_or_else(|error| panic!("{error}"));
    site().start_traced_with(robot(thinking), loaded, SEED)
}

/// What a run gives, as it is printed, and its trace.
fn ended(mut system: Run) -> (String, String) {
    while system.machine.now_s() < 600.0 && system.advance() == Progress::Running {}
    let trace = lines(&system.machine.trace.take());
    match system.outcome() {
        Some(Outcome::Succeeded(value)) => (system.machine.write(&system.program, value), trace),
        Some(Outcome::Failed(failure)) => panic!("{}\n{trace}", system.machine.show(&system.program, failure)),
        other => panic!("{other:?}\n{trace}"),
    }
}

fn value(thinking: &Arc<Patient>, plan: &str) -> String {
    ended(start(thinking.clone(), plan)).0
}

/// Projects a drive, and says how it would go, when it knows, and what it is told of the thinking.
const ASK: &str = "(let ((p (project '(go-to 'table-side) :runs 6)))
   (list (projection-success p) (projection-time p) (now) (projection-thinking p) (projection-stale p)))";

// r[project.live]
#[test]
fn an_answer_is_of_the_moment_it_was_asked_in_and_takes_effect_when_it_has_come() {
    let told = |turns| value(&Patient::new(turns), ASK);
    let (soon, late) = (told(0), told(9));
    let (figures, rest) = late.split_at(late.find("0.5 0.5").unwrap_or_else(|| panic!("{late}")));
    assert_eq!(rest, "0.5 0.5 nil)", "asked at 0, told of at 0.05, and answered nine steps later");
    assert_eq!(soon, format!("{figures}0.05 0.05 nil)"), "how long it takes makes no difference to the answer");
}

// r[project.live]
#[test]
fn the_mission_goes_on_meanwhile_and_what_has_changed_makes_the_answer_stale() {
    let plan = format!(
        "(def-fluent news nil) (defvar told nil)
         (par (setq told {ASK}) (dotimes (n 3) (wait-time 0.1) (setf (value news) n) (print (now))))
         told"
    );
    let system = start(Patient::new(20), &plan);
    let told = ended(system).0;
    assert!(told.ends_with("1.05 1.05 t)"), "{told}");
}

// r[project.live]
#[test]
fn what_nobody_waits_for_any_more_is_not_thought_about() {
    let cases = [
        ("(with-failure-handling ((timeout (f) nil)) (with-timeout 1 (project '(wait-time 5) :runs 2)))", 1.0),
        ("(pursue (wait-time 1) (project '(wait-time 5) :runs 2))", 1.0),
        (
            "(par (:tag job (project '(wait-time 5) :runs 2)) (seq (wait-time 1) (swap-plan (task \"main/job\") '(progn))))",
            1.0,
        ),
    ];
    for (plan, at_s) in cases {
        let patient = Patient::new(100);
        let told = value(&patient, &format!("{plan} (wait-time 1) (now)"));
        assert_eq!(told, format!("{:?}", at_s + 1.0), "{plan}");
        assert_eq!((patient.asked(), patient.dropped()), (vec![0], vec![0]), "{plan}");
        assert!(patient.past().iter().all(|(_, answer)| answer.answered.is_empty()), "{plan}");
    }
}

// r[project.live]
#[test]
fn an_answer_that_comes_to_a_suspended_task_waits_for_it() {
    let plan = "(defvar told nil)
                (par (:tag job (project '(wait-time 5) :runs 2) (setq told (now)))
                     (seq (wait-time 0.2) (with-task-suspended ((task \"main/job\")) (wait-time 3))))
                told";
    assert_eq!(value(&Patient::new(10), plan), "3.2");
}

/// Two tasks ask, one again and again.
const BUSY: &str = "(defvar told nil)
   (par (dotimes (n 3) (push (projection-time (project '(go-to 'table-side) :runs 3)) told))
        (seq (wait-time 0.3) (push (projection-success (project '(wait-time 5) :runs 2)) told)))
   (list told (now))";

// r[project.live]
#[test]
fn a_copy_goes_on_like_the_run_wherever_it_is_made() {
    let patient = Patient::new(4);
    let whole = ended(start(patient.clone(), BUSY));
    let mut system = start(patient.clone(), BUSY);
    let (mut events, mut copies) = (String::new(), 0);
    while system.advance() == Progress::Running {
        events += &lines(&system.machine.trace.take());
        if system.machine.now_s() < 1.0 {
            let (value, rest) = ended(system.fork());
            assert_eq!((&value, format!("{events}{rest}")), (&whole.0, whole.1.clone()));
            copies += 1;
        }
    }
    assert!(copies >= 10, "{copies}");
}

fn loaded(bytes: &[u8], thinking: Arc<dyn Line<ThinkingWords, ThinkingAnswer>>) -> Run {
    let plan = site().compile("plan.rpl", BUSY, &mut NoFiles).unwrap_or_else(|error| panic!("{error}"));
    Run::load(bytes, robot_library(), plan, robot(thinking)).unwrap_or_else(|error| panic!("{error}"))
}

// r[project.live]
#[test]
fn a_saved_run_hears_again_what_was_answered() {
    let patient = Patient::new(4);
    let whole = ended(start(patient.clone(), BUSY));
    let mut system = start(patient.clone(), BUSY);
    let mut events = String::new();
    while system.advance() == Progress::Running {
        events += &lines(&system.machine.trace.take());
        let bytes = system.save();
        let copy = loaded(&bytes, Arc::new(Heard(patient.past())));
        assert!(copy.save() == bytes, "at {} s", system.machine.now_s());
        let (value, rest) = ended(copy);
        assert_eq!((&value, format!("{events}{rest}")), (&whole.0, whole.1.clone()));
    }
}

// r[project.live]
#[test]
fn a_run_that_goes_on_in_another_process_asks_again() {
    let patient = Patient::new(4);
    let mut system = start(patient.clone(), BUSY);
    while system.machine.now_s() < 0.4 {
        system.advance();
    }
    assert_eq!(patient.asked(), [0, 1, 2], "the first is answered, and two are under way");
    let other = Patient::new(4);
    let mut resumed = loaded(&system.save(), other.clone());
    assert!(resumed.renew_outside());
    let (told, _) = ended(resumed);
    assert!(told.ends_with(" 0.9)"), "asked again at 0.4, the last at 0.65: {told}");
    assert_eq!(other.asked(), [3, 4, 5]);
}

// r[project.live]
#[test]
fn a_plan_that_asks_something_else_hears_its_own_answer_at_the_same_moment() {
    let patient = Patient::new(9);
    value(&patient, ASK);
    let told = |plan: &str| ended(start(Arc::new(Heard(patient.past())), plan)).0;
    assert_eq!(told(ASK), value(&Patient::new(9), ASK));
    let other = ASK.replace(":runs 6", ":runs 7");
    assert_eq!(told(&other), value(&Patient::new(9), &other));
    assert_ne!(told(&other), told(ASK));
}

// r[project.live]
#[test]
fn whatever_numbers_fluents_have_are_heard_again() {
    let patient = Patient::new(1);
    let plan = "(def-fluent most (* 1e308 10)) (def-fluent least (- 0 (value most))) (def-fluent none (+ (value most) (value least)))
                (let ((p (project '(wait-time 1) :runs 2)))
                  (map (lambda (name) (second (projection-fluent p name))) '(most least none)))";
    assert_eq!(value(&patient, plan), "(+nan.0 +nan.0 +nan.0)");
    assert_eq!(ended(start(Arc::new(Heard(patient.past())), plan)).0, "(+nan.0 +nan.0 +nan.0)");
}

// r[project.live]
#[test]
fn a_recording_that_has_no_answer_fails_the_plan_that_asks() {
    let plan =
        "(with-failure-handling ((projection-failure (f) (failure-message f))) (project '(wait-time 5) :runs 2))";
    let (told, _) = ended(start(Arc::new(Heard(Vec::new())), plan));
    assert_eq!(told, "\"`thinking` ends after 0 turns\"");
    let wrong = "(with-failure-handling ((error (f) (failure-class f))) (project '(no-such-thing 5) :runs 2))";
    assert_eq!(value(&Patient::new(3), wrong), "error", "what is wrong with a plan is told as it is without a host");
}

// r[project.live]
#[test]
fn only_so_many_questions_are_under_way() {
    let plan = "(defvar refused 0) (defvar answered 0)
                (def-plan ask ()
                  (with-failure-handling ((projection-failure (f) (incf refused)))
                    (project '(wait-time 5) :runs 1)
                    (incf answered)))
                (def-plan ask-much () (dotimes (n 100) (spawn (ask))) (wait-time 1))
                (ask-much)
                (list answered refused)";
    assert_eq!(value(&Patient::new(2), plan), format!("({MOST_UNDER_WAY} {})", 100 - MOST_UNDER_WAY));
}
