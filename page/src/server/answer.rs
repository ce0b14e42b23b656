//! An answer as hyper sends it: parts that lie somewhere already, one after the other.

use hyper::Response;
use hyper::body::{Body, Bytes, Frame, SizeHint};
use hyper::header::{CONNECTION, CONTENT_TYPE, HeaderName, HeaderValue};
use hyper::http::StatusCode;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::pin::Pin;
use std::task::{Context, Poll};

/// What is left to be sent.
#[derive(Debug, Default)]
pub struct Parts(VecDeque<Bytes>);

impl From<Vec<Bytes>> for Parts {
    fn from(parts: Vec<Bytes>) -> Self {
        Self(parts.into())
    }
}

impl Body for Parts {
    type Data = Bytes;
    type Error = Infallible;

    fn poll_frame(mut self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, Infallible>>> {
        Poll::Ready(self.0.pop_front().map(|part| Ok(Frame::data(part))))
    }

    fn is_end_stream(&self) -> bool {
        self.0.is_empty()
    }

    fn size_hint(&self) -> SizeHint {
        SizeHint::with_exact(self.0.iter().map(|part| part.len() as u64).sum())
    }
}

/// An answer with a header.
pub fn answered(parts: Vec<Bytes>, (name, value): (HeaderName, &'static str)) -> Response<Parts> {
    let mut response = Response::new(parts.into());
    response.headers_mut().insert(name, HeaderValue::from_static(value));
    response
}

/// An answer that says why there is none; nothing more is heard on that connection.
pub fn refused(status: StatusCode, why: &'static str) -> Response<Parts> {
    let why = vec![Bytes::from_static(why.as_bytes())];
    let mut response = answered(why, (CONTENT_TYPE, "text/plain; charset=utf-8"));
    response.headers_mut().insert(CONNECTION, HeaderValue::from_static("close"));
    *response.status_mut() = status;
    response
}
