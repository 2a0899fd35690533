//! `counterpointd token`: makes, lists and revokes tokens in the file of identities.
//!
//! Invariants: a token is printed once, when it is made; a running server is not touched, as only its owner may make
//! it read the file again.

use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use super::edit::{self, TokenRecord};
use super::{Role, token};
use crate::output;

/// Digits of a digest that lists show, and the fewest that name a token.
const SHOWN: usize = 12;
const FEWEST: usize = 8;
const DAY_S: u64 = 86_400;
/// Maximum number of days until a token expires.
const MOST_DAYS: u64 = 36_500;
/// Use of a row that the command could not add to a file.
const ROW: &str = "no file of identities is configured: add the row to one, and name it with --access or in the \
     configuration (access)";
/// How a change takes effect.
const RELOAD: &str = "a running server reads the file on SIGHUP (systemctl reload counterpointd)";

/// Commands for tokens.
#[derive(Debug, clap::Subcommand)]
pub enum TokenCommand {
    /// Print a new token and add its row to the file of identities, which is created if it does not exist
    ///
    /// If neither --access nor the configuration names a file, the row is printed after the token.
    New {
        /// Tenant of the caller
        #[arg(long)]
        tenant: String,
        /// Role of the caller
        #[arg(long, value_enum)]
        role: Role,
        /// Name of the caller in the audit log
        #[arg(long, default_value = "token", value_parser = filled)]
        name: String,
        /// Days until the token expires, at most 36500 [default: never]
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MOST_DAYS))]
        days: Option<u64>,
        /// File of identities [default: the file named in the configuration]
        #[arg(long, value_name = "FILE.toml")]
        access: Option<PathBuf>,
    },
    /// List the tokens in the file of identities: digest prefix, name, tenant, role, expiry
    List {
        /// File of identities [default: the file named in the configuration]
        #[arg(long, value_name = "FILE.toml")]
        access: Option<PathBuf>,
    },
    /// Remove a token from the file of identities
    Revoke {
        /// Name of the token, or a prefix of its digest (at least 8 digits), as `token list` shows them
        token: String,
        /// File of identities [default: the file named in the configuration]
        #[arg(long, value_name = "FILE.toml")]
        access: Option<PathBuf>,
    },
}

/// Refuses an empty name, which usually comes from an unset shell variable, and a name with control characters.
fn filled(text: &str) -> Result<String, String> {
    match text.trim() {
        "" => Err("the name is empty: give a name or omit the option (is a variable unset?)".to_owned()),
        _ if text.chars().any(char::is_control) => {
            Err("a name has no control characters, such as a line break".to_owned())
        }
        _ => Ok(text.to_owned()),
    }
}

impl TokenCommand {
    /// Executes the command; `configured` is the file of the configuration, or empty.
    ///
    /// # Errors
    /// When the file cannot be used, the token cannot be made or found, or the output cannot be written.
    pub fn run(&self, configured: &Path) -> Result<(), String> {
        let now_s = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        match self {
            Self::New { tenant, role, name, days, access } => {
                let expires_s = days.map(|days| now_s.saturating_add(days.saturating_mul(DAY_S)));
                let (token, row) = token::create(name, tenant, *role, expires_s)?;
                let access = access.as_deref().unwrap_or(configured);
                if access.as_os_str().is_empty() {
                    output::remark(format_args!("{ROW}"));
                    return output::line(format_args!("{token}\n\n{row}"));
                }
                let same = edit::rows(access).map_or(0, |rows| rows.iter().filter(|row| row.name == *name).count());
                edit::add_row(access, &row)?;
                if same > 0 {
                    output::remark(format_args!("{}", not_unique(name, same)));
                }
                output::remark(format_args!("{RELOAD}"));
                output::line(format_args!("{token}"))
            }
            Self::List { access } => {
                let rows = edit::rows(file(access.as_deref(), configured)?)?;
                rows.iter().try_for_each(|row| output::line(format_args!("{}", shown(row, now_s))))
            }
            Self::Revoke { token, access } => {
                let access = file(access.as_deref(), configured)?;
                let row = chosen(&edit::rows(access)?, token, now_s)?;
                edit::remove(access, &row.sha256)?;
                output::remark(format_args!("{RELOAD}"));
                output::line(format_args!("revoked: {}", shown(&row, now_s)))
            }
        }
    }
}

/// Warns that `revoke` cannot take this name.
fn not_unique(name: &str, same: usize) -> String {
    let tokens = if same == 1 { "another token has".to_owned() } else { format!("{same} other tokens have") };
    format!("{tokens} the name '{name}': `token revoke` needs the beginning of the digest, which `token list` shows")
}

/// The file of identities to use.
fn file<'a>(given: Option<&'a Path>, configured: &'a Path) -> Result<&'a Path, String> {
    let file = given.unwrap_or(configured);
    match file.as_os_str().is_empty() {
        true => Err("the configuration names no file of identities: give it with --access FILE.toml".to_owned()),
        false => Ok(file),
    }
}

/// A token as lists show it.
fn shown(row: &TokenRecord, now_s: u64) -> String {
    let TokenRecord { name, tenant, role, sha256, expires_s } = row;
    let expiry = match expires_s {
        None => "never expires".to_owned(),
        Some(at) if *at <= now_s => "expired".to_owned(),
        Some(at) => match (at - now_s).div_ceil(DAY_S) {
            1 => "expires in 1 day".to_owned(),
            days => format!("expires in {days} days"),
        },
    };
    let digest: String = sha256.chars().take(SHOWN).collect();
    format!("{digest}  {name}  {tenant}  {role}  {expiry}")
}

/// The one token that a text names.
fn chosen(rows: &[TokenRecord], text: &str, now_s: u64) -> Result<TokenRecord, String> {
    let begins = |row: &TokenRecord| text.len() >= FEWEST && row.sha256.starts_with(text);
    let found: Vec<&TokenRecord> = rows.iter().filter(|row| row.name == text || begins(row)).collect();
    match found.as_slice() {
        [] => Err(format!("no token has the name '{text}' or a digest that begins so: `token list` shows them")),
        [row] => Ok((*row).clone()),
        several => {
            let list: String = several.iter().map(|row| format!("\n  {}", shown(row, now_s))).collect();
            Err(format!("'{text}' names several tokens: give the beginning of a digest{list}"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_named_by_its_name_or_its_digest_and_never_chosen_among_several() {
        let row = |name: &str, digit: &str, expires_s| TokenRecord {
            name: name.to_owned(),
            tenant: "t".to_owned(),
            role: "read".to_owned(),
            sha256: digit.repeat(64),
            expires_s,
        };
        let rows = [row("ci", "a", None), row("ci", "b", Some(100)), row("view", "c", Some(100 + DAY_S))];
        assert_eq!(chosen(&rows, "view", 0).unwrap(), rows[2]);
        assert_eq!(chosen(&rows, "bbbbbbbb", 0).unwrap(), rows[1]);
        for none in ["bbbb", "x", ""] {
            assert!(chosen(&rows, none, 0).unwrap_err().contains("no token"), "{none}");
        }
        let several = chosen(&rows, "ci", 100).unwrap_err();
        assert!(several.contains("aaaaaaaaaaaa  ci  t  read  never expires"), "{several}");
        assert!(several.contains("bbbbbbbbbbbb  ci  t  read  expired"), "{several}");
        assert_eq!(shown(&rows[2], 101), "cccccccccccc  view  t  read  expires in 1 day");
        assert!(file(None, Path::new("")).is_err() && file(None, Path::new("a")).is_ok());
    }
}
