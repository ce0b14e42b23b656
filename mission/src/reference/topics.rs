//! The order in which the reference is read: every documented name stands under one topic.

/// A topic: the word that asks for it, its title, its names.
#[derive(Clone, Copy, Debug)]
pub struct Topic {
    /// `rpl doc WORD` lists it.
    pub word: &'static str,
    /// Its heading.
    pub title: &'static str,
    /// What belongs to it, separated by spaces, in the order of reading.
    names: &'static str,
}

impl Topic {
    /// What belongs to it, in the order of reading.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.names.split_whitespace()
    }
}

const fn topic(word: &'static str, title: &'static str, names: &'static str) -> Topic {
    Topic { word, title, names }
}

/// The topic of the commands, which have names of their own.
pub const COMMANDS: &str = "commands";

/// The topic of failure classes.
pub const FAILURE_CLASSES: &str = "failure-classes";

/// All topics.
pub const TOPICS: &[Topic] = &[
    topic(
        "definitions",
        "Definitions",
        "def-plan def-interp-proc defun defmacro defvar defconstant def-fluent global-fluent def-valve def-failure \
         def-goal achieve defstruct def-resume def-revision deftest load",
    ),
    topic(
        "control",
        "Control",
        "if when unless cond case and or not let let* letrec progn seq prog1 block return-from return loop while \
         dolist dotimes n-times do destructuring-bind lambda fn flet labels quote quasiquote funcall apply",
    ),
    topic(
        "parallel",
        "Side by side, one after the other",
        "par pursue try-all gather settle quorum pursue-first-n try-in-order try-each-in-order par-map pursue-map try-all-map gather-map settle-map plan partial-order process :tag \
         spawn with-timeout with-priority execute-plan",
    ),
    topic(
        "tasks",
        "Tasks",
        "this-task task task-path taskp status result begin-task end-task evaporate suspend resume with-task-suspended \
         swap-plan finished? no-revision",
    ),
    topic(
        "revision",
        "Plans as data",
        "plan-match plan-replace plan-steps plan-order plan-resumed plan-revisions with-foresight last-step-first \
         first-step-last side-by-side one-after-the-other other-way-first try-once-more",
    ),
    topic(
        "waiting",
        "Fluents and waiting",
        "wait-for whenever fluent create-fluent fluentp value setf-together pulse pulsed changed count-pulses wait-time at-time now",
    ),
    topic("queues", "Queues", "def-queue make-queue enqueue dequeue queue-length"),
    topic(
        "policies",
        "Policies, valves, clean-up",
        "with-policy with-policies with-valve request-valve release-valve holds-valve? on-interrupt on-resume \
         evap-protect unwind-protect",
    ),
    topic(
        "failures",
        "Failures",
        "fail with-failure-handling with-parts-handled retry refail with-retry-counters do-retry ignore-failures persist assert assert-fails \
         fail-composite failurep failure-class failure-is? failure-message failure-slot failure-parts \
         failure-while-cleaning-up",
    ),
    topic(FAILURE_CLASSES, "Classes of failures", ""),
    topic("places", "Assignment", "setq setf incf decf push pushnew pop"),
    topic(
        "lists",
        "Lists",
        "list list* cons car cdr first second third fourth fifth rest last butlast caar cadr cdar cddr caddr cdddr \
         cadddr nth nthcdr elt length append reverse make-list copy-list flatten member position remove \
         remove-duplicates substitute subseq adjoin union intersection set-difference subsetp range iota concat",
    ),
    topic(
        "functions",
        "Functions over lists and vectors",
        "map mapcar mapc append-map for-each filter remove-if remove-if-not partition reduce find find-if position-if \
         count count-if every some notany sort min-by max-by group-by identity complement constantly compose",
    ),
    topic("vectors", "Vectors", "vector make-vector vref list->vector vector->list"),
    topic(
        "tables",
        "Tables",
        "make-hash-table gethash remhash clrhash maphash hash-table-contains-p hash-table-count hash-table-keys \
         hash-table-values hash-table->alist alist->hash-table acons assoc assoc-value rassoc alist-keys alist-values \
         getf",
    ),
    topic(
        "numbers",
        "Numbers",
        "+ - * / 1+ 1- = /= < <= > >= max min abs signum mod rem floor ceiling round truncate int integer float sqrt isqrt \
         expt exp ln sin cos tan asin acos atan hypot gcd lcm deg->rad rad->deg normalize-angle clamp zerop \
         plusp minusp evenp oddp random",
    ),
    topic(
        "types",
        "What a value is",
        "eq eql equal null atom consp listp numberp integerp floatp stringp symbolp keywordp functionp tablep vectorp",
    ),
    topic(
        "strings",
        "Strings and symbols",
        "print log measure format string write-to-string number->string parse-number string-append string-join string-split \
         string-search string-replace string-repeat string-trim string-upcase string-downcase string-prefix-p \
         string-suffix-p string->list substring string= string< string<= string> string>= symbol-name intern \
         make-keyword gensym",
    ),
    topic(
        "plans",
        "The robot's plans",
        "go-to go-to-point take-bearings is-position-vague? fetch pick-up pick-up-again is-spot-at? put-down bring deliver look-until-sure stay-at at-place spin drive-ahead back-up \
         relocalize-when-necessary charge go-by-another-way deliver-by-another-way fetch-asking make-sure-of-position \
         give-up nearest-delivery-next charge-before another-way elsewhere-meanwhile \
         what-becomes-impossible-first ask-somebody position-before give-up-in-time",
    ),
    topic(
        "foresight",
        "Foresight",
        "project project-rest chance-of-failure projecting? projection-success projection-successes projection-time projection-failures projection-fluent \
         projection-fluents projection-timeline projection-runs projection-horizon projection-thinking \
         projection-stale projection-grain compare-plans compare-all comparison-better comparison-certain comparison-difference comparison-error comparison-runs \
         comparison-first comparison-second comparison-thinking comparison-stale make-projection projection-p \
         copy-projection make-comparison comparison-p copy-comparison",
    ),
    topic(
        "behaviours",
        "The robot's behaviours, valves and fluents",
        "activate deactivate await-signal run-behaviour navigation active-localization position-tracking gripper \
         look-around move-by-odometry wheels arm x* y* o* pos-certainty* position-lost* odometry-slip* map-misfit* navigation-active?* nr-of-nav-goals* travel-mode* region* speed* bumped?* \
         holding* battery* messages* read-message",
    ),
    topic(
        "robot",
        "The robot's functions",
        "place place-pose at-destination? distance-to drive-time charging-places region-of generate-navigation-plan plan-remove-all-goals forget-obstacles \
         set-travel-mode doubt-position belief-maxima locate set-position odometry-pose odometry-in-map",
    ),
    topic(
        "instructions",
        "Finding a room by instructions",
        "follow-instructions follow-instruction ask-back take-likeliest exit-room begin-hallway turn-into enter-opening \
         go-past-foyer go-hallway-end find-opening look-again opening-of sought-opening known-opening opening-ahead \
         fail-faulty perceive-openings await-arrival seek-goal follow-hallway side-turn percept-middle direction-follow \
         wall-follow goal-seek registration feature-detection marker-detection hallway-axis* hallway-registered?* \
         left-distance* right-distance* last-percepts* percept-count* hallway-end?* state-set* instruction-certainty* \
         doorway* parse-instructions instruction-in-words start-state-set progress-state-set explain-instruction \
         absence-probability seen-both-ways? turn-hallway-round opening-at-end opening-pose pose-from has-camera? \
         hallway-position",
    ),
    topic(
        "case-memory",
        "Driving by cases",
        "go-by-cases deliver-by-cases reach-goals reach-goal reconsider-when-necessary reconsider route-by-cases \
         localize-first case-navigation case* case-kind* case-distance* short-term-goal* progressing?* goals* \
         retrieve-case retrieve-next-case retrieved-case explain-case use-case note-case case-kind case-goal case-plan \
         adapt-route retain-case retain-goal forget-case cases cases-of \
         landmark-localization localize-by-landmarks landmark* landmarks",
    ),
    topic(COMMANDS, "Commands", ""),
];
