//! Where the server of a command is.

use clap::Args;

/// Address of a server on this machine.
const DEFAULT: &str = "http://127.0.0.1:7878";

/// Environment variable with the address.
const SERVER: &str = "COUNTERPOINT_SERVER";

/// Where the server is.
#[derive(Debug, Args, Clone)]
pub(crate) struct Remote {
    /// Connect to the server at this address; COUNTERPOINT_TOKEN holds the token
    #[arg(long, env = SERVER, default_value = DEFAULT, value_name = "URL", value_parser = address)]
    pub(crate) server: String,
}

/// An address; an empty variable counts as absent.
fn address(text: &str) -> Result<String, String> {
    let from_variable = || std::env::var_os(SERVER).is_some_and(|value| value.is_empty());
    match text {
        "" if from_variable() => Ok(DEFAULT.to_owned()),
        "" => Err("expected an address such as http://127.0.0.1:7878".to_owned()),
        text => Ok(text.to_owned()),
    }
}
