//! Signed tokens.

use std::time::{SystemTime, UNIX_EPOCH};

use counterpoint_proto::v1;
use rcgen::{KeyPair, PKCS_ED25519, SigningKey as _};
use ring::hmac;
use rustls::pki_types::SubjectPublicKeyInfoDer;
use rustls::pki_types::pem::PemObject as _;

use crate::guarded::*;
use crate::support::*;

/// The public half of a key that was made for this test and thrown away.
const RSA: &str = "\
-----BEGIN PUBLIC KEY-----
MIIBIjANBgkqhkiG9w0BAQEFAAOCAQ8AMIIBCgKCAQEA64MBxxv2n779ffAAv+hT
WK4AHIykW7cLEM/CplmjPnKhWUwfHqTfosZRAwM582U8WmldJ7Q8WJ2tHvKvBeyn
aNUfKJ6eB7zFm7zL5SPTYKjIqwtiiy1tyPIDI+MpCbRYy0nHJ75rC71WvvvRtNQD
ei6E4k6lKkAUCHbJyDIWc17gC0CHNw2o1uJLjmQ0s+au5cOAZm77ZvJjvZVYo/9j
rRVt3Gf81/s5cOdPuUCjEXFGn+Djrihb0E55dejjqMZe1WIwgk7KWMcuH9XrB/wL
tfa406J/SL9bNeQpD4FCofErANJ5ojRFVb6K8Mf2TZ391vZTsXj67+zGs6WVYiWj
fwIDAQAB
-----END PUBLIC KEY-----
";

/// Signed with it: ci, tenant milling, role submit, until 2100.
const RSA_TOKEN: &str = "\
eyJhbGciOiJSUzI1NiIsInR5cCI6IkpXVCIsImtpZCI6InJzYSJ9.eyJzdWIiOiJjaSIsInRlbmFudCI6Im1pbGxpbmciLCJyb2x\
lIjoic3VibWl0IiwiZXhwIjo0MTAyNDQ0ODAwfQ.AHE7A5ePiAmgaLH06wD_TusglL41xaqyEeNzq8k9_FbctWFPlrNpdGwWVQpp\
ZofqF8SzUKKufqcPQgNVkSGRoqxohJbY-8q1Q0OP6EOzFXjk-6RQSriIu2eSIaZM5BmRja2GX040z-q5R8EDJzxyf-oUxXIMnrYM\
PEjOUeS7Z3PC_PDCIsKS7Yi0jUPZ-dgRAK8GCotET0W7RrW_Y6vQQaKja3edd3H-mlP9zQMXmi3OrUHdOTUR1RWr4hefwZs2kK9q\
KT7gzXVcyexgd30CjBJmDSxyCzJz_zYoPRlEMPbJgnK-yH8cZZSSJw1NNwo15TNO-MvyjBbUayEjAyV_0g\
";

fn url64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
    let mut text = String::new();
    for part in bytes.chunks(3) {
        let word = part.iter().fold(0_u32, |word, byte| word << 8 | u32::from(*byte)) << (8 * (3 - part.len()));
        for at in 0..=part.len() {
            text.push(char::from(DIGITS[(word >> (18 - 6 * at)) as usize & 63]));
        }
    }
    text
}

fn sign(key: &KeyPair, header: &str, claims: &str) -> String {
    let text = format!("{}.{}", url64(header.as_bytes()), url64(claims.as_bytes()));
    format!("{text}.{}", url64(&key.sign(text.as_bytes()).unwrap()))
}

/// Signs with a shared secret (HS256).
fn sign_shared(secret: &[u8], kid: &str, claims: &str) -> String {
    let header = format!(r#"{{"alg":"HS256","kid":"{kid}"}}"#);
    let text = format!("{}.{}", url64(header.as_bytes()), url64(claims.as_bytes()));
    let tag = hmac::sign(&hmac::Key::new(hmac::HMAC_SHA256, secret), text.as_bytes());
    format!("{text}.{}", url64(tag.as_ref()))
}

fn row(kid: &str, algorithm: &str, key: &str, more: &str) -> String {
    format!(
        "[[key]]\nkid = \"{kid}\"\nalgorithm = \"{algorithm}\"\nmost = \"submit\"\n{more}\npublic_key = '''\n{key}'''\n"
    )
}

async fn problem(server: &Server, token: &str) -> Option<String> {
    let answer = As::new(server, token).jobs().list_jobs(v1::ListJobsRequest::default()).await;
    answer.err().map(|status| {
        assert_eq!(reason(&status), "UNAUTHENTICATED");
        status.message().to_owned()
    })
}

#[tokio::test]
async fn a_signed_token_gives_its_tenant_and_role_and_keys_are_rotated_by_kid() {
    let folder = tempfile::tempdir().unwrap();
    let options = guarded(folder.path());
    let access = options.guard.access.clone();
    let [first, second] = [(); 2].map(|()| KeyPair::generate_for(&PKCS_ED25519).unwrap());
    let old = row("2026-1", "EdDSA", &first.public_key_pem(), "");
    std::fs::write(&access, format!("{old}{}", row("rsa", "RS256", RSA, ""))).unwrap();
    let server = Server::start(options).await;
    let end = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs() + 600;
    let claims = format!(r#"{{"sub":"ci","tenant":"milling","role":"submit","exp":{end}}}"#);
    let token = sign(&first, r#"{"alg":"EdDSA","kid":"2026-1"}"#, &claims);
    let job = As::new(&server, &token).submit("r", "fanuc-2path-lathe", "EVENTS 3").await.unwrap().job_id;
    assert_eq!(As::new(&server, RSA_TOKEN).list().await, [job], "of the same tenant");
    let next = sign(&second, r#"{"alg":"EdDSA","kid":"2026-2"}"#, &claims);
    assert!(problem(&server, &next).await.unwrap().contains("'2026-2'"));
    let new = row("2026-2", "EdDSA", &second.public_key_pem(), "");
    std::fs::write(&access, format!("{old}{new}")).unwrap();
    server.handle.reload();
    assert_eq!((problem(&server, &token).await, problem(&server, &next).await), (None, None));
    std::fs::write(&access, new).unwrap();
    server.handle.reload();
    assert!(problem(&server, &token).await.is_some() && problem(&server, &next).await.is_none());
    server.stop().await;
}

#[tokio::test]
async fn signed_tokens_that_prove_nothing_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let options = guarded(folder.path());
    let [key, stranger] = [(); 2].map(|()| KeyPair::generate_for(&PKCS_ED25519).unwrap());
    let more = "tenants = [\"milling\"]\nissuer = \"us\"\naudience = \"counterpoint\"";
    let keys = row("k", "EdDSA", &key.public_key_pem(), more) + &row("rsa", "RS256", RSA, "");
    std::fs::write(&options.guard.access, keys).unwrap();
    let server = Server::start(options).await;
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs();
    let header = r#"{"alg":"EdDSA","kid":"k"}"#;
    let good = format!(
        r#"{{"sub":"ci","tenant":"milling","role":"read","iss":"us","aud":"counterpoint","exp":{}}}"#,
        now + 600
    );
    assert_eq!(problem(&server, &sign(&key, header, &good)).await, None);
    let with = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        sign(&key, header, &good.replace(from, to))
    };
    let token = sign(&key, header, &good);
    let (text, signature) = token.rsplit_once('.').unwrap();
    let cases = [
        ("another key", sign(&stranger, header, &good)),
        ("no signature", format!("{text}.")),
        ("a changed signature", format!("{text}.{}", signature.chars().rev().collect::<String>())),
        (
            "changed claims",
            token.replacen(&url64(good.as_bytes()), &url64(good.replace("read", "submit").as_bytes()), 1),
        ),
        ("algorithm none", sign(&key, r#"{"alg":"none","kid":"k"}"#, &good)),
        ("a shared secret", sign(&key, r#"{"alg":"HS256","kid":"k"}"#, &good)),
        ("a key of another algorithm", sign(&key, r#"{"alg":"EdDSA","kid":"rsa"}"#, &good)),
        ("no key", sign(&key, r#"{"alg":"EdDSA"}"#, &good)),
        ("expired", with(&format!("\"exp\":{}", now + 600), &format!("\"exp\":{}", now - 60))),
        ("no end", with(&format!(",\"exp\":{}", now + 600), "")),
        ("not yet", with("\"sub\"", &format!("\"nbf\":{},\"sub\"", now + 300))),
        ("no subject", with("\"sub\":\"ci\",", "")),
        ("another issuer", with("\"us\"", "\"them\"")),
        ("no issuer", with("\"iss\":\"us\",", "")),
        ("another audience", with("\"counterpoint\"", "\"other\"")),
        ("a tenant that the key may not give", with("milling", "turning")),
        ("a role that the key may not give", with("read", "admin")),
        ("a role that is none", with("read", "god")),
        ("no claims", sign(&key, header, "[]")),
    ];
    let reasons = [
        ("another key", "its signature does not fit its key"),
        ("expired", "it has expired (exp)"),
        ("not yet", "it is not valid yet (nbf)"),
        ("no end", "exp"),
        ("another issuer", "its issuer (iss)"),
        ("another audience", "its audience (aud)"),
        ("a shared secret", "its algorithm"),
    ];
    for (what, token) in cases {
        let refusal = problem(&server, &token).await.expect(what);
        let reason = reasons.iter().find(|(case, _)| *case == what).map_or("", |(_, reason)| reason);
        assert!(refusal.contains(reason), "{what}: {refusal}");
    }
    server.stop().await;
}

/// A public key is widely known, so no form of it may serve as a shared secret.
#[tokio::test]
async fn a_token_signed_with_a_public_key_as_its_secret_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let options = guarded(folder.path());
    let key = KeyPair::generate_for(&PKCS_ED25519).unwrap();
    let pem = key.public_key_pem();
    std::fs::write(&options.guard.access, row("ed", "EdDSA", &pem, "") + &row("rsa", "RS256", RSA, "")).unwrap();
    let server = Server::start(options).await;
    assert_eq!(problem(&server, RSA_TOKEN).await, None);
    let claims = r#"{"sub":"ci","tenant":"milling","role":"submit","exp":4102444800}"#;
    assert_eq!(problem(&server, &sign(&key, r#"{"alg":"EdDSA","kid":"ed"}"#, claims)).await, None);
    for (kid, pem) in [("ed", pem.as_str()), ("rsa", RSA)] {
        let der = SubjectPublicKeyInfoDer::from_pem_slice(pem.as_bytes()).unwrap();
        // The key alone is in its structure after the algorithm: 12 bytes of Ed25519, 24 of RSA.
        let secrets = [pem.as_bytes(), pem.trim_end().as_bytes(), &der, &der[12..], &der[24..], b""];
        for secret in secrets {
            let refused = problem(&server, &sign_shared(secret, kid, claims)).await;
            assert!(refused.is_some(), "{kid}, a secret of {} bytes", secret.len());
        }
    }
    server.stop().await;
}
