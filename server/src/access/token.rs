//! Tokens: 256 random bits as a text. The server keeps their digests only.
//!
//! Invariant: the content of the file of identities does not suffice to make calls.

use ring::rand::{SecureRandom as _, SystemRandom};
use sha2::{Digest as _, Sha256};

use super::Role;
use crate::blobs::hex;
use crate::tenant::{self, is_tenant};

/// First letters of every token, so that tools which look for secrets find one that has got lost.
const PREFIX: &str = "cpt_";

/// Digest of a token. It has too many random bits to be guessed from its digest, so a plain hash serves.
pub(super) fn digest(token: &str) -> [u8; 32] {
    Sha256::digest(token).into()
}

/// Whether two digests are the same, in a time that does not depend on where they differ.
pub(super) fn same(a: &[u8; 32], b: &[u8; 32]) -> bool {
    std::hint::black_box(a.iter().zip(b).fold(0, |differ, (a, b)| differ | (a ^ b))) == 0
}

/// A new token and its row for the file of identities.
///
/// # Errors
/// When name or tenant cannot be used, or the system has no random numbers.
pub fn create(name: &str, tenant: &str, role: Role, expires_s: Option<u64>) -> Result<(String, String), String> {
    if !is_tenant(tenant) {
        return Err(format!("'{tenant}' is not a tenant: expected {}", tenant::RULE));
    }
    let mut random = [0; 32];
    SystemRandom::new().fill(&mut random).map_err(|_| "the system has no random numbers".to_owned())?;
    let token = format!("{PREFIX}{}", hex(&random));
    let mut row = toml::Table::new();
    row.insert("name".to_owned(), name.into());
    row.insert("tenant".to_owned(), tenant.into());
    row.insert("role".to_owned(), role.to_string().into());
    row.insert("sha256".to_owned(), hex(&digest(&token)).into());
    if let Some(at) = expires_s {
        row.insert("expires_s".to_owned(), i64::try_from(at).unwrap_or(i64::MAX).into());
    }
    Ok((token, format!("[[token]]\n{row}")))
}
