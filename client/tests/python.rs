//! The Python package, its types and its example against servers; skipped where Python has no grpcio.

#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stderr)]

mod guarded;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use counterpoint_server::options::ServerOptions;
use counterpoint_server::service;

/// Variables that would change the tests.
const VARIABLES: [&str; 6] = [
    "COUNTERPOINT_SERVER",
    "COUNTERPOINT_TOKEN",
    "COUNTERPOINT_CA",
    "COUNTERPOINT_CLIENT_CERT",
    "COUNTERPOINT_CLIENT_KEY",
    "TRACEPARENT",
];

/// An interpreter with the packages that the client needs, and a copy of the client with its generated modules.
struct Python {
    interpreter: String,
    /// The folder `clients/python`.
    source: PathBuf,
    /// The folder of the copy.
    package: PathBuf,
}

impl Python {
    /// `None` if the interpreter does not have the packages.
    fn new(folder: &Path) -> Option<Self> {
        let interpreter = std::env::var("COUNTERPOINT_PYTHON").unwrap_or_else(|_| "python3".to_owned());
        let probe = Command::new(&interpreter).args(["-c", "import grpc, grpc_tools, mypy_protobuf"]).output();
        if !probe.is_ok_and(|output| output.status.success()) {
            eprintln!(
                "skipped: {interpreter} has no grpcio, grpcio-tools and mypy-protobuf (COUNTERPOINT_PYTHON names another \
                 interpreter)"
            );
            return None;
        }
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../clients/python");
        let package = folder.join("package");
        copy(&source.join("counterpoint"), &package.join("counterpoint"));
        let python = Self { interpreter, source, package };
        let generated =
            python.command().arg(python.source.join("generate.py")).arg("--out").arg(&python.package).output();
        let generated = generated.unwrap();
        assert!(generated.status.success(), "{}", text(&generated));
        Some(python)
    }

    fn command(&self) -> Command {
        let mut command = Command::new(&self.interpreter);
        for name in VARIABLES {
            command.env_remove(name);
        }
        command.env("PYTHONPATH", &self.package).env("PYTHONDONTWRITEBYTECODE", "1");
        command
    }

    fn example(&self) -> Command {
        let mut command = self.command();
        command.arg(self.examples().join("python/submit_and_watch.py"));
        command
    }

    fn examples(&self) -> PathBuf {
        self.source.join("../../examples")
    }
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        if entry.file_type().unwrap().is_file() {
            std::fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
        }
    }
}

fn text(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// Starts a server; returns its port.
fn serve(runtime: &tokio::runtime::Runtime, data: &Path, options: ServerOptions) -> u16 {
    let listen = "127.0.0.1:0".parse().unwrap();
    let options = ServerOptions { listen, data: data.to_owned(), grace_s: 0, ..options };
    let service = runtime.block_on(service::build(options)).unwrap();
    let port = service.handle().address().port();
    runtime.spawn(service.run(std::future::pending()));
    port
}

#[test]
fn the_python_package_does_as_it_is_documented() {
    let folder = tempfile::tempdir().unwrap();
    let Some(python) = Python::new(folder.path()) else { return };
    for types in ["v1/jobs_pb2.pyi", "v1/jobs_pb2_grpc.pyi", "refusal_pb2.pyi"] {
        assert!(python.package.join("counterpoint").join(types).is_file(), "messages and stubs have types");
    }
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
    let options = guarded::options(folder.path());
    let mut mutual = options.clone();
    mutual.guard.tls_client_ca = folder.path().join("ca.pem");
    let plain = serve(&runtime, &folder.path().join("plain"), ServerOptions::default());
    let encrypted = serve(&runtime, &folder.path().join("encrypted"), options);
    let mutual = serve(&runtime, &folder.path().join("mutual"), mutual);
    let mut test = python.command();
    test.args(["-m", "unittest", "discover", "-s"]).arg(python.source.join("tests"));
    test.env("COUNTERPOINT_TEST_SERVER", format!("127.0.0.1:{plain}"));
    test.env("COUNTERPOINT_TEST_TLS_SERVER", format!("localhost:{encrypted}"));
    test.env("COUNTERPOINT_TEST_MUTUAL_SERVER", format!("localhost:{mutual}"));
    let output = test.env("COUNTERPOINT_TEST_FOLDER", folder.path()).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
}

#[test]
fn the_types_of_package_tests_and_example_are_right() {
    let folder = tempfile::tempdir().unwrap();
    let Some(python) = Python::new(folder.path()) else { return };
    if !python.command().args(["-c", "import mypy"]).output().unwrap().status.success() {
        eprintln!("skipped: {} has no mypy", python.interpreter);
        return;
    }
    let mut check = python.command();
    check.args(["-m", "mypy", "--strict", "--cache-dir"]).arg(folder.path().join("mypy"));
    check.args(["-p", "counterpoint"]);
    let output = check.current_dir(&python.package).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    let mut check = python.command();
    check.args(["-m", "mypy", "--strict", "--cache-dir"]).arg(folder.path().join("mypy"));
    check.arg(python.source.join("tests")).arg(python.examples().join("python/submit_and_watch.py"));
    let output = check.env("MYPYPATH", &python.package).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
}

#[test]
fn the_example_submits_watches_and_draws() {
    let folder = tempfile::tempdir().unwrap();
    let Some(python) = Python::new(folder.path()) else { return };
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
    let options = guarded::options(folder.path());
    let plain = format!("http://127.0.0.1:{}", serve(&runtime, &folder.path().join("plain"), ServerOptions::default()));
    let encrypted = format!("https://localhost:{}", serve(&runtime, &folder.path().join("encrypted"), options));
    let programs = ["upper.nc", "lower.nc"].map(|name| python.examples().join("two-turret").join(name));
    let drawing = folder.path().join("timeline.svg");
    let mut example = python.example();
    example.args(["--server", &plain, "--machine", "fanuc-2path-lathe", "--timeline"]).arg(&drawing).args(&programs);
    let output = example.output().unwrap();
    assert!(output.status.success() && text(&output).contains("SUCCEEDED after"), "{}", text(&output));
    assert!(std::fs::read_to_string(drawing).unwrap().starts_with("<svg"));
    let output = python.example().args(["--server", &plain, "--machine", "fanuc-2path-lathe"]).args(&programs).output();
    assert!(text(&output.unwrap()).contains("results of the equal job"), "an equal job is not run again");

    let token = std::fs::read_to_string(folder.path().join("token")).unwrap();
    let through = |ca: &str| {
        let mut example = python.example();
        example.env("COUNTERPOINT_SERVER", &encrypted).env("COUNTERPOINT_CA", folder.path().join(ca));
        example.env("COUNTERPOINT_TOKEN", &token).args(&programs).output().unwrap()
    };
    let output = through("ca.pem");
    assert!(output.status.success() && text(&output).contains("SUCCEEDED after"), "{}", text(&output));
    let failed = |output: &Output, code: i32, part: &str| {
        assert_eq!((output.status.code(), text(output).lines().count()), (Some(code), 1), "{}", text(output));
        assert!(text(output).contains(part), "{}", text(output));
    };
    failed(&through("other.pem"), 3, "the certificate of the server");
    for (server, machine, code, part) in [
        ("http://127.0.0.1:1", "fanuc-mill", 3, "no server answers at http://127.0.0.1:1"),
        (&plain, "fanuc-mil", 2, "no machine 'fanuc-mil': the server has"),
    ] {
        let output = python.example().args(["--server", server, "--machine", machine]).args(&programs[..1]).output();
        failed(&output.unwrap(), code, part);
    }
}
