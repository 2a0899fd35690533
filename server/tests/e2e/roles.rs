//! The role and the identity that each call needs.

use std::collections::BTreeSet;
use std::time::Duration;

use counterpoint_proto::DESCRIPTORS;
use counterpoint_server::access::Role;
use prost::Message as _;
use tonic::{Code, Status};
use tonic_reflection::pb::v1 as reflection;

use crate::contract::*;
use crate::guarded::*;
use crate::support::*;

/// Code and reason of a refused call.
fn refused<T>(answer: Result<T, Status>) -> Option<(Code, String)> {
    answer.err().map(|status| (status.code(), reason(&status)))
}

/// Each call is refused to every lower role, and passes with its own role and every higher role. An empty message is
/// enough: the role is checked before the request is read.
#[tokio::test]
async fn each_call_is_refused_to_the_roles_below_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let options = guarded(folder.path());
    let roles = ROLES.map(|(role, _)| (role, grant(&options, &role.to_string(), "t", role)));
    let mut server = Server::start(options).await;
    let callers = roles.map(|(role, token)| (role, As::new(&server, &token)));
    let denied = Some((Code::PermissionDenied, "PERMISSION_DENIED".to_owned()));
    for (needed, calls) in ROLES {
        for name in calls {
            for (role, caller) in &callers {
                let outcome = refused(ask(caller, &path(name), Vec::new()).await);
                assert_eq!(outcome == denied, *role < needed, "{name} as {role}: {outcome:?}");
                assert!(outcome.is_none_or(|(code, _)| code != Code::Unauthenticated), "{name} as {role}");
            }
        }
    }
    tokio::time::timeout(Duration::from_secs(10), &mut server.task)
        .await
        .expect("an administrator drained it")
        .unwrap();
}

/// Names of the services that a server offers, from its reflection.
async fn services(caller: &As) -> BTreeSet<String> {
    use reflection::server_reflection_request::MessageRequest;
    use reflection::server_reflection_response::MessageResponse;
    let message_request = Some(MessageRequest::ListServices(String::new()));
    let request = reflection::ServerReflectionRequest { message_request, ..Default::default() };
    let path = "/grpc.reflection.v1.ServerReflection/ServerReflectionInfo";
    let mut answers = ask(caller, path, request.encode_to_vec()).await.unwrap();
    let answer = answers.message().await.unwrap().unwrap();
    match reflection::ServerReflectionResponse::decode(answer.as_slice()).unwrap().message_response {
        Some(MessageResponse::ListServicesResponse(list)) => list.service.into_iter().map(|one| one.name).collect(),
        other => panic!("{other:?}"),
    }
}

#[tokio::test]
async fn each_call_of_each_service_but_health_needs_an_identity() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = guarded(folder.path());
    options.guard.max_refused_per_s = 0;
    let token = grant(&options, "r", "t", Role::Read);
    let server = Server::start(options).await;
    let sets = [
        DESCRIPTORS,
        tonic_health::pb::FILE_DESCRIPTOR_SET,
        reflection::FILE_DESCRIPTOR_SET,
        tonic_reflection::pb::v1alpha::FILE_DESCRIPTOR_SET,
    ];
    let mut paths: BTreeSet<String> = sets.into_iter().flat_map(methods).map(|method| method.path).collect();
    let of = |path: &str| path.trim_start_matches('/').split('/').next().unwrap().to_owned();
    let tested: BTreeSet<String> = paths.iter().map(|path| of(path)).collect();
    // Reflection does not list its version v1alpha.
    let missing: Vec<_> = services(&As::new(&server, &token)).await.difference(&tested).cloned().collect();
    assert!(missing.is_empty(), "services without a test: {missing:?}");
    paths.extend(["/counterpoint.v1.Jobs/NoSuchCall", "/no.such.Service/Call"].map(str::to_owned));
    let unknown = Some((Code::Unauthenticated, "UNAUTHENTICATED".to_owned()));
    for stranger in [As::nobody(&server), As::new(&server, ""), As::new(&server, "cpt_00"), As::new(&server, "a.b.c")] {
        for path in &paths {
            let outcome = refused(ask(&stranger, path, Vec::new()).await);
            let expected = if of(path) == "grpc.health.v1.Health" { None } else { unknown.clone() };
            assert_eq!(outcome, expected, "{path} with {:?}", stranger.bearer.0);
        }
    }
    As::new(&server, &token).list().await;
    server.stop().await;
}
