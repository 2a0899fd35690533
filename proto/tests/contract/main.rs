//! The wire contract: how it is written, and that nothing of it is ever taken back.
//!
//! `baseline.binpb` holds the descriptors of the contract that clients may rely on. Additions are entered with
//! `UPDATE=1 cargo test --package counterpoint-proto --test contract`. The rules are those of `buf.yaml` (STANDARD and
//! COMMENTS for writing, FILE for changes), so that `buf lint` and `buf breaking` find the same.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test")]

mod breaking;
mod lint;

use prost::Message as _;
use prost_types::FileDescriptorSet;

/// The contract as it is now, without the files of the protobuf project itself.
fn contract() -> FileDescriptorSet {
    let mut set = FileDescriptorSet::decode(counterpoint_proto::DESCRIPTORS).unwrap();
    set.file.retain(|file| file.package().starts_with("counterpoint."));
    set
}

fn baseline_path() -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("baseline.binpb")
}

#[test]
fn it_is_written_by_the_rules() {
    assert_eq!(lint::findings(&contract()), [""; 0]);
}

#[test]
fn it_keeps_what_clients_rely_on() {
    let now = contract();
    if let Ok(bytes) = std::fs::read(baseline_path()) {
        let before = FileDescriptorSet::decode(bytes.as_slice()).unwrap();
        assert_eq!(breaking::findings(&before, &now), [""; 0]);
    }
    let mut kept = now;
    kept.file.iter_mut().for_each(|file| file.source_code_info = None);
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(baseline_path(), kept.encode_to_vec()).unwrap();
    }
    let baseline = FileDescriptorSet::decode(std::fs::read(baseline_path()).unwrap().as_slice()).unwrap();
    assert!(baseline == kept, "the contract has grown: enter the additions with UPDATE=1");
}

/// The contract after a change of its event file.
fn changed(change: impl FnOnce(&mut prost_types::FileDescriptorProto)) -> FileDescriptorSet {
    let mut set = contract();
    change(set.file.iter_mut().find(|file| file.name() == "counterpoint/v1/event.proto").unwrap());
    set
}

#[test]
fn what_breaks_clients_is_found() {
    let found = |change: fn(&mut prost_types::FileDescriptorProto)| breaking::findings(&contract(), &changed(change));
    let one = |findings: Vec<String>, part: &str| {
        assert!(findings.len() == 1 && findings[0].contains(part), "{part}: {findings:?}");
    };
    one(found(|file| drop(file.message_type.pop())), "was removed");
    one(found(|file| drop(file.enum_type[0].value.pop())), "was removed");
    one(found(|file| drop(file.message_type[1].field.pop())), "was removed");
    one(found(|file| file.message_type[0].field[0].name = Some("other".to_owned())), "name");
    one(found(|file| file.message_type[0].field[0].set_type(prost_types::field_descriptor_proto::Type::Bool)), "type");
    one(found(|file| file.enum_type[0].value[1].name = Some("PHASE_OTHER".to_owned())), "name");
    one(found(|file| file.options = None), "go_package");
    let jobs = |change: fn(&mut prost_types::MethodDescriptorProto)| {
        let mut now = contract();
        let file = now.file.iter_mut().find(|file| file.name() == "counterpoint/v1/jobs.proto").unwrap();
        change(&mut file.service[0].method[0]);
        breaking::findings(&contract(), &now)
    };
    one(jobs(|method| method.server_streaming = Some(true)), "stream");
    one(jobs(|method| method.output_type = Some(".counterpoint.v1.Event".to_owned())), "answers with");
    let mut less = contract();
    less.file.pop();
    one(breaking::findings(&contract(), &less), "was removed");
    assert_eq!(breaking::findings(&less, &contract()), [""; 0], "additions are fine");
}

#[test]
fn what_is_not_written_by_the_rules_is_found() {
    let found = |change: fn(&mut prost_types::FileDescriptorProto)| lint::findings(&changed(change));
    let some = |findings: Vec<String>, part: &str| {
        assert!(findings.iter().any(|finding| finding.contains(part)), "{part}: {findings:?}");
    };
    some(found(|file| file.message_type[0].field[0].name = Some("aField".to_owned())), "lower_snake_case");
    some(found(|file| file.message_type[0].name = Some("event_batch".to_owned())), "PascalCase");
    let phase: fn(&mut prost_types::FileDescriptorProto) = |file| {
        let phase = file.enum_type.iter_mut().find(|one| one.name() == "Phase").unwrap();
        phase.value[1].name = Some("RUNNING".to_owned());
    };
    some(found(phase), "PHASE_");
    some(found(|file| file.enum_type[0].value[0].name = Some("PHASE_NONE".to_owned())), "_UNSPECIFIED");
    some(found(|file| file.package = Some("counterpoint".to_owned())), "version");
    some(found(|file| file.options = None), "go_package");
    some(found(|file| file.source_code_info = None), "comment");
    let mut set = contract();
    let file = set.file.iter_mut().find(|file| file.name() == "counterpoint/v1/jobs.proto").unwrap();
    file.service[0].method[0].input_type = Some(".counterpoint.v1.GetJobRequest".to_owned());
    some(lint::findings(&set), "SubmitJobRequest");
}
