//! The role that each call of the contract needs.
//!
//! Invariant: every call of every service has a row (a test compares them with the descriptors); a call without a row
//! is refused without an identity.

use super::Role;

/// The requirements of a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Needs {
    /// Nothing: load balancers ask for the health of the server.
    Nothing,
    Role(Role),
    /// Unknown call.
    Unknown,
}

/// Calls by service and name.
pub(crate) const CALLS: &[(&str, &str, Role)] = &[
    ("counterpoint.v1.Jobs", "SubmitJob", Role::Submit),
    ("counterpoint.v1.Jobs", "GetJob", Role::Read),
    ("counterpoint.v1.Jobs", "ListJobs", Role::Read),
    ("counterpoint.v1.Jobs", "WatchJob", Role::Read),
    ("counterpoint.v1.Jobs", "WaitJob", Role::Read),
    ("counterpoint.v1.Jobs", "CancelJob", Role::Submit),
    ("counterpoint.v1.Jobs", "DeleteJob", Role::Submit),
    ("counterpoint.v1.Jobs", "RerunJob", Role::Submit),
    ("counterpoint.v1.Jobs", "WatchJobs", Role::Read),
    ("counterpoint.v1.Jobs", "PauseJob", Role::Submit),
    ("counterpoint.v1.Jobs", "ResumeJob", Role::Submit),
    ("counterpoint.v1.Jobs", "CancelJobs", Role::Submit),
    ("counterpoint.v1.Jobs", "DeleteJobs", Role::Submit),
    ("counterpoint.v1.Blobs", "FindMissing", Role::Submit),
    ("counterpoint.v1.Blobs", "Upload", Role::Submit),
    ("counterpoint.v1.Blobs", "PutBlob", Role::Submit),
    ("counterpoint.v1.Blobs", "Download", Role::Read),
    ("counterpoint.v1.Machines", "PutMachine", Role::Submit),
    ("counterpoint.v1.Machines", "GetMachine", Role::Read),
    ("counterpoint.v1.Machines", "ListMachines", Role::Read),
    ("counterpoint.v1.Machines", "CheckMachine", Role::Submit),
    ("counterpoint.v1.Machines", "DeleteMachine", Role::Submit),
    ("counterpoint.v1.Results", "GetListing", Role::Read),
    ("counterpoint.v1.Results", "GetTrace", Role::Read),
    ("counterpoint.v1.Results", "GetTimeline", Role::Read),
    ("counterpoint.v1.Results", "GetToolpath", Role::Read),
    ("counterpoint.v1.Results", "GetSummary", Role::Read),
    ("counterpoint.v1.Results", "GetEvents", Role::Read),
    ("counterpoint.v1.Results", "ListFiles", Role::Read),
    ("counterpoint.v1.Results", "GetFile", Role::Read),
    ("counterpoint.v1.Operator", "Attend", Role::Operate),
    ("counterpoint.v1.Operator", "WatchQuestions", Role::Operate),
    ("counterpoint.v1.Operator", "AnswerQuestion", Role::Operate),
    ("counterpoint.v1.Operator", "Debug", Role::Operate),
    ("counterpoint.v1.Admin", "ListConnections", Role::Admin),
    ("counterpoint.v1.Admin", "ListStreams", Role::Admin),
    ("counterpoint.v1.Admin", "ListWorkers", Role::Admin),
    ("counterpoint.v1.Admin", "Drain", Role::Admin),
    ("counterpoint.v1.Admin", "Collect", Role::Admin),
    ("counterpoint.v1.Admin", "CompactLedger", Role::Admin),
];

/// Name of the call of a path for metrics: one of few.
pub(crate) fn name(path: &str) -> &'static str {
    let Some((service, call)) = path.strip_prefix('/').and_then(|path| path.split_once('/')) else { return "other" };
    CALLS.iter().find(|(of, name, _)| *of == service && *name == call).map_or("other", |(_, name, _)| name)
}

/// Calls that are answered when the client or a job has done something, and streams that follow a job.
const LASTING: &[&str] = &["WatchJob", "WaitJob", "Upload", "Attend", "WatchQuestions", "Debug"];

/// Calls whose clients may send messages until the call ends; `other` includes reflection, but not health checks.
const SENDING: &[&str] = &["Upload", "Attend", "Debug", "other"];

/// The services of reflection.
const REFLECTION: [&str; 2] = ["grpc.reflection.v1.ServerReflection", "grpc.reflection.v1alpha.ServerReflection"];

/// Whether a client of the call of a path may send any number of messages.
pub(crate) fn sends_many(path: &str) -> bool {
    SENDING.contains(&name(path)) && !is_of_health(path)
}

/// Whether a path belongs to the health service, which callers without an identity may use.
pub(crate) fn is_of_health(path: &str) -> bool {
    path.starts_with("/grpc.health.v1.Health/")
}

/// Whether the call of a path ends with the rights of its caller: it may last for hours.
pub(crate) fn ends_with_rights(path: &str) -> bool {
    lasts(path) || name(path) == "WatchJobs" || is_of_reflection(path)
}

/// Whether a path belongs to the reflection service, whose clients may hold their stream open.
fn is_of_reflection(path: &str) -> bool {
    let service = path.strip_prefix('/').and_then(|path| path.split('/').next());
    service.is_some_and(|service| REFLECTION.contains(&service))
}

/// Whether the call of a path watches the health of the server until its client ends the call.
pub(crate) fn watches_health(path: &str) -> bool {
    path == "/grpc.health.v1.Health/Watch"
}

/// Whether the call of a path may last however fast the server is.
pub(crate) fn lasts(path: &str) -> bool {
    LASTING.contains(&name(path))
}

/// The role that the call of a path (`/service/call`) needs.
pub(crate) fn needs(path: &str) -> Needs {
    let Some((service, call)) = path.strip_prefix('/').and_then(|path| path.split_once('/')) else {
        return Needs::Unknown;
    };
    match service {
        "grpc.health.v1.Health" => Needs::Nothing,
        service if REFLECTION.contains(&service) => Needs::Role(Role::Read),
        _ => {
            let row = CALLS.iter().find(|(of, name, _)| *of == service && *name == call);
            row.map_or(Needs::Unknown, |(_, _, role)| Needs::Role(*role))
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use prost::Message as _;

    use super::*;

    #[test]
    fn every_call_of_the_contract_has_a_row() {
        let set = prost_types::FileDescriptorSet::decode(counterpoint_proto::DESCRIPTORS).unwrap();
        let mut calls = BTreeSet::new();
        for file in &set.file {
            for service in file.service.iter().filter(|_| file.package() == "counterpoint.v1") {
                let name = format!("{}.{}", file.package(), service.name());
                calls.extend(service.method.iter().map(|method| (name.clone(), method.name().to_owned())));
            }
        }
        let rows: BTreeSet<_> = CALLS.iter().map(|(of, name, _)| ((*of).to_owned(), (*name).to_owned())).collect();
        assert_eq!(rows, calls);
        assert_eq!(rows.len(), CALLS.len(), "no call has two rows");
    }

    #[test]
    fn what_is_not_in_the_table_is_unknown() {
        assert_eq!(needs("/counterpoint.v1.Jobs/SubmitJob"), Needs::Role(Role::Submit));
        assert_eq!(needs("/grpc.health.v1.Health/Watch"), Needs::Nothing);
        for path in ["", "/", "/counterpoint.v1.Jobs", "/counterpoint.v1.Jobs/", "/counterpoint.v1.Jobs/submitjob", "x"]
        {
            assert_eq!(needs(path), Needs::Unknown, "{path}");
        }
    }
}
