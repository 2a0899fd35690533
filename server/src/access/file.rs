//! The file of identities.
//!
//! Invariant: a file with an error is not used in part.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use serde::Deserialize;

use super::jwt::{KeyRow, VerificationKey};
use super::{Identity, Role, token};
use crate::option_file::OptionFile;
use crate::tenant::{is_tenant, no_tenant};

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct IdentityFile {
    #[serde(default)]
    token: Vec<TokenRow>,
    #[serde(default)]
    certificate: Vec<CertificateRow>,
    #[serde(default)]
    key: Vec<KeyRow>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TokenRow {
    name: String,
    tenant: String,
    role: Role,
    sha256: String,
    expires_s: Option<u64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct CertificateRow {
    name: String,
    tenant: String,
    role: Role,
}

#[derive(Debug)]
struct KnownToken {
    digest: [u8; 32],
    expires_s: Option<u64>,
    identity: Arc<Identity>,
}

/// Identities of the file.
#[derive(Debug)]
pub(super) struct KnownIdentities {
    /// By the first bytes of their digests.
    tokens: HashMap<[u8; 8], Vec<KnownToken>>,
    certificates: HashMap<String, Arc<Identity>>,
    keys: HashMap<String, VerificationKey>,
}

impl KnownIdentities {
    pub(super) fn read(path: &Path) -> Result<Self, String> {
        let file = OptionFile::new("access", path);
        let text = String::from_utf8(file.read()?).map_err(|error| file.wrong(error))?;
        Self::parse(&text).map_err(|error| file.wrong(error))
    }

    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let file: IdentityFile = toml::from_str(text).map_err(|error| error.to_string())?;
        let mut known = Self { tokens: HashMap::new(), certificates: HashMap::new(), keys: HashMap::new() };
        for row in file.token {
            let digest = bytes(&row.sha256)
                .ok_or_else(|| format!("token '{}': sha256 must be 64 lower-case hexadecimal digits", row.name))?;
            let identity = identity(&format!("token '{}'", row.name), row.name, row.tenant, row.role)?;
            let token = KnownToken { digest, expires_s: row.expires_s, identity };
            known.tokens.entry(first(&digest)).or_default().push(token);
        }
        for row in file.certificate {
            let place = format!("certificate '{}'", row.name);
            let name = row.name.to_ascii_lowercase();
            let identity = identity(&place, row.name, row.tenant, row.role)?;
            if known.certificates.insert(name, identity).is_some() {
                return Err(format!("{place} is there twice"));
            }
        }
        for row in file.key {
            let place = format!("key '{}'", row.kid);
            let kid = row.kid.clone();
            let key = VerificationKey::new(row).map_err(|error| format!("{place}: {error}"))?;
            if known.keys.insert(kid, key).is_some() {
                return Err(format!("{place} is there twice"));
            }
        }
        Ok(known)
    }

    /// The identity of a token of this file, and when that ends, seconds since 1970.
    pub(super) fn token(&self, token: &str, now_s: u64) -> Option<(Arc<Identity>, u64)> {
        let digest = token::digest(token);
        let mut found = None;
        for candidate in self.tokens.get(&first(&digest)).into_iter().flatten() {
            let valid = candidate.expires_s.is_none_or(|at| now_s < at);
            if token::same(&candidate.digest, &digest) && valid {
                found = Some((candidate.identity.clone(), candidate.expires_s.unwrap_or(u64::MAX)));
            }
        }
        found
    }

    /// The identity of a client certificate with these names.
    pub(super) fn certificate(&self, names: &[String]) -> Option<Arc<Identity>> {
        names.iter().find_map(|name| self.certificates.get(&name.to_ascii_lowercase()).cloned())
    }

    /// The identity that a signed token states, and when that ends, seconds since 1970.
    pub(super) fn signed(&self, token: &str) -> Result<(Identity, u64), String> {
        let kid = super::jwt::kid(token)?;
        let key =
            self.keys.get(&kid).ok_or_else(|| format!("the token is signed with a key '{kid}' that is not known"))?;
        key.verify(token)
    }
}

fn identity(place: &str, name: String, tenant: String, role: Role) -> Result<Arc<Identity>, String> {
    if is_tenant(&tenant) { Ok(Arc::new(Identity { name, tenant, role })) } else { Err(no_tenant(place, &tenant)) }
}

fn first(digest: &[u8; 32]) -> [u8; 8] {
    digest.first_chunk().copied().unwrap_or_default()
}

fn bytes(digits: &str) -> Option<[u8; 32]> {
    if !crate::blobs::is_digest(digits) {
        return None;
    }
    let mut out = [0; 32];
    for (slot, pair) in out.iter_mut().zip(digits.as_bytes().chunks_exact(2)) {
        *slot = u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok()?;
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_created_token_is_known_until_it_expires() {
        let (token, row) = token::create("ci", "milling", Role::Submit, Some(1000)).unwrap();
        let (other, _) = token::create("ci", "milling", Role::Submit, None).unwrap();
        let known = KnownIdentities::parse(&row).unwrap();
        let (identity, until) = known.token(&token, 999).unwrap();
        assert_eq!((identity.name.as_str(), identity.tenant.as_str(), identity.role), ("ci", "milling", Role::Submit));
        assert_eq!(until, 1000);
        assert!(known.token(&token, 1000).is_none(), "expired");
        assert!(known.token(&other, 0).is_none() && known.token("", 0).is_none());
        assert!(!row.contains(&token), "the file holds no token");
        assert!(token::create("x", "No Tenant", Role::Read, None).is_err());
    }

    #[test]
    fn files_with_errors_are_refused_and_say_where() {
        let wrong = [
            ("[[token]]\nname = \"a\"\ntenant = \"t\"\nrole = \"submit\"\nsha256 = \"12\"", "token 'a': sha256"),
            ("[[certificate]]\nname = \"a\"\ntenant = \"../t\"\nrole = \"read\"", "certificate 'a': '../t'"),
            ("[[certificate]]\nname = \"a\"\ntenant = \"t\"\nrole = \"boss\"", "boss"),
            ("[[tokens]]\n", "tokens"),
            (
                "[[key]]\nkid = \"k\"\nalgorithm = \"none\"\npublic_key = \"\"\nmost = \"read\"",
                "key 'k': algorithm 'none'",
            ),
            ("[[key]]\nkid = \"k\"\nalgorithm = \"EdDSA\"\npublic_key = \"x\"\nmost = \"read\"", "key 'k': public_key"),
        ];
        for (text, part) in wrong {
            let error = KnownIdentities::parse(text).unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
    }

    #[test]
    fn names_of_certificates_do_not_depend_on_case() {
        let known = KnownIdentities::parse("[[certificate]]\nname = \"Cell.Example\"\ntenant = \"t\"\nrole = \"read\"")
            .unwrap();
        assert!(known.certificate(&["other".to_owned(), "cell.example".to_owned()]).is_some());
        assert!(known.certificate(&[]).is_none() && known.certificate(&["cell".to_owned()]).is_none());
    }
}
