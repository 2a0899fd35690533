//! The start of `counterpointd`: its log, and the reasons and exit codes of starts that fail.

use std::path::Path;
use std::process::Command;

/// Exit code and standard error of a server that does not start.
fn refused(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpointd"));
    command.args(["--listen", "127.0.0.1:0", "--data"]).arg(folder).args(arguments);
    let output = command.output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

/// The unit restarts the server after exit code 3 only.
#[test]
fn a_mistake_in_the_configuration_and_trouble_of_the_system_have_different_exit_codes() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "quue = 3\n").unwrap();
    let path = file.to_str().unwrap();
    for mistake in [
        &["--config", path][..],
        &["--quue", "3"],
        &["--access", path],
        &["--tls-cert", path, "--tls-key", path],
        &["--metrics", "here"],
    ] {
        let (code, text) = refused(&folder.path().join("data"), mistake);
        assert_eq!(code, Some(2), "{mistake:?}: {text}");
    }
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    for (data, trouble) in [("data", &["--metrics", &address][..]), ("file", &[])] {
        let (code, text) = refused(&folder.path().join(data), trouble);
        assert_eq!(code, Some(3), "{data} {trouble:?}: {text}");
    }
}

#[test]
fn a_refused_start_names_the_option_the_file_and_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let (file, none) = (folder.path().join("file"), folder.path().join("none"));
    std::fs::write(&file, "quue = 3\n").unwrap();
    let (file, none) = (file.to_str().unwrap(), none.to_str().unwrap());
    let (code, text) = refused(&data, &["--tls-cert", file]);
    assert!(code == Some(2) && text.contains("tls_key is missing"), "{text}");
    for (option, path, more) in [
        ("access", file, "quue"),
        ("access", none, "No such file"),
        ("tls_key", file, "there is no key in it"),
        ("tls_key", none, "No such file"),
    ] {
        let flag = format!("--{}", option.replace('_', "-"));
        let certificate = ["--tls-cert", file];
        let certificate = if option == "tls_key" { &certificate[..] } else { &[] };
        let (code, text) = refused(&data, &[certificate, &[flag.as_str(), path]].concat());
        assert_eq!(code, Some(2), "{text}");
        let named = text.contains(&format!("'{path}' (option {option})"));
        assert!(named && text.contains(more), "{option} {path}: {text}");
    }
}

/// A file of root, in a folder that others may enter, as the user of the server sees it.
#[cfg(target_os = "linux")]
#[test]
fn a_file_that_the_user_of_the_server_cannot_read_is_reported_with_that_user() {
    use std::os::unix::fs::PermissionsExt as _;
    use std::os::unix::process::CommandExt as _;
    if !rustix::process::getuid().is_root() {
        println!("skipped: only root can start a server as another user");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mode = |path: &Path, mode| std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
    mode(folder.path(), 0o755);
    let file = folder.path().join("secret");
    std::fs::write(&file, "").unwrap();
    mode(&file, 0o600);
    for (option, more) in [("access", &[][..]), ("tls-key", &["--tls-cert", "cert.pem"])] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_counterpointd"));
        command.args(["--listen", "127.0.0.1:0", "--data", "/nowhere"]).arg(format!("--{option}")).arg(&file);
        let output = command.args(more).uid(65_534).gid(65_534).output().unwrap();
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{text}");
        let option = option.replace('-', "_");
        assert!(text.contains(&format!("(option {option}): Permission denied")), "{text}");
        assert!(text.contains("the user of the server (uid 65534) must be able to read the file"), "{text}");
    }
}

/// Standard output and standard error of a command that must succeed.
fn done(arguments: &[&str]) -> (String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_counterpointd")).args(arguments).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    let (out, log) = (text(output.stdout), text(output.stderr));
    assert!(output.status.success(), "{arguments:?}: {out}{log}");
    (out, log)
}

#[test]
fn commands_take_the_configuration_before_and_after_their_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (config, access) = (path("c.toml"), path("access.toml"));
    std::fs::write(&config, format!("access = {access:?}\ndata = {:?}\n", path("data"))).unwrap();
    let new = ["token", "new", "--tenant", "t", "--role", "read", "--name", "ci"];
    done(&[&new[..], &["--config", &config]].concat());
    for arguments in [
        &["token", "list", "--config", &config][..],
        &["token", "--config", &config, "list"],
        &["--config", &config, "token", "list"],
    ] {
        let (listed, _) = done(arguments);
        assert!(listed.contains("  ci  t  read  "), "{arguments:?}: {listed}");
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpointd"));
    let output = command.args(["doctor", "--config", &config]).output().unwrap();
    assert!(String::from_utf8_lossy(&output.stderr).contains(&path("data")), "doctor examines the folder of the file");
    let listed = Command::new(env!("CARGO_BIN_EXE_counterpointd"))
        .args(["token", "list"])
        .env("COUNTERPOINT_CONFIG", &config)
        .output()
        .unwrap();
    assert!(String::from_utf8_lossy(&listed.stdout).contains("  ci  t  read  "), "the environment names the file");
}

#[test]
fn a_configuration_is_printed_with_comments_and_can_be_used() {
    let folder = tempfile::tempdir().unwrap();
    let (printed, _) = done(&["--queue", "7", "--print-config"]);
    assert!(printed.contains("# Maximum number of jobs that wait in the queue\nqueue = 7\n"), "{printed}");
    let config = folder.path().join("c.toml");
    std::fs::write(&config, &printed).unwrap();
    assert_eq!(done(&["--print-config", "--config", config.to_str().unwrap()]).0, printed);
}

#[test]
fn each_command_has_a_man_page() {
    let folder = tempfile::tempdir().unwrap();
    done(&["man", folder.path().to_str().unwrap()]);
    let page = |name: &str| std::fs::read_to_string(folder.path().join(format!("{name}.8"))).unwrap();
    let main = page("counterpointd");
    assert!(main.contains(".SH SYNOPSIS\ncounterpointd [OPTIONS] [COMMAND]\n"), "{main}");
    for part in
        [".TH counterpointd 8", "max\\-blob\\-bytes", "COUNTERPOINT_QUEUE", "/etc/counterpoint", "operations.md"]
    {
        assert!(main.contains(part), "{part}: {main}");
    }
    for (name, part) in
        [("doctor", "repair"), ("backup", "FOLDER"), ("restore", "damaged"), ("token-new", "tenant"), ("man", "pages")]
    {
        assert!(page(&format!("counterpointd-{name}")).contains(part), "{name}");
    }
}

/// With port 0 only the log says which port monitoring has.
#[cfg(unix)]
#[test]
fn the_log_has_the_version_the_folder_the_jobs_and_the_addresses() {
    use std::io::{BufRead as _, BufReader};
    let folder = tempfile::tempdir().unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_counterpointd"))
        .args(["--listen", "127.0.0.1:0", "--metrics", "127.0.0.1:0", "--log-format", "json", "--data", "data"])
        .current_dir(folder.path())
        .env("COUNTERPOINT_LOG", "info")
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut announced = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut announced).unwrap();
    let url = announced.trim().strip_prefix("listening on ").unwrap().to_owned();
    // The line precedes the announcement.
    child.kill().unwrap();
    child.wait().unwrap();
    let lines: Vec<String> = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap).collect();
    let lines = lines.iter().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
    let started =
        lines.into_iter().find(|line| line["fields"]["message"] == "started").expect("a line about the start");
    let fields = &started["fields"];
    assert_eq!((&fields["version"], &fields["url"]), (&env!("CARGO_PKG_VERSION").into(), &url.into()), "{fields}");
    assert_eq!((&fields["unfinished_jobs"], &started["level"]), (&0.into(), &"INFO".into()), "{fields}");
    let data = folder.path().canonicalize().unwrap().join("data");
    assert_eq!(fields["data"], data.to_str().unwrap(), "{fields}");
    let metrics = fields["metrics"].as_str().unwrap();
    let port = metrics.strip_prefix("http://127.0.0.1:").and_then(|rest| rest.strip_suffix("/metrics")).unwrap();
    assert_ne!(port, "0", "{fields}");
}

/// Exit code, standard output and standard error of a command that needs no server. It gets
/// only the given variables of the server, since a run of all tests may set others.
fn outcome(arguments: &[&str], variables: &[(&str, &str)]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpointd"));
    for (name, _) in std::env::vars_os() {
        if name.to_string_lossy().starts_with("COUNTERPOINT_") {
            command.env_remove(name);
        }
    }
    let output = command.args(arguments).envs(variables.iter().copied()).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// A configuration file has signed numbers.
#[test]
fn a_number_that_no_configuration_file_can_contain_is_refused_by_name() {
    let (code, _, text) = outcome(&["--queue", "18446744073709551615", "--print-config"], &[]);
    assert!(code == Some(2) && text.contains("option queue: the largest number is 9223372036854775807"), "{text}");
    let (code, printed, text) = outcome(&["--queue", "9223372036854775807", "--print-config"], &[]);
    assert!(code == Some(0) && printed.contains("\nqueue = 9223372036854775807\n"), "{text}");
}

#[test]
fn man_pages_need_no_configuration_and_no_command_is_ignored() {
    let folder = tempfile::tempdir().unwrap();
    let (pages, none) = (folder.path().join("man"), folder.path().join("none.toml"));
    let (pages_text, none) = (pages.to_str().unwrap(), none.to_str().unwrap());
    let (code, printed, text) = outcome(&["--print-config", "man", pages_text], &[]);
    assert!(code == Some(2) && text.contains("--print-config cannot be combined with a command"), "{printed}{text}");
    assert!(!pages.exists());
    let (code, _, text) = outcome(&["man", pages_text], &[("COUNTERPOINT_CONFIG", none)]);
    assert!(code == Some(0) && pages.join("counterpointd.8").is_file(), "{text}");
}

#[test]
fn an_empty_path_means_the_same_in_the_environment_and_in_the_file() {
    let files = ["CONFIG", "ACCESS", "TLS_CERT", "TLS_KEY", "TLS_CLIENT_CA", "AUDIT"];
    let variables = files.map(|name| format!("COUNTERPOINT_{name}"));
    let variables = variables.each_ref().map(|name| (name.as_str(), ""));
    let (code, printed, text) = outcome(&["--print-config"], &variables);
    assert_eq!((code, printed), (Some(0), outcome(&["--print-config"], &[]).1), "{text}");
}

/// A unit or a Compose file that passes on an unset variable must not switch identities or the audit log off.
#[test]
fn an_empty_variable_does_not_override_the_file_and_only_a_flag_does() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("c.toml");
    let set = "access = \"a.toml\"\naudit = \"a.jsonl\"\nqueue = 7\nlog_format = \"json\"\ninsecure = true\n";
    std::fs::write(&config, set).unwrap();
    let print = ["--print-config", "--config", config.to_str().unwrap()];
    let (_, printed, _) = outcome(&print, &[]);
    assert!(printed.contains("\naccess = \"a.toml\"\n") && printed.contains("\ninsecure = true\n"), "{printed}");
    let names =
        printed.lines().filter_map(|line| line.split_once(" = ")).filter(|(name, _)| !name.contains(['#', ' ']));
    let variables: Vec<String> = names.map(|(name, _)| format!("COUNTERPOINT_{}", name.to_uppercase())).collect();
    assert!(variables.len() > 50, "{variables:?}");
    let variables: Vec<(&str, &str)> = variables.iter().map(|name| (name.as_str(), "")).collect();
    let (code, same, text) = outcome(&print, &variables);
    assert_eq!((code, same), (Some(0), printed), "{text}");
    let (code, printed, text) = outcome(&[&print[..], &["--access", ""]].concat(), &variables);
    assert!(code == Some(0) && printed.contains("\naccess = \"\"\n"), "{printed}{text}");
}

#[test]
fn a_wrong_value_names_the_variable_that_has_it() {
    for (variable, flag) in [("COUNTERPOINT_QUEUE", "--queue"), ("COUNTERPOINT_LOG_FORMAT", "--log-format")] {
        let (code, _, text) = outcome(&["--print-config"], &[(variable, "many")]);
        assert!(code == Some(2) && text.contains("'many'") && text.contains(variable) && text.contains(flag), "{text}");
        let (code, _, text) = outcome(&["--print-config", flag, "many"], &[(variable, "few")]);
        assert!(code == Some(2) && text.contains("'many'") && !text.contains(variable), "{text}");
    }
}

/// A misspelled variable has no effect, so the server reports it. Variables of the clients, and those that Kubernetes
/// sets for a service of this name, are not reported.
#[test]
fn a_variable_without_an_option_is_reported_with_a_similar_name() {
    let (code, _, text) = outcome(&["--print-config"], &[("COUNTERPOINT_QUEU", "3"), ("COUNTERPOINT_ZZZZZZ", "1")]);
    assert_eq!(code, Some(0), "{text}");
    let line = |name: &str| text.lines().find(|line| line.contains(name)).unwrap_or_else(|| panic!("{name}: {text}"));
    assert!(line("'COUNTERPOINT_QUEU'").contains("did you mean COUNTERPOINT_QUEUE?"), "{text}");
    assert!(!line("'COUNTERPOINT_ZZZZZZ'").contains("did you mean"), "{text}");
    let known = [
        "LOG",
        "SERVER",
        "TOKEN",
        "CA",
        "CLIENT_CERT",
        "CLIENT_KEY",
        "QUEUE",
        "CONFIG",
        "SERVICE_HOST",
        "SERVICE_PORT",
    ];
    let more = ["SERVICE_PORT_GRPC", "PORT", "PORT_7878_TCP", "PORT_7878_TCP_ADDR"];
    let names: Vec<String> = known.iter().chain(&more).map(|name| format!("COUNTERPOINT_{name}")).collect();
    let variables: Vec<(&str, &str)> = names.iter().map(|name| (name.as_str(), "")).collect();
    assert_eq!(outcome(&["--print-config"], &variables).2, "");
    // The log of a server has the warning, too.
    let folder = tempfile::tempdir().unwrap();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let mut server = Command::new(env!("CARGO_BIN_EXE_counterpointd"));
    server.args(["--listen", "127.0.0.1:0", "--metrics", &address, "--data"]).arg(folder.path().join("data"));
    let output = server.env("COUNTERPOINT_QUEU", "3").output().unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(text.contains("COUNTERPOINT_QUEU") && text.contains("did you mean COUNTERPOINT_QUEUE?"), "{text}");
}

#[cfg(unix)]
#[test]
fn a_data_folder_that_cannot_exist_and_a_pipe_as_a_file_of_identities_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (config, pipe) = (folder.path().join("c.toml"), folder.path().join("pipe"));
    std::fs::write(&config, "data = \"a\\u0000b\"\n").unwrap();
    let (code, _, text) = outcome(&["--listen", "127.0.0.1:0", "--config", config.to_str().unwrap()], &[]);
    assert!(code == Some(2) && text.contains("option data") && text.contains("NUL"), "{text}");
    let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    let (code, text) = refused(&folder.path().join("data"), &["--access", pipe.to_str().unwrap()]);
    assert!(code == Some(2) && text.contains("(option access): is not a regular file"), "{text}");
}

/// A line break in a value does not break a line of the log.
#[cfg(unix)]
#[test]
fn a_line_break_in_the_data_folder_breaks_no_line_of_the_log() {
    use std::io::{BufRead as _, BufReader, Read as _};
    let folder = tempfile::tempdir().unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_counterpointd"))
        .args(["--listen", "127.0.0.1:0", "--data", "first\nsecond"])
        .current_dir(folder.path())
        .env("COUNTERPOINT_LOG", "info")
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut String::new()).unwrap();
    child.kill().unwrap();
    child.wait().unwrap();
    let mut log = String::new();
    child.stderr.take().unwrap().read_to_string(&mut log).unwrap();
    let started = log.lines().find(|line| line.contains("started")).unwrap_or_else(|| panic!("{log}"));
    assert!(started.contains("first\\nsecond") && started.contains("unfinished_jobs"), "{log}");
}
