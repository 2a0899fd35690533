//! The floors of the house: which crate may depend on which.
//!
//! Invariant: a crate depends only on crates of floors below its own; crates of one floor do not know each other.
//! Dependencies that only tests of a crate use do not count.

use crate::graph::Package;

/// Crates from the ground up, without `counterpoint-`.
const FLOORS: &[&[&str]] = &[
    &["fault", "motion", "proto", "mdspec"],
    &["event", "lang"],
    &["ports", "lang-standalone", "signs"],
    &["machine"],
    &["program"],
    &["control-api", "results"],
    &[
        "control-fanuc",
        "control-heidenhain",
        "control-isg",
        "control-okuma",
        "control-rs274",
        "control-siemens",
        "sync",
    ],
    &["controls"],
    &["waits"],
    &["channel"],
    &["emulator"],
    &["actions", "lint", "macro-host"],
    &["kernel"],
    &["server", "client"],
    &["cli"],
    &["tests"],
];

fn floor(name: &str) -> Option<usize> {
    let short = name.strip_prefix("counterpoint-")?;
    FLOORS.iter().position(|floor| floor.contains(&short))
}

/// Arrows that do not go down.
pub(crate) fn findings(packages: &[Package]) -> Vec<String> {
    let mut out = Vec::new();
    for package in packages.iter().filter(|package| package.source.is_none() && package.name != "xtask") {
        let Some(own) = floor(&package.name) else {
            out.push(format!("{} has no floor: give it one in xtask/src/floors.rs", package.name));
            continue;
        };
        for dependency in package.dependencies.iter().filter(|one| one.kind.as_deref() != Some("dev")) {
            if floor(&dependency.name).is_some_and(|other| other >= own) {
                out.push(format!("{} uses {}, which is not on a floor below it", package.name, dependency.name));
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Dependency;

    fn package(name: &str, uses: &[(&str, Option<&str>)]) -> Package {
        let dependencies = uses.iter().map(|(name, kind)| Dependency {
            name: (*name).to_owned(),
            kind: kind.map(str::to_owned),
            req: "*".to_owned(),
            path: Some(String::new()),
        });
        Package {
            name: name.to_owned(),
            version: "0.1.0".to_owned(),
            license: None,
            source: None,
            dependencies: dependencies.collect(),
        }
    }

    #[test]
    fn arrows_go_down_only() {
        let good =
            package("counterpoint-machine", &[("counterpoint-lang", None), ("counterpoint-server", Some("dev"))]);
        let up = package("counterpoint-lang", &[("counterpoint-machine", None)]);
        let beside = package("counterpoint-control-api", &[("counterpoint-results", Some("build"))]);
        let new = package("counterpoint-attic", &[]);
        let findings = findings(&[good, up, beside, new]);
        assert_eq!(findings.len(), 3, "{findings:?}");
        assert!(findings[0].starts_with("counterpoint-lang uses counterpoint-machine"), "{findings:?}");
        assert!(findings[1].starts_with("counterpoint-control-api uses counterpoint-results"), "{findings:?}");
        assert!(findings[2].starts_with("counterpoint-attic has no floor"), "{findings:?}");
    }
}
