//! Signed tokens (JWT): EdDSA and RS256.
//!
//! Invariants: the algorithm is that of the key in the file, never that of the token; a token without an end is
//! refused; a key gives no more than the tenants and the role that its row allows.

use std::sync::Once;
use std::time::{SystemTime, UNIX_EPOCH};

use jsonwebtoken::crypto::{CryptoProvider, JwtVerifier, KeyUtils};
use jsonwebtoken::errors::{ErrorKind, Result as Checked, new_error};
use jsonwebtoken::signature::{Error as WrongSignature, Verifier};
use jsonwebtoken::{Algorithm, DecodingKey, DecodingKeyKind, Validation, decode, decode_header};
use ring::signature::{ED25519, RSA_PKCS1_2048_8192_SHA256, UnparsedPublicKey, VerificationAlgorithm};
use serde::Deserialize;

use super::{Identity, Role};
use crate::tenant::{is_tenant, no_tenant};

/// Seconds since 1970.
pub(super) fn now_s() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs())
}

/// A key that signs tokens.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct KeyRow {
    pub(super) kid: String,
    pub(super) algorithm: String,
    pub(super) public_key: String,
    pub(super) issuer: Option<String>,
    pub(super) audience: Option<String>,
    /// Tenants that tokens signed with it may name; empty = any.
    #[serde(default)]
    pub(super) tenants: Vec<String>,
    /// Highest role that they may have.
    pub(super) most: Role,
}

/// A key that verifies tokens.
#[derive(Debug)]
pub(super) struct VerificationKey {
    key: DecodingKey,
    validation: Validation,
    tenants: Vec<String>,
    most: Role,
}

#[derive(Debug, Deserialize)]
struct Claims {
    sub: String,
    tenant: String,
    role: Role,
    exp: u64,
}

impl VerificationKey {
    pub(super) fn new(row: KeyRow) -> Result<Self, String> {
        static PROVIDER: CryptoProvider = CryptoProvider {
            signer_factory: |_, _| Err(new_error(ErrorKind::InvalidAlgorithm)),
            verifier_factory: verifier,
            key_utils: KeyUtils::new_unimplemented(),
        };
        static INSTALLED: Once = Once::new();
        INSTALLED.call_once(|| {
            // Another one in this process verifies as well.
            let _ = PROVIDER.install_default();
        });
        let pem = row.public_key.as_bytes();
        let (algorithm, key) = match row.algorithm.as_str() {
            "EdDSA" => (Algorithm::EdDSA, DecodingKey::from_ed_pem(pem)),
            "RS256" => (Algorithm::RS256, DecodingKey::from_rsa_pem(pem)),
            other => return Err(format!("algorithm '{other}' is not 'EdDSA' or 'RS256'")),
        };
        let key = key.map_err(|error| format!("public_key is not a PEM public key for {}: {error}", row.algorithm))?;
        if let Some(tenant) = row.tenants.iter().find(|tenant| !is_tenant(tenant)) {
            return Err(no_tenant("tenants", tenant));
        }
        let mut validation = Validation::new(algorithm);
        validation.leeway = 30;
        validation.validate_nbf = true;
        let mut required = vec!["exp", "sub"];
        match &row.audience {
            Some(audience) => {
                validation.set_audience(&[audience]);
                required.push("aud");
            }
            None => validation.validate_aud = false,
        }
        if let Some(issuer) = &row.issuer {
            validation.set_issuer(&[issuer]);
            required.push("iss");
        }
        validation.set_required_spec_claims(&required);
        Ok(Self { key, validation, tenants: row.tenants, most: row.most })
    }

    /// The identity of a token, and when that ends, seconds since 1970.
    pub(super) fn verify(&self, token: &str) -> Result<(Identity, u64), String> {
        let decoded = decode::<Claims>(token, &self.key, &self.validation);
        let Claims { sub, tenant, role, exp } =
            decoded.map_err(|error| format!("the token is refused: {}", reason(error.kind())))?.claims;
        let allowed = self.tenants.is_empty() || self.tenants.contains(&tenant);
        if !is_tenant(&tenant) || !allowed || role > self.most {
            return Err("the key of the token may not give this tenant and role".to_owned());
        }
        Ok((Identity { name: sub, tenant, role }, exp))
    }
}

/// Reason why a token is refused.
fn reason(kind: &ErrorKind) -> String {
    match kind {
        ErrorKind::ExpiredSignature => "it has expired (exp)".to_owned(),
        ErrorKind::ImmatureSignature => "it is not valid yet (nbf)".to_owned(),
        ErrorKind::InvalidSignature => "its signature does not fit its key".to_owned(),
        ErrorKind::InvalidAlgorithm => "its algorithm is not the algorithm of its key".to_owned(),
        ErrorKind::InvalidAudience => "its audience (aud) is not the audience of its key".to_owned(),
        ErrorKind::InvalidIssuer => "its issuer (iss) is not the issuer of its key".to_owned(),
        ErrorKind::MissingRequiredClaim(claim) => format!("it has no {claim}"),
        ErrorKind::Json(error) => format!("it must have sub, tenant, role and exp ({error})"),
        other => format!("{other:?}"),
    }
}

/// The key that a token says it is signed with.
pub(super) fn kid(token: &str) -> Result<String, String> {
    let header = decode_header(token).map_err(|error| format!("the token cannot be read: {error}"))?;
    header.kid.ok_or_else(|| "the token names no key (kid)".to_owned())
}

/// Verifies with the same library as TLS.
struct Ring {
    algorithm: Algorithm,
    with: &'static dyn VerificationAlgorithm,
    key: Vec<u8>,
}

fn verifier(algorithm: &Algorithm, key: &DecodingKey) -> Checked<Box<dyn JwtVerifier>> {
    let with: &'static dyn VerificationAlgorithm = match algorithm {
        Algorithm::EdDSA => &ED25519,
        Algorithm::RS256 => &RSA_PKCS1_2048_8192_SHA256,
        _ => return Err(new_error(ErrorKind::InvalidAlgorithm)),
    };
    match key.kind() {
        DecodingKeyKind::SecretOrDer(bytes) => Ok(Box::new(Ring { algorithm: *algorithm, with, key: bytes.clone() })),
        DecodingKeyKind::RsaModulusExponent { .. } => Err(new_error(ErrorKind::InvalidKeyFormat)),
    }
}

impl Verifier<Vec<u8>> for Ring {
    fn verify(&self, message: &[u8], signature: &Vec<u8>) -> Result<(), WrongSignature> {
        UnparsedPublicKey::new(self.with, &self.key).verify(message, signature).map_err(|_| WrongSignature::new())
    }
}

impl JwtVerifier for Ring {
    fn algorithm(&self) -> Algorithm {
        self.algorithm
    }
}
