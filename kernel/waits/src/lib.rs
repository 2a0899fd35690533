//! The waits of a machine: from a word or a statement of the program to a wait or an act of `sync`, by the machine's
//! data.
//!
//! *Invariant:* the kernels and the coordinator of a job name the rules in the same way. Facts: reference
//! channel-synchronisation.md 1.0 to 1.9.

pub mod balance;
mod channels;
pub mod coupling;
mod fanuc;
pub mod leases;
mod line_up;
mod siemens;
mod signals;
mod statements;

pub use leases::of_axis;
pub use line_up::of_systems;
pub use signals::{signal, signal_number, signal_wait};
pub use statements::{WaitStatement, by_statement, known_channel, operands};

use counterpoint_event::event::Primitive;
use counterpoint_machine::ident::CodeId;
use counterpoint_machine::index::RegisterId;
use counterpoint_machine::model;
use counterpoint_machine::model::{Machine, WaitAct, WaitRow};
use counterpoint_machine::rows::{CodeForm, CodeRow};
use counterpoint_sync::wait::{
    Absent, ChannelSet, Lasts, MarkSpace, RuleId, Send, Wait, WaitMark, WaitNotation, WaitOp, WaitRule, WaitRules,
};

/// Letters of the marks of both heads: on each, at the start of a stretch, at its end.
const HEADS: [char; 3] = ['S', 'B', 'E'];

/// The meaning of a word of the program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Meaning {
    /// It waits.
    Wait(Wait),
    /// It does something for others, which is shown as this wait would be.
    Act(WaitOp, Wait),
}

/// Data of a block at a waiting code.
#[derive(Debug, Clone, Copy)]
pub struct WaitArguments {
    /// Channel of the program.
    pub channel: u16,
    /// Number of the mark.
    pub number: u32,
    /// Value of the list of channels.
    pub list: Option<f64>,
}

/// The rules of all waits of a machine. The rules of a composite machine and of its components have the same
/// identifiers, regardless of their registers.
#[must_use]
pub fn rules(machine: &Machine) -> WaitRules {
    let start = std::iter::once((RuleId::Start, WaitRule::plain("START")));
    let heads = (0..).zip(HEADS).map(|(at, letter)| (RuleId::Head(at), fanuc::rule(&letter.to_string())));
    let bare = std::iter::once((RuleId::Bare, fanuc::rule("M")));
    let letters = ('A'..='Z').map(|letter| (RuleId::Letter(letter), fanuc::rule(&letter.to_string())));
    let rows = (0..).zip(&machine.sync.waits).map(|(at, row)| (RuleId::Row(at), rule(machine, row)));
    let balance = (0..).zip(balance::rules(machine)).map(|(at, rule)| (RuleId::Balance(at), rule));
    let couplings = (0..).zip(coupling::rules(machine)).map(|(at, rule)| (RuleId::Coupling(at), rule));
    WaitRules::new(start.chain(heads).chain(bare).chain(letters).chain(rows).chain(balance).chain(couplings))
}

/// The word of the first row with a code, of the machine or of one of its components.
fn word(machine: &Machine, id: CodeId) -> Option<String> {
    let own = machine.codes.iter().filter(|row| row.id == id && row.enable).find_map(|row| match row.form {
        CodeForm::Register { register, min, .. } => Some(format!("{}{min}", machine.registers[register].name)),
        _ => None,
    });
    own.or_else(|| machine.components.iter().find_map(|component| word(&component.machine, id)))
}

/// The rule of codes of a letter.
fn of_letter(letter: char) -> RuleId {
    let letter = letter.to_ascii_uppercase();
    if letter.is_ascii_uppercase() { RuleId::Letter(letter) } else { RuleId::Bare }
}

fn letter(name: &str) -> char {
    name.chars().next().unwrap_or('M')
}

/// The rule of a row of `[[waits]]`.
fn rule(machine: &Machine, row: &WaitRow) -> WaitRule {
    WaitRule {
        word: if row.signals.keys { signals::word(row) } else { row.word.as_str().into() },
        numbered: match &row.form {
            Some(form) => !matches!(form, CodeForm::Text(_)),
            None => statements::has_mark(row.primitive),
        } || row.line_up,
        list: " P".into(),
        style: match row.form {
            None if row.signals.keys => WaitNotation::Keys,
            None => WaitNotation::Statement,
            Some(_) if row.line_up => WaitNotation::LineUp,
            Some(_) => WaitNotation::Word,
        },
        met_by: row.met_by,
        mismatch: match row.mismatch {
            model::MismatchRule::Free => None,
            model::MismatchRule::Fanuc => Some(fanuc::MISMATCH),
            model::MismatchRule::Siemens => Some(siemens::MISMATCH),
        },
        absent: if row.absent_counts { Absent::Counts } else { Absent::Missed },
        signals: signals::rule(machine, row),
        acts: false,
        names: if statements::takes_axes(row) { leases::names(machine) } else { Default::default() },
    }
}

/// Whether the path need not stop at a wait.
pub fn is_passed_in_motion(machine: &Machine, wait: &Wait) -> bool {
    let RuleId::Row(row) = wait.rule else { return false };
    machine.sync.waits.get(usize::from(row)).is_some_and(|row| !row.stops)
}

/// All channels of the machine.
fn all(machine: &Machine) -> ChannelSet {
    machine.channels.iter().map(|channel| channel.number).collect()
}

/// The first two channels.
pub fn heads(machine: &Machine) -> ChannelSet {
    machine.channels.iter().take(2).map(|channel| channel.number).collect()
}

/// The mark of both heads with one of their letters.
pub fn head_mark(letter: char, number: u32, heads: ChannelSet) -> Wait {
    let index = HEADS.iter().position(|head| *head == letter).unwrap_or(0);
    barrier(letter, number, (None, heads), RuleId::Head(index as u16))
}

/// The start of the other head by this one, and the wait of the other head for it.
pub fn start(by: u16, heads: ChannelSet) -> (WaitOp, Wait) {
    let key = WaitMark { space: MarkSpace::Letter('S'), number: u32::from(by) };
    let wait = Wait { primitive: Primitive::Signal, key, named: None, parts: heads, need: 0, rule: RuleId::Start };
    (WaitOp::Signal(Send { key, to: heads.without(by), broadcast: false, lasts: Lasts::Each }), wait)
}

fn barrier(letter: char, number: u32, (named, parts): (Option<ChannelSet>, ChannelSet), rule: RuleId) -> Wait {
    let key = WaitMark { space: MarkSpace::Letter(letter), number };
    Wait { primitive: Primitive::Barrier, key, named, parts, need: 0, rule }
}

/// The meaning of a waiting code of the machine.
///
/// # Errors
/// Why its list of channels is not possible.
pub fn meaning(machine: &Machine, code: &CodeRow, said: WaitArguments) -> Result<Meaning, String> {
    let index = machine.sync.waits.iter().position(|row| row.is_of(&code.form));
    match index.and_then(|index| Some((index, machine.sync.waits.get(index)?))) {
        Some((index, row)) => by_row(machine, (index as u16, row), said),
        None => by_letter(machine, code, said),
    }
}

/// Whether waiting codes of this row do something on this machine.
pub fn is_on(machine: &Machine, code: &CodeRow) -> bool {
    machine.sync.dialect != model::SyncDialect::None || machine.sync.waits.iter().any(|row| row.is_of(&code.form))
}

/// Whether this is a wait for a signal that no other channel can send.
pub fn is_for_nobody(wait: &Wait, own: u16) -> bool {
    wait.primitive == Primitive::Signal && wait.parts.without(own).is_empty()
}

/// A waiting code of the Fanuc kind.
fn by_letter(machine: &Machine, code: &CodeRow, said: WaitArguments) -> Result<Meaning, String> {
    let register = register(&code.form);
    let name = register.map_or("M", |register| machine.registers[register].name.as_str());
    let rule = register.map_or(RuleId::Bare, |_| of_letter(letter(name)));
    let parts = fanuc::participants(said, machine.sync.paths, all(machine))?;
    Ok(Meaning::Wait(barrier(letter(name), said.number, parts, rule)))
}

fn register(form: &CodeForm) -> Option<RegisterId> {
    match form {
        CodeForm::Register { register, .. } | CodeForm::RegisterAsData { register, .. } => Some(*register),
        CodeForm::Text(_) | CodeForm::NotApplicable => None,
    }
}

/// A word or text of `[[waits]]`.
fn by_row(machine: &Machine, (index, row): (u16, &WaitRow), said: WaitArguments) -> Result<Meaning, String> {
    let everybody = all(machine);
    let (named, parts) = match row.mismatch {
        model::MismatchRule::Fanuc => fanuc::participants(said, machine.sync.paths, everybody)?,
        model::MismatchRule::Free | model::MismatchRule::Siemens => {
            let named = said.list.map(|list| channels::named(list, machine.sync.paths, everybody)).transpose()?;
            (named, named.unwrap_or(everybody).with(said.channel))
        }
    };
    let number = if matches!(row.form, Some(CodeForm::Text(_))) { row.mark } else { said.number };
    let space = match (row.primitive, row.form.as_ref().and_then(register)) {
        // Words that wait for each other have one letter; the others belong together under any name.
        (Primitive::Barrier | Primitive::Count, Some(_)) => MarkSpace::Word(first_of_word(machine, row)),
        (Primitive::Barrier | Primitive::Count, None) => MarkSpace::Row(index),
        _ => MarkSpace::Statements,
    };
    let key = WaitMark { space, number };
    Ok(of_row((index, row), key, (named, parts), said.channel))
}

/// The first row that is written with the same letters, by position.
fn first_of_word(machine: &Machine, row: &WaitRow) -> u16 {
    let same = |other: &WaitRow| other.word == row.word && other.form.as_ref().and_then(register).is_some();
    machine.sync.waits.iter().position(same).unwrap_or(0) as u16
}

/// Meaning of a row for a mark and channels, in the channel with the number `own`.
fn of_row(
    (index, row): (u16, &WaitRow),
    key: WaitMark,
    (named, parts): (Option<ChannelSet>, ChannelSet),
    own: u16,
) -> Meaning {
    let broadcast = row.primitive == Primitive::Signal && named.is_none();
    let need = if broadcast { 1 } else { row.need };
    let rule = RuleId::Row(index);
    let wait = Wait { primitive: row.primitive, key, named, parts, need, rule };
    match row.act {
        // A word neither selects nor starts: the loader refuses that.
        WaitAct::Wait | WaitAct::Select | WaitAct::Start => Meaning::Wait(wait),
        WaitAct::Set => Meaning::Act(WaitOp::Set(key), wait),
        WaitAct::Clear => Meaning::Act(WaitOp::Clear(key), wait),
        WaitAct::Signal => {
            let send = Send { key, to: parts.without(own), broadcast, lasts: Lasts::Each };
            Meaning::Act(WaitOp::Signal(send), wait)
        }
        WaitAct::Release => Meaning::Act(WaitOp::Release(key), wait),
        WaitAct::Take | WaitAct::Give => Meaning::Act(WaitOp::Take(key), wait),
    }
}
