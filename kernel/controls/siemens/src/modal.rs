//! MCALL: a subprogram that blocks with path motion call.
//!
//! Facts: 840D programming manual, modal subprogram call. The last MCALL counts, also in subprograms, until MCALL alone
//! or the end of the program; its arguments are passed once, with their values at MCALL. A block calls if it programs a
//! path axis, if it has only F or S while G0 or G1 is active, or if it has G0 or G1 with only other G functions.
//! Invariant: the blocks of the modal subprogram itself, and of the programs it calls, do not call it.

use std::sync::Arc;

use super::calls::Calling;
use super::item::SiemensItem;
use super::left::SiemensRemainder;
use super::syntax;
use super::variable_store::PassedArgument;
use super::{Outcome, Siemens};
use counterpoint_control_api::host::{InterpreterHost, SubprogramCall};

/// The program that blocks with path motion call.
#[derive(Debug)]
pub(super) struct SiemensModalCall {
    /// Text that stays in the block if the name is not a subprogram.
    words: String,
    call: Option<SubprogramCall>,
    passes: Option<u32>,
    given: Arc<Vec<PassedArgument>>,
    /// Subprograms that were running when it was programmed: variables of the caller are those of this level.
    level: usize,
}

/// Statements whose axis words are not positions of the path.
const STILL: [&str; 13] = [
    "TRANS", "ATRANS", "ROT", "AROT", "ROTS", "AROTS", "CROTS", "SCALE", "ASCALE", "MIRROR", "AMIRROR", "PRESETON",
    "GEOAX",
];

/// G functions of the same kind: dwell, limits, parts of frames, reference and fixed points, poles.
const STILL_CODES: [u32; 10] = [4, 25, 26, 58, 59, 74, 75, 110, 111, 112];

/// G functions of the motion group that are neither G0 nor G1.
const CURVES: [u32; 9] = [2, 3, 33, 34, 35, 63, 331, 332, 335];

impl Siemens {
    /// MCALL with the text after it.
    pub(super) fn set_modal(&mut self, host: &mut dyn InterpreterHost, items: &[SiemensItem]) -> Outcome<()> {
        self.modal = None;
        if !items.is_empty() {
            let mut left = SiemensRemainder::default();
            for item in items {
                self.item(host, item, &mut left)?;
            }
            let given = self.calling.take().map(|calling| calling.given).unwrap_or_default();
            let (words, call, passes) = (left.words, left.call, left.passes);
            if call.is_some() && !words.trim().is_empty() {
                return syntax(format!("MCALL takes one call and no further words: {}", words.trim()));
            }
            if call.is_none() && self.settings.subprograms {
                not_called(host, items, &words)?;
            }
            let level = host.level();
            self.modal = Some(SiemensModalCall { words, call, passes, given, level });
        }
        self.watch(host);
        Ok(())
    }

    /// Calls the program of MCALL if the block asks for it.
    pub(super) fn call_modally(&mut self, host: &dyn InterpreterHost, left: &mut SiemensRemainder) {
        // A contour that a cycle reads does not move.
        if self.modal.is_none() || host.reads_contour() {
            return;
        }
        let level = host.level();
        if self.modal_from.is_some_and(|from| level > from) {
            return;
        }
        self.modal_from = None;
        if left.call.is_some() || !asks(host, left) {
            return;
        }
        let Some(modal) = &self.modal else { return };
        if !modal.words.is_empty() {
            left.add(&modal.words);
        }
        let Some(call) = &modal.call else { return };
        let own = modal.level == level;
        let given = match own {
            true => Arc::clone(&modal.given),
            false => Arc::new(modal.given.iter().map(PassedArgument::without_variable).collect()),
        };
        self.calling = Some(Calling { line: host.place().line, part: false, outer: 0, given });
        left.call = Some(call.clone());
        left.passes = modal.passes;
        self.modal_from = Some(level);
    }
}

/// Refuses words after MCALL that neither call a subprogram nor are a code of the machine.
fn not_called(host: &mut dyn InterpreterHost, items: &[SiemensItem], words: &str) -> Outcome<()> {
    match items.iter().find(|item| !matches!(item, SiemensItem::Passes(..))) {
        // A macro of the machine has taken or replaced the name.
        Some(SiemensItem::Bare(name) | SiemensItem::Function(name, _)) if !words.contains(name.as_str()) => Ok(()),
        Some(SiemensItem::Bare(name) | SiemensItem::Function(name, _)) => {
            if host.is_code_text(name) || host.is_register(&format!("{name}(")) {
                return Ok(());
            }
            Ok(host.report_unrecognised(words.trim())?)
        }
        _ => syntax(format!("MCALL takes the name of a subprogram, not {}", words.trim())),
    }
}

/// Whether a word makes axis words of its block something other than positions of the path.
pub(super) fn is_still(word: &str) -> bool {
    STILL.contains(&word) || code(word).is_some_and(|code| STILL_CODES.contains(&code))
}

/// Whether a G function of the motion group is neither G0 nor G1.
pub(super) fn is_curve(word: &str) -> bool {
    code(word).is_some_and(|code| CURVES.contains(&code))
}

fn code(word: &str) -> Option<u32> {
    word.strip_prefix(['G', 'g'])?.trim().parse().ok()
}

/// Whether the block has path motion, or an equivalent.
fn asks(host: &dyn InterpreterHost, left: &SiemensRemainder) -> bool {
    let mut axis = left.moves;
    let (mut rates, mut straight, mut curve, mut others) = (false, false, false, false);
    for word in words(&left.words) {
        let name = word.split(|c: char| !c.is_ascii_alphabetic() && c != '_').next().unwrap_or_default();
        let letter = name.bytes().next().unwrap_or(b' ').to_ascii_uppercase();
        if name.len() != 1 {
            if STILL.iter().any(|still| still.eq_ignore_ascii_case(name)) {
                return false;
            }
            // Polar coordinates.
            axis |= name.eq_ignore_ascii_case("AP") || name.eq_ignore_ascii_case("RP");
            continue;
        }
        match letter {
            b'G' => {
                let code = code(word);
                if code.is_some_and(|code| STILL_CODES.contains(&code)) {
                    return false;
                }
                straight |= code.is_some_and(|code| code < 2);
                curve |= code.is_some_and(|code| CURVES.contains(&code));
            }
            b'N' => {}
            b'F' | b'S' => rates = true,
            _ => {
                let is_axis = host.axis_letter(name).is_some_and(|letter| letter.eq_ignore_ascii_case(name));
                axis |= is_axis;
                others |= !is_axis;
            }
        }
    }
    axis || (!others && (straight || (rates && !curve && host.moves_straight())))
}

/// Words of a block, without texts and without the contents of parentheses.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split([' ', '\t']).filter(|word| word.bytes().next().is_some_and(|byte| byte.is_ascii_alphabetic()))
}
