//! Writes a random program that uses every construct.
//!
//! Each clean-up tells when its part is entered and when it runs, by the natives of
//! [`super::robot`]. What runs in a clean-up or in a plan ends by itself or waits for what does not
//! come: nothing there goes on for ever, so that a run that is told to stop must end. `n` never
//! grows on the way in, and a plan is called only with less, so that recursion ends too.

use super::Dice;

const FLUENTS: &[&str] = &["f0", "f1", "f2", "*shared*"];
const TIMES: &[&str] = &["0", "0.1", "0.1", "0.2", "0.5", "1"];
const VALVES: &[&str] = &["v0", "v0", "v1", "v2", "v3", "wheels"];
const PLANS: &[&str] = &["p0", "p1", "p2"];

/// What a function calls itself through, as deep as it is told or a limit lets it.
const AROUND: &[&str] = &[
    "(seq (dive (- k 1)) k)",
    "(par (dive (- k 1)))",
    "(pursue (dive (- k 1)) (wait-time 1))",
    "(try-all (dive (- k 1)))",
    "(try-in-order (dive (- k 1)) nil)",
    "(par-map (m (list (- k 1))) (dive m))",
    "(plan ((:tag d (dive (- k 1))) (:tag e k)) (:order d e))",
    "(with-policy (wait-for f0) (dive (- k 1)))",
    "(with-timeout 5 (dive (- k 1)))",
    "(with-priority 1 (dive (- k 1)))",
    "(with-valve v0 (dive (- k 1)))",
    "(unwind-protect (dive (- k 1)) (incf n))",
    "(evap-protect (dive (- k 1)) (wait-time 0.1))",
    "(with-failure-handling ((timeout (f) (refail))) (dive (- k 1)))",
    "(ignore-failures (timeout) (dive (- k 1)))",
    "(let ((left 2)) (persist (< (decf left) 0) (timeout) (dive (- k 1))))",
    "(block b (dive (- k 1)) (return-from b k))",
    "(let ((g (lambda () (dive (- k 1))))) (g) k)",
    "(on-interrupt (note k) (dive (- k 1)))",
    "(list k (funcall dive (- k 1)))",
    "(list k (apply apply (list dive (list (- k 1)))))",
    "(map dive (list (- k 1)))",
    "(seq (execute-plan (list 'dive (- k 1))) k)",
    "(seq (spawn (dive (- k 1))) (wait-time 0.1))",
    "(value (fluent (if (> k 0) (list k f0 (value (fluent (list k f0)))) nil)))",
];

/// What may be written where the writer stands.
#[derive(Clone, Default)]
struct Place {
    /// It must come to an end.
    ends: bool,
    /// Blocks that can be left from here.
    blocks: Vec<String>,
    /// Retry counters.
    counters: Vec<String>,
    /// In a handler: its failure.
    failure: Option<String>,
}

impl Place {
    /// In a task of its own, which no block or handler reaches across.
    fn in_task(&self) -> Self {
        Self { ends: self.ends, ..Self::default() }
    }
}

struct Writer {
    dice: Dice,
    /// Forms that may still be written.
    left: i32,
    names: usize,
    /// Tags of the plan being written, and whether they are placed.
    tags: Vec<(String, bool)>,
}

/// The program of a seed. The same seed gives the same program.
pub fn program(seed: u64) -> String {
    let mut dice = Dice::new(seed);
    let left = 6 + dice.below(34) as i32;
    let mut writer = Writer { dice, left, names: 0, tags: Vec::new() };
    let mut text = String::from(
        "(def-fluent f0 nil)\n(def-fluent f1 nil)\n(def-fluent f2 0)\n(def-fluent *shared* t)\n(def-valve v0)\n(def-valve v1)\n(def-valve v2 2)\n(def-valve v3 3)\n(def-queue q0 :most 2)\n\
         (defvar n 2)\n(defvar kept nil)\n(defvar entries 0)\n\
         (defun note-enter () (setq entries (+ entries 1)) (%note-enter entries))\n(def-failure spilled (plan-failure) (where))\n\
         (defun both (a b) (and (value a) (value b)))\n(defun deep (k) (+ 1 (deep k)))\n",
    );
    text.push_str("(def-fluent g0 (fluent (and f0 (not f1))))\n(def-fluent g1 (fluent (or (both f1 g0) (> f2 2))))\n(defvar c0 (count-pulses f0))\n");
    let around = writer.dice.pick(AROUND);
    text.push_str(&format!("(defun dive (k) (if (> k 0) {around} (wait-time 0.1)))\n"));
    let body = writer.plan_body(Place::default());
    let share = writer.left.max(6);
    for plan in PLANS {
        writer.left = share / 2;
        let body = writer.plan_body(Place { ends: true, ..Place::default() });
        text.push_str(&format!("(def-plan {plan} (n) {body})\n"));
    }
    text.push_str(&format!("(seq {body})\n"));
    text
}

impl Writer {
    fn below(&mut self, end: usize) -> usize {
        self.dice.below(end)
    }

    fn fresh(&mut self, stem: &str) -> String {
        self.names += 1;
        format!("{stem}{}", self.names)
    }

    fn plan_body(&mut self, place: Place) -> String {
        let outer = std::mem::take(&mut self.tags);
        let mut body = self.forms(&place, 2);
        for (tag, placed) in std::mem::replace(&mut self.tags, outer) {
            if !placed {
                body.push_str(&format!(" (:tag {tag} (wait-time 0.1))"));
            }
        }
        body
    }

    fn forms(&mut self, place: &Place, most: usize) -> String {
        let count = 1 + self.below(most);
        let forms: Vec<String> = (0..count).map(|_| self.form(place)).collect();
        forms.join(" ")
    }

    fn form(&mut self, place: &Place) -> String {
        self.left -= 1;
        if self.left <= 0 || self.dice.once_in(4) { self.leaf(place) } else { self.composite(place) }
    }

    fn child(&mut self, place: &Place) -> String {
        let place = place.in_task();
        if self.dice.once_in(6) { self.tagged(&place) } else { self.form(&place) }
    }

    fn children(&mut self, place: &Place) -> String {
        let count = self.below(4);
        let children: Vec<String> = (0..count).map(|_| self.child(place)).collect();
        children.join(" ")
    }

    /// A tag of this plan: one that is known, or one that will be.
    fn tag(&mut self) -> String {
        if self.tags.is_empty() || (self.tags.len() < 3 && self.dice.once_in(3)) {
            let name = self.fresh("t");
            self.tags.push((name, false));
        }
        let at = self.below(self.tags.len());
        self.tags[at].0.clone()
    }

    fn tagged(&mut self, place: &Place) -> String {
        let body = self.forms(&place.in_task(), 2);
        self.tagged_as(&body)
    }

    fn tagged_as(&mut self, body: &str) -> String {
        let known = self.tags.iter_mut().find(|(_, placed)| !*placed);
        let name = match known {
            Some((name, placed)) => {
                *placed = true;
                name.clone()
            }
            None => {
                let name = self.fresh("t");
                self.tags.push((name.clone(), true));
                name
            }
        };
        let head = self.dice.pick(&[":tag", "process"]);
        format!("({head} {name} {body})")
    }

    fn task(&mut self) -> String {
        if self.dice.once_in(8) { "(this-task)".into() } else { self.tag() }
    }

    fn condition(&mut self) -> String {
        let fluent = self.dice.pick(FLUENTS);
        match self.below(16) {
            0 => format!("(not {fluent})"),
            1 => format!("(and {fluent} {})", self.dice.pick(FLUENTS)),
            2 => format!("(or (pulsed {fluent}) {})", self.dice.pick(FLUENTS)),
            3 => format!("(changed {fluent})"),
            4 => format!("(> {fluent} 1)"),
            5 => "g0".into(),
            6 => "(and g1 (not g0))".into(),
            7 => "(> c0 1)".into(),
            8 => format!("(eq (status {}) '{})", self.tag(), self.dice.pick(&["running", "suspended", "succeeded"])),
            9 => format!("(end-task {})", self.tag()),
            10 => format!("(begin-task {})", self.tag()),
            11 => self.dice.pick(&["level*", "bump*", "(> level* 1)"]).to_string(),
            12 => format!("(both {fluent} g0)"),
            _ => fluent.into(),
        }
    }

    fn class(&mut self) -> &'static str {
        self.dice.pick(&[
            "plan-failure",
            "failure",
            "spilled",
            "timeout",
            "composite-failure",
            "error",
            "deadlock",
            "runaway",
            "valve-error",
            "behaviour-failure",
        ])
    }

    fn leaf(&mut self, place: &Place) -> String {
        let (fluent, time, valve) = (self.dice.pick(FLUENTS), self.dice.pick(TIMES), self.dice.pick(VALVES));
        match self.below(38) {
            0..=5 => format!("(wait-time {time})"),
            6 => format!("(wait-time {time} :active)"),
            7 | 8 => format!("(setf (value {fluent}) {})", self.dice.pick(&["t", "nil", "nil", "1", "(+ n 2)"])),
            9 | 10 => format!("(pulse {fluent})"),
            11 => format!("(wait-for {})", self.condition()),
            12 | 13 => format!("(wait-for {} :timeout {time})", self.condition()),
            14 => "(fail)".into(),
            15 => "(fail spilled \"at ~a\" (now) :where 'here)".into(),
            16 => format!("(evaporate {})", self.task()),
            17 => format!("(suspend {})", self.task()),
            18 => format!("(resume {})", self.task()),
            19 => format!("({} {valve})", self.dice.pick(&["request-valve", "release-valve", "holds-valve?"])),
            20..=22 => format!("(if (> n 0) ({} (- n 1)) nil)", self.dice.pick(PLANS)),
            23 => match place.blocks.len() {
                0 => "(at-time 0.5)".into(),
                count => format!("(return-from {} n)", place.blocks[self.dice.below(count)]),
            },
            24 => match &place.failure {
                Some(_) if self.dice.once_in(2) => "(refail)".into(),
                Some(_) if !place.ends && self.dice.once_in(2) => "(seq (wait-time 0.1) (retry))".into(),
                Some(_) => match place.counters.first() {
                    Some(counter) => format!("(do-retry {counter} (retry))"),
                    None => "(refail)".into(),
                },
                None => "(car n)".into(),
            },
            25 => self
                .dice
                .pick(&[
                    "(loop nil)",
                    "(deep n)",
                    "(car (list n 'x))",
                    "(map both '(1) '(2))",
                    "(value (fluent (car f0)))",
                ])
                .into(),
            26 => format!(
                "(if (> n 0) (execute-plan (list 'seq '(wait-time {time}) (list '{} (- n 1)))) nil)",
                self.dice.pick(PLANS)
            ),
            27 => self
                .dice
                .pick(&[
                    "(activate drive)",
                    "(activate look)",
                    "(deactivate drive)",
                    "(deactivate look)",
                    "(run-behaviour look)",
                    "(with-valve wheels (run-behaviour drive))",
                    "(await-signal look)",
                ])
                .into(),
            28 => format!("(push (fluent {}) kept)", self.condition()),
            29 => format!("(list (value (status {})) (value c0))", self.tag()),
            30 => "(note (list 'value (value f0) (value f2)))".into(),
            31 => "(incf (value f2))".into(),
            32 => self
                .dice
                .pick(&[
                    "(enqueue q0 n)",
                    "(dequeue q0)",
                    "(dequeue q0 :if integerp)",
                    "(value (queue-length q0))",
                    "(setf-together (value f0) n (value f1) nil)",
                ])
                .into(),
            34 => format!("(dive {})", self.dice.pick(&["3", "20", "70"])),
            35 => self
                .dice
                .pick(&[
                    "(apply apply (list + (list n 1)))",
                    "(funcall funcall funcall (lambda () n))",
                    "(map apply (list + list) (list '(1 2) '(3)))",
                    "(apply execute-plan '((seq 1)))",
                    "(let ((l (list apply nil))) (setf (nth 1 l) l) (apply apply l))",
                    "(apply wait-time (list 0.1))",
                    "(map wait-time '(0.1 0))",
                    "(apply map (list list (list n 1)))",
                ])
                .into(),
            36 => self
                .dice
                .pick(&[
                    "(push (make-list 300 n) kept)",
                    "(length (append (make-list 2000 n) (make-list 2000 n)))",
                    "(push (string-repeat \"text\" 500) kept)",
                    "(dotimes (i 40) (push (list i i i i i i) kept))",
                    "(dotimes (i 20) (push (create-fluent i) kept))",
                    "(let ((h (make-hash-table))) (dotimes (i 60) (setf (gethash (list i) h) i)) (push h kept))",
                    "(let ((v (make-vector 60 n))) (dotimes (i 60) (setf (vref v i) (list i))) (push v kept) (equal v #(1)))",
                    "(dolist (v kept) (if (vectorp v) (setf (vref v 0) (map list v)) nil))",
                    "(push (sort (lambda (a b) (wait-time 0.1) (< a b)) (list 3 n 1 2)) kept)",
                    "(par-map (m (iota 40)) (wait-time 0.1))",
                    "(dotimes (i 9) (execute-plan (list 'quote (list i n))))",
                    "(setq kept nil)",
                ])
                .into(),
            _ => "(note (format \"~a\" (list n (now) \"text\" 0.5)))".into(),
        }
    }

    fn composite(&mut self, place: &Place) -> String {
        let time = self.dice.pick(TIMES);
        match self.below(43) {
            0..=2 => format!("(seq {})", self.forms(place, 3)),
            3..=5 => {
                let head = self.dice.pick(&["par", "par", "par", "gather", "settle"]);
                format!("({head} {})", self.children(place))
            }
            6 | 7 => format!("(pursue {})", self.children(place)),
            8 => format!("(try-all {})", self.children(place)),
            9 => {
                let successes = self.dice.pick(&["1", "2", "3", "n", ":all"]);
                let failures = self.dice.pick(&["1", "2", ":all", ":all"]);
                format!("(quorum {successes} {failures} {})", self.children(place))
            }
            10 => {
                let ways: Vec<String> = (0..1 + self.below(3)).map(|_| self.form(&place.in_task())).collect();
                format!("(try-in-order {})", ways.join(" "))
            }
            11 => format!("(try-each-in-order (n (list 0 n)) {})", self.form(&place.in_task())),
            12 => {
                let head = self.dice.pick(&["par-map", "pursue-map", "try-all-map", "gather-map", "settle-map"]);
                let most = if head == "pursue-map" { "" } else { self.dice.pick(&["", "", " :most 1", " :most 2"]) };
                format!("({head} (n (list 0 n 0){most}) {})", self.forms(&place.in_task(), 2))
            }
            13 => self.partial_order(place),
            14 | 15 => {
                let policy = self.form(&place.in_task());
                format!("(with-policy {policy} {})", self.forms(&place.in_task(), 2))
            }
            16 => {
                let policies = [self.form(&place.in_task()), self.form(&place.in_task())];
                format!("(with-policies ({}) {})", policies.join(" "), self.forms(&place.in_task(), 2))
            }
            17 => format!("(with-timeout {time} {})", self.forms(&place.in_task(), 2)),
            18 => format!("(with-timeout {time} :active {})", self.forms(&place.in_task(), 2)),
            19 => {
                let number = self.dice.pick(&["-1", "1", "2", "n"]);
                format!("(with-priority {number} {})", self.forms(&place.in_task(), 2))
            }
            // It lives as long as the plan call, clean-ups included: one that goes on for ever would
            // let a clean-up wait for ever.
            20 => format!("(spawn {})", self.forms(&Place { ends: true, ..Place::default() }, 2)),
            21 => self.tagged(place),
            22 => format!("(with-task-suspended ({}) {})", self.tag(), self.forms(place, 2)),
            23 | 24 => self.whenever(place),
            25 | 26 => {
                let valve = self.dice.pick(VALVES);
                let timeout = if self.dice.once_in(4) { format!(" :timeout {time}") } else { String::new() };
                format!("(with-valve {valve}{timeout} {})", self.forms(place, 2))
            }
            27 => {
                let hook = self.form(&Place { ends: true, ..Place::default() });
                let head = self.dice.pick(&["on-interrupt", "on-resume"]);
                format!("({head} {hook} {})", self.forms(place, 2))
            }
            28..=31 => self.protected(place),
            32 | 33 => self.handled(place),
            34 => format!("(ignore-failures ({}) {})", self.class(), self.forms(place, 2)),
            35 => {
                let name = self.fresh("b");
                let mut inside = place.clone();
                inside.blocks.push(name.clone());
                format!("(block {name} {})", self.forms(&inside, 3))
            }
            36 => self.repeated(place),
            37 => {
                let function = self.fresh("g");
                format!("(let (({function} (lambda () {}))) ({function}))", self.forms(&place.in_task(), 2))
            }
            38 => format!("(map (lambda (n) {}) (list 0 n))", self.form(&place.in_task())),
            39 | 40 => {
                let valve = self.dice.pick(VALVES);
                self.borrowers(&place.in_task(), valve)
            }
            _ => format!(
                "(if {} {} {})",
                self.dice.pick(&["(value f0)", "(value g0)", "n"]),
                self.form(place),
                self.form(place)
            ),
        }
    }

    /// An owner of a valve, and several below it who want it too.
    fn borrowers(&mut self, place: &Place, valve: &str) -> String {
        self.left -= 1;
        let count = 2 + self.below(2);
        let parts: Vec<String> = (0..count).map(|_| self.borrower(place, valve)).collect();
        let head = self.dice.pick(&["par", "par", "par", "pursue", "try-all", "with-policy"]);
        format!("(with-valve {valve} ({head} {}))", parts.join(" "))
    }

    /// One of them, or one who acts upon them.
    fn borrower(&mut self, place: &Place, valve: &str) -> String {
        let time = self.dice.pick(TIMES);
        let part = match self.below(9) {
            0..=2 => format!("(with-valve {valve} {})", self.forms(place, 2)),
            3 => format!("(seq (wait-time {time}) (with-valve {valve} {}))", self.form(place)),
            4 if self.left > 0 => self.borrowers(place, valve),
            5 => {
                let body = format!("(with-valve {valve} (wait-time {time}) {})", self.form(place));
                self.tagged_as(&body)
            }
            6 => {
                let act = self.dice.pick(&["evaporate", "evaporate", "suspend", "resume"]);
                format!("(seq (wait-time {time}) ({act} {}))", self.tag())
            }
            7 => {
                let hook = self.form(&Place { ends: true, ..Place::default() });
                let head = self.dice.pick(&["on-interrupt", "on-resume"]);
                format!("(with-valve {valve} ({head} {hook} (wait-time {time}) {}))", self.form(place))
            }
            _ => self.protected(place),
        };
        match self.dice.once_in(3) {
            true => format!("(with-priority {} {part})", self.dice.pick(&["-1", "1", "2"])),
            false => part,
        }
    }

    fn partial_order(&mut self, place: &Place) -> String {
        let names: Vec<String> = (0..3).map(|_| self.fresh("s")).collect();
        let steps: Vec<String> =
            names.iter().map(|name| format!("(:tag {name} {})", self.form(&place.in_task()))).collect();
        let order = self.dice.pick(&["(:order A B)", "(:order A B) (:order B C)", "(:order A C) (:order B C)", ""]);
        let order = order.replace('A', &names[0]).replace('B', &names[1]).replace('C', &names[2]);
        format!("(plan ({}) {order})", steps.join(" "))
    }

    fn whenever(&mut self, place: &Place) -> String {
        let condition = self.condition();
        let missed = self.dice.pick(&["", "", ":missed :always ", ":missed :never ", ":missed :once "]);
        let body = self.forms(&place.in_task(), 2);
        if place.ends {
            let time = self.dice.pick(&["0.1", "0.5"]);
            format!("(ignore-failures (timeout) (with-timeout {time} (whenever {condition} {missed}{body})))")
        } else {
            let bound = if self.dice.once_in(2) { " (return n)" } else { "" };
            format!("(whenever {condition} {missed}{body}{bound})")
        }
    }

    /// A part with a clean-up; both tell what happens to them.
    fn protected(&mut self, place: &Place) -> String {
        let entry = self.fresh("e");
        let clean = self.forms(&Place { ends: true, ..Place::default() }, 2);
        let body = self.forms(place, 2);
        if self.dice.once_in(2) {
            format!("(let (({entry} (note-enter))) (unwind-protect (seq {body}) (note-clean {entry}) {clean}))")
        } else {
            let value = self.fresh("r");
            format!(
                "(let (({entry} (note-enter))) (evap-protect (let (({value} (seq {body}))) (note-pass {entry}) {value}) (note-clean {entry}) {clean}))"
            )
        }
    }

    fn handled(&mut self, place: &Place) -> String {
        let (failure, counter) = (self.fresh("f"), self.fresh("k"));
        let mut inside = place.clone();
        inside.counters.insert(0, counter.clone());
        let body = self.forms(&Place { failure: None, ..inside.clone() }, 2);
        inside.failure = Some(failure.clone());
        let clauses: Vec<String> = (0..1 + self.below(2))
            .map(|_| {
                let class = self.class();
                let last = if self.dice.once_in(2) {
                    format!("(do-retry {counter} (wait-time 0.1) (retry))")
                } else {
                    format!("(note (failure-message {failure}))")
                };
                format!("({class} ({failure}) {} {last})", self.form(&inside))
            })
            .collect();
        format!("(with-retry-counters (({counter} 2)) (with-failure-handling ({}) {body}))", clauses.join(" "))
    }

    fn repeated(&mut self, place: &Place) -> String {
        let name = self.fresh("i");
        let body = self.forms(place, 2);
        match self.below(if place.ends { 3 } else { 5 }) {
            0 => format!("(n-times 2 {body} until (value f1))"),
            1 => format!("(dotimes ({name} 2) {body})"),
            2 => format!("(dolist ({name} (list 1 n)) {body} (if (value g0) (return n) nil))"),
            3 => format!("(loop (wait-time 0.2) {body} until (value f1))"),
            _ => format!("(loop (wait-for {}) (wait-time 0.1) {body})", self.condition()),
        }
    }
}
