//! Axes of two channels that codes couple: the axes that the numbers of a block name, and the wait of both channels.
//!
//! Fanuc: synchronous control G51.4 and G50.4, composite control G51.5 and G50.5, superimposed control G51.6 and G50.6;
//! P is the master, Q the slave, both by their numbers of parameter 12600. Decisions: each code is a wait of the
//! channels of both axes, which stand in different channels. *Invariant:* two channels take part.

use counterpoint_event::event::{FileId, Primitive};
use counterpoint_event::info::Info;
use counterpoint_machine::ident::{CodeId, codes};
use counterpoint_machine::index::AxisId;
use counterpoint_machine::model::Machine;
use counterpoint_program::shape::ProgramRange;
use counterpoint_program::sources::SeenSources;
use counterpoint_sync::wait::{ChannelSet, MarkSpace, RuleId, Wait, WaitMark, WaitNotation, WaitRule};

/// The effect of the code on two axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CouplingKind {
    /// The slave follows the master.
    Synchronous,
    /// The words of each channel move the axis of the other channel.
    Composite,
    /// The moves of the master are added to those of the slave.
    Superimposed,
}

impl CouplingKind {
    /// All of them, in the order of their rules.
    const ALL: [Self; 3] = [Self::Synchronous, Self::Composite, Self::Superimposed];

    /// The codes that start and end it.
    fn codes(self) -> [CodeId; 2] {
        match self {
            Self::Synchronous => [codes::COUPLE_SYNCHRONOUS, codes::COUPLE_SYNCHRONOUS_OFF],
            Self::Composite => [codes::COUPLE_COMPOSITE, codes::COUPLE_COMPOSITE_OFF],
            Self::Superimposed => [codes::COUPLE_SUPERIMPOSED, codes::COUPLE_SUPERIMPOSED_OFF],
        }
    }

    /// As it is logged.
    pub fn name(self) -> &'static str {
        match self {
            Self::Synchronous => "synchronous",
            Self::Composite => "composite",
            Self::Superimposed => "superimposed",
        }
    }

    /// The alarm for an axis that is coupled already.
    pub fn taken(self) -> &'static str {
        match self {
            Self::Synchronous => "PS0352",
            Self::Composite => "PS0357",
            Self::Superimposed => "PS0362",
        }
    }
}

/// An axis that a code names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CoupledAxis {
    /// Its number.
    pub number: u16,
    /// The axis.
    pub axis: AxisId,
    /// Its channel.
    pub channel: u16,
}

/// Two axes that a code couples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CoupledPair {
    /// How.
    pub kind: CouplingKind,
    /// The axis that P names.
    pub master: CoupledAxis,
    /// The axis that Q names.
    pub slave: CoupledAxis,
}

/// The rules of the codes, two for each kind.
pub(super) fn rules(machine: &Machine) -> impl Iterator<Item = WaitRule> {
    CouplingKind::ALL.into_iter().flat_map(CouplingKind::codes).map(|id| {
        let word = super::word(machine, id).unwrap_or_else(|| machine.code_name(id).to_owned());
        WaitRule { style: WaitNotation::Axes, acts: true, ..WaitRule::plain(&word) }
    })
}

/// The axis with a number, and its channel.
///
/// # Errors
/// The number is missing, or names no axis that can be coupled.
pub fn end(machine: &Machine, letter: char, number: Option<f64>) -> Result<CoupledAxis, String> {
    let Some(value) = number else { return Err(format!("{letter} with the number of an axis is missing")) };
    let has = |number: u16| f64::from(number) == value;
    let named = machine.axes.find(|axis| axis.coupling.number.is_some_and(has));
    let Some((axis, number)) = named.and_then(|axis| Some((axis, machine.axes[axis].coupling.number?))) else {
        return Err(format!("no axis of the machine has the number {letter}{value}"));
    };
    let mut owners = machine.channels.iter().filter(|channel| channel.axes.as_slice().contains(&axis));
    match (owners.next(), owners.next()) {
        (Some(owner), None) => Ok(CoupledAxis { number, axis, channel: owner.number }),
        (Some(_), Some(_)) => Err(format!("axis {} belongs to several channels", machine.axes[axis].name)),
        (None, _) => Err(format!("axis {} belongs to no channel", machine.axes[axis].name)),
    }
}

/// Whether the program of a channel, and programs of other channels, have the code of synchronous control.
pub fn words(machine: &Machine, (info, sources): (&Info, SeenSources<'_>), own: (FileId, ProgramRange)) -> [bool; 2] {
    let mut found = [false; 2];
    let known = super::word(machine, codes::COUPLE_SYNCHRONOUS);
    let known: Vec<&str> = known.iter().chain(&machine.sync.coupling_words).map(String::as_str).collect();
    if known.is_empty() {
        return found;
    }
    let couples = |line: &[u8]| known.iter().any(|word| has_word(line, word.as_bytes()));
    let mut files: Vec<FileId> = info.channels.iter().filter(|c| !c.program.is_empty()).map(|c| c.file).collect();
    files.sort_unstable();
    files.dedup();
    for file in files {
        let Some(source) = sources.get(file) else { continue };
        for line in (1..=source.lines()).filter(|&line| couples(source.line(line))) {
            let is_own = file == own.0 && (own.1.first..=own.1.last).contains(&line);
            if let Some(slot) = found.get_mut(usize::from(!is_own)) {
                *slot = true;
            }
        }
    }
    found
}

/// Whether a line has a word outside of comments.
fn has_word(line: &[u8], word: &[u8]) -> bool {
    let mut deep = 0_u32;
    line.iter().enumerate().any(|(at, byte)| {
        match byte {
            b'(' => deep += 1,
            b')' => deep = deep.saturating_sub(1),
            _ => {}
        }
        let here = line.get(at..at + word.len()).is_some_and(|text| text.eq_ignore_ascii_case(word));
        deep == 0 && here && !line.get(at + word.len()).is_some_and(u8::is_ascii_digit)
    })
}

/// Two axes as a code couples them.
///
/// # Errors
/// Why the control does not couple them.
pub fn pair(
    machine: &Machine,
    kind: CouplingKind,
    master: CoupledAxis,
    slave: CoupledAxis,
) -> Result<CoupledPair, String> {
    let name = |end: CoupledAxis| &machine.axes[end.axis].name;
    if master.axis == slave.axis {
        return Err(format!("P and Q both name axis {}", name(master)));
    }
    if master.channel == slave.channel {
        let channel = master.channel;
        return Err(format!("axes {} and {} are both in channel {channel}", name(master), name(slave)));
    }
    if machine.axes[master.axis].role.is_rotary() != machine.axes[slave.axis].role.is_rotary() {
        return Err(format!("one of the axes {} and {} turns, the other one does not", name(master), name(slave)));
    }
    Ok(CoupledPair { kind, master, slave })
}

impl CoupledPair {
    /// Where both channels meet before the code acts. A code that names the slave alone is shown so.
    pub fn wait(&self, off: bool) -> Wait {
        let at = self.kind as u16 * 2 + u16::from(off);
        let master = if off && self.kind != CouplingKind::Composite { 0 } else { u32::from(self.master.number) };
        let key = WaitMark { space: MarkSpace::Coupling(at), number: (master << 15) | u32::from(self.slave.number) };
        let parts: ChannelSet = [self.master.channel, self.slave.channel].into_iter().collect();
        Wait { primitive: Primitive::Barrier, key, named: None, parts, need: 0, rule: RuleId::Coupling(at) }
    }

    /// The axis of a channel, and the other axis.
    pub fn of(&self, channel: u16) -> Option<(CoupledAxis, CoupledAxis)> {
        if channel == self.master.channel {
            Some((self.master, self.slave))
        } else if channel == self.slave.channel {
            Some((self.slave, self.master))
        } else {
            None
        }
    }

    /// −1 if the two axes point in opposite directions.
    pub fn sign(&self, machine: &Machine) -> f64 {
        let mirrored = |end: CoupledAxis| machine.axes[end.axis].coupling.mirrored;
        if mirrored(self.master) == mirrored(self.slave) { 1.0 } else { -1.0 }
    }
}
