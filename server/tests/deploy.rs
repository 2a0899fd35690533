//! The content of `deploy/`: every file is read as its tool would read it, and every name in it exists.

#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]

use std::collections::BTreeSet;
use std::path::PathBuf;

use counterpoint_server::options::ServerOptions;
use serde_json::{Value, json};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &str) -> String {
    let path = root().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn yaml(text: &str) -> Value {
    serde_saphyr::from_str(text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Names of metrics in the docs, which another test compares with those of the server.
fn metrics() -> BTreeSet<String> {
    let docs = read("docs/operations.md");
    let rows = docs.split_once("| metric | kind | meaning |").unwrap().1.lines().skip(2);
    let mut names = BTreeSet::new();
    for row in rows.take_while(|line| line.starts_with('|')) {
        let mut cells = row.split('|').map(str::trim).skip(1);
        let (name, kind) = (cells.next().unwrap().trim_matches('`').to_owned(), cells.next().unwrap());
        match kind {
            "histogram" => names.extend(["_bucket", "_count", "_sum"].map(|part| format!("{name}{part}"))),
            _ => drop(names.insert(name)),
        }
    }
    assert!(names.len() > 15, "{names:?}");
    names
}

/// Checks a query as far as names and brackets go.
fn check_query(query: &str) {
    let known = metrics();
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == ':';
    let words = query
        .split(|c: char| !is_part(c))
        .filter(|word| ["counterpoint", "process_"].iter().any(|begin| word.starts_with(begin)));
    let words: Vec<&str> = words.filter(|word| *word != "counterpoint").collect();
    for name in &words {
        assert!(known.contains(*name), "{name} is not a metric: {query}");
    }
    assert!(!words.is_empty() || query.starts_with("up{"), "{query}");
    let mut open = Vec::new();
    for c in query.chars() {
        match c {
            '(' | '[' | '{' => open.push(c),
            ')' | ']' | '}' => {
                let expected = open.pop();
                assert!(matches!((expected, c), (Some('('), ')') | (Some('['), ']') | (Some('{'), '}')), "{query}");
            }
            _ => {}
        }
    }
    assert!(open.is_empty() && query.matches('"').count().is_multiple_of(2), "{query}");
}

#[test]
fn the_unit_has_known_keys_and_waits_for_the_server() {
    let known = [
        ("Unit", &["Description", "After", "Wants", "StartLimitIntervalSec", "StartLimitBurst"][..]),
        (
            "Service",
            &[
                "Type",
                "NotifyAccess",
                "WatchdogSec",
                "ExecStart",
                "ExecReload",
                "TimeoutStopSec",
                "Restart",
                "RestartSec",
                "RestartPreventExitStatus",
                "User",
                "Group",
                "StateDirectory",
                "StateDirectoryMode",
                "LogsDirectory",
                "LogsDirectoryMode",
                "LimitNOFILE",
                "MemoryMax",
                "NoNewPrivileges",
                "ProtectSystem",
                "ProtectHome",
                "PrivateTmp",
                "PrivateDevices",
                "ProtectKernelTunables",
                "ProtectKernelModules",
                "ProtectControlGroups",
                "RestrictAddressFamilies",
                "RestrictNamespaces",
                "LockPersonality",
                "MemoryDenyWriteExecute",
                "SystemCallArchitectures",
                "RestrictRealtime",
                "RestrictSUIDSGID",
                "PrivateUsers",
                "ProtectClock",
                "ProtectHostname",
                "ProtectKernelLogs",
                "ProtectProc",
                "ProcSubset",
                "CapabilityBoundingSet",
                "UMask",
                "SystemCallFilter",
                "SystemCallErrorNumber",
            ],
        ),
        ("Install", &["WantedBy"]),
    ];
    let text = read("deploy/counterpointd.service");
    let (mut section, mut values) = (String::new(), Vec::new());
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#')) {
        if let Some(name) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
            name.clone_into(&mut section);
            continue;
        }
        let (key, value) = line.split_once('=').unwrap_or_else(|| panic!("{line}"));
        let keys = known.iter().find(|(name, _)| *name == section).unwrap_or_else(|| panic!("[{section}]")).1;
        assert!(keys.contains(&key) && (!value.is_empty() || key == "CapabilityBoundingSet"), "[{section}] {line}");
        values.push((key.to_owned(), value.to_owned()));
    }
    let value = |name: &str| values.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str());
    assert_eq!((value("Type"), value("NotifyAccess")), (Some("notify"), Some("main")));
    let seconds = |name: &str| value(name).unwrap().parse::<u64>().unwrap();
    assert!(seconds("TimeoutStopSec") > ServerOptions::default().grace_s, "a stop gets longer than running jobs do");
    assert!(seconds("WatchdogSec") >= 30);
    assert_eq!(value("RestartPreventExitStatus"), Some("2"), "a mistake in the configuration ends the restarts");
    let limit = seconds("StartLimitBurst") * (seconds("RestartSec") + 1);
    assert!(limit < seconds("StartLimitIntervalSec"), "a start that fails within a second reaches the limit");
    assert_eq!((value("User"), value("Group")), (Some("counterpoint"), Some("counterpoint")));
    assert_eq!((value("StateDirectory"), value("LogsDirectory")), (Some("counterpoint"), Some("counterpoint")));
    let docs = read("docs/security.md");
    let shipped = ServerOptions::from_file(&root().join("deploy/debian/counterpointd.toml")).unwrap();
    assert_eq!(shipped.data, PathBuf::from("/var/lib/counterpoint"));
    for file in ["data = \"/var/lib/counterpoint\"", "audit = \"/var/log/counterpoint/", "-g counterpoint key.pem"] {
        assert!(docs.contains(file), "the documented files are where the unit may use them: {file}");
    }
    assert!(value("RestrictAddressFamilies").unwrap().contains("AF_UNIX"), "signs of life go over a local socket");
}

#[test]
fn the_container_file_builds_what_is_there_as_nobody() {
    let text = read("deploy/Containerfile").replace("\\\n", " ");
    let mut stages = BTreeSet::new();
    let mut instructions = Vec::new();
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#')) {
        let (name, rest) = line.split_once(' ').unwrap();
        let known = ["FROM", "WORKDIR", "COPY", "RUN", "ENV", "VOLUME", "EXPOSE", "USER", "STOPSIGNAL", "ENTRYPOINT"];
        assert!(known.contains(&name), "{line}");
        if let Some((_, stage)) = rest.split_once(" AS ") {
            stages.insert(stage.to_owned());
        }
        if let Some(from) = rest.strip_prefix("--from=").and_then(|rest| rest.split(' ').next()) {
            assert!(stages.contains(from), "{line}");
        }
        instructions.push((name.to_owned(), rest.to_owned()));
    }
    let of = |name: &str| instructions.iter().filter(|one| one.0 == name).map(|one| one.1.as_str()).collect::<Vec<_>>();
    let toolchain: toml::Table = read("rust-toolchain.toml").parse().unwrap();
    let version = toolchain["toolchain"]["channel"].as_str().unwrap();
    let minor = version.splitn(3, '.').take(2).collect::<Vec<_>>().join(".");
    assert!(of("FROM")[0].contains(&format!("rust:{minor}-")), "the compiler is that of rust-toolchain.toml");
    let user = of("USER")[0];
    assert!(user.split(':').next().unwrap().parse::<u32>().is_ok_and(|id| id > 0), "{user}");
    // A variable would override the same option of a mounted file.
    let configuration = "/etc/counterpoint/counterpointd.toml";
    assert_eq!(of("ENV"), [format!("COUNTERPOINT_CONFIG={configuration}")]);
    assert!(of("COPY").contains(&format!("deploy/container.toml {configuration}").as_str()));
    let options = ServerOptions::from_file(&root().join("deploy/container.toml")).unwrap();
    assert_eq!(options.data.to_str(), Some(of("VOLUME")[0]));
    for port in [options.listen.port().to_string(), options.connections.metrics.rsplit(':').next().unwrap().to_owned()]
    {
        assert!(of("EXPOSE")[0].split(' ').any(|exposed| exposed == port), "{port}");
    }
    let entry: Vec<String> = serde_json::from_str(of("ENTRYPOINT")[0]).unwrap();
    assert_eq!(entry, ["/usr/local/bin/counterpointd"]);
    assert!(of("COPY")[1].contains("/release/counterpointd ") && of("COPY")[1].ends_with("/usr/local/bin/"));
}

/// Executes the part of the Helm language that the templates of the chart use.
struct Render<'a> {
    scope: &'a Value,
}

impl Render<'_> {
    /// The text of a template for values.
    fn render(&self, template: &str) -> String {
        let mut parts = Vec::new();
        let mut rest = template;
        while let Some((text, more)) = rest.split_once("{{") {
            let (action, after) = more.split_once("}}").expect("an action ends");
            let (trimmed, action) = match action.strip_prefix('-') {
                Some(action) => (text.trim_end(), action),
                None => (text, action),
            };
            parts.push((Some(trimmed.to_owned()), action.trim().to_owned()));
            rest = after;
        }
        parts.push((Some(rest.to_owned()), String::new()));
        let (text, used) = self.block(&parts, 0, &[], true);
        assert_eq!(used, parts.len(), "every block ends once");
        text
    }

    fn block(
        &self,
        parts: &[(Option<String>, String)],
        from: usize,
        own: &[(&str, &Value)],
        on: bool,
    ) -> (String, usize) {
        let (mut out, mut at) = (String::new(), from);
        while let Some((text, action)) = parts.get(at) {
            if on {
                out += text.as_deref().unwrap_or_default();
            }
            at += 1;
            if action == "end" {
                return (out, at);
            } else if let Some(condition) = action.strip_prefix("if ") {
                let on = on && self.is_true(condition, own);
                let (inner, next) = self.block(parts, at, own, on);
                out += &inner;
                at = next;
            } else if let Some(range) = action.strip_prefix("range ") {
                let (names, list) = range.split_once(" := ").expect("a range names its variables");
                let (key_name, value_name) = names.split_once(", ").expect("a key and a value");
                // A block that is not rendered has no values to read.
                let map = if on { self.value(list, own) } else { json!({}) };
                let mut next = self.block(parts, at, own, false).1;
                for (key, value) in map.as_object().expect("a map") {
                    let key = json!(key);
                    let inner_values = [own, &[(key_name, &key), (value_name, value)]].concat();
                    let (inner, end) = self.block(parts, at, &inner_values, on);
                    out += &inner;
                    next = end;
                }
                at = next;
            } else if !action.is_empty() && on {
                match self.value(action, own) {
                    Value::String(text) => out += &text,
                    Value::Object(_) | Value::Array(_) => panic!("{action} is not a scalar"),
                    other => out += &other.to_string(),
                }
            }
        }
        (out, at)
    }

    /// A condition, which may ask for the kind of a value.
    fn is_true(&self, condition: &str, own: &[(&str, &Value)]) -> bool {
        if let Some(inner) = condition.strip_prefix("not (").and_then(|inner| inner.strip_suffix(')')) {
            return !self.is_true(inner, own);
        }
        if let Some(name) = condition.strip_prefix("kindIs \"map\" ") {
            return self.value(name, own).is_object();
        }
        let value = self.value(condition, own);
        !matches!(value, Value::Null | Value::Bool(false)) && value != json!("") && value != json!({})
    }

    fn value(&self, pipeline: &str, own: &[(&str, &Value)]) -> Value {
        let mut steps = pipeline.split('|').map(str::trim);
        let first = steps.next().unwrap();
        let mut value = match own.iter().find(|(name, _)| *name == first) {
            Some((_, value)) => (*value).clone(),
            None => {
                let path = first.strip_prefix('.').unwrap_or_else(|| panic!("{pipeline}"));
                let step = |value: &Value, name: &str| value.get(name).cloned();
                let found = path.split('.').try_fold(self.scope.clone(), |value, name| step(&value, name));
                found.unwrap_or_else(|| panic!("{first} is not in values.yaml"))
            }
        };
        for step in steps {
            value = match step {
                "toJson" => json!(value.to_string()),
                "quote" => json!(json!(value.as_str().unwrap()).to_string()),
                other => panic!("{other}: {pipeline}"),
            };
        }
        value
    }
}

/// The chart with its values, some of them replaced.
fn chart(change: impl FnOnce(&mut Value)) -> Vec<(String, Value)> {
    let mut values = yaml(&read("deploy/helm/counterpoint/values.yaml"));
    change(&mut values);
    let scope = json!({"Values": values, "Release": {"Name": "try"}});
    let folder = root().join("deploy/helm/counterpoint/templates");
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let render = |path: &PathBuf| {
        let text = Render { scope: &scope }.render(&std::fs::read_to_string(path).unwrap());
        (!text.trim().is_empty()).then(|| (path.file_stem().unwrap().to_string_lossy().into_owned(), yaml(&text)))
    };
    files.iter().filter_map(render).collect()
}

/// The options of the server in a rendered part, read as the server reads them.
fn options(config: &Value) -> ServerOptions {
    let text = config["data"]["counterpointd.toml"].as_str().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("counterpointd.toml");
    std::fs::write(&file, text).unwrap();
    ServerOptions::from_file(&file).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// A map in `config` is a table of the file, and single options precede all tables.
#[test]
fn the_server_reads_the_tables_of_the_chart() {
    let parts = chart(|values| {
        values["config"] = json!({
            "allow_system": false,
            "queue": 10_000_000,
            "tenants": {"assembly": {"queued": 5000, "keep_s": 2_592_000}, "cells": {"running": 2}},
            "tenant_queued": 500,
            "webhooks": {"mes": {"url": "https://mes.example/?a=1&b=2", "secret_file": "/s", "tenants": ["a", "b"]}},
        });
    });
    let options = options(&parts[0].1);
    assert_eq!((options.queue, options.quotas.tenant_queued), (10_000_000, 500));
    let tenants = &options.tables.tenants;
    assert_eq!((tenants["assembly"].queued, tenants["assembly"].keep_s), (Some(5000), Some(2_592_000)));
    assert_eq!((tenants["cells"].running, tenants["cells"].queued), (Some(2), None));
    let hook = &options.tables.webhooks["mes"];
    assert_eq!((hook.url.as_str(), hook.tenants.len()), ("https://mes.example/?a=1&b=2", 2));
}

/// The monitor has the job label of the rules, and monitoring, which has no identities, stays inside the cluster.
#[test]
fn monitoring_has_the_job_of_the_rules_and_a_service_inside_the_cluster() {
    let parts = chart(|values| {
        values["metrics"]["serviceMonitor"] = json!(true);
        values["service"]["type"] = json!("LoadBalancer");
    });
    let part = |name: &str| &parts.iter().find(|(of, _)| of == name).unwrap().1;
    let ports = |name: &str| {
        let ports = part(name)["spec"]["ports"].as_array().unwrap();
        ports.iter().map(|port| port["name"].as_str().unwrap()).collect::<Vec<_>>()
    };
    assert_eq!((ports("service"), ports("metrics")), (vec!["grpc"], vec!["metrics"]));
    assert_eq!(
        (&part("service")["spec"]["type"], &part("metrics")["spec"]["type"]),
        (&json!("LoadBalancer"), &json!("ClusterIP"))
    );
    let (monitor, labels) = (&part("servicemonitor")["spec"], &part("metrics")["metadata"]["labels"]);
    let job = labels[monitor["jobLabel"].as_str().unwrap()].as_str().unwrap();
    assert!(read("deploy/prometheus/rules.yaml").contains(&format!("up{{job=\"{job}\"}}")), "{job}");
    for (name, value) in monitor["selector"]["matchLabels"].as_object().unwrap() {
        assert_eq!(&labels[name], value, "{name}");
    }
    let others = &part("service")["metadata"]["labels"];
    assert!(others["app.kubernetes.io/component"].is_null(), "the monitor selects one service: {others}");
}

#[test]
fn the_chart_renders_and_its_parts_fit_together() {
    let head = yaml(&read("deploy/helm/counterpoint/Chart.yaml"));
    assert_eq!((&head["apiVersion"], &head["appVersion"]), (&json!("v2"), &json!(env!("CARGO_PKG_VERSION"))));
    let parts = chart(|_| {});
    let names: Vec<&str> = parts.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["config", "metrics", "service", "statefulset"]);
    let part = |name: &str| &parts.iter().find(|(of, _)| of == name).unwrap().1;
    let (config, set, service) = (part("config"), part("statefulset"), part("service"));
    let options = options(config);
    assert_eq!((options.grace_s, options.listen.port()), (60, 7878));
    let pod = &set["spec"]["template"]["spec"];
    assert!(pod["terminationGracePeriodSeconds"].as_u64().unwrap() > options.grace_s);
    assert_eq!(
        (&set["spec"]["replicas"], &pod["volumes"][0]["configMap"]["name"]),
        (&json!(1), &config["metadata"]["name"])
    );
    let container = &pod["containers"][0];
    assert_eq!(container["image"], json!(format!("counterpoint:{}", env!("CARGO_PKG_VERSION"))));
    let volumes: BTreeSet<&str> =
        pod["volumes"].as_array().unwrap().iter().filter_map(|v| v["name"].as_str()).collect();
    for mount in container["volumeMounts"].as_array().unwrap() {
        let name = mount["name"].as_str().unwrap();
        assert!(volumes.contains(name) || name == "data", "{mount}");
    }
    for path in [&options.guard.tls_cert, &options.guard.tls_key, &options.guard.access, &options.data] {
        let mounts = container["volumeMounts"].as_array().unwrap();
        assert!(mounts.iter().any(|mount| path.starts_with(mount["mountPath"].as_str().unwrap())), "{path:?}");
    }
    let ports: Vec<&Value> = container["ports"].as_array().unwrap().iter().map(|port| &port["name"]).collect();
    for service in [service, part("metrics")] {
        for port in service["spec"]["ports"].as_array().unwrap() {
            assert!(ports.contains(&&port["targetPort"]), "{port}");
        }
        assert_eq!(service["spec"]["selector"], set["spec"]["selector"]["matchLabels"]);
    }
    assert_eq!(container["readinessProbe"]["httpGet"]["path"], "/readyz");
    let all = chart(|values| {
        values["metrics"]["serviceMonitor"] = json!(true);
        values["storage"]["className"] = json!("fast");
    });
    assert_eq!(all.len(), 5);
    let set = &all.iter().find(|(name, _)| name == "statefulset").unwrap().1;
    assert_eq!(set["spec"]["volumeClaimTemplates"][0]["spec"]["storageClassName"], "fast");
}

#[test]
fn rules_and_board_ask_for_metrics_that_exist() {
    let rules = yaml(&read("deploy/prometheus/rules.yaml"));
    let tests = read("deploy/prometheus/tests.yaml");
    let mut names = BTreeSet::new();
    for rule in rules["groups"].as_array().unwrap().iter().flat_map(|group| group["rules"].as_array().unwrap()) {
        check_query(rule["expr"].as_str().unwrap());
        let name = rule["alert"].as_str().or(rule["record"].as_str()).unwrap();
        assert!(names.insert(name.to_owned()), "{name} is there twice");
        assert!(tests.contains(name), "{name} has no test");
        if rule["alert"].is_string() {
            assert!(["info", "warning", "critical"].contains(&rule["labels"]["severity"].as_str().unwrap()), "{rule}");
            assert!(
                rule["annotations"]["summary"].is_string() && rule["annotations"]["description"].is_string(),
                "{rule}"
            );
        }
    }
    let board: Value = serde_json::from_str(&read("deploy/grafana/counterpoint.json")).unwrap();
    let panels = board["panels"].as_array().unwrap();
    let (mut ids, mut places) = (BTreeSet::new(), BTreeSet::new());
    let mut shown = String::new();
    for panel in panels {
        assert!(ids.insert(panel["id"].as_u64().unwrap()), "{panel}");
        let side = |name: &str| panel["gridPos"][name].as_u64().unwrap();
        for x in side("x")..side("x") + side("w") {
            for y in side("y")..side("y") + side("h") {
                assert!(x < 24 && places.insert((x, y)), "{} lies over another panel", panel["title"]);
            }
        }
        for target in panel["targets"].as_array().unwrap() {
            let query = target["expr"].as_str().unwrap();
            check_query(query);
            shown += query;
        }
    }
    for name in metrics().iter().filter(|name| !name.ends_with("_count") && !name.ends_with("_sum")) {
        assert!(shown.contains(name.as_str()), "{name} is on no panel");
    }
}
