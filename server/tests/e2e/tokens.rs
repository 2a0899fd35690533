//! `counterpointd token`: tokens come into the file of identities and out of it, and the server follows on SIGHUP.

use std::path::Path;
use std::process::Command;

use counterpoint_proto::v1;
use counterpoint_server::access::Role;

use crate::guarded::*;
use crate::support::*;

/// Exit code, standard output and standard error of a command.
fn token(access: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpointd"));
    let output = command.arg("token").args(arguments).arg("--access").arg(access).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[tokio::test]
async fn a_token_is_made_listed_and_revoked_and_the_server_follows_when_it_reads_the_file_again() {
    let folder = tempfile::tempdir().unwrap();
    let options = guarded(folder.path());
    let access = options.guard.access.clone();
    std::fs::write(&access, "# Ask Kim.\n\n").unwrap();
    let server = Server::start(options).await;
    let (code, made, hint) = token(&access, &["new", "--tenant", "t", "--role", "read", "--name", "ci", "--days", "9"]);
    assert_eq!((code, made.lines().count()), (Some(0), 1), "{hint}");
    assert!(hint.contains("SIGHUP"), "{hint}");
    let secret = made.trim();
    let file = || std::fs::read_to_string(&access).unwrap();
    assert!(file().starts_with("# Ask Kim.\n") && !file().contains(secret), "the file holds no token");
    let list = || v1::ListJobsRequest::default();
    let caller = As::new(&server, secret);
    caller.jobs().list_jobs(list()).await.expect_err("the server has not read it yet");
    server.handle.reload();
    caller.jobs().list_jobs(list()).await.unwrap();

    for days in ["0", "36501", "18446744073709551615"] {
        let (code, out, refusal) = token(&access, &["new", "--tenant", "t", "--role", "read", "--days", days]);
        assert_eq!((code, out.as_str()), (Some(2), ""), "a token of {days} days is of no use");
        assert!(refusal.contains("--days"), "{refusal}");
    }
    let (code, out, refusal) = token(&access, &["new", "--tenant", "t", "--role", "read", "--name", ""]);
    assert_eq!((code, out.as_str()), (Some(2), ""), "the audit log could not name the caller");
    assert!(refusal.contains("--name") && refusal.contains("is a variable unset?"), "{refusal}");

    let (code, listed, _) = token(&access, &["list"]);
    assert_eq!((code, listed.lines().count()), (Some(0), 1));
    assert!(listed.trim().ends_with("  ci  t  read  expires in 9 days"), "{listed}");
    let (code, _, refusal) = token(&access, &["new", "--tenant", "t", "--role", "read", "--name", "a\nb"]);
    assert!(code == Some(2) && refusal.contains("control characters"), "{refusal}");
    let (code, _, talk) = token(&access, &["new", "--tenant", "t", "--role", "read", "--name", "ci"]);
    assert!(code == Some(0) && talk.contains("another token has the name 'ci'"), "{talk}");
    assert!(!hint.contains("another token"), "{hint}");
    let other = token(&access, &["list"]).1.lines().nth(1).unwrap().split_whitespace().next().unwrap().to_owned();
    assert_eq!(token(&access, &["revoke", &other]).0, Some(0));
    let (code, out, refusal) = token(&access, &["revoke", "other"]);
    assert_eq!((code, out.as_str()), (Some(3), ""));
    assert!(refusal.contains("no token has the name 'other'"), "{refusal}");
    assert_eq!(token(&access, &["revoke", "ci"]).0, Some(0));
    assert_eq!((token(&access, &["list"]).1.as_str(), file().contains("# Ask Kim.")), ("", true));
    server.handle.reload();
    let refused = caller.jobs().list_jobs(list()).await.unwrap_err();
    assert_eq!(reason(&refused), "UNAUTHENTICATED");
    server.stop().await;

    std::fs::write(&access, "[[tokens]]\n").unwrap();
    for arguments in [&["list"][..], &["revoke", "ci"], &["new", "--tenant", "t", "--role", "read"]] {
        let (code, out, refusal) = token(&access, arguments);
        assert_eq!((code, out.as_str()), (Some(3), ""), "{refusal}");
        assert!(refusal.contains("tokens"), "{refusal}");
    }
}

/// The file of identities holds digests; no part of its content is a token.
#[tokio::test]
async fn the_content_of_the_file_of_identities_is_not_a_token() {
    let folder = tempfile::tempdir().unwrap();
    let options = guarded(folder.path());
    let token = grant(&options, "ci", "t", Role::Admin);
    let rows = std::fs::read_to_string(&options.guard.access).unwrap();
    let server = Server::start(options).await;
    assert!(As::new(&server, &token).list().await.is_empty(), "the token itself is known");
    let digest = digest(token.as_bytes());
    assert!(rows.contains(&digest), "{rows}");
    let again = crate::support::digest(digest.as_bytes());
    for stolen in [digest.clone(), digest.to_uppercase(), format!("cpt_{digest}"), format!("sha256:{digest}"), again] {
        let answer = As::new(&server, &stolen).jobs().list_jobs(v1::ListJobsRequest::default()).await;
        assert_eq!(reason(&answer.unwrap_err()), "UNAUTHENTICATED", "{stolen}");
    }
    server.stop().await;
}

#[tokio::test]
async fn a_call_with_two_tokens_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let options = guarded(folder.path());
    let tokens = ["one", "two"].map(|tenant| grant(&options, tenant, tenant, Role::Admin));
    let server = Server::start(options).await;
    for tokens in [[&tokens[0], &tokens[1]], [&tokens[0], &tokens[0]]] {
        let mut request = tonic::Request::new(v1::ListJobsRequest::default());
        for token in tokens {
            request.metadata_mut().append("authorization", format!("Bearer {token}").parse().unwrap());
        }
        let refused = server.jobs().list_jobs(request).await.unwrap_err();
        assert_eq!(reason(&refused), "UNAUTHENTICATED");
        assert!(refused.message().contains("more than one 'authorization'"), "{refused:?}");
    }
    server.stop().await;
}

/// Without a file of identities the command says where the printed row goes.
#[test]
fn the_row_of_a_token_without_a_file_names_its_place() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpointd"));
    let output = command.args(["token", "new", "--tenant", "t", "--role", "read"]).output().unwrap();
    let (made, hint) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
    assert!(output.status.success() && made.contains("sha256"), "{made}");
    assert!(hint.contains("add the row to one, and name it with --access"), "{hint}");
}
