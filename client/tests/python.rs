//! The Python package and its types against a server; skipped where Python has no grpcio.

#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stderr)]

use std::path::Path;
use std::process::Command;

use counterpoint_server::options::Options;
use counterpoint_server::service;

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        if entry.file_type().unwrap().is_file() {
            std::fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
        }
    }
}

#[test]
fn the_python_package_submits_watches_and_draws() {
    let python = std::env::var("COUNTERPOINT_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let probe = Command::new(&python).args(["-c", "import grpc, grpc_tools, mypy_protobuf"]).output();
    if !probe.is_ok_and(|output| output.status.success()) {
        eprintln!(
            "skipped: {python} has no grpcio, grpcio-tools and mypy-protobuf (COUNTERPOINT_PYTHON names another interpreter)"
        );
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("../clients/python");
    let out = folder.path().join("package");
    copy(&package.join("counterpoint"), &out.join("counterpoint"));
    let generated = Command::new(&python).arg(package.join("generate.py")).arg("--out").arg(&out).output().unwrap();
    assert!(generated.status.success(), "{}", String::from_utf8_lossy(&generated.stderr));
    for types in ["jobs_pb2.pyi", "jobs_pb2_grpc.pyi"] {
        assert!(out.join("counterpoint/v1").join(types).is_file(), "messages and stubs have types");
    }
    if Command::new(&python).args(["-c", "import mypy"]).output().unwrap().status.success() {
        let mut check = Command::new(&python);
        check.args(["-m", "mypy", "--strict", "--cache-dir"]).arg(folder.path().join("mypy")).arg("counterpoint");
        let output = check.current_dir(&out).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    }
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
    let listen = "127.0.0.1:0".parse().unwrap();
    let options = Options { listen, data: folder.path().join("data"), grace_s: 0, ..Options::default() };
    let service = runtime.block_on(service::build(options)).unwrap();
    let address = service.handle().address().to_string();
    runtime.spawn(service.run(std::future::pending()));
    let mut test = Command::new(&python);
    test.arg(package.join("tests/test_client.py")).env("PYTHONPATH", &out).env("COUNTERPOINT_TEST_SERVER", &address);
    let output = test.env("PYTHONDONTWRITEBYTECODE", "1").output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));

    let examples = package.join("../../examples");
    let drawing = folder.path().join("timeline.svg");
    let mut example = Command::new(&python);
    example.arg(examples.join("python/submit_and_watch.py")).args(["--server", &address]);
    example.args(["--machine", "fanuc-2path-lathe", "--timeline"]).arg(&drawing);
    example.args(["upper.nc", "lower.nc"].map(|name| examples.join("two-turret").join(name)));
    let output = example.env("PYTHONPATH", &out).env("PYTHONDONTWRITEBYTECODE", "1").output().unwrap();
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{printed}{}", String::from_utf8_lossy(&output.stderr));
    assert!(printed.contains("SUCCEEDED after"), "{printed}");
    for (wrong, code, text) in [
        (["--server", "127.0.0.1:1"], 3, "no server without TLS answers at 127.0.0.1:1"),
        (["--machine", "fanuc-mil"], 2, "no machine 'fanuc-mil': the server has"),
    ] {
        let mut example = Command::new(&python);
        example.arg(examples.join("python/submit_and_watch.py")).args(["--server", &address]).args(wrong);
        example.arg(examples.join("two-turret/upper.nc")).env("PYTHONPATH", &out).env("PYTHONDONTWRITEBYTECODE", "1");
        let output = example.output().unwrap();
        let printed = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), printed.lines().count()), (Some(code), 1), "{printed}");
        assert!(printed.contains(text), "{printed}");
    }
    assert!(std::fs::read_to_string(drawing).unwrap().starts_with("<svg"));
}
