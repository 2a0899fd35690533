//! `[[waits]]`: words, texts and statements at which channels wait for each other, under any name.
//!
//! Invariant: every word and every text has exactly one row of the code table, with `CODE_SYNC_REG`; a statement has
//! none. Facts: reference channel-synchronisation.md 1.1.

use counterpoint_event::event::Primitive;

use crate::ident::codes;
use crate::index::RegisterId;
use crate::model::{MismatchRule, SignalRow, WaitAct, WaitRow};
use crate::preprocessor::Preprocessor;
use crate::rows::{CodeForm, CodeRow, Register};
use crate::toml::check::FindingCollector;
use crate::toml::node::{DefinitionPlace, Node, TomlEntry, TomlTable, TomlValue};
use crate::toml::section::TableReader;

/// Most rows.
const MOST: usize = 200;

/// Highest mark.
const HIGHEST: u32 = 99_999_999;

/// Keys that a row of `[[waits]]` and its row of the code table share.
const OF_CODES: [&str; 5] = ["word", "text", "with", "without", "ignores"];

/// The purpose of a row.
const FORMS: [&str; 4] = ["word", "text", "line_up", "statement"];

/// Adds the rows of the code table that the words and texts of `[[waits]]` need.
pub(super) fn expand(table: &mut TomlTable) {
    let Some(TomlValue::Array(waits)) = table.get("waits").map(|node| &node.value) else { return };
    let made: Vec<Node> = waits.iter().filter_map(code_row).collect();
    let Some(place) = made.first().map(|row| row.place.clone()) else { return };
    if table.get("codes").is_none() {
        table.entries.push(entry("codes", &place, TomlValue::Array(Vec::new())));
    }
    let codes = table.entries.iter_mut().find(|entry| entry.key == "codes").map(|entry| &mut entry.node.value);
    if let Some(TomlValue::Array(rows)) = codes {
        rows.extend(made);
    }
}

fn code_row(wait: &Node) -> Option<Node> {
    let TomlValue::Table(table) = &wait.value else { return None };
    if ["word", "text", "line_up"].iter().all(|form| table.get(form).is_none()) {
        return None;
    }
    let mut entries: Vec<TomlEntry> =
        table.entries.iter().filter(|entry| OF_CODES.contains(&entry.key.as_str())).cloned().collect();
    if let Some(mark) = table.get("line_up") {
        entries.push(entry("text", &mark.place, mark.value.clone()));
    }
    entries.push(entry("id", &wait.place, TomlValue::Text("CODE_SYNC_REG".to_owned())));
    if table.get("word").is_some() {
        entries.push(entry("as_data", &wait.place, TomlValue::Text("REG_SYNC".to_owned())));
    }
    Some(Node { place: wait.place.clone(), value: TomlValue::Table(TomlTable { entries }) })
}

fn entry(key: &str, place: &DefinitionPlace, value: TomlValue) -> TomlEntry {
    TomlEntry { key: key.to_owned(), place: place.clone(), node: Node { place: place.clone(), value } }
}

/// Reads the rows, which have their rows of the code table by now.
pub(super) fn read(
    top: &mut TableReader<'_>,
    (rows, registers): (&[CodeRow], &crate::index::IdTable<RegisterId, Register>),
    (preprocessor, composite): (Preprocessor, bool),
    channels: usize,
    check: &FindingCollector,
) -> Vec<WaitRow> {
    let mut waits = Vec::new();
    // A family may have rows for machines with several channels.
    let alone = (channels == 1 && !composite).then(|| std::sync::Arc::clone(&top.place().file));
    for mut section in top.rows("waits", "[[waits]]", MOST) {
        for key in OF_CODES {
            section.node(key);
        }
        let row = read_row(&mut section, preprocessor.row().wait_keys, check);
        let statement = statement(&mut section, preprocessor, composite);
        let place = section.place().clone();
        section.finish();
        if alone.as_deref() == Some(&*place.file) {
            check.idle(&place, "[[waits]] on a machine with one channel: no other channel can arrive, nothing waits");
        }
        if let Some((row, word)) = row.as_ref().zip(statement) {
            waits.push(WaitRow { word, ..row.clone() });
            continue;
        }
        let code = rows.iter().find(|code| code.line == place.line && *code.file == *place.file);
        let Some((row, code)) = row.zip(code.filter(|code| code.id == codes::SYNC_REG)) else { continue };
        let word = word(&code.form, registers);
        waits.push(WaitRow { form: Some(code.form.clone()), word, ..row });
    }
    waits
}

/// Name of a statement of the pre-processor, in capitals. Of a composite machine and its components one may have it.
fn statement(section: &mut TableReader<'_>, preprocessor: Preprocessor, composite: bool) -> Option<String> {
    let name = section.name("statement", 32)?.to_ascii_uppercase();
    if OF_CODES.iter().any(|key| section.node(key).is_some()) {
        section.error("statement", "a row with `statement` cannot have `word`, `text` or a condition of a code");
    } else if !preprocessor.row().wait_statements && !composite {
        let name = preprocessor.row().name;
        section.error("statement", format!("the pre-processor \"{name}\" has no statements between channels"));
    } else if name.len() < 2 || !name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_') {
        section.error("statement", "a statement has a name of letters, digits and underscores, at least two");
    }
    Some(name)
}

fn read_row(section: &mut TableReader<'_>, keys: bool, check: &FindingCollector) -> Option<WaitRow> {
    if FORMS.iter().all(|form| section.node(form).is_none()) {
        check
            .error(section.place(), "[[waits]] needs a form: `word` (\"M100-M149\"), `text`, `line_up` or `statement`");
    }
    let primitives = [
        ("barrier", Primitive::Barrier),
        ("flag", Primitive::Flag),
        ("order", Primitive::Order),
        ("count", Primitive::Count),
        ("signal", Primitive::Signal),
        ("join", Primitive::Join),
        ("lease", Primitive::Lease),
    ];
    section.require("primitive", "what the word waits for");
    let primitive = section.choice("primitive", &primitives);
    let acts = [
        ("wait", WaitAct::Wait),
        ("set", WaitAct::Set),
        ("clear", WaitAct::Clear),
        ("signal", WaitAct::Signal),
        ("release", WaitAct::Release),
        ("take", WaitAct::Take),
        ("give", WaitAct::Give),
        ("select", WaitAct::Select),
        ("start", WaitAct::Start),
    ];
    let act = section.choice("act", &acts).unwrap_or(WaitAct::Wait);
    let mark = section.integer("mark", 0..=i64::from(HIGHEST)).unwrap_or(0) as u32;
    let highest = section.integer("highest", 0..=i64::from(HIGHEST)).map_or(HIGHEST, |highest| highest as u32);
    let need = section.integer("need", 1..=99).unwrap_or(0) as u16;
    let absent = section.choice("absent", &[("missed", false), ("counts", true)]);
    let mismatches = [("free", MismatchRule::Free), ("fanuc", MismatchRule::Fanuc), ("siemens", MismatchRule::Siemens)];
    let mismatch = section.choice("mismatch", &mismatches).unwrap_or(MismatchRule::Free);
    let met_by = section.choice("met_by", &[("order", Primitive::Order)]);
    let line_up = section.name("line_up", 1).filter(|mark| line_up_mark(section, mark));
    let signals = signals(section, keys);
    let stops = section.flag("stops").unwrap_or(true);
    if !stops && (act != WaitAct::Wait || !matches!(primitive, Some(Primitive::Flag | Primitive::Barrier))) {
        section.error("stops", "only a wait at a flag or a barrier can be passed without a stop");
    }
    let primitive = primitive?;
    check_row(section, check, (primitive, act, mismatch));
    Some(WaitRow {
        form: None,
        word: String::new(),
        primitive,
        act,
        mark,
        highest,
        need,
        met_by,
        line_up: line_up.is_some(),
        absent_counts: absent.unwrap_or(primitive == Primitive::Order),
        stops,
        mismatch,
        signals,
    })
}

/// The data of a row about signals.
fn signals(section: &mut TableReader<'_>, keys: bool) -> SignalRow {
    let stays = section.choice("broadcast", &[("each", false), ("stays", true)]).unwrap_or(false);
    let in_order = section.flag("in_order").unwrap_or(false);
    let keys = keys && section.node("statement").is_some();
    if stays && !keys {
        section.error("broadcast", "only statements with key words can remove a signal that stays");
    }
    if in_order && !keys {
        section.error("in_order", "`in_order` is for statements with key words");
    }
    SignalRow { keys, stays, in_order }
}

/// A mark that words begin with at which systems line up, if it can be one.
fn line_up_mark(section: &mut TableReader<'_>, mark: &str) -> bool {
    let good = mark.bytes().all(|byte| byte.is_ascii_punctuation()) && !mark.is_empty();
    if !good {
        section.error("line_up", "`line_up` is one character that is neither a letter nor a digit");
    }
    if ["word", "text"].iter().any(|form| section.node(form).is_some()) {
        section.error("line_up", "a row has one form: `word`, `text`, `line_up` or `statement`");
    }
    good
}

/// Keys that do not go together.
fn check_row(
    section: &mut TableReader<'_>,
    check: &FindingCollector,
    (primitive, act, mismatch): (Primitive, WaitAct, MismatchRule),
) {
    let fits = match act {
        WaitAct::Wait => true,
        WaitAct::Set | WaitAct::Clear => primitive == Primitive::Flag,
        WaitAct::Signal => primitive == Primitive::Signal,
        WaitAct::Release => primitive == Primitive::Lease,
        WaitAct::Take | WaitAct::Give => primitive == Primitive::Lease && section.node("statement").is_some(),
        WaitAct::Select | WaitAct::Start => primitive == Primitive::Join && section.node("statement").is_some(),
    };
    if !fits {
        let text = "`act` does not go with this primitive: flags are set and cleared, signals are sent by \"signal\", leases \
                    are given back by \"release\", and statements \"take\" and \"give\" them, or \"select\" and \"start\" the programs of a join";
        section.error("act", text);
    }
    let fits = match mismatch {
        MismatchRule::Free => true,
        MismatchRule::Fanuc => primitive == Primitive::Barrier,
        MismatchRule::Siemens => primitive == Primitive::Flag,
    };
    if !fits {
        section.error("mismatch", "\"fanuc\" is a rule for barriers, \"siemens\" one for flags");
    }
    if section.node("line_up").is_some() && primitive != Primitive::Barrier {
        section.error("primitive", "systems line up at a barrier");
    }
    if section.node("met_by").is_some() && primitive != Primitive::Count {
        check.warning(section.place_of("met_by"), "`met_by` is for a count: other primitives need their partners");
    }
    if section.node("need").is_some() && primitive != Primitive::Count {
        check.warning(section.place_of("need"), "`need` is for a count: this primitive needs all channels of its list");
    }
    if section.node("broadcast").is_some() && act != WaitAct::Signal {
        check.warning(section.place_of("broadcast"), "`broadcast` is for `act = \"signal\"`");
    }
    if section.node("in_order").is_some() && (primitive != Primitive::Signal || act != WaitAct::Wait) {
        check.warning(section.place_of("in_order"), "`in_order` is for waits for signals");
    }
    if section.node("highest").is_some() && section.node("statement").is_none() {
        check.warning(section.place_of("highest"), "`highest` is for a `statement`: a word has a range of numbers");
    }
    if section.node("mark").is_some() && section.node("text").is_none() {
        check.warning(section.place_of("mark"), "`mark` is for a `text`: a word has its mark in its number");
    }
}

/// The text, or the letters of the word.
fn word(form: &CodeForm, registers: &crate::index::IdTable<RegisterId, Register>) -> String {
    match form {
        CodeForm::Text(text) => text.clone(),
        CodeForm::Register { register, .. } | CodeForm::RegisterAsData { register, .. } => {
            registers[*register].name.clone()
        }
        CodeForm::NotApplicable => String::new(),
    }
}
