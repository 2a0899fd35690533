//! Registers of a machine by their use, and rules of its blocks, determined once.

use crate::refusal_rules::Refusals;
use crate::syntax::Syntax;
use crate::tape::Tape;
use crate::visible::RemarkDelimiters;
use counterpoint_machine::Machine;
use counterpoint_machine::ident::kind::data::DataKind;
use counterpoint_machine::ident::{self, CodeId, DataId, codes, data, takes};
use counterpoint_machine::index::{CodeRowId, IdTable, RegisterId};
use counterpoint_machine::rows::{CodeForm, CodeRow, Register, TimeOverlap};

/// Registers that a block is looked through for.
#[derive(Debug)]
pub struct ScannedRegisters {
    /// That of the G letter, for macro calls of the pre-processor.
    pub g: Option<RegisterId>,
    /// That which defines programs (O).
    pub definition: Option<RegisterId>,
    /// Those of the sequence numbers of the main and of the side head.
    pub head_sequences: [Option<RegisterId>; 2],
    /// Those whose words can move an axis or shape an arc, bit by register.
    pub motion: u128,
    /// Those whose words make corners and directions of lines, bit by register; in blocks with an arc those of arcs do
    /// not.
    pub contour: ContourRegisters,
    /// Those whose words are data for any value, one bit per register.
    pub only_data: u128,
    /// Those that carry the spindle speed, bit by register.
    pub speed: u128,
    /// That of the M letter.
    pub function: Option<RegisterId>,
    /// Those of offset numbers that count without their codes, bit by register.
    pub offsets: u128,
    /// Those of them with the number of a length, bit by register.
    pub length: u128,
    /// Those whose words may act before the codes of their block, bit by register.
    pub before_codes: u128,
}

/// Registers of corners and of directions of lines.
#[derive(Debug, Clone, Copy, Default)]
pub struct ContourRegisters {
    /// On blocks with a straight move.
    pub line: u128,
    /// On blocks with an arc: those that arcs have no other use for.
    pub arc: u128,
}

impl ContourRegisters {
    fn new(machine: &Machine) -> Self {
        let of = |kind: DataKind| {
            let rows = machine.data.iter().filter(|row| row.enable && row.id.kind() == kind);
            rows.filter_map(|row| row.register).fold(0_u128, |bits, register| bits | register.bit())
        };
        let line = of(DataKind::Contour);
        Self { line, arc: line & !of(DataKind::Arc) }
    }
}

/// Reasons why a block differs from its line.
#[derive(Debug)]
pub struct Edits {
    /// Rules of the tape editor.
    pub tape: Option<Tape>,
    /// There is a tape editor, or a character that ends blocks, or a comment may end in front of one.
    pub reshapes: bool,
    /// Comments continue over lines.
    pub long_comments: bool,
}

impl Edits {
    /// Changes of the text of blocks on a machine.
    pub fn new(machine: &Machine, syntax: &Syntax) -> Self {
        Self {
            tape: Tape::new(&machine.tape_editor, RemarkDelimiters::new(&machine.format, syntax)),
            reshapes: !machine.tape_editor.is_empty() || machine.format.eob.is_some() || machine.format.long_comments,
            long_comments: machine.format.long_comments,
        }
    }
}

impl ScannedRegisters {
    /// The registers of a machine.
    pub fn new(machine: &Machine) -> Self {
        let register_of = |id| machine.data.iter().find(|r| r.id == id && r.enable).and_then(|r| r.register);
        let (mut motion, mut speed) = (0_u128, 0_u128);
        for row in machine.data.iter().filter(|r| r.enable) {
            let Some(register) = row.register else { continue };
            if matches!(
                row.id.kind(),
                DataKind::Axis(_) | DataKind::Arc | DataKind::Polar | DataKind::Contour | DataKind::Orientation
            ) {
                motion |= register.bit();
            }
            if row.id == data::SPINDLE_RPM || row.id == data::SPINDLE_CSS {
                speed |= register.bit();
            }
        }
        let g = machine.registers.find(|register| register.name == "G");
        let definition = register_of(data::DEFSUB_ID);
        let only_data = machine.registers.ids().filter(|&id| {
            let known = !machine.tables.data_of(id).is_empty();
            known && !machine.tables.has_codes(id) && Some(id) != g && Some(id) != definition
        });
        let alone = machine.compensation.numbers_alone;
        let offsets = if alone { offsets(machine, &OFFSET_NUMBERS) } else { 0 };
        Self {
            only_data: only_data.fold(0, |bits, register| bits | register.bit()),
            head_sequences: [register_of(data::SEQNO_MAIN), register_of(data::SEQNO_SIDE)],
            g,
            definition,
            motion,
            contour: ContourRegisters::new(machine),
            speed,
            function: machine.registers.find(|register| register.name == "M"),
            offsets,
            length: if alone { self::offsets(machine, &[data::COMP_LENGTH]) } else { 0 },
            before_codes: offsets | speed,
        }
    }
}

/// The rules of a control for blocks and values beyond the meaning of their words.
#[derive(Debug)]
pub struct BlockRules {
    /// Group within which only the last G code of a block acts, by code row, 0 for none; `None` where all act.
    pub exclusive: Option<IdTable<CodeRowId, u16>>,
    /// Steps of one unit that values of expressions are rounded to, by register in primary and secondary units; none
    /// where values stay as they are.
    pub steps: Option<IdTable<RegisterId, [f64; 2]>>,
    /// The lead of a thread and the feed per revolution are one word that stays active (F of Fanuc controls).
    pub lead_is_feed: bool,
    /// Circles may continue in the direction of the last move, which is kept for them.
    pub keeps_last_move: bool,
    /// Functions or spindles take their time beside other things.
    pub overlaps: bool,
    /// Rules by which the control refuses blocks.
    pub refusals: Option<Box<Refusals>>,
    /// Registers of offset numbers whose words a code takes, by code row; empty where numbers need their codes.
    pub number_takers: IdTable<CodeRowId, u128>,
    /// An axis moves by a change of the tool length.
    pub length_moves: bool,
}

impl BlockRules {
    /// The rules of a machine, given its register `G`, and whether its control keeps the lead of a thread as the feed.
    pub fn new(machine: &Machine, g: Option<RegisterId>, lead_is_feed: bool) -> Self {
        Self {
            exclusive: exclusive(machine, g),
            steps: steps(machine),
            lead_is_feed: lead_is_feed && lead_has_register_of_feed(machine),
            keeps_last_move: machine.codes.iter().any(|row| row.enable && row.id == codes::INTERP_ARC_TANGENT),
            overlaps: machine.codes.iter().any(|row| row.seconds > 0.0 && row.overlap != TimeOverlap::None)
                || machine.spindles.iter().any(|spindle| spindle.overlap != TimeOverlap::None)
                || machine.time.tool_overlap != TimeOverlap::None,
            refusals: Refusals::new(machine),
            number_takers: number_takers(machine),
            length_moves: machine.compensation.length.moves,
        }
    }
}

/// Group of the one-shot codes, which have none in the table of identifiers.
const ONE_SHOT: u16 = 1000;

/// Groups of rows whose codes exclude each other in a block: those of G words.
fn exclusive(machine: &Machine, g: Option<RegisterId>) -> Option<IdTable<CodeRowId, u16>> {
    if !machine.habits.last_of_group {
        return None;
    }
    let group = |row: &CodeRow| match row.form {
        CodeForm::Register { register, .. } | CodeForm::RegisterAsData { register, .. } if Some(register) == g => {
            match row.group {
                0 if !machine.habits.one_shots_of_group => 0,
                0 => ONE_SHOT,
                _ if row.id == codes::LCS_TRANSLATE_ON => ONE_SHOT,
                group => group,
            }
        }
        _ => 0,
    };
    Some(machine.codes.map(|_, row| group(row)))
}

/// Data with the numbers of offsets.
const OFFSET_NUMBERS: [DataId; 2] = [data::COMP_LENGTH, data::COMP_DIAM];

/// Registers of offset numbers, bit by register.
fn offsets(machine: &Machine, numbers: &[DataId]) -> u128 {
    let rows = numbers.iter().flat_map(|&id| machine.tables.data(id));
    let registers = rows.filter_map(|&row| machine.data[row].register);
    registers.fold(0, |bits, register| bits | register.bit())
}

/// Registers of offset numbers whose words the action of a code may take; all for custom codes, whose words are not
/// known.
fn number_takers(machine: &Machine) -> IdTable<CodeRowId, u128> {
    let offsets = if machine.compensation.numbers_alone { offsets(machine, &OFFSET_NUMBERS) } else { 0 };
    let rows = machine.data.iter().filter(|row| row.enable);
    let on_them = rows.filter_map(|row| Some((row.id, row.register?.bit() & offsets))).filter(|(_, bit)| *bit != 0);
    let takers: Vec<_> = on_them.map(|(id, bit)| (takes::codes_of(machine.data_name(id)), bit)).collect();
    machine.codes.map(|_, row| {
        if ident::code_facts(row.id).is_none() {
            return offsets;
        }
        let name = machine.code_name(row.id);
        takers.iter().filter(|(codes, _)| codes.contains(&name)).fold(0, |bits, (_, bit)| bits | bit)
    })
}

/// Steps of one unit at each register.
fn steps(machine: &Machine) -> Option<IdTable<RegisterId, [f64; 2]>> {
    let of = |_, register: &Register| {
        let digits = |digits: u8| register.increment.map_or(10_f64.powi(i32::from(digits)), f64::recip);
        [digits(register.format.frac), digits(register.secondary.frac)]
    };
    machine.habits.rounded.then(|| machine.registers.map(of))
}

/// First enabled row of each code.
pub fn rows_of_code(machine: &Machine) -> IdTable<CodeId, Option<CodeRowId>> {
    let mut rows = machine.code_names.map(|_, _| None);
    for (at, row) in machine.codes.entries().filter(|(_, row)| row.enable) {
        rows[row.id].get_or_insert(at);
    }
    rows
}

/// Whether the lead of a thread and the feed per revolution are modal and have the same register.
fn lead_has_register_of_feed(machine: &Machine) -> bool {
    let row = |id| machine.data.iter().find(|row| row.id == id && row.enable && row.process && row.modal);
    let registers = [data::INTERP_THREAD_PITCH, data::FEED_UPR].map(|id| row(id).and_then(|row| row.register));
    registers[0].is_some() && registers[0] == registers[1]
}
