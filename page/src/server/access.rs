//! Who may do what at the page.

use hyper::header::{HOST, HeaderName, ORIGIN};
use hyper::{HeaderMap, Uri};
use std::net::{IpAddr, SocketAddr};

/// Who may do what.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Access {
    /// What the link must have in it; none if whoever reaches the server may look.
    pub token: Option<String>,
    /// Whether the run can be steered.
    pub control: bool,
}

impl Access {
    /// Whether a request was meant for the server at this address: a page of somebody else can have a browser ask under that
    /// page's name, or send something from its origin.
    pub fn is_meant(&self, uri: &Uri, headers: &HeaderMap, address: SocketAddr) -> bool {
        // A proxy is asked with the whole address, a server with the path alone.
        if uri.authority().is_some() {
            return false;
        }
        let is_here = |host: &str| {
            let name = host.rsplit_once(':').map_or(host, |(name, _)| name).trim_matches(['[', ']']);
            name == "localhost"
                || name.parse::<IpAddr>().is_ok_and(|ip| ip == address.ip() || !address.ip().is_loopback())
        };
        let Some(host) = field(headers, HOST) else { return false };
        // Behind an address for all networks the machine has names we do not know; there is the token.
        let is_named = is_here(host) || self.token.is_some();
        let origin = field(headers, ORIGIN).filter(|origin| *origin != "null");
        is_named && origin.is_none_or(|origin| origin.trim_start_matches("http://") == host)
    }

    /// Whether the query of a request has the token that is needed.
    pub fn allows(&self, query: &str) -> bool {
        self.token.as_deref().is_none_or(|token| value(query, "token").is_some_and(|said| is_same(said, token)))
    }
}

/// A header as text; one that is no text is as good as another server's.
fn field(headers: &HeaderMap, name: HeaderName) -> Option<&str> {
    headers.get(name).map(|value| value.to_str().unwrap_or(""))
}

/// A value of a query.
pub fn value<'q>(query: &'q str, name: &str) -> Option<&'q str> {
    query.split('&').find_map(|pair| pair.strip_prefix(name)?.strip_prefix('='))
}

/// Whether two secrets are the same, in a time that does not tell how far they are.
fn is_same(said: &str, token: &str) -> bool {
    said.len() == token.len() && said.bytes().zip(token.bytes()).fold(0, |differ, (a, b)| differ | (a ^ b)) == 0
}
