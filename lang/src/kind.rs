//! The kinds of argument native functions take. The word by which a native function names a parameter
//! says the kind: `number`, `list`, `seconds`. The run time refuses an argument by it, and `rpl check`
//! one that is written out and can never do.

/// A kind of argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Any value; also where what is taken depends on other arguments.
    Any,
    /// An integer or a float.
    Number,
    /// An integer.
    Integer,
    /// A time as a number.
    Seconds,
    /// An angle in radians as a number.
    Angle,
    /// A string.
    Text,
    /// A list, the empty one included.
    List,
    /// A list, but for one place among several, which depends on how many there are.
    ListOrEnd,
    /// A vector.
    Vector,
    /// A list or a vector.
    Elements,
    /// A list, a vector or a string.
    Sequence,
    /// A list or a string.
    ListOrText,
    /// A symbol, nil and t included.
    Symbol,
    /// A symbol, keyword or string that spells a name.
    Name,
    /// The name of a place of the world.
    Place,
    /// The symbol of a class of failures.
    Class,
    /// A function, plan or native function.
    Function,
    /// A fluent.
    Fluent,
    /// A task.
    Task,
    /// A valve.
    Valve,
    /// A behaviour.
    Behaviour,
    /// A failure.
    Failure,
    /// A hash table.
    Table,
}

/// Words for parameters, by the kind they name.
const WORDS: &[(Kind, &[&str])] = &[
    (
        Kind::Any,
        &[
            "a",
            "anew",
            "arguments",
            "b",
            "by-pairs",
            "clock",
            "datum",
            "default",
            "former",
            "form",
            "initial",
            "item",
            "key",
            "message",
            "pair",
            "rest",
            "slots",
            "test",
            "tree",
            "value",
            "value-after-default",
            "values",
        ],
    ),
    (
        Kind::Number,
        &[
            "ahead",
            "base",
            "charge",
            "degrees",
            "divisor",
            "exponent",
            "from",
            "from-or-to",
            "high",
            "left",
            "limit",
            "low",
            "number",
            "numbers",
            "priority",
            "radians",
            "radius",
            "step",
            "to",
            "x",
            "x0",
            "x1",
            "y",
            "y0",
            "y1",
        ],
    ),
    (Kind::Angle, &["angle", "heading", "turn"]),
    (Kind::Integer, &["case", "count", "end", "integer", "integers", "length", "position", "start", "times"]),
    (Kind::Seconds, &["deadline", "patience", "seconds", "time"]),
    (
        Kind::Text,
        &[
            "characters-or-string",
            "pattern",
            "prefix",
            "replacement",
            "separator",
            "string",
            "strings",
            "suffix",
            "template",
        ],
    ),
    (
        Kind::List,
        &["alist", "columns", "elements", "instruction", "list", "other", "parts", "percept", "plist", "pose"],
    ),
    (Kind::ListOrEnd, &["argument", "lists", "more"]),
    (Kind::Vector, &["vector"]),
    (Kind::Elements, &["list-or-vector"]),
    (Kind::Sequence, &["sequence"]),
    (Kind::ListOrText, &["instructions"]),
    (Kind::Symbol, &["symbol"]),
    (Kind::Name, &["kind", "mode", "name", "names", "path", "room", "side", "stem", "words"]),
    (Kind::Place, &["place"]),
    (Kind::Class, &["class"]),
    (Kind::Function, &["function", "less", "predicate"]),
    (Kind::Fluent, &["fluent"]),
    (Kind::Task, &["task"]),
    (Kind::Valve, &["valve"]),
    (Kind::Behaviour, &["behaviour"]),
    (Kind::Failure, &["failure"]),
    (Kind::Table, &["table"]),
];

impl Kind {
    /// The kind a word for a parameter names.
    pub fn of_parameter(word: &str) -> Option<Kind> {
        WORDS.iter().find(|(_, words)| words.contains(&word)).map(|&(kind, _)| kind)
    }

    /// What is expected, as messages say it.
    pub fn noun(self) -> &'static str {
        match self {
            Kind::Any => "a value",
            Kind::Number => "a number",
            Kind::Integer => "an integer",
            Kind::Seconds => "a number of seconds",
            Kind::Angle => "an angle",
            Kind::Text => "a string",
            Kind::List | Kind::ListOrEnd => "a list",
            Kind::Vector => "a vector",
            Kind::Elements => "a list or a vector",
            Kind::Sequence => "a list, a vector or a string",
            Kind::ListOrText => "a list or a string",
            Kind::Symbol => "a symbol",
            Kind::Name => "a name",
            Kind::Place => "the name of a place",
            Kind::Class => "a failure class",
            Kind::Function => "a function",
            Kind::Fluent => "a fluent",
            Kind::Task => "a task",
            Kind::Valve => "a valve",
            Kind::Behaviour => "a behaviour",
            Kind::Failure => "a failure",
            Kind::Table => "a hash table",
        }
    }
}

/// The time a string spells, as it is to be written: `5min` of `"5 min"`.
pub fn time_in_string(text: &str) -> Option<String> {
    let joined: String = text.split_whitespace().collect();
    let unit = joined.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
    let is_time = unit.len() < joined.len() && matches!(unit, "" | "ms" | "s" | "min" | "h");
    (is_time && crate::number::parse_number(&joined).is_ok()).then_some(joined)
}
