//! Runs the example clients in Go, in C#, for Node and for browsers against a server. An example is skipped with a
//! message if its tools or packages are missing.

#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stderr)]

#[cfg(unix)]
mod guarded;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use counterpoint_server::options::ServerOptions;
use counterpoint_server::service;

fn repository() -> PathBuf {
    std::fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).unwrap()
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        if entry.file_type().unwrap().is_file() {
            std::fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
        }
    }
}

/// Whether a preparation step succeeds; otherwise prints the reason for the skip.
fn prepared(step: &mut Command) -> bool {
    match step.output() {
        Ok(output) if output.status.success() => true,
        Ok(output) => {
            eprintln!("skipped: {step:?}: {}", String::from_utf8_lossy(&output.stderr));
            false
        }
        Err(error) => {
            eprintln!("skipped: {step:?}: {error}");
            false
        }
    }
}

fn serve(runtime: &tokio::runtime::Runtime, data: &Path) -> String {
    let listen = "127.0.0.1:0".parse().unwrap();
    let mut options = ServerOptions { listen, data: data.to_owned(), grace_s: 0, ..ServerOptions::default() };
    options.guard.grpc_web = true;
    let service = runtime.block_on(service::build(options)).unwrap();
    let address = service.handle().address().to_string();
    runtime.spawn(service.run(std::future::pending()));
    address
}

/// An address without a listener.
fn silent() -> String {
    std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string()
}

fn text(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// Runs a client with a job of two channels, a job with a dialog, a wrong address and a wrong machine. `dash` is the
/// prefix of options.
fn check(command: &dyn Fn() -> Command, dash: &str, folder: &Path) {
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
    let address = serve(&runtime, &folder.join("data"));
    let (examples, listing) = (repository().join("examples"), folder.join("job.lce"));
    let run = |server: &str, machine: &str, set: &[&str], programs: &[&str]| {
        let mut command = command();
        for (option, value) in [("server", server), ("machine", machine)] {
            command.arg(format!("{dash}{option}")).arg(value);
        }
        command.arg(format!("{dash}listing")).arg(&listing);
        for value in set {
            command.arg(format!("{dash}set")).arg(value);
        }
        command.args(programs.iter().map(|name| examples.join(name))).output().unwrap()
    };
    let two = ["two-turret/upper.nc", "two-turret/lower.nc"];
    let output = run(&address, "fanuc-2path-lathe", &[], &two);
    assert!(output.status.success() && text(&output).contains("SUCCEEDED after"), "{}", text(&output));
    let written = std::fs::read_to_string(&listing).unwrap();
    assert!(written.contains("upper.nc") && written.contains("lower.nc"), "{written}");

    let output = run(&address, "tern-bar-lathe", &["PERCENT=50"], &["bar-part/pin.nc"]);
    assert!(output.status.success() && text(&output).contains("dialog 'Set-up'"), "{}", text(&output));
    let written = std::fs::read_to_string(&listing).unwrap();
    assert!(written.contains("feed 50 %"), "the answer has arrived: {written}");

    let wrong = silent();
    let output = run(&wrong, "fanuc-mill", &[], &two[..1]);
    assert_eq!((output.status.code(), text(&output).lines().count()), (Some(3), 1), "{}", text(&output));
    assert!(text(&output).contains(&wrong) && text(&output).contains("check the address"), "{}", text(&output));
    assert_prose(&text(&output));
    let output = run(&address, "fanuc-mil", &[], &two[..1]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output));
    assert!(text(&output).contains("no machine 'fanuc-mil'"), "{}", text(&output));
    assert_prose(&text(&output));
}

/// An error is a sentence: it has no gRPC code and no text of the operating system or of OpenSSL.
fn assert_prose(text: &str) {
    for raw in ["UNAVAILABLE", "UNAUTHENTICATED", "NOT_FOUND", "Unavailable", "NotFound", "rpc error", "[not_found]"] {
        assert!(!text.contains(raw), "{raw}: {text}");
    }
    for raw in ["ECONN", "SSL routines", ":error:", "OPENSSL", "errno", "Error: ", "at async", "undefined"] {
        assert!(!text.contains(raw), "{raw}: {text}");
    }
}

/// `GOFLAGS` may name a module file with local copies of the modules.
#[test]
fn the_example_in_go_runs() {
    let folder = tempfile::tempdir().unwrap();
    let (source, proto) = (folder.path().join("go"), repository().join("proto"));
    copy(&repository().join("examples/go"), &source);
    let mut generate = Command::new("protoc");
    generate.arg("-I").arg(&proto).args(["--go_out=.", "--go_opt=module=counterpoint"]);
    generate.args(["--go-grpc_out=.", "--go-grpc_opt=module=counterpoint"]).current_dir(&source);
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(proto.join("counterpoint/v1")).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let go = |arguments: &[&str]| {
        let mut command = Command::new("go");
        command.args(arguments).current_dir(&source);
        command
    };
    if !prepared(&mut go(&["version"])) || !prepared(generate.args(files)) {
        return;
    }
    let given = std::env::var("GOFLAGS").is_ok_and(|flags| flags.contains("-modfile"));
    if !given && !prepared(&mut go(&["mod", "tidy"])) || !prepared(&mut go(&["list", "-deps", "."])) {
        return;
    }
    for step in [&["vet", "."][..], &["build", "-o", "client", "."]] {
        let output = go(step).output().unwrap();
        assert!(output.status.success(), "{}", text(&output));
    }
    let program = source.join("client");
    check(&|| Command::new(&program), "-", folder.path());
}

/// Restores the packages first, so that a computer that cannot get them skips the test.
#[test]
fn the_example_in_csharp_runs() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("examples/csharp");
    copy(&repository().join("examples/csharp"), &source);
    copy(&repository().join("proto/counterpoint/v1"), &folder.path().join("proto/counterpoint/v1"));
    let dotnet = |arguments: &[&str]| {
        let mut command = Command::new("dotnet");
        command.args(arguments).current_dir(&source).env("DOTNET_CLI_TELEMETRY_OPTOUT", "1");
        command
    };
    if !prepared(&mut dotnet(&["--version"])) || !prepared(&mut dotnet(&["restore"])) {
        return;
    }
    let output = dotnet(&["build", "--no-restore", "--output", "built"]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
    let address = serve(&runtime, &folder.path().join("data"));
    let programs = ["two-turret/upper.nc", "two-turret/lower.nc"].map(|name| repository().join("examples").join(name));
    let run = |server: &str, machine: &str| {
        let server = format!("http://{server}");
        dotnet(&["built/counterpoint.dll", &server, machine]).args(&programs).output().unwrap()
    };
    let output = run(&address, "fanuc-2path-lathe");
    assert!(output.status.success() && text(&output).contains("Succeeded after"), "{}", text(&output));
    assert!(std::fs::read_to_string(source.join("summary.json")).unwrap().contains("\"SUCCEEDED\""));
    let output = run(&silent(), "fanuc-mill");
    assert_eq!((output.status.code(), text(&output).lines().count()), (Some(3), 1), "{}", text(&output));
    assert!(text(&output).contains("check the address"), "{}", text(&output));
    assert_prose(&text(&output));
    let output = run(&address, "fanuc-mil");
    assert_eq!((output.status.code(), text(&output).lines().count()), (Some(2), 1), "{}", text(&output));
    assert!(text(&output).contains("no machine 'fanuc-mil'"), "{}", text(&output));
    assert_prose(&text(&output));
}

/// The folder with the packages of an example: its own or `COUNTERPOINT_NODE_MODULES`. None = the test is skipped.
fn packages(example: &str, needed: &[&str]) -> Option<PathBuf> {
    let of_example = repository().join("examples").join(example).join("node_modules");
    let modules = std::env::var_os("COUNTERPOINT_NODE_MODULES").map_or(of_example, PathBuf::from);
    if let Some(absent) = needed.iter().find(|name| !modules.join(name).is_dir()) {
        eprintln!("skipped: no package {absent} in {} (COUNTERPOINT_NODE_MODULES names a folder)", modules.display());
        return None;
    }
    prepared(Command::new("node").arg("--version")).then_some(modules)
}

/// Copies an example and links its packages.
#[cfg(unix)]
fn beside(modules: &Path, example: &str, folder: &Path) -> PathBuf {
    let source = folder.join(example);
    copy(&repository().join("examples").join(example), &source);
    std::os::unix::fs::symlink(modules, source.join("node_modules")).unwrap();
    source
}

#[cfg(unix)]
fn node(script: PathBuf) -> impl Fn() -> Command {
    move || {
        let mut command = Command::new("node");
        command.arg(&script).env("COUNTERPOINT_PROTO", repository().join("proto"));
        command
    }
}

#[cfg(unix)]
#[test]
fn the_example_for_node_runs() {
    let Some(modules) = packages("node", &["@grpc/grpc-js", "@grpc/proto-loader"]) else { return };
    let folder = tempfile::tempdir().unwrap();
    let source = beside(&modules, "node", folder.path());
    check(&node(source.join("submit_and_watch.js")), "--", folder.path());
    check_encrypted(&node(source.join("submit_and_watch.js")), folder.path());
}

/// Runs a client that takes address, token and authorities from the environment, against a server with TLS.
#[cfg(unix)]
fn check_encrypted(command: &dyn Fn() -> Command, folder: &Path) {
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
    let options = ServerOptions { data: folder.join("encrypted"), grace_s: 0, ..guarded::options(folder) };
    let options = ServerOptions { listen: "127.0.0.1:0".parse().unwrap(), ..options };
    let service = runtime.block_on(service::build(options)).unwrap();
    let port = service.handle().address().port();
    runtime.spawn(service.run(std::future::pending()));
    let (examples, token) = (repository().join("examples"), std::fs::read_to_string(folder.join("token")).unwrap());
    let run = |server: &str, ca: &str| {
        let mut command = command();
        command.env("COUNTERPOINT_SERVER", server).env("COUNTERPOINT_CA", folder.join(ca));
        command.env("COUNTERPOINT_TOKEN", &token).args(["--machine", "fanuc-2path-lathe", "--listing"]);
        command.arg(folder.join("encrypted.lce"));
        command.args(["upper.nc", "lower.nc"].map(|name| examples.join("two-turret").join(name)));
        command.output().unwrap()
    };
    for server in [format!("https://localhost:{port}"), format!("localhost:{port}")] {
        let output = run(&server, "ca.pem");
        assert!(output.status.success() && text(&output).contains("SUCCEEDED after"), "{}", text(&output));
    }
    for (server, ca, part) in [
        (format!("https://localhost:{port}"), "other.pem", "is signed by an unknown authority"),
        (format!("http://localhost:{port}"), "ca.pem", "it may expect https://"),
    ] {
        let output = run(&server, ca);
        assert_eq!((output.status.code(), text(&output).lines().count()), (Some(3), 1), "{}", text(&output));
        assert!(text(&output).contains(part), "{}", text(&output));
        assert_prose(&text(&output));
    }
    let mut unknown = command();
    unknown.env("COUNTERPOINT_SERVER", format!("https://localhost:{port}")).env("COUNTERPOINT_TOKEN", "wrong");
    unknown.env("COUNTERPOINT_CA", folder.join("ca.pem")).arg(examples.join("two-turret/upper.nc"));
    let output = unknown.output().unwrap();
    assert_eq!((output.status.code(), text(&output).lines().count()), (Some(3), 1), "{}", text(&output));
    assert!(text(&output).contains("the token is not known") && text(&output).contains("COUNTERPOINT_TOKEN"));
    assert_prose(&text(&output));
    let output = run(&format!("https://localhost:{port}"), "absent.pem");
    assert!(text(&output).starts_with("COUNTERPOINT_CA: "), "{}", text(&output));
}

#[cfg(unix)]
#[test]
fn the_example_for_browsers_runs() {
    let needed = ["@bufbuild/buf", "@bufbuild/protoc-gen-es", "@connectrpc/connect-web", "esbuild"];
    let Some(modules) = packages("web", &needed) else { return };
    let folder = tempfile::tempdir().unwrap();
    let source = beside(&modules, "web", folder.path());
    let tools = std::env::join_paths(
        [modules.join(".bin")].into_iter().chain(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default())),
    );
    let mut generate = Command::new(modules.join(".bin/buf"));
    generate.arg("generate").arg(repository().join("proto")).current_dir(&source).env("PATH", tools.unwrap());
    let output = generate.output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    let mut bundle = Command::new(modules.join(".bin/esbuild"));
    bundle.args(["page.js", "--bundle", "--format=esm", "--outfile=page.bundle.js"]).current_dir(&source);
    let output = bundle.output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    check(&node(source.join("submit_and_watch.js")), "--", folder.path());
}
