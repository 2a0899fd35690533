//! Where the server of a command is.

use clap::Args;

/// Where the server is.
#[derive(Debug, Args, Clone)]
pub(crate) struct Remote {
    /// Connect to the server at this address; COUNTERPOINT_TOKEN holds the token
    #[arg(long, env = "COUNTERPOINT_SERVER", default_value = "http://127.0.0.1:7878", value_name = "URL")]
    pub(crate) server: String,
}
