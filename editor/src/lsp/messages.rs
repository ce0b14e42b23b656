//! What is said over the stream, as JSON-RPC 2.0 has it: requests, their answers, and notifications.

use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::Value;

/// By what an editor knows a request.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum RequestId {
    /// A number.
    Number(i32),
    /// A text.
    Text(String),
}

/// What is to be answered.
#[derive(Clone, Debug)]
pub struct Request {
    /// What the answer names.
    pub id: RequestId,
    /// What is asked.
    pub method: String,
    /// About what.
    pub params: Value,
}

/// What has no answer.
#[derive(Clone, Debug, Serialize)]
pub struct Notification {
    /// What has happened.
    pub method: String,
    /// To what.
    pub params: Value,
}

/// What an editor says.
#[derive(Clone, Debug)]
pub enum Heard {
    /// It asks.
    Request(Request),
    /// It tells.
    Notification(Notification),
    /// It answers.
    Response,
    /// It says what is none of these.
    Malformed(Response),
    /// It says nothing more.
    End,
}

/// Why a request is not answered: codes of JSON-RPC and of the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorCode {
    /// It is no JSON.
    ParseError = -32700,
    /// It is no request, or none that can come now.
    InvalidRequest = -32600,
    /// Nobody knows it.
    MethodNotFound = -32601,
    /// It is about something else than such a request is.
    InvalidParams = -32602,
    /// The answer cannot be said.
    InternalError = -32603,
    /// `initialize` has not come.
    ServerNotInitialized = -32002,
    /// It cannot be done.
    RequestFailed = -32803,
}

/// A request that is not answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// What kind of fault it is.
    pub code: ErrorCode,
    /// One sentence.
    pub reason: String,
}

impl Refusal {
    /// One with its reason.
    pub fn new(code: ErrorCode, reason: impl Into<String>) -> Self {
        Self { code, reason: reason.into() }
    }
}

/// An answer.
#[derive(Clone, Debug)]
pub struct Response {
    /// Of which request; none if that cannot be known.
    pub id: Option<RequestId>,
    /// The answer, or why there is none.
    pub outcome: Result<Value, Refusal>,
}

/// What is said to an editor.
#[derive(Clone, Debug)]
pub enum Said {
    /// A request.
    Request(Request),
    /// An answer.
    Response(Response),
    /// What has no answer.
    Notification(Notification),
}

impl Heard {
    /// What a message says.
    pub fn of(message: Value) -> Self {
        let Value::Object(mut fields) = message else {
            let what = if message.is_array() { "several messages in one" } else { "a message that is no object" };
            return Self::malformed(ErrorCode::InvalidRequest, what);
        };
        let id = fields.remove("id").map(|id| serde_json::from_value::<RequestId>(id).ok());
        let params = fields.remove("params").unwrap_or_default();
        match (fields.remove("method"), id) {
            (Some(Value::String(method)), Some(Some(id))) => Self::Request(Request { id, method, params }),
            (Some(Value::String(method)), None) => Self::Notification(Notification { method, params }),
            (Some(Value::String(method)), Some(None)) => {
                let why = format!("`{method}` with an `id` that is neither a number of 32 bits nor a text");
                Self::malformed(ErrorCode::InvalidRequest, why)
            }
            (None, Some(_)) if fields.contains_key("result") || fields.contains_key("error") => Self::Response,
            (_, id) => {
                let refusal = Refusal::new(ErrorCode::InvalidRequest, "a message whose `method` is no text");
                Self::Malformed(Response { id: id.flatten(), outcome: Err(refusal) })
            }
        }
    }

    /// What is no message, and why.
    pub fn malformed(code: ErrorCode, reason: impl Into<String>) -> Self {
        Self::Malformed(Response { id: None, outcome: Err(Refusal::new(code, reason)) })
    }
}

#[derive(Serialize)]
struct Fault<'a> {
    code: i32,
    message: &'a str,
}

impl Serialize for Said {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_map(None)?;
        fields.serialize_entry("jsonrpc", "2.0")?;
        match self {
            Self::Response(Response { id, outcome }) => {
                fields.serialize_entry("id", id)?;
                match outcome {
                    Ok(result) => fields.serialize_entry("result", result)?,
                    Err(Refusal { code, reason }) => {
                        fields.serialize_entry("error", &Fault { code: *code as i32, message: reason })?;
                    }
                }
            }
            Self::Request(Request { id, method, params }) => {
                fields.serialize_entry("id", id)?;
                fields.serialize_entry("method", method)?;
                fields.serialize_entry("params", params)?;
            }
            Self::Notification(Notification { method, params }) => {
                fields.serialize_entry("method", method)?;
                fields.serialize_entry("params", params)?;
            }
        }
        fields.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn refused(message: Value) -> Value {
        match Heard::of(message) {
            Heard::Malformed(response) => serde_json::to_value(Said::Response(response)).expect("it can be said"),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn what_is_no_message_is_an_invalid_request() {
        let strange_ids = [json!(null), json!(1.5), json!(true), json!([1]), json!({}), json!(3_000_000_000_u64)];
        let strange = strange_ids.map(|id| json!({ "id": id, "method": "shutdown" }));
        let others = [
            json!([{ "id": 1, "method": "shutdown" }]),
            json!([]),
            json!(7),
            json!("exit"),
            json!({}),
            json!({ "method": 7 }),
        ];
        for message in strange.into_iter().chain(others) {
            let said = refused(message.clone());
            assert_eq!((&said["id"], &said["error"]["code"]), (&Value::Null, &json!(-32600)), "{message}");
        }
        // Whoever asked is told, if that is known.
        assert_eq!(refused(json!({ "id": 7, "method": 1 }))["id"], 7);
        assert_eq!(refused(json!({ "id": "a" }))["id"], "a");
    }

    #[test]
    fn an_answer_is_no_request() {
        for answer in [json!({ "id": 1, "result": null }), json!({ "id": null, "error": {} })] {
            assert!(matches!(Heard::of(answer), Heard::Response));
        }
    }
}
