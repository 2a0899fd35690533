//! The steps of `deploy/Containerfile`, executed without a builder of images.
//!
//! Each stage is a folder in which the instructions are executed by `chroot`. The first stage begins as a layer over
//! this system, the last one with the shared libraries of the base image only. *Invariant:* an instruction that this
//! test does not know fails it.

#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stderr)]
#![cfg(target_os = "linux")]

mod built;

use std::fmt::Write as _;
use std::process::Command;

use built::{done, programs, root};

/// Shared libraries of the base image that the programs may need.
const LIBRARIES: [&str; 4] = ["ld-linux-x86-64.so.2", "libc.so.6", "libm.so.6", "libgcc_s.so.1"];

/// A shell script that executes the instructions of the file below `$1`; `$2` is the folder of the built programs.
fn steps(file: &str) -> String {
    let text = file.replace("\\\n", " ");
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let (mut script, mut stage, mut folder) = (String::new(), 0, "/".to_owned());
    for line in lines {
        let (name, rest) = line.split_once(' ').unwrap();
        match name {
            "FROM" => {
                stage += 1;
                let tree = if stage == 1 { "build" } else { "image" };
                write!(script, "tree=\"$1\"/{tree}; ").unwrap();
            }
            "WORKDIR" => {
                rest.clone_into(&mut folder);
                write!(script, "mkdir -p \"$tree\"{rest}; ").unwrap();
            }
            // The programs were built beside this test, from the same files.
            "COPY" if rest == ". ." => {
                write!(script, "mkdir -p \"$tree\"{folder}/target/release; ").unwrap();
                write!(script, "cp \"$2\"/counterpoint \"$2\"/counterpointd \"$tree\"{folder}/target/release; ")
                    .unwrap();
            }
            "RUN" if rest.starts_with("cargo build --release ") => {
                assert!(rest.ends_with("--bin counterpointd --bin counterpoint"), "{rest}");
            }
            "RUN" => write!(script, "chroot \"$tree\" sh -ec 'cd {folder}; {rest}'; ").unwrap(),
            "COPY" => script.push_str(&copy(rest)),
            "ENV" => rest.split_whitespace().for_each(|pair| write!(script, "export {pair}; ").unwrap()),
            "VOLUME" => write!(script, "mkdir -p \"$tree\"{rest}; ").unwrap(),
            "USER" => write!(script, "user={rest}; ").unwrap(),
            "ENTRYPOINT" => {
                let words: Vec<String> = serde_json::from_str(rest).unwrap();
                write!(script, "entry='{}'; ", words.join(" ")).unwrap();
            }
            "EXPOSE" | "STOPSIGNAL" => {}
            _ => panic!("unknown instruction: {line}"),
        }
    }
    assert_eq!(stage, 2);
    script
}

/// COPY of a file of `deploy`, whose path is `$4`, or from the first stage. It copies the contents of a folder, and a
/// new target belongs to the user.
fn copy(operands: &str) -> String {
    if let Some(source) = operands.strip_prefix("deploy/") {
        let (source, target) = source.split_once(' ').unwrap();
        return format!("install -D -m 644 \"$4\"/{source} \"$tree\"{target}; ");
    }
    let (options, paths): (Vec<_>, Vec<_>) = operands.split_whitespace().partition(|word| word.starts_with("--"));
    assert!(options.contains(&"--from=build"), "{operands}");
    let owner = options.iter().find_map(|option| option.strip_prefix("--chown=")).unwrap_or("0:0");
    let (target, sources) = paths.split_last().unwrap();
    let mut script = String::new();
    for source in sources {
        let (from, to) = (format!("\"$1\"/build{source}"), format!("\"$tree\"{target}"));
        write!(
            script,
            "if [ -d {from} ]; then mkdir -p {to}; cp -R {from}/. {to}; chown -R {owner} {to}; \
             else mkdir -p {to}; cp {from} {to}; chown {owner} {to}/$(basename {source}); fi; "
        )
        .unwrap();
    }
    script
}

/// What the image does: the instructions of the file have left `$tree`, `$user`, `$entry` and the environment.
const USE: &str = r#"
inside() { chroot --userspec="$user" "$tree" "$@"; }
inside $entry --version
echo "ok: starts"
if inside $entry 2>"$1"/refusal; then exit 1; fi
grep -q -e tls -e access "$1"/refusal || { cat "$1"/refusal; exit 1; }
echo "ok: refuses strangers without identities"
printf 'O1\nT0101\nG97 S1000 M3\nG0 X20. Z2.\nG1 Z-10. F0.2\nM30\n' > "$tree"/part.nc
# A configuration of the user replaces that of the image.
cat > "$tree"/etc/counterpoint/counterpointd.toml <<END
listen = "127.0.0.1:0"
data = "/var/lib/counterpoint/own"
END
chroot --userspec="$user" "$tree" $entry > "$1"/address 2> "$1"/log &
server=$!
while ! grep -q listening "$1"/address; do kill -0 $server || { cat "$1"/log; exit 1; }; done
address=$(sed -n 's|.*listening on \(http://[0-9.:]*\).*|\1|p' "$1"/address)
job=$(inside "${entry%d}" submit --server "$address" --machine fanuc-lathe /part.nc)
inside "${entry%d}" wait --server "$address" "$job"
[ -e "$tree"/var/lib/counterpoint/own/ledger.redb ]
echo "ok: runs a job"
kill -TERM $server
wait $server
echo "ok: stops"
"#;

/// Makes the folders of both stages.
const STAGES: &str = r#"
mount -t tmpfs tmpfs "$1"
mkdir "$1"/upper "$1"/work "$1"/build "$1"/image
mount -t overlay overlay -o "lowerdir=/,upperdir=$1/upper,workdir=$1/work" "$1"/build
mkdir "$1"/image/dev "$1"/image/proc "$1"/image/tmp "$1"/image/lib64
chmod 1777 "$1"/image/tmp
mount --bind /dev "$1"/image/dev
mount -t proc proc "$1"/image/proc
for library in $3; do cp "$library" "$1"/image/lib64; done
ln -s lib64 "$1"/image/lib
ip link set lo up
chroot "$1"/build true
echo ready
"#;

/// The shared libraries of the base image in this system.
fn libraries(program: &std::path::Path) -> String {
    let listed = done(Command::new("ldd").arg(program));
    let paths = listed.split_whitespace().filter(|word| word.starts_with('/'));
    let known = |path: &&str| path.rsplit('/').next().is_some_and(|name| LIBRARIES.contains(&name));
    paths.filter(known).collect::<Vec<_>>().join(" ")
}

#[test]
fn the_steps_of_the_container_file_make_an_image_that_runs_jobs() {
    let folder = tempfile::tempdir().unwrap();
    let programs = programs();
    let libraries = libraries(&programs.join("counterpointd"));
    let run = |script: &str| {
        let mut command = Command::new("unshare");
        command.args(["--mount", "--pid", "--net", "--fork", "--kill-child", "sh", "-e", "-c", script, "sh"]);
        command.arg(folder.path()).arg(&programs).arg(&libraries).arg(root().join("deploy"));
        command
    };
    match run(STAGES).output() {
        Ok(output) if output.status.success() => {}
        Ok(output) => return eprintln!("skipped: no stages here: {}", String::from_utf8_lossy(&output.stderr)),
        Err(error) => return eprintln!("skipped: unshare: {error}"),
    }
    let file = std::fs::read_to_string(root().join("deploy/Containerfile")).unwrap();
    let text = done(&mut run(&[STAGES, &steps(&file), USE].concat()));
    for part in ["starts", "refuses strangers without identities", "runs a job", "stops"] {
        assert!(text.contains(&format!("ok: {part}")), "{part}: {text}");
    }
}
