//! What a mission and a host both know, and nobody else is told.

use crate::files::inputs;
use crate::files::shown::Shown;
use anyhow::{Result, anyhow};
use clap::ValueHint;
use rpl_protocol::token::Token;
use std::path::PathBuf;

/// Where the token stands: not on the command line, which everybody on the machine can see.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct TokenArgument {
    /// File with the token shared by mission and host, one line of at least 16 characters; a host with a token refuses
    /// all other clients
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub token_file: Option<PathBuf>,
}

impl TokenArgument {
    /// The token, if a file of one is named.
    ///
    /// # Errors
    /// The file cannot be read, or has no token.
    pub fn read(&self) -> Result<Option<Token>> {
        let Some(path) = &self.token_file else { return Ok(None) };
        let no_token = |why: String| anyhow!("the token file `{}` {why}", path.shown());
        let text = inputs::short_text(path).map_err(|why| no_token(format!("cannot be read: {why}")))?;
        Token::new(&text).map(Some).map_err(no_token)
    }
}
