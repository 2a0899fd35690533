//! Words that are written with `=`, and texts with values, as the tables of the machine know them.
//!
//! Facts: reference control-emulator.md 5.4. Decisions: positions given by AC and IC become words of the machine: the
//! incremental letter of the axis if it has one, otherwise the current position of the axis is added or subtracted; DC,
//! ACP and ACN become the position to which a rotary axis continues from its current position; AC of I, J and K counts
//! from the start of the circle. Invariant: a number is written without an exponent.

use std::borrow::Cow;

use super::aims::Aim;
use super::compiled::{IndexedName, SiemensArgument, as_name};
use super::conversions::number;
use super::evaluate::words_name;
use super::item::{AssignmentValue, PositionMode, Width};
use super::left::SiemensRemainder;
use super::number_text::{is_number, shown};
use super::value::Data;
use super::{Outcome, Siemens, SiemensBlockError};
use counterpoint_control_api::host::{AxisPlace, InterpreterHost};
use counterpoint_control_api::words::Meanings;
use counterpoint_fault as diag;
use counterpoint_machine::index::RegisterId;
use rustc_hash::FxHashMap;

/// Largest value of a word.
const BOUND: f64 = 1e12;
/// Addresses whose values count in another way with a keyword, and the register of that: heights of soft approach and
/// its feed.
const OTHERWISE: [(&str, PositionMode, &str); 4] = [
    ("DISCL", PositionMode::Absolute, "SC_DISCL"),
    ("DISRP", PositionMode::Absolute, "SC_DISRP"),
    ("FAD", PositionMode::PerMinute, "SC_FADM"),
    ("FAD", PositionMode::PerRevolution, "SC_FADR"),
];
/// Most addresses whose spelling is remembered.
const MOST_SPELLINGS: usize = 500;

/// Words of the machine that have been looked up.
#[derive(Debug, Default)]
pub(super) struct MachineWords {
    /// How the machine spells addresses.
    pub(super) spellings: FxHashMap<String, Spelling>,
    pub(super) meanings: Meanings,
}

/// How the registers of the machine spell an address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Spelling {
    /// `X`.
    plain: bool,
    /// `X=`.
    equals: bool,
    /// Registers of words whose values are data: without and with an equal sign.
    data: [Option<(RegisterId, bool)>; 2],
}

impl Spelling {
    /// Whether a register has it.
    fn is_word(self) -> bool {
        self.plain || self.equals
    }
}

impl Siemens {
    /// `ADDRESS=value` as a word.
    pub(super) fn word(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &IndexedName,
        value: &AssignmentValue,
        left: &mut SiemensRemainder,
    ) -> Outcome<()> {
        if self.spindle_word(host, name, value, left)? {
            return Ok(());
        }
        let address: Cow<'_, str> = match (name.name.as_str(), name.index.as_slice()) {
            ("AX", [_]) => self.axis_of(host, name)?.text().into(),
            (address, []) => address.into(),
            _ => self.written(host, name)?.into(),
        };
        let aim = Aim::of(&address).filter(|_| super::orientation::has_directions(host));
        if let (Some(aim), AssignmentValue::One(value, _)) = (aim, value) {
            let value = number(&self.evaluate(host, value)?)?;
            left.aims.get_or_insert_default().set(aim, value);
            return Ok(());
        }
        let mut spelling = self.spelling(host, &address);
        let has_word = spelling.is_word();
        let letter = host.axis_letter(&address);
        left.moves |= letter.is_some();
        let (address, named) = match letter {
            // The name of an axis stands for the letter by which the channel programs it.
            Some(letter) if !has_word => (Cow::from(letter.to_owned()), Some(address)),
            _ => (address, None),
        };
        if named.is_some() {
            spelling = self.spelling(host, &address);
        }
        let text: Cow<'_, str> = match value {
            AssignmentValue::One(_, text) if is_number(text) => text.into(),
            AssignmentValue::One(value, _) => self.evaluate(host, value)?.word().into(),
            AssignmentValue::List(values) => format!("SET({})", self.texts(host, values)?).into(),
            AssignmentValue::Fill(values) => format!("REP({})", self.texts(host, values)?).into(),
            AssignmentValue::Positioned(way, value, key) => {
                let value = number(&self.evaluate(host, value)?)?;
                let value = if value.abs() <= BOUND {
                    value
                } else {
                    return super::wrong_type("the position is out of range");
                };
                let other = OTHERWISE.iter().find(|(name, by, _)| *name == address && by == way);
                if let Some((_, _, register)) = other {
                    left.add(&format!("{register}={}", Data::Real(value).word()));
                    return Ok(());
                }
                if let (PositionMode::Incremental, Some(at)) =
                    (*way, ["AP", "RP"].iter().position(|name| *name == address))
                {
                    let Some(last) = host.polar().get(at).copied().flatten() else {
                        return super::syntax(format!("{address}=IC( ) needs a position about the pole before it"));
                    };
                    let word = format!("{address}={}", Data::Real(last + value).word());
                    left.add(&word);
                    return Ok(());
                }
                let relative = left.relative.unwrap_or_else(|| host.relative());
                let axes = host.axes();
                let axis = axes.iter().find(|axis| axis.is(named.as_deref().unwrap_or(&address)));
                check_turn(host, axis, *way, value)?;
                // Positions of one step along the axis.
                let step = if axis.is_some_and(|axis| axis.diameter) && host.steps_are_radii() { 2.0 } else { 1.0 };
                let (way, value) = across(host, (&address, axis), (*way, value), step)?;
                match placed(&axes, axis, &address, way, value, relative.then_some(step)) {
                    Placed::Value(value) => Data::Real(value).word().into(),
                    Placed::Step(value) => match host.second(&address) {
                        Some(second) => {
                            left.add(&format!("{second}{}", Data::Real(value).word()));
                            return Ok(());
                        }
                        None => {
                            let at = axis.map_or(0.0, |axis| axis.from);
                            Data::Real(if relative { value } else { at + value * step }).word().into()
                        }
                    },
                    Placed::Text => format!("{key}({})", shown(value)).into(),
                }
            }
        };
        if address == "AP"
            && matches!(value, AssignmentValue::One(..))
            && text.parse::<f64>().is_ok_and(|angle| angle.abs() > 360.0)
        {
            let text = format!("the polar angle {text} is beyond 360 degrees (alarm 14210)");
            return Err(SiemensBlockError::Alarm(&diag::SIEMENS_STATE, text));
        }
        if !has_word && let Some(plain) = self.without_number(host, &address) {
            left.add(&format!("{plain}{text}"));
            return Ok(());
        }
        let sign = self.sign(&address, spelling);
        if address.len() > 1 && splits(&address) && !has_word {
            let word = [&*address, sign, &*text].concat();
            if !host.is_code_text(&word) {
                // The scanner would read a word of the letter and its extension.
                host.report_unrecognised(&word)?;
                return Ok(());
            }
        }
        left.add(&address);
        let start = left.words.len() - address.len();
        left.words.push_str(sign);
        let [without, with] = spelling.data;
        let register = if sign.is_empty() { without } else { with };
        left.places.note_number(register, [start, left.words.len(), left.words.len() + text.len()]);
        left.words.push_str(&text);
        Ok(())
    }

    /// The address without the number of the only spindle, and H without its number.
    fn without_number(&mut self, host: &dyn InterpreterHost, address: &str) -> Option<&'static str> {
        let plain = match address.as_bytes() {
            b"M1" => "M",
            b"S1" => "S",
            [b'H', digits @ ..] if !digits.is_empty() && digits.iter().all(u8::is_ascii_digit) => "H",
            _ => return None,
        };
        let spindles = plain != "H" && (self.spelling(host, "S1").is_word() || host.is_code_text("M1=3"));
        (!spindles && self.spelling(host, plain).is_word()).then_some(plain)
    }

    /// `=`, or nothing, between an address and its value.
    fn sign(&self, address: &str, spelling: Spelling) -> &'static str {
        let one = address.len() == 1;
        let collapses = match self.settings.collapse {
            Some(collapse) => collapse && one,
            None => one && spelling.plain && !spelling.equals,
        };
        if collapses { "" } else { "=" }
    }

    /// How the registers of the machine spell an address.
    fn spelling(&mut self, host: &dyn InterpreterHost, address: &str) -> Spelling {
        if let Some(known) = self.known.spellings.get(address) {
            return *known;
        }
        let with_sign = format!("{address}=");
        let spelling = Spelling {
            plain: host.is_register(address),
            equals: host.is_register(&with_sign),
            data: [address, &*with_sign].map(|before| host.data_register(before)),
        };
        if self.known.spellings.len() < MOST_SPELLINGS {
            self.known.spellings.insert(address.to_owned(), spelling);
        }
        spelling
    }

    /// Arguments of the text that stays in the block: their values if they have any, otherwise their text.
    pub(super) fn texts(&mut self, host: &mut dyn InterpreterHost, arguments: &[SiemensArgument]) -> Outcome<String> {
        let mut texts = Vec::new();
        for argument in arguments {
            let value = match &argument.value {
                Ok(None) | Err(_) => None,
                Ok(Some(value)) if matches!(value.as_constant(), Some(Data::Text(_))) => None,
                Ok(Some(value)) if as_name(value).is_some_and(|name| !self.has_value(host, name)) => None,
                Ok(Some(_)) if is_number(&argument.text) => None,
                Ok(Some(expression)) => self.quietly(|this| this.evaluate(host, expression))?,
            };
            texts.push(match value {
                None => argument.text.clone(),
                Some(Data::Real(value)) => shown(value),
                Some(value) => value.word(),
            });
        }
        Ok(texts.join(","))
    }

    fn has_value(&self, host: &dyn InterpreterHost, name: &IndexedName) -> bool {
        let known = name.name == "R" || name.name.starts_with('$') || self.variables.knows(&name.name);
        known && !(name.index.is_empty() && words_name(host, &name.name) && !self.variables.knows(&name.name))
    }
}

/// A letter with a number after it.
fn splits(address: &str) -> bool {
    address.as_bytes().get(1).is_some_and(u8::is_ascii_digit)
}

/// Whether a name that the machine does not have starts with a code: `TRANSX10`.
pub(super) fn begins_with_code(host: &dyn InterpreterHost, name: &str) -> bool {
    let letters = name.trim_end_matches(|c: char| c.is_ascii_digit() || c == '.');
    let is_name = name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
    let mut beginnings = (2..name.len()).filter_map(|end| name.get(..end));
    is_name && letters != name && !host.is_register(letters) && beginnings.any(|beginning| host.is_code_text(beginning))
}

/// DAC, DIC, RAC and RIC as the program counts: a position or a distance across the axis of turning.
///
/// # Errors
/// The address is not the transverse axis.
fn across(
    host: &dyn InterpreterHost,
    (address, axis): (&str, Option<&AxisPlace>),
    (way, value): (PositionMode, f64),
    step: f64,
) -> Outcome<(PositionMode, f64)> {
    let (width, steps) = match way {
        PositionMode::AbsoluteAs(width) => (width, false),
        PositionMode::IncrementalAs(width) => (width, true),
        _ => return Ok((way, value)),
    };
    let Some(axis) = axis.filter(|axis| axis.letter.eq_ignore_ascii_case("X") && host.is_code_text("DIAMON")) else {
        return super::wrong_type(format!(
            "{address} is not a transverse axis: it takes no diameter or radius values (alarm 16510)"
        ));
    };
    let value = match (width, axis.diameter) {
        (Width::Diameter, false) => value / 2.0,
        (Width::Radius, true) => value * 2.0,
        (Width::Diameter, true) | (Width::Radius, false) => value,
    };
    Ok(if steps { (PositionMode::Incremental, value / step) } else { (PositionMode::Absolute, value) })
}

/// DC, ACP and ACN are for rotary axes, and on one without limits within a turn.
fn check_turn(host: &dyn InterpreterHost, axis: Option<&AxisPlace>, way: PositionMode, value: f64) -> Outcome<()> {
    let (key, alarm) = match way {
        PositionMode::Shortest => ("DC", 16800),
        PositionMode::Positive => ("ACP", 16810),
        PositionMode::Negative => ("ACN", 16820),
        _ => return Ok(()),
    };
    let Some(axis) = axis else { return Ok(()) };
    let text = if !axis.turns {
        format!("{key} is for rotary axes, and axis {} does not turn (alarm {alarm})", axis.letter)
    } else if !(0.0..360.0).contains(&value) && host.travel(&axis.letter).is_none() {
        format!("{key} takes a position from 0 to less than 360 degrees, not {value} (alarm 16830)")
    } else {
        return Ok(());
    };
    Err(SiemensBlockError::Alarm(&diag::SIEMENS_STATE, text))
}

/// Conversion of a position.
enum Placed {
    Value(f64),
    /// A distance from where the axis is.
    Step(f64),
    /// It stays as it is written.
    Text,
}

fn placed(
    axes: &[AxisPlace],
    axis: Option<&AxisPlace>,
    address: &str,
    way: PositionMode,
    value: f64,
    relative: Option<f64>,
) -> Placed {
    if way == PositionMode::Value {
        return Placed::Value(value);
    }
    if let Some(axis) = axis {
        let to = |end: f64| Placed::Value(relative.map_or(end, |step| (end - axis.from) / step));
        let turn = (value - axis.work).rem_euclid(360.0);
        return match way {
            PositionMode::Incremental => Placed::Step(value),
            PositionMode::Absolute
            | PositionMode::Value
            | PositionMode::PerMinute
            | PositionMode::PerRevolution
            | PositionMode::AbsoluteAs(_)
            | PositionMode::IncrementalAs(_) => to(value),
            PositionMode::Shortest => to(axis.work + if turn > 180.0 { turn - 360.0 } else { turn }),
            PositionMode::Positive => to(axis.work + turn),
            PositionMode::Negative => to(axis.work + if turn == 0.0 { 0.0 } else { turn - 360.0 }),
        };
    }
    let center = ["I", "J", "K"].iter().position(|name| name.eq_ignore_ascii_case(address));
    match (center.and_then(|at| ["X", "Y", "Z"].get(at)), way) {
        (Some(_), PositionMode::Incremental) => Placed::Value(value),
        (Some(along), PositionMode::Absolute) => {
            match axes.iter().find(|axis| axis.letter.eq_ignore_ascii_case(along)) {
                Some(axis) => Placed::Value((value - axis.work) / if axis.diameter { 2.0 } else { 1.0 }),
                None => Placed::Text,
            }
        }
        (None, PositionMode::Absolute | PositionMode::Shortest | PositionMode::Positive | PositionMode::Negative)
            if !address.contains('[') =>
        {
            Placed::Value(value)
        }
        _ => Placed::Text,
    }
}
