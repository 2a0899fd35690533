//! The columns of the data table apply to every value that macros take, in every way of taking it.
//!
//! Every column of `[[data]]` is set in turn, and the value is taken in every way, in millimetres and in inches. All
//! columns apply to written values. Added values (`$FCEADD`, EXEC with identifiers) are final: they need an enabled
//! row, and no column changes them. Macros see a value before the conversion from inches, actions see it afterwards.
//!
//! *Invariant:* the columns of the test are the keys of the table in `docs/machine-definition.md`.

use std::fmt::Write as _;
use std::sync::Arc;

use counterpoint_kernel::diag;
use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::log::event::Kind;
use counterpoint_kernel::machine::load;
use counterpoint_kernel::machine::package::Overlay;
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::Work;

/// How the value 5 reaches the macro or the action.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    /// `$FCEGET` of a word.
    Get,
    /// `$FCESEEK` of a word.
    Seek,
    /// `$FCESEEK` with MODAL, after `$FCEGET`.
    Modal,
    /// `$FCEGET` of a word that EXEC has written as text.
    Text,
    /// `$P2` of a data macro that `$FCEGET` runs.
    DataMacro,
    /// `$FCEGET` of the value of a code.
    Code,
    /// `$FCEGET` of a value that `$FCEADD` has added.
    Added,
    /// `$FCEGET` of a value that EXEC has added.
    Executed,
    /// A built-in action takes a word.
    Action,
    /// `$P2` of a data macro that a built-in action runs.
    ActionMacro,
    /// A built-in action takes the value of a code.
    ActionCode,
}

const WAYS: [Way; 11] = [
    Way::Get,
    Way::Seek,
    Way::Modal,
    Way::Text,
    Way::DataMacro,
    Way::Code,
    Way::Added,
    Way::Executed,
    Way::Action,
    Way::ActionMacro,
    Way::ActionCode,
];

impl Way {
    fn is_action(self) -> bool {
        matches!(self, Self::Action | Self::ActionMacro | Self::ActionCode)
    }

    fn is_added(self) -> bool {
        matches!(self, Self::Added | Self::Executed)
    }

    fn is_code(self) -> bool {
        matches!(self, Self::Code | Self::ActionCode)
    }

    fn block(self) -> &'static str {
        match self {
            Self::Get | Self::Seek | Self::Modal | Self::DataMacro => "M8 E5",
            Self::Text => "M7",
            Self::Code => "M405",
            Self::Added => "M8",
            Self::Executed => "M9",
            Self::Action | Self::ActionMacro => "G4 E5",
            Self::ActionCode => "G405",
        }
    }

    /// The macro of M8.
    fn flood(self) -> &'static str {
        match self {
            Self::Seek => "PPRINT/'!(*)',$FCESEEK(REG_MYE)\n%L01=$FCEGET(REG_MYE)\n",
            Self::Modal => "%L01=$FCEGET(REG_MYE)\nPPRINT/'!(*)',$FCESEEK(REG_MYE,MODAL)\n",
            Self::Added => "%L01=$FCEADD(REG_MYE,5)\nPPRINT/'!(*)',$FCEGET(REG_MYE)\n",
            Self::DataMacro => "%L01=$FCEGET(REG_MYE)\n",
            _ => "PPRINT/'!(*)',$FCEGET(REG_MYE)\n",
        }
    }
}

/// A column and its value as written in the table; blank if no column is set.
const COLUMNS: &[(&str, &str)] = &[
    ("", ""),
    ("id", ""),
    ("custom", ""),
    ("register", "none"),
    ("modal", "true"),
    ("enable", "false"),
    ("process", "false"),
    ("min", "6"),
    ("max", "4"),
    ("mul", "2"),
    ("add", "1"),
    ("dimension", "\"none\""),
    ("dimension", "\"length\""),
    ("dimension", "\"increments\""),
    ("dimension", "\"angle\""),
    ("dimension", "\"feed\""),
    ("dimension", "\"feed-tenths\""),
    ("dimension", "\"surface-speed\""),
    ("dimension", "\"time\""),
    ("increment", "[0.01, 0.001]"),
];

/// The value that is taken, if any, and the complaint.
#[derive(Debug, PartialEq)]
struct Taken {
    value: Option<f64>,
    complaint: Option<&'static str>,
}

/// The rules of the columns.
fn expected(way: Way, (column, setting): (&str, &str), inches: bool) -> Taken {
    let of_value = |value: f64| Taken { value: Some(value), complaint: None };
    let none = |complaint| Taken { value: None, complaint };
    let remembered = way != Way::Modal || column == "modal";
    if way.is_added() {
        return match column {
            "enable" if way == Way::Executed => none(Some("missing-word")),
            "enable" => none(None),
            _ => of_value(5.0),
        };
    }
    // Without a row the word is unknown, and the value of a code has no columns.
    if column == "enable" || column == "register" {
        return if way.is_code() { of_value(5.0) } else { none(Some("unknown-text")) };
    }
    let value = match (column, setting) {
        ("process", _) => return none(Some("word-not-processed")),
        ("min" | "max", _) => {
            let value = if remembered { Some(5.0) } else { None };
            return Taken { value, complaint: Some("value-out-of-range") };
        }
        ("mul", _) => 10.0,
        ("add", _) => 6.0,
        ("dimension", "\"increments\"") if inches && way == Way::Action => 5.0 * 0.0001,
        ("dimension", "\"increments\"") => 5.0 * 0.001,
        // The number of a code is not a number without a decimal point.
        ("increment", _) if !way.is_code() => 5.0 * if inches { 0.001 } else { 0.01 },
        _ => 5.0,
    };
    // A surface speed stays in the unit of the program; the spindle converts it.
    let converted = match setting {
        "\"length\"" | "\"increments\"" | "\"feed\"" => 25.4,
        "\"feed-tenths\"" => 2.54,
        _ => 1.0,
    };
    let acts = matches!(way, Way::Action | Way::ActionCode);
    Taken { value: remembered.then_some(if acts && inches { value * converted } else { value }), complaint: None }
}

/// The machine of a way with one column set.
fn machine(way: Way, (column, setting): (&str, &str)) -> MemoryFiles {
    let (id, custom) = if way.is_action() { ("REG_DELAY", false) } else { ("REG_MYE", true) };
    let register = if way.is_code() || column == "register" { "" } else { "register = \"E\", " };
    let set =
        if setting.is_empty() || column == "register" { String::new() } else { format!(", {column} = {setting}") };
    let numbers = if column == "increment" { "increments" } else { "as-written" };
    let mut definition = format!(
        "extends = \"fanuc-mill-exact\"\ncontrol.numbers = \"{numbers}\"\nregisters = [{{ index = 60, name = \"E\", whole = 4, frac = 3, \
         signed = true, point = \"keep\" }}]\n"
    );
    // Without these the rows of the family would apply.
    let own = "  { id = \"REG_DELAY\", register = \"P\", enable = false },\n  { id = \"REG_DELAY\", register = \"X\", enable = false },\n";
    let others = if way.is_action() { own } else { "" };
    _ = writeln!(definition, "data = [\n{others}  {{ id = \"{id}\", {register}custom = {custom}{set} }},\n]");
    let code = if way.is_action() { ("CODE_DELAY", "G405") } else { ("CODE_MYC", "M405") };
    _ = writeln!(
        definition,
        "codes = [{{ id = \"{}\", word = \"{}\", custom = {custom2}, as_data = \"{id}\", add = -400 }}]",
        code.0,
        code.1,
        custom2 = !way.is_action(),
    );
    if !way.is_action() {
        let rows = [
            ("CODE_COOLANT_FLOOD", "flood.mac"),
            ("CODE_COOLANT_MIST", "text.mac"),
            ("CODE_COOLANT_OFF", "executed.mac"),
            ("CODE_MYC", "flood.mac"),
        ];
        let codes: String =
            rows.iter().map(|(code, file)| format!("  {{ match = [\"{code}\"], file = \"{file}\" }},\n")).collect();
        _ = writeln!(definition, "macros.code = [\n{codes}]");
    }
    if matches!(way, Way::DataMacro | Way::ActionMacro) {
        _ = writeln!(definition, "macros.data = [{{ match = [\"{id}\"], file = \"data.mac\" }}]");
    }
    definition += "\n[ce]\nname = \"values\"\n";
    let mut folder = MemoryFiles::default();
    folder.insert("values/machine.toml", definition);
    folder.insert("values/flood.mac", way.flood());
    folder.insert("values/text.mac", "EXEC/NOW,'M8 E5'\n");
    folder.insert("values/executed.mac", "EXEC/NOW,CODE_COOLANT_FLOOD,REG_MYE,5\n");
    folder.insert("values/data.mac", "PPRINT/'!(*)',$P2\n");
    folder
}

/// The value that is taken, or the reason why the job could not be made.
fn taken(way: Way, column: (&str, &str), inches: bool) -> Result<Taken, String> {
    let loaded = load(&Overlay::new(machine(way, column), counterpoint_tests::library()), "values");
    let machine = loaded.machine.ok_or_else(|| format!("{:?}", loaded.findings))?;
    let text = format!("{}{}\nM30\n", if inches { "G20\n" } else { "" }, way.block());
    let done =
        Work::texts(Arc::new(machine), &[text], JobOptions::default()).run(None).map_err(|why| why.to_string())?;
    let mut taken = Taken { value: None, complaint: None };
    for event in &done.events {
        match &event.kind {
            Kind::Message(message) => taken.value = message.text.parse().ok().or(taken.value),
            Kind::Dwell(_) if way != Way::ActionMacro => taken.value = Some(event.dur_ns as f64 / 1e9),
            Kind::Diagnostic(told) => taken.complaint = taken.complaint.or(diag::name(told.number)),
            _ => {}
        }
    }
    Ok(taken)
}

#[test]
fn every_column_holds_for_every_way() {
    let mut wrong = String::new();
    for column in COLUMNS {
        for way in WAYS {
            for inches in [false, true] {
                let expected = expected(way, *column, inches);
                let same = |found: &Taken| {
                    let near = match (found.value, expected.value) {
                        (Some(one), Some(two)) => (one - two).abs() < 1e-6,
                        (one, two) => one.is_none() && two.is_none(),
                    };
                    near && found.complaint == expected.complaint
                };
                match taken(way, *column, inches) {
                    Ok(found) if same(&found) => {}
                    found => _ = writeln!(wrong, "{column:?} {way:?} inches {inches}: {found:?}, not {expected:?}"),
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn the_columns_are_those_of_the_table() {
    let page = include_str!("../../docs/machine-definition.md");
    let section = page.split("\n## ").find(|section| section.starts_with("`[[data]]`")).expect("a section");
    let rows = section.lines().filter_map(|line| line.strip_prefix("| `")?.split_once(" |")).map(|(keys, _)| keys);
    let mut keys: Vec<&str> = rows.flat_map(|keys| keys.split(", ")).map(|key| key.trim_matches('`')).collect();
    let mut known: Vec<&str> = COLUMNS.iter().map(|(column, _)| *column).filter(|column| !column.is_empty()).collect();
    keys.sort_unstable();
    known.sort_unstable();
    known.dedup();
    assert_eq!(known, keys);
}
