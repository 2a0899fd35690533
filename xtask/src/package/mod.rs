//! `cargo xtask package`: both programs with completions, man pages, the documentation, the unit, a configuration and
//! all licences, as a Debian package and as a `.tar.gz`.
//!
//! *Invariant:* every file of a package comes from the repository or from the two programs, which print their own man
//! pages, completions and options. The same programs produce the same packages, byte for byte.

mod archive;
mod debian;
mod documents;
mod notices;

use std::path::{Path, PathBuf};
use std::process::Command;

use archive::{File, Files};

use crate::graph;

/// Input and output folders and formats of the packages.
#[derive(Debug)]
pub struct Plan {
    /// Folder with the programs `counterpoint` and `counterpointd`.
    pub programs: PathBuf,
    /// Folder for the packages.
    pub out: PathBuf,
    /// Whether to build the Debian package as well.
    pub debian: bool,
    /// Compression level, 0 to 9.
    pub level: u32,
}

/// Options that print the example configuration.
const EXAMPLE: [&str; 3] = ["--data", "/var/lib/counterpoint", "--print-config"];
/// Path of a completion script below `usr/share`, by shell.
const COMPLETIONS: [(&str, &str); 3] = [
    ("bash", "bash-completion/completions/counterpoint"),
    ("zsh", "zsh/vendor-completions/_counterpoint"),
    ("fish", "fish/vendor_completions.d/counterpoint.fish"),
];
/// Folder of the programs in the unit of the repository, and in a package.
const PROGRAMS: (&str, &str) = ("/usr/local/bin/", "/usr/bin/");

fn read(path: &Path) -> Result<Vec<u8>, String> {
    std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))
}

/// Runs a program that must succeed, without options from the environment; returns its output.
fn printed(program: &Path, arguments: &[&str]) -> Result<Vec<u8>, String> {
    let mut command = Command::new(program);
    for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_string_lossy().starts_with("COUNTERPOINT_")) {
        command.env_remove(name);
    }
    let output = command.args(arguments).output().map_err(|error| format!("{}: {error}", program.display()))?;
    match output.status.success() {
        true => Ok(output.stdout),
        false => Err(format!("{}: {}", program.display(), String::from_utf8_lossy(&output.stderr))),
    }
}

/// The unit with the paths of a package.
fn unit(text: &str) -> Result<String, String> {
    let (from, to) = PROGRAMS;
    match text.contains(from) {
        true => Ok(text.replace(from, to)),
        false => Err(format!("deploy/counterpointd.service no longer contains '{from}'")),
    }
}

/// A property of the last commit, if this is a repository.
fn commit(root: &Path, format: &str) -> Option<String> {
    let output = Command::new("git").args(["log", "-1", format]).current_dir(root).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?.trim().to_owned();
    (output.status.success() && !text.is_empty()).then_some(text)
}

/// SOURCE_DATE_EPOCH, or else the time of the last commit, in seconds since 1970.
fn time(root: &Path) -> u64 {
    let given = std::env::var("SOURCE_DATE_EPOCH").ok();
    given.or_else(|| commit(root, "--format=%ct")).and_then(|text| text.trim().parse().ok()).unwrap_or(1)
}

/// Name and address for the Debian package: DEBFULLNAME and DEBEMAIL, otherwise the committer of the last commit.
fn maintainer(root: &Path) -> Result<String, String> {
    let given = |name: &str| std::env::var(name).ok().filter(|text| !text.is_empty());
    let by_variables = given("DEBFULLNAME").zip(given("DEBEMAIL")).map(|(name, address)| format!("{name} <{address}>"));
    by_variables.or_else(|| commit(root, "--format=%cn <%ce>")).ok_or_else(|| {
        "the Debian package has no maintainer: set DEBFULLNAME and DEBEMAIL, or build in a clone of the repository"
            .into()
    })
}

/// All files, at their paths in a Debian package.
fn files(root: &Path, plan: &Plan) -> Result<Files, String> {
    let mut files = Files::new();
    let mut add = |path: &str, content: Vec<u8>, executable| {
        files.insert(path.to_owned(), File { content, executable });
    };
    let (line, server) = (plan.programs.join("counterpoint"), plan.programs.join("counterpointd"));
    add("usr/bin/counterpoint", read(&line)?, true);
    add("usr/bin/counterpointd", read(&server)?, true);
    for (shell, path) in COMPLETIONS {
        add(&format!("usr/share/{path}"), printed(&line, &["completions", shell])?, false);
    }
    for (program, section) in [(&line, "man1"), (&server, "man8")] {
        let pages = plan.out.join("man");
        printed(program, &["man", &pages.to_string_lossy()])?;
        for page in std::fs::read_dir(&pages).map_err(|error| format!("{}: {error}", pages.display()))?.flatten() {
            let content = archive::gzip(&read(&page.path())?, plan.level).map_err(|error| error.to_string())?;
            add(&format!("usr/share/man/{section}/{}.gz", page.file_name().to_string_lossy()), content, false);
        }
        std::fs::remove_dir_all(&pages).map_err(|error| format!("{}: {error}", pages.display()))?;
    }
    let text = String::from_utf8_lossy(&read(&root.join("deploy/counterpointd.service"))?).into_owned();
    add("usr/lib/systemd/system/counterpointd.service", unit(&text)?.into_bytes(), false);
    add("etc/counterpoint/counterpointd.toml", read(&root.join("deploy/debian/counterpointd.toml"))?, false);
    let of = |name: &str| format!("usr/share/doc/counterpoint/{name}");
    add(&of("counterpointd.toml.example"), printed(&server, &EXAMPLE)?, false);
    for name in documents::all(root)? {
        add(&of(&name), read(&root.join(&name))?, false);
    }
    let own = "Counterpoint: MIT OR Apache-2.0, see LICENSE-MIT and LICENSE-APACHE beside this file.\n\n";
    let linked = graph::linked(root, &["counterpoint-server", "counterpoint-cli"])?;
    add(&of("copyright"), [own, &notices::notices(&linked)?].concat().into_bytes(), false);
    Ok(files)
}

/// Builds the packages; returns their paths.
///
/// # Errors
/// A program cannot be run, a file cannot be read or written, or a crate names no licence.
pub fn make(root: &Path, plan: &Plan) -> Result<Vec<PathBuf>, String> {
    std::fs::create_dir_all(&plan.out).map_err(|error| format!("{}: {error}", plan.out.display()))?;
    let (files, time) = (files(root, plan)?, time(root));
    let (version, processor) = (env!("CARGO_PKG_VERSION"), std::env::consts::ARCH);
    let name = format!("counterpoint-{version}-{}-{processor}", std::env::consts::OS);
    let archive = archive::tar_gz(&files, &name, (time, plan.level)).map_err(|error| error.to_string())?;
    let mut made = vec![(format!("{name}.tar.gz"), archive)];
    if plan.debian {
        let maintainer = maintainer(root)?;
        made.push(debian::package(root, &files, (version, processor, &maintainer), (time, plan.level))?);
    }
    let write = |(name, content): (String, Vec<u8>)| {
        let path = plan.out.join(name);
        std::fs::write(&path, content).map_err(|error| format!("{}: {error}", path.display())).map(|()| path)
    };
    made.into_iter().map(write).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_of_a_package_has_its_paths() {
        let text = include_str!("../../../deploy/counterpointd.service");
        let unit = unit(text).unwrap();
        assert!(unit.contains("ExecStart=/usr/bin/counterpointd --config /etc/counterpoint/counterpointd.toml"));
        assert!(super::unit("[Service]\n").is_err_and(|error| error.contains("/usr/local/bin/")));
    }
}
