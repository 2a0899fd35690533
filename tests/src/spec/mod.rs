//! Meaning of the fences of the pages in `tests/spec/emulator` and `tests/spec/tables` (`tests/spec/README.md`).
//!
//! *Invariant:* an example depends on its page and its machine only, not on other examples.

pub mod machines;
mod observe;
mod outcome;
mod run;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::job::ProgramSelection;
use counterpoint_kernel::machine::package::Overlay;
use counterpoint_kernel::machine::{Machine, load};
use counterpoint_kernel::options::JobOptions;
use counterpoint_mdspec::{Example, Fence, Fences, Role, Suite};

pub use run::check;

use crate::Work;

/// The fences of pages about the emulated control.
pub const FENCES: Fences = &[
    ("toml", Role::Setup),
    ("macro", Role::Setup),
    ("nc", Role::Program),
    ("file", Role::Input),
    ("options", Role::Input),
    ("events", Role::Outcome),
    ("timed", Role::Outcome),
    ("diagnostics", Role::Outcome),
    ("texts", Role::Outcome),
    ("trace", Role::Outcome),
    ("listing", Role::Outcome),
    ("shows", Role::Outcome),
    ("log", Role::Outcome),
    ("merged", Role::Outcome),
    ("console", Role::Outcome),
    ("written", Role::Outcome),
    ("ran", Role::Outcome),
    ("findings", Role::Outcome),
    ("refused", Role::Outcome),
];

/// The folder of the pages of this kind.
#[must_use]
pub fn folder(kind: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("spec").join(kind)
}

/// The tests of a folder of pages.
#[must_use]
pub fn suite(kind: &str) -> Suite {
    Suite::of(&folder(kind), FENCES, run::check)
}

/// The program of an example.
#[derive(Debug)]
pub struct Case {
    /// Its machine, unless loading it finds errors.
    pub machine: Option<Arc<Machine>>,
    /// The machine as TOML.
    pub definition: String,
    /// The findings of loading it, one line each.
    pub findings: String,
    programs: Vec<ProgramSelection>,
    files: MemoryFiles,
    options: JobOptions,
    /// File of the job and its fence.
    fences: Vec<(String, usize)>,
}

impl Case {
    /// The program of an example.
    ///
    /// # Errors
    /// Line and reason, when the page is wrong about it: no such machine, options or TOML that cannot be read.
    pub fn of(example: &Example) -> Result<Self, (usize, String)> {
        let definition = machines::definition(example)?;
        let mut folder = MemoryFiles::default();
        folder.insert("example/machine.toml", definition.clone());
        let mut case = Self {
            machine: None,
            definition,
            findings: String::new(),
            programs: Vec::new(),
            files: MemoryFiles::default(),
            options: JobOptions::default(),
            fences: Vec::new(),
        };
        for (at, fence) in example.fences.iter().enumerate() {
            match fence.kind.as_str() {
                "macro" => folder.insert(format!("example/{}", fence.words), fence.body.text.clone()),
                "options" => {
                    case.options = toml::from_str(&fence.body.text).map_err(|e| (fence.line, e.to_string()))?
                }
                "nc" => {
                    let file = program_name(fence, case.programs.len() + 1);
                    case.programs.push(ProgramSelection {
                        file: file.clone(),
                        number: None,
                        section: None,
                        channel: None,
                    });
                    case.file(file, fence, at);
                }
                "file" => case.file(fence.words.clone(), fence, at),
                _ => {}
            }
        }
        let loaded = load(&Overlay::new(folder, crate::library()), "example");
        for finding in &loaded.findings {
            let _ = writeln!(case.findings, "{}", finding.to_string().trim_start_matches("example/"));
        }
        case.machine = loaded.machine.map(Arc::new);
        Ok(case)
    }

    fn file(&mut self, name: String, fence: &Fence, at: usize) {
        self.files.insert(name.clone(), &fence.body.text);
        self.fences.push((name, at));
    }

    /// The job, when there is something to run; with other options than those of the page.
    #[must_use]
    pub fn work(&self, change: impl FnOnce(&mut JobOptions)) -> Option<Work> {
        let machine = self.machine.clone().filter(|_| !self.programs.is_empty())?;
        let mut options = self.options.clone();
        change(&mut options);
        Some(Work { machine, files: self.files.clone(), programs: self.programs.clone(), options })
    }
}

/// The file of a program: the name after `nc`, otherwise `p1.nc`, `p2.nc`, one for each channel.
fn program_name(fence: &Fence, number: usize) -> String {
    let name = fence.words.split(' ').find(|word| !word.is_empty() && word.parse::<u16>().is_err());
    name.map_or_else(|| format!("p{number}.nc"), str::to_owned)
}
