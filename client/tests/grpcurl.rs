//! Every line with `grpcurl` in docs/api.md is executed against a server, in order, as grpcurl would do it: the input
//! and output of a call are learned through reflection, messages come from JSON and go to JSON.

#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use bytes::{Buf as _, BufMut as _};
use counterpoint_server::options::ServerOptions;
use counterpoint_server::service;
use prost::Message as _;
use prost_reflect::{DescriptorPool, DynamicMessage, MessageDescriptor, MethodDescriptor};
use serde_json::Value;
use tonic::codec::{Codec, DecodeBuf, Decoder, EncodeBuf, Encoder};
use tonic::transport::Channel;
use tonic::{Request, Status};
use tonic_reflection::pb::v1::ServerReflectionRequest;
use tonic_reflection::pb::v1::server_reflection_client::ServerReflectionClient;
use tonic_reflection::pb::v1::server_reflection_request::MessageRequest;
use tonic_reflection::pb::v1::server_reflection_response::MessageResponse;

const DOCS: &str = include_str!("../../docs/api.md");

/// Messages of a type that is known at run time only.
struct Dynamic(MessageDescriptor);

impl Codec for Dynamic {
    type Encode = DynamicMessage;
    type Decode = DynamicMessage;
    type Encoder = Self;
    type Decoder = Self;

    fn encoder(&mut self) -> Self {
        Self(self.0.clone())
    }

    fn decoder(&mut self) -> Self {
        Self(self.0.clone())
    }
}

impl Encoder for Dynamic {
    type Item = DynamicMessage;
    type Error = Status;

    fn encode(&mut self, message: DynamicMessage, to: &mut EncodeBuf<'_>) -> Result<(), Status> {
        to.put_slice(&message.encode_to_vec());
        Ok(())
    }
}

impl Decoder for Dynamic {
    type Item = DynamicMessage;
    type Error = Status;

    fn decode(&mut self, from: &mut DecodeBuf<'_>) -> Result<Option<DynamicMessage>, Status> {
        let bytes = from.copy_to_bytes(from.remaining());
        let message = DynamicMessage::decode(self.0.clone(), bytes);
        message.map(Some).map_err(|error| Status::internal(error.to_string()))
    }
}

/// The answer of reflection.
struct Reflection(ServerReflectionClient<Channel>);

impl Reflection {
    async fn ask(&mut self, question: MessageRequest) -> MessageResponse {
        let request = ServerReflectionRequest { message_request: Some(question), ..Default::default() };
        let answer = self.0.server_reflection_info(tokio_stream::iter([request])).await.unwrap();
        answer.into_inner().message().await.unwrap().unwrap().message_response.unwrap()
    }

    async fn services(&mut self) -> Vec<String> {
        match self.ask(MessageRequest::ListServices(String::new())).await {
            MessageResponse::ListServicesResponse(list) => list.service.into_iter().map(|one| one.name).collect(),
            other => panic!("{other:?}"),
        }
    }

    /// The files that define a service, with all that they import.
    async fn files(&mut self, service: &str, known: &mut BTreeMap<String, prost_types::FileDescriptorProto>) {
        let mut questions = vec![MessageRequest::FileContainingSymbol(service.to_owned())];
        while let Some(question) = questions.pop() {
            let MessageResponse::FileDescriptorResponse(files) = self.ask(question).await else { panic!("{service}") };
            for file in files.file_descriptor_proto {
                let file = prost_types::FileDescriptorProto::decode(&*file).unwrap();
                let missing = file.dependency.iter().filter(|name| !known.contains_key(*name));
                questions.extend(missing.map(|name| MessageRequest::FileByFilename(name.clone())));
                known.insert(file.name().to_owned(), file);
            }
        }
    }
}

/// The call whose stream ends with its caller only.
const ENDLESS: &str = "WatchJobs";

/// Calls a method with messages in JSON; returns the answers in JSON.
async fn call(channel: &Channel, method: &MethodDescriptor, json: &str) -> Result<Vec<Value>, Status> {
    let objects = serde_json::Deserializer::from_str(json).into_iter::<Value>();
    let messages: Vec<DynamicMessage> = objects
        .map(|object| {
            DynamicMessage::deserialize(method.input(), object.unwrap()).expect("the message is one of the call")
        })
        .collect();
    assert!(method.is_client_streaming() || messages.len() == 1, "{json}");
    let path = format!("/{}/{}", method.parent_service().full_name(), method.name()).parse().unwrap();
    let mut client = tonic::client::Grpc::new(channel.clone());
    client.ready().await.unwrap();
    let request = Request::new(tokio_stream::iter(messages));
    let answer = client.streaming(request, path, Dynamic(method.output())).await?;
    let (mut stream, mut answers) = (answer.into_inner(), Vec::new());
    while let Some(message) = stream.message().await? {
        answers.push(serde_json::to_value(&message).unwrap());
        if method.name() == ENDLESS {
            break;
        }
    }
    Ok(answers)
}

/// Words of a line as a shell gives them to the program, with the variable `JOB`.
fn words(line: &str, job: &str) -> Vec<String> {
    let script = format!("grpcurl() {{ printf '%s\\n' grpcurl \"$@\"; }}\n{line}");
    let output = Command::new("sh").arg("-c").arg(script).env("JOB", job).output().unwrap();
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect()
}

/// Lines of the fence, those that end with `\` joined with the next ones.
fn lines() -> Vec<String> {
    let mut lines = Vec::new();
    let mut open = String::new();
    for line in DOCS.lines() {
        if line.starts_with("grpcurl ") || !open.is_empty() {
            open += line.trim_end_matches('\\');
            if !line.ends_with('\\') {
                lines.push(std::mem::take(&mut open));
            }
        }
    }
    lines
}

#[tokio::test]
async fn every_call_has_a_line_and_every_line_works() {
    let folder = tempfile::tempdir().unwrap();
    let listen = "127.0.0.1:0".parse().unwrap();
    let options = ServerOptions { listen, data: folder.path().to_owned(), ..ServerOptions::default() };
    let service = service::build(options).await.unwrap();
    let url = service.handle().url();
    let server = tokio::spawn(service.run(std::future::pending()));
    let channel = Channel::from_shared(url).unwrap().connect().await.unwrap();
    let mut reflection = Reflection(ServerReflectionClient::new(channel.clone()));
    let mut files = BTreeMap::new();
    let services = reflection.services().await;
    for service in services.iter().filter(|name| name.starts_with("counterpoint.")) {
        reflection.files(service, &mut files).await;
    }
    // A client needs these definitions to show a refusal.
    reflection.files("google.rpc.ErrorInfo", &mut files).await;
    let mut pool = DescriptorPool::new();
    pool.add_file_descriptor_protos(files.into_values()).unwrap();
    for detail in ["ErrorInfo", "BadRequest", "QuotaFailure", "RetryInfo"] {
        assert!(pool.get_message_by_name(&format!("google.rpc.{detail}")).is_some(), "{detail}");
    }
    let all: BTreeSet<String> = pool
        .services()
        .flat_map(|service| service.methods().map(|method| method.full_name().to_owned()).collect::<Vec<_>>())
        .collect();

    let (mut done, mut job) = (BTreeSet::new(), String::new());
    for line in lines() {
        let words = words(&line, &job);
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let ["grpcurl", "-plaintext", "-d", json, "127.0.0.1:7878", name] = words[..] else {
            panic!("the line has another form: {line}")
        };
        let (service, method) = name.rsplit_once('/').unwrap();
        let service = pool.get_service_by_name(service).unwrap_or_else(|| panic!("no service: {line}"));
        let method = service.methods().find(|one| one.name() == method).unwrap_or_else(|| panic!("no call: {line}"));
        let answers = call(&channel, &method, json).await;
        let answers = answers.unwrap_or_else(|status| panic!("{line}: {status}"));
        assert!(!answers.is_empty() || method.is_server_streaming(), "{line}");
        if method.name() == "SubmitJob" {
            answers[0]["status"]["jobId"].as_str().unwrap().clone_into(&mut job);
        }
        done.insert(method.full_name().to_owned());
    }
    assert_eq!(done, all, "every call of the contract has a line in docs/api.md");
    // No job is left that would need the grace time.
    tokio::time::timeout(std::time::Duration::from_secs(20), server).await.expect("Drain stops it").unwrap().unwrap();
}
