//! Licences, banned crates and sources of everything that is built, by the rules of `deny.toml`.
//!
//! The file is that of cargo-deny, which finds the same where it is installed. Read here: `licenses.allow`,
//! `licenses.private.ignore`, `bans.deny`, `bans.wildcards`, `sources`. Invariant: a setting that is not read is an
//! error.

use std::path::Path;

use serde::Deserialize;

use crate::graph::{Package, packages};

const FILE: &str = "deny.toml";
/// The registry that crates come from without further settings.
const REGISTRY: &str = "https://github.com/rust-lang/crates.io-index";

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Level {
    #[default]
    Allow,
    Warn,
    Deny,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Private {
    #[serde(default)]
    ignore: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Licenses {
    allow: Vec<String>,
    /// Counts for texts of licences, which are not looked at here.
    #[serde(rename = "confidence-threshold")]
    _confidence: Option<f64>,
    #[serde(default)]
    private: Private,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Ban {
    name: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Bans {
    #[serde(default)]
    multiple_versions: Level,
    #[serde(default)]
    wildcards: Level,
    #[serde(default)]
    deny: Vec<Ban>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Sources {
    #[serde(default)]
    unknown_registry: Level,
    #[serde(default)]
    unknown_git: Level,
    #[serde(default)]
    allow_registry: Vec<String>,
    #[serde(default)]
    allow_git: Vec<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Rules {
    #[serde(rename = "graph")]
    _graph: Option<toml::Table>,
    licenses: Licenses,
    #[serde(default)]
    bans: Bans,
    #[serde(default)]
    sources: Sources,
}

/// The parts of a licence expression.
fn tokens(expression: &str) -> Vec<String> {
    let spaced = expression.replace('(', " ( ").replace(')', " ) ").replace('/', " OR ");
    let words: Vec<&str> = spaced.split_whitespace().collect();
    let mut tokens: Vec<String> = Vec::new();
    let mut words = words.into_iter();
    while let Some(word) = words.next() {
        match (word, tokens.last_mut()) {
            ("WITH", Some(last)) => *last = format!("{last} WITH {}", words.next().unwrap_or("")),
            _ => tokens.push(word.to_owned()),
        }
    }
    tokens
}

/// A licence expression that is read from its first token on: `OR` of `AND` of licences and groups.
struct Reader<'t> {
    tokens: &'t [String],
    allow: &'t [String],
}

impl Reader<'_> {
    fn take(&mut self, word: &str) -> bool {
        match self.tokens.split_first() {
            Some((first, rest)) if first == word => {
                self.tokens = rest;
                true
            }
            _ => false,
        }
    }

    fn any(&mut self) -> Option<bool> {
        let mut good = self.all()?;
        while self.take("OR") {
            good |= self.all()?;
        }
        Some(good)
    }

    fn all(&mut self) -> Option<bool> {
        let mut good = self.one()?;
        while self.take("AND") {
            good &= self.one()?;
        }
        Some(good)
    }

    fn one(&mut self) -> Option<bool> {
        if self.take("(") {
            let good = self.any()?;
            return self.take(")").then_some(good);
        }
        let (first, rest) = self.tokens.split_first()?;
        self.tokens = rest;
        (!matches!(first.as_str(), "OR" | "AND" | "(" | ")")).then(|| self.allow.contains(first))
    }
}

/// Whether a licence expression can be met with the licences that are allowed; none if it cannot be read.
fn is_met(expression: &str, allow: &[String]) -> Option<bool> {
    let tokens = tokens(expression);
    let mut reader = Reader { tokens: &tokens, allow };
    let good = reader.any()?;
    reader.tokens.is_empty().then_some(good)
}

fn license(package: &Package, rules: &Licenses) -> Option<String> {
    if package.source.is_none() && rules.private.ignore {
        return None;
    }
    let of = format!("{} {}", package.name, package.version);
    let Some(expression) = &package.license else { return Some(format!("{of} names no licence")) };
    match is_met(expression, &rules.allow) {
        Some(true) => None,
        Some(false) => Some(format!("{of}: the licence '{expression}' is not allowed by {FILE}")),
        None => Some(format!("{of}: the licence '{expression}' cannot be read")),
    }
}

fn source(package: &Package, rules: &Sources) -> Option<String> {
    let source = package.source.as_deref()?;
    let (kind, place) = source.split_once('+').unwrap_or(("", source));
    let (level, known) = match kind {
        "registry" | "sparse" => {
            (rules.unknown_registry, place == REGISTRY || rules.allow_registry.iter().any(|r| r == place))
        }
        _ => (rules.unknown_git, rules.allow_git.iter().any(|git| place.starts_with(git.as_str()))),
    };
    (level == Level::Deny && !known)
        .then(|| format!("{} {} comes from {place}, which {FILE} does not allow", package.name, package.version))
}

fn bans(packages: &[Package], rules: &Bans) -> Vec<String> {
    let mut out = Vec::new();
    for package in packages {
        if rules.deny.iter().any(|ban| ban.name == package.name) {
            out.push(format!("{} {} is banned by {FILE}", package.name, package.version));
        }
        let wild = |d: &&crate::graph::Dependency| d.req == "*" && d.path.is_none();
        if rules.wildcards == Level::Deny && package.source.is_none() {
            let names = package.dependencies.iter().filter(wild);
            out.extend(names.map(|d| format!("{} takes any version of {}", package.name, d.name)));
        }
    }
    if rules.multiple_versions == Level::Deny {
        let mut names: Vec<&str> = packages.iter().map(|package| package.name.as_str()).collect();
        names.sort_unstable();
        let mut several: Vec<&str> = names
            .windows(2)
            .filter(|pair| pair.first() == pair.last())
            .filter_map(|pair| pair.first().copied())
            .collect();
        several.dedup();
        out.extend(several.into_iter().map(|name| format!("{name} is built in several versions")));
    }
    out
}

/// The findings of the rules of `deny.toml`.
///
/// # Errors
/// The rules cannot be read, or cargo cannot name the crates.
pub fn check(root: &Path) -> Result<Vec<String>, String> {
    let text = std::fs::read_to_string(root.join(FILE)).map_err(|error| format!("{FILE}: {error}"))?;
    let rules: Rules = toml::from_str(&text).map_err(|error| format!("{FILE}: {error}"))?;
    let packages = packages(root)?;
    let mut out: Vec<String> = packages.iter().filter_map(|package| license(package, &rules.licenses)).collect();
    out.extend(packages.iter().filter_map(|package| source(package, &rules.sources)));
    out.append(&mut bans(&packages, &rules.bans));
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn package(name: &str, license: Option<&str>, source: Option<&str>) -> Package {
        Package {
            name: name.to_owned(),
            version: "1.0.0".to_owned(),
            license: license.map(str::to_owned),
            source: source.map(str::to_owned),
            dependencies: Vec::new(),
        }
    }

    #[test]
    fn expressions_of_licences() {
        let allow = ["MIT", "Apache-2.0 WITH LLVM-exception", "Unicode-3.0"].map(str::to_owned);
        let met = |expression| is_met(expression, &allow);
        assert_eq!(met("MIT OR GPL-3.0-only"), Some(true));
        assert_eq!(met("Unlicense/MIT"), Some(true));
        assert_eq!(met("MIT AND GPL-3.0-only"), Some(false));
        assert_eq!(met("(GPL-3.0-only OR MIT) AND Unicode-3.0"), Some(true));
        assert_eq!(met("GPL-3.0-only OR MIT AND BSD-3-Clause"), Some(false));
        assert_eq!(met("Apache-2.0 WITH LLVM-exception"), Some(true));
        assert_eq!(met("Apache-2.0"), Some(false));
        assert_eq!((met(""), met("MIT OR"), met("(MIT"), met("MIT MIT")), (None, None, None, None));
    }

    #[test]
    fn what_is_not_allowed_is_found() {
        let text = "[licenses]\nallow = ['MIT']\nprivate.ignore = true\n[bans]\nmultiple-versions = 'deny'\n\
                    deny = [{ name = 'bad' }]\n[sources]\nunknown-registry = 'deny'\nunknown-git = 'deny'";
        let rules: Rules = toml::from_str(text).unwrap();
        let registry = format!("registry+{REGISTRY}");
        assert_eq!(license(&package("own", None, None), &rules.licenses), None);
        assert!(license(&package("a", None, Some(&registry)), &rules.licenses).is_some_and(|f| f.contains("names no")));
        assert_eq!(source(&package("a", None, Some(&registry)), &rules.sources), None);
        for other in ["registry+https://elsewhere", "git+https://elsewhere/a"] {
            assert!(source(&package("a", None, Some(other)), &rules.sources).is_some(), "{other}");
        }
        let several = ["a", "bad", "a"].map(|name| package(name, None, Some(&registry)));
        let found = bans(&several, &rules.bans);
        assert_eq!(found, ["bad 1.0.0 is banned by deny.toml", "a is built in several versions"]);
        assert!(toml::from_str::<Rules>("[licenses]\nallow = []\nunknown = 1").is_err());
    }
}
