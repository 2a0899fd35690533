//! Each kind of thing that channels share is judged for races, or has a rule of its own.

use std::sync::Arc;

use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::machine::package::Overlay;
use counterpoint_kernel::machine::{Machine, load};
use counterpoint_kernel::options::{JobOptions, RacePolicy};
use counterpoint_tests::{Work, machine};

const RACE: u32 = 2_900_440;
const SPINDLE: u32 = 2_900_022;

/// Numbers and texts of the reports about two programs, the same with one thread as with two.
fn reported(machine: &Arc<Machine>, texts: &[&str]) -> Vec<(u32, String)> {
    let options = JobOptions { races: RacePolicy::Warn, ..JobOptions::default() };
    let mut work = Work::texts(Arc::clone(machine), texts, options);
    let done = work.run(None).unwrap();
    work.options.threads = 1;
    assert_eq!(work.run(None).unwrap().summary, done.summary);
    done.summary.diagnostics.iter().map(|one| (one.number, one.text.to_string())).collect()
}

/// A lathe whose blocks write a variable of all channels.
fn counting() -> Arc<Machine> {
    let mut user = MemoryFiles::default();
    let toml =
        "extends = \"fanuc-2path-lathe-exact\"\n[ce]\nname = \"counting\"\n[macros]\nblock_startup = \"m.mac\"\n";
    user.insert("counting/machine.toml", toml);
    user.insert("counting/m.mac", "DECLAR/GLOBAL,REAL,COUNTED\nCOUNTED=1\n");
    let loaded = load(&Overlay::new(user, counterpoint_tests::library()), "counting");
    loaded.machine.map(Arc::new).unwrap_or_else(|| panic!("{:#?}", loaded.findings))
}

#[test]
fn global_variables_of_macros_race() {
    let found = reported(&counting(), &["G4P10\nM30\n", "G4P10\nM30\n"]);
    assert!(!found.is_empty() && found.iter().all(|(number, _)| *number == RACE), "{found:?}");
    assert!(found.iter().all(|(_, text)| text.contains("COUNTED")), "{found:?}");
}

#[test]
fn spindles_have_a_rule_of_their_own() {
    let found = reported(&machine("fanuc-2path-lathe-exact", ""), &["G97S500M3\nM30\n", "G97S600M3\nM30\n"]);
    assert_eq!(found.iter().map(|(number, _)| *number).collect::<Vec<_>>(), [SPINDLE], "{found:?}");
}

#[test]
fn lines_of_several_channels_in_one_file_are_in_order() {
    let program = "POPEN\nDPRNT[A]\nG4P10\nDPRNT[B]\nPCLOS\nM30\n";
    assert_eq!(reported(&machine("fanuc-2path-lathe-exact", ""), &[program, program]), []);
}
