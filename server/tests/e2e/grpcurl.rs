//! The lines with `grpcurl` in `docs/api.md`, executed in their order against a server, as that tool would: the
//! contract comes from the reflection of the server, and the JSON is read by it.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead as _, BufReader};
use std::process::{Command, Stdio};

use prost::Message as _;
use prost_reflect::{DescriptorPool, DynamicMessage, MessageDescriptor, MethodDescriptor};
use prost_types::{FileDescriptorProto, FileDescriptorSet};
use serde_json::Value;
use tonic::codec::{Codec, DecodeBuf, Decoder, EncodeBuf, Encoder};
use tonic::transport::Channel;
use tonic::{Request, Status};
use tonic_reflection::pb::v1 as reflection;

/// Messages that are known by their description only; this one is of the answers.
#[derive(Clone)]
struct Dynamic(MessageDescriptor);

impl Encoder for Dynamic {
    type Item = DynamicMessage;
    type Error = Status;

    fn encode(&mut self, item: DynamicMessage, out: &mut EncodeBuf<'_>) -> Result<(), Status> {
        item.encode(out).map_err(|error| Status::internal(error.to_string()))
    }
}

impl Decoder for Dynamic {
    type Item = DynamicMessage;
    type Error = Status;

    fn decode(&mut self, bytes: &mut DecodeBuf<'_>) -> Result<Option<DynamicMessage>, Status> {
        let message = DynamicMessage::decode(self.0.clone(), bytes);
        message.map(Some).map_err(|error| Status::internal(error.to_string()))
    }
}

impl Codec for Dynamic {
    type Encode = DynamicMessage;
    type Decode = DynamicMessage;
    type Encoder = Self;
    type Decoder = Self;

    fn encoder(&mut self) -> Self {
        self.clone()
    }

    fn decoder(&mut self) -> Self {
        self.clone()
    }
}

/// The contract as the server reports it: the files of its services and all their imports.
async fn contract(connection: &Channel) -> DescriptorPool {
    use reflection::server_reflection_request::MessageRequest::{FileByFilename, FileContainingSymbol, ListServices};
    use reflection::server_reflection_response::MessageResponse;
    let mut client = reflection::server_reflection_client::ServerReflectionClient::new(connection.clone());
    let mut open = vec![ListServices(String::new())];
    let (mut files, mut asked) = (BTreeMap::new(), BTreeSet::new());
    while let Some(question) = open.pop() {
        let request = reflection::ServerReflectionRequest { host: String::new(), message_request: Some(question) };
        let answers = client.server_reflection_info(tokio_stream::iter([request])).await.unwrap();
        match answers.into_inner().message().await.unwrap().unwrap().message_response.unwrap() {
            MessageResponse::ListServicesResponse(list) => {
                let own = list.service.into_iter().filter(|service| service.name.starts_with("counterpoint."));
                open.extend(own.map(|service| FileContainingSymbol(service.name)));
            }
            MessageResponse::FileDescriptorResponse(found) => {
                for bytes in found.file_descriptor_proto {
                    let file = FileDescriptorProto::decode(&*bytes).unwrap();
                    let new = file.dependency.iter().filter(|name| asked.insert((*name).clone()));
                    open.extend(new.cloned().map(FileByFilename));
                    files.insert(file.name().to_owned(), file);
                }
            }
            other => panic!("{other:?}"),
        }
    }
    let set = FileDescriptorSet { file: files.into_values().collect() };
    DescriptorPool::decode(&*set.encode_to_vec()).unwrap()
}

/// JSON and name of the call of each line, in the order of the page.
fn lines() -> Vec<(String, String)> {
    let page = include_str!("../../../docs/api.md").split_once("## Every call with grpcurl").unwrap().1;
    let block = page.split_once("```sh\n").unwrap().1.split_once("```").unwrap().0.replace("\\\n", " ");
    let line = |line: &str| {
        let (data, place) = line.strip_prefix("grpcurl -plaintext -d '").unwrap().rsplit_once("' ").unwrap();
        let call = place.trim().strip_prefix("127.0.0.1:7878 ").unwrap();
        (data.to_owned(), call.trim().to_owned())
    };
    block.lines().filter(|text| !text.is_empty()).map(line).collect()
}

/// All answers to a call; only the first of one that never ends.
async fn answers(connection: &Channel, call: &MethodDescriptor, data: &str) -> Result<Vec<Value>, Status> {
    let requests: Vec<DynamicMessage> = serde_json::Deserializer::from_str(data)
        .into_iter::<Value>()
        .map(|value| DynamicMessage::deserialize(call.input(), value.unwrap()).unwrap())
        .collect();
    let path = format!("/{}/{}", call.parent_service().full_name(), call.name());
    let mut client = tonic::client::Grpc::new(connection.clone());
    client.ready().await.unwrap();
    let request = Request::new(tokio_stream::iter(requests));
    let mut stream = client.streaming(request, path.parse().unwrap(), Dynamic(call.output())).await?.into_inner();
    let mut answers = Vec::new();
    while let Some(answer) = stream.message().await? {
        answers.push(serde_json::to_value(&answer).unwrap());
        if call.name() == "WatchJobs" {
            break;
        }
    }
    Ok(answers)
}

#[tokio::test]
async fn every_line_with_grpcurl_in_the_page_of_the_contract_works_and_no_call_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpointd"));
    command.args(["--listen", "127.0.0.1:0", "--grace-s", "0", "--data"]).arg(folder.path().join("try"));
    let mut server = command.stdout(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(server.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let url = line.trim().strip_prefix("listening on ").unwrap().to_owned();
    let connection = Channel::from_shared(url).unwrap().connect().await.unwrap();
    let pool = contract(&connection).await;
    let calls: BTreeMap<String, MethodDescriptor> = pool
        .services()
        .flat_map(|service| service.methods().collect::<Vec<_>>())
        .map(|call| (format!("{}/{}", call.parent_service().full_name(), call.name()), call))
        .collect();

    let (mut job, mut done) = (String::new(), BTreeSet::new());
    for (data, name) in lines() {
        let call = calls.get(&name).unwrap_or_else(|| panic!("the contract has no call {name}"));
        let data = data.replace("'$JOB'", &job);
        let answers = answers(&connection, call, &data).await.unwrap_or_else(|error| panic!("{name} {data}: {error}"));
        assert!(!answers.is_empty(), "{name} {data}");
        match call.name() {
            "SubmitJob" => job = answers[0]["status"]["jobId"].as_str().unwrap().to_owned(),
            "WaitJob" => assert_eq!(answers[0]["status"]["state"], "JOB_STATE_SUCCEEDED"),
            _ => {}
        }
        done.insert(name);
    }
    assert_eq!(done, calls.into_keys().collect(), "every call has a line");
    assert_eq!(server.wait().unwrap().code(), Some(0), "the last line ends the server");
}
