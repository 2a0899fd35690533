//! Frames of the program: functions that make them, and the effect of an assignment on the machine.
//!
//! Facts: reference control-emulator.md 5.4, functions.md 9 (`APPLYFRAMES`). Decisions: the programmable frame is set
//! by blocks with the words TRANS, AROT, ASCALE and AMIRROR of the machine's tables, a settable frame by the work
//! offset of its number. Invariant: a part without a word of the machine is reported, and then nothing of the frame is
//! set.

use rustc_hash::FxHashMap;

use super::beside::{AxisFrame, AxisFrames};
use super::compiled::{IndexedName, SiemensArgument};
use super::frame::{FrameComponents, SPACE, SiemensFrame};
use super::frame_component::FrameComponent;
use super::value::Data;
use super::{Outcome, Siemens, syntax, wrong_type};
use counterpoint_control_api::host::{InterpreterHost, NO_OFFSET};
use counterpoint_fault as diag;

/// Frames that were assigned but are not active, or not yet active.
#[derive(Debug, Default)]
pub(super) struct AssignedFrames {
    program: SiemensFrame,
    /// Settable frames that wait for their G function; where nothing is applied, all that were assigned.
    settable: FxHashMap<u32, SiemensFrame>,
}

impl AssignedFrames {
    /// The settable frames of the program before stay.
    pub(super) fn keep(&mut self, before: Self) {
        self.settable = before.settable;
    }

    /// Settable frames wait for their G functions.
    pub(super) fn wait(&self) -> bool {
        !self.settable.is_empty()
    }
}

/// The settable frame that a word activates.
fn activated(word: &str) -> Option<u32> {
    let digits = word.strip_prefix(['G', 'g'])?.trim_start_matches('0');
    match digits.parse().ok()? {
        500 => Some(NO_OFFSET),
        number @ 54..=57 => Some(number - 53),
        number @ 505..=599 => Some(number - 500),
        _ => None,
    }
}

/// Largest number of a settable frame.
const MOST_SETTABLE: i64 = 99;

/// Names of the geometry axes.
const GEOMETRY: [&str; 3] = ["X", "Y", "Z"];

/// X, Y or Z as 0, 1 or 2; from 3 on the axes of the channel, for parts that are not rotations.
pub(super) fn place(host: &dyn InterpreterHost, axis: &Data, part: FrameComponent) -> Outcome<usize> {
    let others = host.axes();
    let other = |name: &String| others.iter().position(|axis| axis.is(name) && !is_geometry(&axis.letter));
    match axis {
        Data::Axis(name) if part != FrameComponent::Rotation => match other(name) {
            Some(at) => Ok(SPACE + at),
            None => geometry(host, axis),
        },
        _ => geometry(host, axis),
    }
}

fn is_geometry(letter: &str) -> bool {
    GEOMETRY.iter().any(|name| name.eq_ignore_ascii_case(letter))
}

/// X, Y or Z as 0, 1 or 2.
fn geometry(host: &dyn InterpreterHost, axis: &Data) -> Outcome<usize> {
    if let Data::Axis(wanted) = axis {
        let is = |name: &&str| name.eq_ignore_ascii_case(wanted);
        let letter = host.axes().into_iter().find(|axis| axis.name.eq_ignore_ascii_case(wanted));
        let letter = letter.map(|axis| axis.letter);
        let by_letter = |letter: &String| GEOMETRY.iter().position(|name| name.eq_ignore_ascii_case(letter));
        if let Some(at) = GEOMETRY.iter().position(is).or_else(|| letter.as_ref().and_then(by_letter)) {
            return Ok(at);
        }
    }
    wrong_type(format!("{} is not a geometry axis", axis.described()))
}

fn parts(frame: &SiemensFrame) -> Outcome<FrameComponents> {
    match frame.parts() {
        Some(parts) => Ok(parts),
        None => wrong_type("the frame has no translation, rotation and scaling as parts"),
    }
}

/// A part of a frame along an axis.
pub(super) fn part_of(frame: &SiemensFrame, axis: usize, part: FrameComponent) -> Outcome<f64> {
    Ok(parts(frame)?.get(axis, part))
}

/// The frame with another value of a part.
pub(super) fn with_part(
    frame: &SiemensFrame,
    axis: usize,
    part: FrameComponent,
    value: &Data,
) -> Outcome<SiemensFrame> {
    let mut parts = parts(frame)?;
    parts.set(axis, part, super::conversions::number(value)?);
    match parts.frame() {
        Some(frame) => Ok(frame),
        None => wrong_type("the frame is out of range"),
    }
}

impl Siemens {
    /// CTRANS, CFINE, CROT, CSCALE, CMIRROR; none for other functions.
    pub(super) fn frame_function(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        arguments: &[SiemensArgument],
    ) -> Outcome<Option<Data>> {
        let part = match name {
            "CTRANS" => FrameComponent::Translation,
            "CFINE" => FrameComponent::Fine,
            "CROT" => FrameComponent::Rotation,
            "CSCALE" => FrameComponent::Scale,
            "CMIRROR" => FrameComponent::Mirror,
            _ => return Ok(None),
        };
        let mut made = FrameComponents::default();
        let mut arguments = arguments.iter();
        while let Some(argument) = arguments.next() {
            let Some(axis) = self.argument(host, argument)? else { return syntax(format!("{name} needs an axis")) };
            let axis = place(host, &axis, part)?;
            if part == FrameComponent::Mirror {
                made.set(axis, part, 1.0);
                continue;
            }
            let value = match arguments.next() {
                Some(argument) => self.argument(host, argument)?,
                None => None,
            };
            let Some(value) = value else { return syntax(format!("{name} needs a value for each axis")) };
            made.set(axis, part, super::conversions::number(&value)?);
        }
        match made.frame() {
            Some(frame) => Ok(Some(Data::Frame(Box::new(frame)))),
            None => wrong_type("the frame is out of range"),
        }
    }

    /// A frame of the control by its name, and the number of a settable one; none if it is no such name.
    fn frame_name(&mut self, host: &mut dyn InterpreterHost, name: &IndexedName) -> Outcome<Option<(u32, usize)>> {
        let active = host.work_offset();
        Ok(match name.name.as_str() {
            "$P_PFRAME" => Some((u32::MAX, 0)),
            "$P_IFRAME" => Some((if active == 0 { NO_OFFSET } else { active }, 0)),
            "$P_BFRAME" | "$P_CHBFRAME" => Some((0, 0)),
            "$P_UIFR" => {
                let Some(index) = name.index.first() else { return syntax("$P_UIFR needs an index") };
                let number = self.whole_number(host, index)?;
                if !(1..=MOST_SETTABLE).contains(&number) {
                    return wrong_type(format!("settable frame {number} does not exist"));
                }
                Some((number as u32, 1))
            }
            _ => None,
        })
    }

    /// A frame of the control, or a part of it.
    pub(super) fn control_frame(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &IndexedName,
    ) -> Outcome<Option<Data>> {
        let Some((number, used)) = self.frame_name(host, name)? else { return Ok(None) };
        let frame = self.current(host, number, name.name != "$P_UIFR");
        let rest = name.index.get(used..).unwrap_or_default();
        if rest.is_empty() {
            return Ok(Some(Data::Frame(Box::new(frame))));
        }
        let (axis, part) = self.frame_part(host, rest)?;
        part_of(&frame, axis, part).map(|value| Some(Data::Real(value)))
    }

    /// Activates the settable frames of the block's G functions as they were assigned.
    pub(super) fn activate_frames(&mut self, host: &mut dyn InterpreterHost, words: &str) -> Outcome<()> {
        if !self.frames.wait() || !self.settings.applies_frames {
            return Ok(());
        }
        for number in words.split(' ').filter_map(activated) {
            if let Some(frame) = self.frames.settable.remove(&number) {
                self.apply(host, number, &frame);
            }
        }
        self.watch(host);
        Ok(())
    }

    /// Puts a settable frame into force.
    fn apply(&self, host: &mut dyn InterpreterHost, number: u32, frame: &SiemensFrame) {
        if let Err(text) = offset(host, number, frame) {
            let text = format!("{text}, in '{}'", host.block_text());
            host.diagnose(&diag::SIEMENS_FRAME, text);
        }
    }

    /// The value of a frame: for `$P_UIFR` the frame assigned last, for `$P_IFRAME` the active frame.
    fn current(&self, host: &dyn InterpreterHost, number: u32, active: bool) -> SiemensFrame {
        if number == u32::MAX {
            return if self.settings.applies_frames {
                let mut beside = AxisFrames::default();
                for (at, axis) in host.axes().iter().enumerate() {
                    beside.put(at, AxisFrame::of_line(axis.line));
                }
                SiemensFrame::from_numbers(&host.local_frame()).unwrap_or_default().with_beside(beside)
            } else {
                self.frames.program
            };
        }
        if let Some(kept) = self.frames.settable.get(&number).filter(|_| !active || !self.settings.applies_frames) {
            return *kept;
        }
        let mut made = FrameComponents::default();
        if let Some(turn) = host.offset_turn(number) {
            made.angles =
                SiemensFrame::turned(turn).and_then(|frame| frame.parts()).map_or([0.0; 3], |parts| parts.angles);
        }
        for (place, (axis, value)) in host.axes().iter().zip(host.offset(number)).enumerate() {
            let at = GEOMETRY.iter().position(|name| name.eq_ignore_ascii_case(&axis.letter));
            made.set(at.unwrap_or(SPACE + place), FrameComponent::Translation, value);
        }
        made.frame().unwrap_or_default()
    }

    /// Assigns a frame of the control; the blocks that set it. None if it is no such name.
    pub(super) fn set_control_frame(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &IndexedName,
        value: &Data,
    ) -> Outcome<Option<Vec<String>>> {
        let Some((number, used)) = self.frame_name(host, name)? else { return Ok(None) };
        let rest = name.index.get(used..).unwrap_or_default();
        let frame = if rest.is_empty() {
            super::conversions::as_frame(value.clone())?
        } else {
            let (axis, part) = self.frame_part(host, rest)?;
            with_part(&self.current(host, number, name.name != "$P_UIFR"), axis, part, value)?
        };
        host.effect();
        if !self.settings.applies_frames {
            if number == u32::MAX {
                self.frames.program = frame;
            } else {
                self.frames.settable.insert(number, frame);
            }
            return Ok(Some(Vec::new()));
        }
        if name.name == "$P_UIFR" {
            // It acts from its G function on.
            if let Err(text) = fits(host, &frame) {
                let text = format!("{text}, in '{}'", host.block_text());
                host.diagnose(&diag::SIEMENS_FRAME, text);
            } else {
                self.frames.settable.insert(number, frame);
                self.watch(host);
            }
            return Ok(Some(Vec::new()));
        }
        if name.name == "$P_IFRAME" {
            // The frame of the table stays as it is.
            let kept = self.current(host, number, true);
            self.frames.settable.entry(number).or_insert(kept);
            self.watch(host);
        }
        let blocks =
            if number == u32::MAX { blocks(host, &frame) } else { offset(host, number, &frame).map(|()| Vec::new()) };
        match blocks {
            Ok(blocks) => Ok(Some(blocks)),
            Err(text) => {
                let text = format!("{text}, in '{}'", host.block_text());
                host.diagnose(&diag::SIEMENS_FRAME, text);
                Ok(Some(Vec::new()))
            }
        }
    }
}

/// The reason if a work offset cannot be this frame.
fn fits(host: &dyn InterpreterHost, frame: &SiemensFrame) -> Result<(), String> {
    let parts = frame.parts().unwrap_or_default();
    let only =
        FrameComponents { shift: parts.shift, fine: parts.fine, angles: parts.angles, ..FrameComponents::default() };
    let same = |only: SiemensFrame| only.numbers().iter().zip(frame.numbers()).all(|(a, b)| (a - b).abs() < 1e-9);
    if !only.frame().is_some_and(same) || !parts.beside.is_shift() {
        return Err(
            "a work offset of this machine can be translated and rotated, but not scaled or mirrored".to_owned()
        );
    }
    let axes = host.axes();
    let missing = (0..3).zip(GEOMETRY).any(|(at, name)| {
        let there = axes.iter().any(|axis| axis.letter.eq_ignore_ascii_case(name));
        !there && parts.get(at, FrameComponent::Translation) + parts.get(at, FrameComponent::Fine) != 0.0
    });
    if missing { Err("the frame moves an axis that the channel does not have".to_owned()) } else { Ok(()) }
}

/// Sets a work offset to a frame that is a translation and a rotation.
fn offset(host: &mut dyn InterpreterHost, number: u32, frame: &SiemensFrame) -> Result<(), String> {
    fits(host, frame)?;
    let parts = frame.parts().unwrap_or_default();
    let turned = parts.angles.iter().any(|angle| *angle != 0.0);
    let mut values = host.offset(number);
    let mut rest: [f64; 3] =
        [0, 1, 2].map(|at| parts.get(at, FrameComponent::Translation) + parts.get(at, FrameComponent::Fine));
    for (place, (axis, value)) in host.axes().iter().zip(&mut values).enumerate() {
        let at = GEOMETRY.iter().position(|name| name.eq_ignore_ascii_case(&axis.letter));
        *value = match at.and_then(|at| rest.get_mut(at)) {
            Some(slot) => std::mem::take(slot),
            None => parts.beside.of(place).shift + parts.beside.of(place).fine,
        };
    }
    if matches!(number, 0 | NO_OFFSET) && turned {
        return Err("the base frame of this machine, or its frame under G500, can only be a translation".to_owned());
    }
    if turned || host.offset_turn(number).is_some() {
        host.turn_offset(number, turned.then(|| frame.linear()));
    }
    if host.set_offset(number, &values) { Ok(()) } else { Err(format!("work offset {number} cannot be kept")) }
}

/// Blocks that set the programmable frame.
fn blocks(host: &dyn InterpreterHost, frame: &SiemensFrame) -> Result<Vec<String>, String> {
    let Some(parts) = frame.parts() else {
        return Err("the frame has no translation, rotation and scaling as parts, so the machine has no words for it"
            .to_owned());
    };
    let axes = host.axes();
    let present = GEOMETRY.map(|name| axes.iter().any(|axis| axis.letter.eq_ignore_ascii_case(name)));
    let word = |code: &str, words: String| {
        if host.is_code_text(code) {
            Ok(format!("{code} {}", words.trim_start()))
        } else {
            Err(format!("the machine has no literal code {code} for the frame"))
        }
    };
    let named = |at: usize, value: f64| {
        let name = GEOMETRY.get(at).copied().unwrap_or_default();
        format!("{name}{}", Data::Real(value).word())
    };
    let mut shift = String::new();
    for (at, present) in present.into_iter().enumerate() {
        let value = parts.get(at, FrameComponent::Translation) + parts.get(at, FrameComponent::Fine);
        if present {
            shift.push(' ');
            shift.push_str(&named(at, value));
        } else if value != 0.0 {
            return Err("the frame moves an axis that the channel does not have".to_owned());
        }
    }
    let others = axes.iter().enumerate().filter(|(_, axis)| !is_geometry(&axis.letter));
    let others: Vec<_> = others.map(|(at, axis)| (&axis.letter, parts.beside.of(at))).collect();
    let other = |letter: &str, value: f64| format!("{letter}{}", Data::Real(value).word());
    for (letter, own) in others.iter().filter(|(_, own)| own.shift + own.fine != 0.0) {
        shift.push(' ');
        shift.push_str(&other(letter, own.shift + own.fine));
    }
    let mut blocks = vec![word("TRANS", shift)?];
    for at in [2, 1, 0] {
        let angle = parts.get(at, FrameComponent::Rotation);
        if angle != 0.0 {
            blocks.push(word("AROT", named(at, angle))?);
        }
    }
    let changed = |part: FrameComponent, nothing: f64| {
        let words = (0..3).filter(|at| parts.get(*at, part) != nothing);
        let words = words.map(|at| named(at, if part == FrameComponent::Mirror { 0.0 } else { parts.get(at, part) }));
        let beside = others.iter().filter_map(|(letter, own)| match part {
            FrameComponent::Mirror => own.mirror.then(|| other(letter, 0.0)),
            _ => (own.scale != nothing).then(|| other(letter, own.scale)),
        });
        words.chain(beside).collect::<Vec<_>>()
    };
    for (code, words) in
        [("ASCALE", changed(FrameComponent::Scale, 1.0)), ("AMIRROR", changed(FrameComponent::Mirror, 0.0))]
    {
        if !words.is_empty() {
            blocks.push(word(code, words.join(" "))?);
        }
    }
    Ok(blocks)
}
