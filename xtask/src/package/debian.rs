//! The Debian package: control data and the maintainer scripts of `deploy/debian`.

use std::fmt::Write as _;
use std::path::Path;

use super::archive::{self, File, Files};

/// Debian's name of a processor.
fn architecture(of_rust: &str) -> Result<&'static str, String> {
    match of_rust {
        "x86_64" => Ok("amd64"),
        "aarch64" => Ok("arm64"),
        "riscv64" | "riscv64gc" => Ok("riscv64"),
        other => Err(format!("no Debian package for {other}: use --format tar.gz")),
    }
}

/// The newest version of the C library that a program needs, from the version names in the program.
fn libc(program: &[u8]) -> (u32, u32) {
    const MARK: &[u8] = b"GLIBC_2.";
    let places = program.windows(MARK.len()).enumerate().filter(|(_, window)| *window == MARK);
    let minors = places.filter_map(|(at, _)| {
        let digits = program.get(at + MARK.len()..)?.iter().take_while(|byte| byte.is_ascii_digit());
        String::from_utf8(digits.copied().collect()).ok()?.parse().ok()
    });
    (2, minors.max().unwrap_or(0))
}

fn control(files: &Files, version: &str, architecture: &str, maintainer: &str) -> String {
    let bytes: usize = files.values().map(|file| file.content.len()).sum();
    let programs = files.values().filter(|file| file.executable);
    let (major, minor) = programs.map(|file| libc(&file.content)).max().unwrap_or((2, 0));
    let mut out = String::new();
    let _ = write!(
        out,
        "Package: counterpoint\nVersion: {version}\nArchitecture: {architecture}\nSection: science\n\
         Priority: optional\nMaintainer: {maintainer}\n\
         Installed-Size: {}\nDepends: libc6 (>= {major}.{minor}), libgcc-s1, adduser, debconf (>= 0.5) | debconf-2.0\n\
         Description: runs NC programs as the control of the machine would\n \
         The server counterpointd and the command line counterpoint run programs for machines with\n \
         several channels, and report deadlocks, alarms and the cycle time.\n",
        bytes.div_ceil(1024)
    );
    out
}

/// The package as the bytes of a `.deb`, and its name.
///
/// # Errors
/// A maintainer script cannot be read, or Debian has no name for the processor.
pub(super) fn package(
    root: &Path,
    files: &Files,
    (version, processor, maintainer): (&str, &str, &str),
    (time, level): (u64, u32),
) -> Result<(String, Vec<u8>), String> {
    let architecture = architecture(processor)?;
    let folder = root.join("deploy/debian");
    let mut data = Files::new();
    let mut add = |name: &str, content: Vec<u8>, executable| data.insert(name.to_owned(), File { content, executable });
    for name in ["postinst", "prerm", "postrm", "templates"] {
        let path = folder.join(name);
        let content = std::fs::read(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        add(name, content, name != "templates");
    }
    add("control", control(files, version, architecture, maintainer).into_bytes(), false);
    let configuration = files.keys().filter(|path| path.starts_with("etc/")).map(|path| format!("/{path}\n"));
    add("conffiles", configuration.collect::<String>().into_bytes(), false);
    let wrong = |error: std::io::Error| format!("archive: {error}");
    let members = [
        ("debian-binary", b"2.0\n".to_vec()),
        ("control.tar.gz", archive::tar_gz(&data, ".", (time, level)).map_err(wrong)?),
        ("data.tar.gz", archive::tar_gz(files, ".", (time, level)).map_err(wrong)?),
    ];
    Ok((format!("counterpoint_{version}_{architecture}.deb"), archive::ar(&members, time)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_version_of_the_c_library_counts() {
        assert_eq!(libc(b"x GLIBC_2.9\0GLIBC_2.34\0GLIBC_2.17\0GLIBC_PRIVATE"), (2, 34));
        assert_eq!(libc(b"nothing"), (2, 0));
    }

    #[test]
    fn a_processor_without_a_name_in_debian_is_refused() {
        assert_eq!(architecture("x86_64"), Ok("amd64"));
        assert!(architecture("s390").is_err_and(|error| error.contains("tar.gz")));
    }
}
