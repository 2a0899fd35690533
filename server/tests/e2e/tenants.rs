//! Two tenants: neither sees, stops, reads or reuses data of the other.

use counterpoint_proto::v1;
use counterpoint_server::access::Role;
use counterpoint_server::options::{Retention, ServerOptions};
use counterpoint_server::{backup, doctor};

use crate::guarded::*;
use crate::support::*;

const LATHE: &str = "fanuc-2path-lathe";

struct Two {
    server: Server,
    options: ServerOptions,
    one: As,
    other: As,
}

async fn two(folder: &std::path::Path) -> Two {
    let options = guarded(folder);
    let tokens = ["one", "other"].map(|tenant| grant(&options, "admin", tenant, Role::Admin));
    let server = Server::start(options.clone()).await;
    let [one, other] = tokens.map(|token| As::new(&server, &token));
    Two { server, options, one, other }
}

#[tokio::test]
async fn request_ids_and_machines_belong_to_their_tenant_also_after_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let Two { server, options, one, other } = two(folder.path()).await;
    let first = one.submit("r", LATHE, "EVENTS 3").await.unwrap().job_id;
    let second = other.submit("r", LATHE, "EVENTS 4").await.unwrap().job_id;
    assert_ne!(first, second);
    let own = one.put_machine("own", "of one").await.unwrap();
    let get = |name: &str| v1::GetMachineRequest { name: name.into(), ..Default::default() };
    let pinned = format!("own@{}", own.revision);
    for (name, expected) in [("own", "UNKNOWN_MACHINE"), (&pinned, "UNKNOWN_MACHINE"), ("one/own", "INVALID_REQUEST")] {
        let status = other.machines().get_machine(get(name)).await.unwrap_err();
        assert_eq!(reason(&status), expected, "{name}");
    }
    assert_eq!(reason(&other.submit("m", "own", "EVENTS 1").await.unwrap_err()), "UNKNOWN_MACHINE");
    other.put_machine("own", "of other").await.unwrap();
    server.stop().await;
    let server = Server::start(options).await;
    for (caller, events, description) in [(one, 3, "of one"), (other, 4, "of other")] {
        let caller = As { connection: server.connection.clone(), ..caller };
        let again = caller.submit("r", LATHE, &format!("EVENTS {events}")).await.unwrap();
        assert!(again.job_id == first || again.job_id == second);
        assert_eq!(caller.wait(&again.job_id).await.events, events);
        let machine = caller.machines().get_machine(get("own")).await.unwrap().into_inner().machine.unwrap();
        assert_eq!(machine.description, description);
        let all =
            caller.machines().list_machines(v1::ListMachinesRequest::default()).await.unwrap().into_inner().machines;
        assert_eq!(all.iter().filter(|machine| !machine.shipped).count(), 1);
        let job = caller.submit("own", "own", "EVENTS 1").await.unwrap().job_id;
        assert_eq!(caller.wait(&job).await.state(), v1::JobState::Succeeded);
    }
    server.stop().await;
}

#[tokio::test]
async fn a_file_is_there_only_for_the_tenant_that_has_uploaded_it() {
    let folder = tempfile::tempdir().unwrap();
    let Two { server, one, other, .. } = two(folder.path()).await;
    let secret = one.upload(b"EVENTS 5").await.unwrap();
    let ask = || v1::FindMissingRequest { digests: vec![secret.clone()] };
    assert!(one.blobs().find_missing(ask()).await.unwrap().into_inner().digests.is_empty());
    let missing = other.blobs().find_missing(ask()).await.unwrap().into_inner().digests;
    assert_eq!(missing, std::slice::from_ref(&secret));
    let download = v1::DownloadRequest { digest: secret.clone() };
    assert_eq!(reason(&other.blobs().download(download).await.unwrap_err()), "UNKNOWN_BLOB");
    let request = v1::SubmitJobRequest {
        request_id: "steal".into(),
        machine: LATHE.into(),
        programs: vec![v1::Program { path: "main.nc".into(), ..Default::default() }],
        files: vec![v1::FileRef { path: "main.nc".into(), digest: secret.clone() }],
        ..Default::default()
    };
    assert_eq!(reason(&other.jobs().submit_job(request).await.unwrap_err()), "MISSING_BLOBS");
    let file = v1::MachineFile { path: "m/machine.toml".into(), digest: secret };
    let check = v1::CheckMachineRequest { name: "m".into(), files: vec![file] };
    assert_eq!(reason(&other.machines().check_machine(check).await.unwrap_err()), "MISSING_BLOBS");
    server.stop().await;
}

/// The digest of a foreign file neither makes a machine nor passes for an upload; nothing is stored.
#[tokio::test]
async fn no_machine_is_made_of_the_files_of_another_tenant_or_of_paths_that_lead_out() {
    let folder = tempfile::tempdir().unwrap();
    let Two { server, one, other, .. } = two(folder.path()).await;
    let theirs = one.upload(b"extends = \"fanuc-mill\"\n[ce]\nname = \"own\"\n").await.unwrap();
    let own = other.upload(b"extends = \"fanuc-mill\"\n[ce]\nname = \"own\"\n# mine\n").await.unwrap();
    let file = |path: &str, digest: &str| v1::MachineFile { path: path.into(), digest: digest.into() };
    let put = async |files: Vec<v1::MachineFile>| {
        let request = v1::PutMachineRequest { name: "own".into(), files };
        reason(&other.machines().put_machine(request).await.unwrap_err())
    };
    let machine = file("own/machine.toml", &own);
    assert_eq!(put(vec![file("own/machine.toml", &theirs)]).await, "MISSING_BLOBS");
    assert_eq!(put(vec![machine.clone(), file("own/part.mac", &theirs)]).await, "MISSING_BLOBS");
    for path in ["../machine.toml", "own/../../x", "/etc/machine.toml", "own/./x", "own\\x", "C:/x", "..", ""] {
        assert_eq!(put(vec![machine.clone(), file(path, &own)]).await, "INVALID_REQUEST", "{path}");
        let check = v1::CheckMachineRequest { name: "own".into(), files: vec![machine.clone(), file(path, &own)] };
        assert_eq!(reason(&other.machines().check_machine(check).await.unwrap_err()), "INVALID_REQUEST", "{path}");
    }
    let empty = v1::UploadRequest { digest: theirs.clone(), ..Default::default() };
    let claimed = other.blobs().upload(tokio_stream::iter([empty])).await.unwrap_err();
    assert_eq!(reason(&claimed), "DIGEST_MISMATCH");
    let find = v1::FindMissingRequest { digests: vec![theirs.clone()] };
    assert_eq!(other.blobs().find_missing(find).await.unwrap().into_inner().digests, [theirs]);
    let list = v1::ListMachinesRequest::default();
    let machines = other.machines().list_machines(list).await.unwrap().into_inner().machines;
    assert!(machines.iter().all(|machine| machine.shipped), "{machines:?}");
    let request = v1::PutMachineRequest { name: "own".into(), files: vec![machine] };
    other.machines().put_machine(request).await.unwrap();
    server.stop().await;
}

#[tokio::test]
async fn files_of_tenants_are_collected_examined_and_backed_up_like_others() {
    let folder = tempfile::tempdir().unwrap();
    let Two { server, options, one, other } = two(folder.path()).await;
    for caller in [&one, &other] {
        let job = caller.submit("r", LATHE, "EVENTS 3").await.unwrap().job_id;
        caller.wait(&job).await;
    }
    one.put_machine("own", "of one").await.unwrap();
    let stray = other.upload(b"nobody needs it").await.unwrap();
    server.stop().await;
    let data = &options.data;
    assert_eq!(doctor::examine(data, false).unwrap(), []);
    let copy = folder.path().join("copy");
    let contents = backup::backup(data, &copy).unwrap();
    assert_eq!((contents.jobs, contents.blobs, contents.left_out), (2, 3, 0));
    assert_eq!(doctor::examine(&copy, false).unwrap(), []);

    let place = |digest: &str| data.join("blobs/@other").join(&digest[..2]).join(digest);
    let kept = place(&digest(b"EVENTS 3"));
    let server = Server::start(ServerOptions {
        retention: Retention { blob_grace_s: 0, ..Retention::default() },
        ..options.clone()
    })
    .await;
    for _ in 0..2000 {
        if !place(&stray).exists() {
            break;
        }
        tokio::time::sleep(std::time::Duration::from_millis(5)).await;
    }
    assert!(!place(&stray).exists() && kept.exists(), "what no job of its tenant needs is collected");
    server.stop().await;
    std::fs::write(&kept, "changed").unwrap();
    let found = doctor::examine(data, true).unwrap();
    assert!(found.iter().any(|damage| damage.path == kept && damage.repaired), "{found:?}");
    assert!(data.join("blobs/@one").join(&digest(b"EVENTS 3")[..2]).join(digest(b"EVENTS 3")).exists());
}
