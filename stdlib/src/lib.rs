//! What plans can call: native pure functions, and the prelude in RPL itself.
