//! No statement lacks both an effect and a report: at each place of macros, each statement that works on blocks changes
//! the log of the job, is a finding of the machine, or raises a diagnostic in the run.

use std::fmt::Write as _;
use std::sync::Arc;

use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::log::event::Kind;
use counterpoint_kernel::machine::load;
use counterpoint_kernel::machine::package::Overlay;
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::Work;

/// Places of macros: the key of the machine definition, and the rest of the macro, which lets the control act.
const PLACES: &[(&str, &str)] = &[
    ("macros.declaration = FILE", ""),
    ("macros.machine_startup = FILE", ""),
    ("macros.machine_shutdown = FILE", ""),
    ("macros.program_startup = FILE", ""),
    ("macros.program_shutdown = FILE", ""),
    ("macros.subprogram_startup = FILE", ""),
    ("macros.subprogram_shutdown = FILE", ""),
    ("macros.preprocessor_startup = FILE", ""),
    ("macros.preprocessor_shutdown = FILE", ""),
    ("macros.block_startup = FILE", ""),
    ("macros.block_shutdown = FILE", ""),
    ("macros.motion = FILE", "OUTPUT\n"),
    ("macros.tool = FILE", "OUTPUT\n"),
    ("macros.cycle = FILE", "OUTPUT\n"),
    ("macros.diagnostic = FILE", "OUTPUT\n"),
    ("macros.code = [{ match = [\"CODE_COOLANT_FLOOD\"], file = FILE }]", "OUTPUT\n"),
    ("macros.data = [{ match = [\"REG_AXIS_Y\"], file = FILE }]", ""),
];

/// Statements that work on blocks.
const STATEMENTS: &[&str] = &[
    "EXEC/NOW,'G4 P7777'",
    "EXEC/NEXT,'G4 P7777'",
    "EXEC/'G4 P7777'",
    "EXEC/NOW,CODE_COOLANT_MIST",
    "RSTMODAL",
    "SEARCH/FORWARD,'X4'",
];

const PROGRAM: &str = "O1
G90 G0 X1. Y1.
M8
T5 M6
M98 P77
G81 X3. Z-5. R2. F100
G80
X9. BOGUS
G3 X4. I1.
X5.
M30
O77
G0 Y2.
M99
";

/// The findings of the machine and the log of the job, as text.
fn shown(place: &str, text: &str) -> String {
    let definition = format!("extends = \"mill100\"\n{}\n\n[ce]\nname = \"it\"\n", place.replace("FILE", "\"it.mac\""));
    let mut folder = MemoryFiles::default();
    folder.insert("mill100/machine.toml", include_str!("../spec/machines/mill100.toml"));
    folder.insert("it/machine.toml", definition);
    folder.insert("it/it.mac", text);
    let loaded = load(&Overlay::new(folder, counterpoint_tests::library()), "it");
    let mut shown: String = loaded.findings.iter().map(|finding| format!("{}\n", finding.text)).collect();
    let Some(machine) = loaded.machine else { return shown };
    match Work::texts(Arc::new(machine), &[PROGRAM], JobOptions::default()).run(None) {
        Ok(done) => {
            for event in &done.events {
                match &event.kind {
                    Kind::Block(_) => {}
                    Kind::Diagnostic(told) => _ = writeln!(shown, "{} {}", told.number, told.text),
                    kind => _ = writeln!(shown, "{kind:?}"),
                }
            }
        }
        Err(error) => _ = writeln!(shown, "{error}"),
    }
    shown
}

#[test]
fn every_statement_has_an_effect_or_a_report() {
    let mut idle = String::new();
    for (place, rest) in PLACES {
        let plain = shown(place, &format!("%L02=1\n{rest}"));
        for statement in STATEMENTS {
            if shown(place, &format!("%L02=1\n{statement}\n{rest}")) == plain {
                _ = writeln!(idle, "{statement} in {place}");
            }
        }
    }
    assert!(idle.is_empty(), "{idle}");
}
