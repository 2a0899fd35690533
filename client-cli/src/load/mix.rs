//! The kinds of jobs of a load, from a file.
//!
//! *Invariant:* jobs come in a fixed order in which each kind is spread evenly by its weight, so two runs submit the
//! same.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use counterpoint_client::Blob;
use counterpoint_proto::v1;
use serde::Deserialize;

use crate::error::Error;

/// Most lines that are made of a program.
const MOST_LINES: u64 = 10_000_000;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MixFile {
    job: Vec<MixRow>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MixRow {
    name: String,
    #[serde(default = "one")]
    weight: u32,
    machine: String,
    #[serde(default)]
    programs: Vec<PathBuf>,
    #[serde(default)]
    made: Vec<GeneratedProgram>,
    #[serde(default)]
    watch: FollowLevel,
}

fn one() -> u32 {
    1
}

/// A program that is made: `{n}` in `lines` counts from 1.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct GeneratedProgram {
    name: String,
    #[serde(default)]
    head: String,
    #[serde(default)]
    lines: String,
    #[serde(default = "one")]
    times: u32,
    #[serde(default)]
    foot: String,
}

/// How a job is followed.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum FollowLevel {
    /// Not at all: its caller submits the next job at once.
    None,
    Progress,
    Diagnostics,
    Blocks,
    #[default]
    Everything,
}

/// A kind of job.
#[derive(Debug)]
pub(super) struct JobKind {
    pub(super) name: String,
    weight: i64,
    /// Without its request id.
    pub(super) request: v1::SubmitJobRequest,
    blobs: Vec<Blob>,
    pub(super) watch: Option<v1::WatchLevel>,
}

/// All kinds, and whose turn it is.
#[derive(Debug)]
pub(super) struct Mix {
    jobs: Vec<(Arc<JobKind>, i64)>,
}

impl Mix {
    pub(super) fn read(path: &Path) -> Result<Self, Error> {
        let text = std::fs::read_to_string(path).map_err(Error::file(path))?;
        let bad = |text: String| Error::Usage(format!("{}: {text}", path.display()));
        let file: MixFile = toml::from_str(&text).map_err(|error| bad(error.message().to_owned()))?;
        if file.job.iter().all(|row| row.weight == 0) {
            return Err(bad("no job has a weight above 0".to_owned()));
        }
        let folder = path.parent().unwrap_or(Path::new("."));
        let rows = file.job.into_iter().filter(|row| row.weight > 0);
        let jobs = rows.map(|row| Ok((Arc::new(job(row, folder, &bad)?), 0))).collect::<Result<_, Error>>()?;
        Ok(Self { jobs })
    }

    /// Contents of all files.
    pub(super) fn blobs(&self) -> Vec<Blob> {
        self.jobs.iter().flat_map(|(job, _)| job.blobs.clone()).collect()
    }

    /// The next job: each kind gains its weight, the one with most is taken and pays the sum of the weights.
    pub(super) fn next(&mut self) -> Option<Arc<JobKind>> {
        let sum: i64 = self.jobs.iter().map(|(job, _)| job.weight).sum();
        self.jobs.iter_mut().for_each(|(job, credit)| *credit += job.weight);
        let most = self.jobs.iter().map(|(_, credit)| *credit).max()?;
        let (job, credit) = self.jobs.iter_mut().find(|(_, credit)| *credit == most)?;
        *credit -= sum;
        Some(job.clone())
    }
}

fn job(row: MixRow, folder: &Path, bad: &dyn Fn(String) -> Error) -> Result<JobKind, Error> {
    // Every job runs, although the jobs of a row are equal.
    let options = Some(v1::JobOptions { no_cache: true, ..Default::default() });
    let mut request = v1::SubmitJobRequest { machine: row.machine, options, ..Default::default() };
    let mut blobs = Vec::new();
    let mut add = |path: String, content: Vec<u8>| {
        let blob = Blob::new(content);
        request.programs.push(v1::Program { path: path.clone(), ..Default::default() });
        request.files.push(v1::FileRef { path, digest: blob.digest().to_owned() });
        blobs.push(blob);
    };
    for path in &row.programs {
        let path = folder.join(path);
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        add(name, std::fs::read(&path).map_err(Error::file(&path))?);
    }
    for made in row.made {
        let lines = u64::from(made.times) * made.lines.lines().count() as u64;
        if lines > MOST_LINES {
            return Err(bad(format!("program '{}' has {lines} lines, at most {MOST_LINES} are made", made.name)));
        }
        let mut text = made.head;
        for n in 1..=made.times {
            text += &made.lines.replace("{n}", &n.to_string());
        }
        add(made.name, (text + &made.foot).into_bytes());
    }
    if request.programs.is_empty() {
        return Err(bad(format!("job '{}' has no program: give programs or made", row.name)));
    }
    let watch = match row.watch {
        FollowLevel::None => None,
        FollowLevel::Progress => Some(v1::WatchLevel::Progress),
        FollowLevel::Diagnostics => Some(v1::WatchLevel::Diagnostics),
        FollowLevel::Blocks => Some(v1::WatchLevel::Blocks),
        FollowLevel::Everything => Some(v1::WatchLevel::Everything),
    };
    Ok(JobKind { name: row.name, weight: row.weight.into(), request, blobs, watch })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mix(text: &str) -> Result<Mix, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mix.toml");
        std::fs::write(&path, text).unwrap();
        Mix::read(&path)
    }

    #[test]
    fn kinds_are_spread_evenly_by_weight() {
        let row = |name: &str, weight| {
            format!("[[job]]\nname = \"{name}\"\nweight = {weight}\nmachine = \"m\"\nmade = [{{ name = \"p\" }}]\n")
        };
        let mut mix = mix(&(row("a", 4) + &row("b", 2) + &row("c", 1) + &row("never", 0))).unwrap();
        let order: String = (0..14).map(|_| mix.next().unwrap().name.clone()).collect();
        assert_eq!(order, "abacabaabacaba");
    }

    #[test]
    fn programs_are_made_line_by_line() {
        let text = "[[job]]\nname = \"a\"\nmachine = \"m\"\nwatch = \"none\"\n[[job.made]]\nname = \"p.nc\"\nhead = \"O1\\n\"\n\
                    lines = \"N{n} X{n}\\n\"\ntimes = 2\nfoot = \"M30\\n\"\n";
        let mut mix = mix(text).unwrap();
        let job = mix.next().unwrap();
        assert!(job.watch.is_none());
        assert_eq!(job.request.files[0].digest, mix.blobs()[0].digest());
        assert_eq!(&mix.blobs()[0].content()[..], b"O1\nN1 X1\nN2 X2\nM30\n");
    }

    #[test]
    fn a_mix_that_is_wrong_says_where() {
        for (text, with) in [
            ("", "missing field `job`"),
            ("[[job]]\nname = \"a\"\nmachine = \"m\"\n", "job 'a' has no program"),
            ("[[job]]\nname = \"a\"\nmachine = \"m\"\nprogram = 1\n", "unknown field"),
            ("[[job]]\nname = \"a\"\nmachine = \"m\"\nweight = 0\n", "no job has a weight"),
            ("[[job]]\nname = \"a\"\nmachine = \"m\"\nprograms = [\"none.nc\"]\n", "none.nc' does not exist"),
            (
                "[[job]]\nname = \"a\"\nmachine = \"m\"\nmade = [{ name = \"p\", lines = \"G0\", times = 4000000000 }]\n",
                "at most 10000000",
            ),
        ] {
            let error = mix(text).unwrap_err().to_string();
            assert!(error.contains(with), "{error}");
        }
    }
}
