//! The contract as data: calls with their required roles, and calls by path with messages as bytes.

use std::collections::BTreeSet;

use bytes::{Buf as _, BufMut as _};
use counterpoint_proto::DESCRIPTORS;
use counterpoint_server::access::Role;
use prost::Message as _;
use prost_types::{DescriptorProto, FileDescriptorSet};
use tokio_stream::Stream;
use tonic::client::Grpc;
use tonic::codec::{Codec, DecodeBuf, Decoder, EncodeBuf, Encoder};
use tonic::codegen::http::uri::PathAndQuery;
use tonic::service::interceptor::InterceptedService;
use tonic::{Request, Status, Streaming};

use crate::guarded::As;

/// The calls of each role by the table of roles in `docs/security.md`. `Drain` comes last because it ends the server.
pub const ROLES: [(Role, &[&str]); 4] = [
    (
        Role::Read,
        &[
            "Jobs/GetJob",
            "Jobs/ListJobs",
            "Jobs/WatchJob",
            "Jobs/WaitJob",
            "Jobs/WatchJobs",
            "Blobs/Download",
            "Machines/GetMachine",
            "Machines/ListMachines",
            "Results/GetListing",
            "Results/GetTrace",
            "Results/GetTimeline",
            "Results/GetToolpath",
            "Results/GetSummary",
            "Results/GetEvents",
            "Results/ListFiles",
            "Results/GetFile",
        ],
    ),
    (
        Role::Submit,
        &[
            "Jobs/SubmitJob",
            "Jobs/CancelJob",
            "Jobs/CancelJobs",
            "Jobs/DeleteJob",
            "Jobs/DeleteJobs",
            "Jobs/RerunJob",
            "Jobs/PauseJob",
            "Jobs/ResumeJob",
            "Blobs/FindMissing",
            "Blobs/Upload",
            "Blobs/PutBlob",
            "Machines/PutMachine",
            "Machines/CheckMachine",
            "Machines/DeleteMachine",
        ],
    ),
    (Role::Operate, &["Operator/Attend", "Operator/WatchQuestions", "Operator/AnswerQuestion", "Operator/Debug"]),
    (
        Role::Admin,
        &[
            "Admin/ListConnections",
            "Admin/ListStreams",
            "Admin/ListWorkers",
            "Admin/Collect",
            "Admin/CompactLedger",
            "Admin/Drain",
        ],
    ),
];

/// A call of a set of descriptors.
pub struct Method {
    /// Path on the wire: `/package.Service/Call`.
    pub path: String,
    pub request: DescriptorProto,
}

impl Method {
    /// Service and call without the package.
    pub fn name(&self) -> &str {
        self.path.trim_start_matches("/counterpoint.v1.")
    }

    /// The number of a field of the request.
    pub fn field(&self, name: &str) -> Option<u32> {
        let field = self.request.field.iter().find(|field| field.name() == name);
        field.map(|field| u32::try_from(field.number()).unwrap())
    }
}

/// The calls in a set of descriptors.
pub fn methods(descriptors: &[u8]) -> Vec<Method> {
    let set = FileDescriptorSet::decode(descriptors).unwrap();
    let mut methods = Vec::new();
    for file in &set.file {
        for service in &file.service {
            for method in &service.method {
                let mut request = set.file.iter().flat_map(|file| {
                    let named = |message: &&DescriptorProto| {
                        method.input_type() == format!(".{}.{}", file.package(), message.name())
                    };
                    file.message_type.iter().find(named)
                });
                methods.push(Method {
                    path: format!("/{}.{}/{}", file.package(), service.name(), method.name()),
                    request: request.next().unwrap().clone(),
                });
            }
        }
    }
    methods
}

/// Path of a call of the contract.
pub fn path(call: &str) -> String {
    format!("/counterpoint.v1.{call}")
}

/// A text field of a message, on the wire.
pub fn text(number: u32, value: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    prost::encoding::string::encode(number, &value.to_owned(), &mut bytes);
    bytes
}

/// Messages as their bytes.
#[derive(Default)]
struct Raw;

impl Codec for Raw {
    type Encode = Vec<u8>;
    type Decode = Vec<u8>;
    type Encoder = Self;
    type Decoder = Self;

    fn encoder(&mut self) -> Self {
        Self
    }

    fn decoder(&mut self) -> Self {
        Self
    }
}

impl Encoder for Raw {
    type Item = Vec<u8>;
    type Error = Status;

    fn encode(&mut self, item: Vec<u8>, out: &mut EncodeBuf<'_>) -> Result<(), Status> {
        out.put_slice(&item);
        Ok(())
    }
}

impl Decoder for Raw {
    type Item = Vec<u8>;
    type Error = Status;

    fn decode(&mut self, from: &mut DecodeBuf<'_>) -> Result<Option<Vec<u8>>, Status> {
        Ok(Some(from.copy_to_bytes(from.remaining()).to_vec()))
    }
}

/// Makes a call by its path with these messages; returns its answers, or its refusal.
pub async fn call(
    caller: &As,
    path: &str,
    messages: impl Stream<Item = Vec<u8>> + Send + 'static,
) -> Result<Streaming<Vec<u8>>, Status> {
    let mut client = Grpc::new(InterceptedService::new(caller.connection.clone(), caller.bearer.clone()));
    client.ready().await.unwrap();
    let path = PathAndQuery::try_from(path).unwrap();
    Ok(client.streaming(Request::new(messages), path, Raw).await?.into_inner())
}

/// Makes a call with one message.
pub async fn ask(caller: &As, path: &str, message: Vec<u8>) -> Result<Streaming<Vec<u8>>, Status> {
    call(caller, path, tokio_stream::once(message)).await
}

#[test]
fn every_call_of_the_contract_has_one_documented_role() {
    let methods = methods(DESCRIPTORS);
    let calls: BTreeSet<_> = methods.iter().map(Method::name).collect();
    let listed: Vec<_> = ROLES.iter().flat_map(|(_, calls)| calls.iter().copied()).collect();
    assert_eq!(listed.iter().copied().collect::<BTreeSet<_>>(), calls);
    assert_eq!(listed.len(), calls.len(), "no call has two roles");
}
