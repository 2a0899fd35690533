//! `[sync]`: how channels meet.
//!
//! Invariant: the form of the channel list can name every channel of the machine. Facts: reference
//! channel-synchronisation.md 1.3.

use crate::ident::{self, CodeId, codes};
use crate::model::{AlarmScope, Channel, PathsForm, Sync, SyncDialect, WaitRow};
use crate::rows::{CodeForm, CodeRow};
use crate::toml::check::FindingCollector;
use crate::toml::node::DefinitionPlace;
use crate::toml::section::TableReader;

/// Longest delay in seconds.
const LONGEST: f64 = 86_400.0;

/// Largest limit of signals.
const MOST_SIGNALS: i64 = 100_000;

/// Tick of a polling loop, ns, when the file does not say.
const POLL_NS: i64 = 1_000_000;

/// Codes at whose words channels meet.
const MARKS: [CodeId; 5] =
    [codes::SYNC_REG, codes::SYNC_REG_MAIN, codes::SYNC_REG_SIDE, codes::SYNC_REG_START, codes::SYNC_REG_STOP];

/// Further codes at which two channels meet; without a `dialect` they have no effect.
const TOGETHER: [CodeId; 6] = [
    codes::SYNC_START_MAIN,
    codes::SYNC_START_SIDE,
    codes::BALANCE_ON,
    codes::COUPLE_SYNCHRONOUS,
    codes::COUPLE_COMPOSITE,
    codes::COUPLE_SUPERIMPOSED,
];

/// Reads the section.
pub(super) fn read(
    top: &mut TableReader<'_>,
    channels: &[Channel],
    (rows, waits): (&[CodeRow], Vec<WaitRow>),
    check: &FindingCollector,
) -> Sync {
    let mut sync = Sync {
        dialect: SyncDialect::None,
        paths: PathsForm::List,
        alarm_scope: AlarmScope::Own,
        release_ns: 0,
        poll_ns: POLL_NS,
        signals: None,
        asks_for_axes: false,
        composite_places: false,
        coupling_words: Vec::new(),
        waits,
    };
    let Some(mut section) = top.table("sync", "[sync]") else {
        let meets = |row: &&CodeRow| row.enable && (MARKS.contains(&row.id) || is_together(row, channels, top.place()));
        for row in rows.iter().filter(meets) {
            if !sync.waits.iter().any(|wait| wait.is_of(&row.form)) {
                let place = DefinitionPlace { file: row.file.as_str().into(), line: row.line, column: 1 };
                check.idle(
                    &place,
                    "the word of this synchronisation has no effect: the machine has no [sync] with `dialect`",
                );
            }
        }
        return sync;
    };
    let dialects = [("none", SyncDialect::None), ("fanuc", SyncDialect::Fanuc)];
    sync.dialect = section.choice("dialect", &dialects).unwrap_or(SyncDialect::None);
    let forms = [("list", PathsForm::List), ("bits", PathsForm::Bits), ("either", PathsForm::Either)];
    sync.paths = section.choice("paths", &forms).unwrap_or(PathsForm::List);
    let scopes = [("own", AlarmScope::Own), ("all", AlarmScope::All)];
    sync.alarm_scope = section.choice("alarm_scope", &scopes).unwrap_or(AlarmScope::Own);
    sync.release_ns = nanoseconds(&mut section, "release").unwrap_or(0);
    sync.poll_ns = nanoseconds(&mut section, "poll").unwrap_or(POLL_NS);
    sync.signals = section.integer("signals", 1..=MOST_SIGNALS).map(|most| most as u32);
    let exchanges = [("commanded", false), ("automatic", true)];
    sync.asks_for_axes = section.choice("exchange", &exchanges).unwrap_or(false);
    let composites = [("continues", false), ("place", true)];
    sync.composite_places = section.choice("composite", &composites).unwrap_or(false);
    let words = section.texts("couples").unwrap_or_default();
    sync.coupling_words = words.into_iter().map(|(word, _)| word.to_owned()).collect();
    if sync.poll_ns < 1 {
        section.error("poll", "`poll` must be at least 1e-9 s: a polling loop must take time");
    }
    check_form(&section, sync.paths, channels);
    check_words(&section, &sync, channels, rows, check);
    section.finish();
    sync
}

fn nanoseconds(section: &mut TableReader<'_>, key: &'static str) -> Option<i64> {
    let seconds = section.at_least_zero(key)?;
    if seconds > LONGEST {
        section.error(key, format!("`{key}` must be at most {LONGEST} s, not {seconds}"));
        return None;
    }
    Some((seconds * 1e9).round() as i64)
}

fn check_form(section: &TableReader<'_>, form: PathsForm, channels: &[Channel]) {
    let largest = channels.iter().map(|channel| channel.number).max().unwrap_or(0);
    match form {
        PathsForm::Either if largest > 2 => {
            let text = "`paths = \"either\"` is unambiguous with channels 1 and 2 only; say \"list\" or \"bits\"";
            section.error("paths", text);
        }
        PathsForm::List if largest > 10 => {
            section.error("paths", format!("a list of digits cannot name channel {largest}, only 1 to 10"));
        }
        PathsForm::Bits if largest > 26 => {
            section.error("paths", format!("a sum of eight digits cannot name channel {largest}, only 1 to 26"));
        }
        _ => {}
    }
}

fn check_words(
    section: &TableReader<'_>,
    sync: &Sync,
    channels: &[Channel],
    rows: &[CodeRow],
    check: &FindingCollector,
) {
    let own = |row: &CodeRow| sync.waits.iter().any(|wait| wait.is_of(&row.form));
    let words = rows.iter().any(|row| MARKS.contains(&row.id) && row.enable && !own(row));
    if sync.dialect == SyncDialect::Fanuc && !words && sync.waits.is_empty() && channels.len() > 1 {
        let text = "the channels of this machine cannot meet: no row of [[codes]] has CODE_SYNC_REG";
        check.warning(section.place_of("dialect"), text);
    }
    if sync.dialect == SyncDialect::None {
        let place = section.place_of("dialect");
        let meets = |row: &CodeRow| MARKS.contains(&row.id) || is_together(row, channels, place);
        let idle = |row: &&CodeRow| row.enable && !own(row) && meets(row);
        if let Some(row) = rows.iter().find(idle) {
            let name = ident::code_facts(row.id).map_or("CODE_SYNC_REG", |facts| facts.name);
            let text = format!("{name} has a word, but `dialect` is \"none\": the word will do nothing");
            check.warning(section.place_of("dialect"), text);
        }
    }
}

/// Whether channels meet at the code of a row of the same file on a machine with several channels. A family may have
/// such rows for other machines.
fn is_together(row: &CodeRow, channels: &[Channel], place: &DefinitionPlace) -> bool {
    let own = row.file == *place.file && row.form != CodeForm::NotApplicable;
    own && channels.len() > 1 && TOGETHER.contains(&row.id)
}
