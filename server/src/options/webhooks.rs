//! Targets of webhooks.
//!
//! Only the configuration file has these, one table per target: `[webhooks.NAME]`. Invariant: without a table nothing
//! is sent.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// A target that the server notifies when jobs end.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Webhook {
    /// Address, `https://HOST/PATH`; `http` for this computer only, unless the server is `insecure`.
    pub url: String,
    /// File of the secret that signs the messages.
    pub secret_file: PathBuf,
    /// Tenants whose jobs are reported; `*` = all.
    pub tenants: Vec<String>,
    /// States that are reported; empty = every end.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub states: Vec<String>,
    /// PEM file of the authorities that may issue the target's certificate; absent = those of the system.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ca_file: Option<PathBuf>,
}
