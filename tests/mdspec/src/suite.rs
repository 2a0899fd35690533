//! One test an example: names, filters, `--list` and threads as `cargo test` has them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};

use libtest_mimic::{Arguments, Failed, Trial};

use crate::check::Check;
use crate::page::{Example, Fences, Page};
use crate::update::{Edit, rewritten};

type Edits = Arc<Mutex<BTreeMap<PathBuf, Vec<Edit>>>>;

/// The tests of a folder of pages.
#[derive(Default)]
pub struct Suite {
    trials: Vec<Trial>,
    edits: Edits,
    pages: Vec<Page>,
}

impl Suite {
    /// Every example of the pages of a folder becomes a test: `run` returns its result. With `UPDATE` in the
    /// environment the result is written into the pages.
    ///
    /// A page that cannot be read becomes a test that fails with the line that is wrong.
    #[must_use]
    pub fn of(folder: &Path, fences: Fences, run: fn(&Example, &mut Check<'_>)) -> Self {
        let mut paths: Vec<PathBuf> = match std::fs::read_dir(folder) {
            Ok(entries) => entries.filter_map(|entry| Some(entry.ok()?.path())).collect(),
            Err(_) => Vec::new(),
        };
        paths
            .retain(|path| path.extension().is_some_and(|extension| extension == "md") && !path.ends_with("README.md"));
        paths.sort();
        let mut suite = Self::default();
        if paths.is_empty() {
            let text = format!("there are no pages in {}", folder.display());
            suite.test("pages", move || Err(text));
        }
        for path in paths {
            let Some(page) = suite.read(&path, fences) else { continue };
            for example in page.examples {
                suite.trial(&path, &example.name.clone(), vec![example], move |examples, check| {
                    examples.iter().for_each(|example| run(example, check));
                });
            }
        }
        suite
    }

    /// One page becomes one test, for pages whose examples build on each other.
    #[must_use]
    pub fn whole(path: &Path, fences: Fences, run: fn(&[Example], &mut Check<'_>)) -> Self {
        let mut suite = Self::default();
        if let Some(page) = suite.read(path, fences) {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            suite.trial(path, &name, page.examples, run);
        }
        suite
    }

    /// The page, or none and a test that fails with the line that is wrong.
    fn read(&mut self, path: &Path, fences: Fences) -> Option<Page> {
        let shown = shown(path);
        let (line, text) = match Page::read(path, fences) {
            Ok(page) if !page.examples.is_empty() => {
                self.pages.push(page.clone());
                return Some(page);
            }
            Ok(_) => (1, "no examples".to_owned()),
            Err(fault) => (fault.line, fault.text),
        };
        self.test(&shown.clone(), move || Err(format!("{shown}:{line}: {text}")));
        None
    }

    fn trial(
        &mut self,
        path: &Path,
        name: &str,
        examples: Vec<Example>,
        run: impl FnOnce(&[Example], &mut Check<'_>) + Send + 'static,
    ) {
        let update = std::env::var_os("UPDATE").is_some_and(|value| value != "0");
        let (edits, path, shown) = (Arc::clone(&self.edits), path.to_owned(), shown(path));
        self.test(name, move || {
            let Some(first) = examples.first() else { return Ok(()) };
            let mut check = Check::new(&shown, first);
            run(&examples, &mut check);
            let (wrong, changes) = check.finish();
            if wrong.is_empty() {
                return Ok(());
            }
            if update && !changes.is_empty() {
                edits.lock().unwrap_or_else(PoisonError::into_inner).entry(path).or_default().extend(changes);
                return Ok(());
            }
            let hint = if changes.is_empty() { "" } else { "\nUPDATE=1 writes what was found into the page" };
            Err(format!("{}{hint}", wrong.trim_end()))
        });
    }

    /// The pages that could be read.
    #[must_use]
    pub fn pages(&self) -> &[Page] {
        &self.pages
    }

    /// Another test of this suite.
    pub fn test(&mut self, name: &str, test: impl FnOnce() -> Result<(), String> + Send + 'static) {
        self.trials.push(Trial::test(name, move || test().map_err(Failed::from)));
    }

    /// Runs the tests that the command line requests, and writes the edits that `UPDATE` requests.
    #[must_use]
    pub fn run(self) -> ExitCode {
        let conclusion = libtest_mimic::run(&Arguments::from_args(), self.trials);
        let edits = self.edits.lock().unwrap_or_else(PoisonError::into_inner);
        for (path, edits) in edits.iter() {
            let Some(page) = self.pages.iter().find(|page| page.path == *path) else { continue };
            if let Err(error) = std::fs::write(path, rewritten(&page.text, edits)) {
                report(&format!("{}: {error}", path.display()));
                return ExitCode::FAILURE;
            }
            report(&format!("updated {}", shown(path)));
        }
        conclusion.exit_code()
    }
}

#[allow(clippy::print_stderr, reason = "the harness of a test")]
fn report(text: &str) {
    eprintln!("{text}");
}

/// The page as a failure names it: without the path to the project.
fn shown(path: &Path) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap_or(Path::new(""));
    let path = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    path.strip_prefix(root).unwrap_or(&path).display().to_string()
}
