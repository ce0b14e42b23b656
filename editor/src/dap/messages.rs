//! The messages, with the fields that are used; names as the specification has them.

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// What a debugger asks.
#[derive(Clone, Debug, Deserialize)]
pub struct Request {
    /// Its number, which the answer names.
    pub seq: i64,
    /// What is asked.
    pub command: String,
    /// What more is said.
    #[serde(default)]
    pub arguments: Value,
}

/// What is said to a debugger.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub enum Said {
    /// An answer.
    Response {
        /// The number of the request.
        request_seq: i64,
        /// Whether it was done.
        success: bool,
        /// What was asked.
        command: String,
        /// Why it was not done.
        #[serde(skip_serializing_if = "Option::is_none")]
        message: Option<String>,
        /// The answer.
        #[serde(skip_serializing_if = "Option::is_none")]
        body: Option<Value>,
    },
    /// Something has happened.
    Event {
        /// What.
        event: &'static str,
        /// More of it.
        #[serde(skip_serializing_if = "Option::is_none")]
        body: Option<Value>,
    },
}

/// A message with its number.
#[derive(Clone, Debug, Serialize)]
pub struct Numbered {
    /// Counts what is said, from 1.
    pub seq: i64,
    /// What is said.
    #[serde(flatten)]
    pub said: Said,
}

/// The arguments of `launch`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Launch {
    /// The plan file.
    pub program: String,
    /// Words of `rpl step` that say where it runs, such as `--world dept`.
    #[serde(default)]
    pub args: Vec<String>,
    /// Whether the plan stands before its first form at first.
    #[serde(default)]
    pub stop_on_entry: bool,
}

/// A text.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Source {
    /// Its name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Its file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path: Option<String>,
    /// The number by which a text without a file is asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source_reference: Option<i64>,
}

/// The arguments of `setBreakpoints`.
#[derive(Clone, Debug, Deserialize)]
pub struct SetBreakpoints {
    /// The text.
    pub source: Source,
    /// All breakpoints in it.
    #[serde(default)]
    pub breakpoints: Vec<SourceBreakpoint>,
}

/// A line to stop at.
#[derive(Clone, Debug, Deserialize)]
pub struct SourceBreakpoint {
    /// From 1, or from 0, as the debugger has said.
    pub line: i64,
    /// A form that must be true there.
    pub condition: Option<String>,
}

/// The arguments of `setFunctionBreakpoints`.
#[derive(Clone, Debug, Deserialize)]
pub struct SetFunctionBreakpoints {
    /// All of them.
    #[serde(default)]
    pub breakpoints: Vec<FunctionBreakpoint>,
}

/// A plan, function or tag to stop at, or a condition over fluents, in parentheses.
#[derive(Clone, Debug, Deserialize)]
pub struct FunctionBreakpoint {
    /// Which.
    pub name: String,
}

/// What became of a breakpoint.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Breakpoint {
    /// Whether the run can stop there.
    pub verified: bool,
    /// Why not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub message: Option<String>,
    /// Where it is, if that is another line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<i64>,
}

/// The arguments of `setExceptionBreakpoints`.
#[derive(Clone, Debug, Deserialize)]
pub struct SetExceptionBreakpoints {
    /// Which are on.
    #[serde(default)]
    pub filters: Vec<String>,
}

/// The arguments of requests about a thread.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct OfThread {
    /// The thread.
    #[serde(default)]
    pub thread_id: i64,
}

/// The arguments of `stackTrace`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct StackTrace {
    /// The thread.
    pub thread_id: i64,
    /// The first frame that is wanted.
    #[serde(default)]
    pub start_frame: usize,
    /// How many; none or 0 for all.
    pub levels: Option<usize>,
}

/// A call in a stack.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct StackFrame {
    /// By which it is asked for.
    pub id: i64,
    /// The function or plan.
    pub name: String,
    /// Its text.
    pub source: Source,
    /// Where it stands.
    pub line: i64,
    /// Where it stands.
    pub column: i64,
    /// The end of the form.
    pub end_line: i64,
    /// The end of the form.
    pub end_column: i64,
    /// How much it matters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub presentation_hint: Option<&'static str>,
}

/// The arguments of `scopes`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Scopes {
    /// The frame.
    pub frame_id: i64,
}

/// The arguments of `variables`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Variables {
    /// The scope.
    pub variables_reference: i64,
}

/// A name and its value.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Variable {
    /// The name.
    pub name: String,
    /// The value as text.
    pub value: String,
    /// 0: there is nothing more in it.
    pub variables_reference: i64,
}

/// The arguments of `evaluate`.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Evaluate {
    /// A form.
    pub expression: String,
    /// Whose variables it sees.
    pub frame_id: Option<i64>,
}

/// The arguments of `source`.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SourceRequest {
    /// The text.
    pub source_reference: i64,
}
