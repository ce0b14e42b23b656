//! Messages of editors and debuggers as bytes, written and read by the specification: a header with the length, an
//! empty line, JSON.

use serde_json::Value;

/// Messages as they go over a stream.
pub fn written(messages: &[Value]) -> Vec<u8> {
    let message = |message: &Value| {
        let text = message.to_string();
        format!("Content-Length: {}\r\n\r\n{text}", text.len()).into_bytes()
    };
    messages.iter().flat_map(message).collect()
}

/// The messages on a stream that has ended.
pub fn messages(mut bytes: &[u8]) -> Vec<Value> {
    let mut messages = Vec::new();
    while !bytes.is_empty() {
        let end = bytes.windows(4).position(|four| four == b"\r\n\r\n").expect("the header ends");
        let header = std::str::from_utf8(&bytes[..end]).expect("the header is text");
        let length = header.lines().find_map(|line| line.strip_prefix("Content-Length: ")).expect("it has a length");
        let length: usize = length.parse().expect("the length is a number");
        let (message, rest) = bytes[end + 4..].split_at(length);
        messages.push(serde_json::from_slice(message).expect("the message is JSON"));
        bytes = rest;
    }
    messages
}
