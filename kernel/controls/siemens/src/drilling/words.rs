//! Words of the blocks of a hole.
//!
//! *Invariant:* positions are rounded to nine decimals, like every value that the control's language gives to a word.

use super::super::system::plane;
use super::SiemensHoleBuilder;
use counterpoint_control_api::host::{InterpreterHost, MadeWord};

/// Steps per unit in the value of a word.
const STEPS: f64 = 1e9;

/// Register of a word of the machine.
type Register = Option<(counterpoint_machine::index::RegisterId, bool)>;

/// Registers of the abscissa, the ordinate and the applicate; the cycle drills along the applicate.
#[derive(Debug, Clone, Copy)]
pub(super) struct HoleAxes {
    registers: [Register; 3],
    /// Letters of the axes.
    pub(super) letters: [u8; 3],
}

impl HoleAxes {
    /// The axes of the active plane.
    pub(super) fn of(host: &dyn InterpreterHost) -> Self {
        Self::in_plane(host, plane(host))
    }

    /// The axes of a plane: 1 G17, 2 G18, 3 G19. Without a Y axis the applicate is always Z.
    pub(super) fn in_plane(host: &dyn InterpreterHost, plane: Option<i64>) -> Self {
        let has = |letter: u8| host.axis_letter(std::str::from_utf8(&[letter]).unwrap_or_default()).is_some();
        let letters = match plane.filter(|_| has(b'Y')) {
            Some(2) => *b"ZXY",
            Some(3) => *b"YZX",
            _ => *b"XYZ",
        };
        Self { registers: letters.map(|letter| host.register(letter).filter(|_| has(letter))), letters }
    }

    /// Whether the channel has an axis of the plane: 0 abscissa, 1 ordinate.
    pub(super) fn has(&self, at: usize) -> bool {
        self.registers.get(at).is_some_and(Option::is_some)
    }
}

impl SiemensHoleBuilder<'_> {
    /// Adds a word by its letter.
    pub(super) fn letter(&mut self, letter: u8, value: f64) {
        let register = self.host.register(letter);
        self.add(register, value);
    }

    /// Adds a word by the name of its register.
    pub(super) fn named(&mut self, name: &str, value: f64) {
        let register = self.host.register_named(name);
        self.add(register, value);
    }

    fn add(&mut self, register: Register, value: f64) {
        let Some((register, incremental)) = register else { return };
        let value = (value * STEPS).round() / STEPS;
        self.blocks.push(MadeWord { register, incremental, value, written: None, span: (0, 0) });
    }

    /// Adds a word of an axis of the plane: 0 = abscissa, 1 = ordinate, 2 = applicate.
    pub(super) fn axis(&mut self, at: usize, value: f64) {
        let register = self.axes.registers.get(at).copied().flatten();
        self.add(register, value);
    }

    /// Adds a word of the applicate.
    pub(super) fn along(&mut self, level: f64) {
        self.axis(2, level);
    }

    /// Ends the block.
    pub(super) fn end(&mut self) {
        self.blocks.end();
    }

    /// Moves to an absolute level at rapid (G90 G0).
    pub(super) fn rapid_absolute(&mut self, level: f64) {
        self.letter(b'G', 90.0);
        self.rapid(level);
    }

    /// Moves to a level at rapid (G0).
    pub(super) fn rapid(&mut self, level: f64) {
        self.move_by(0.0, level);
    }

    /// Moves to a level at feed (G1).
    pub(super) fn feed(&mut self, level: f64) {
        self.move_by(1.0, level);
    }

    /// Moves to a level with a G function.
    pub(super) fn move_by(&mut self, code: f64, level: f64) {
        self.letter(b'G', code);
        self.along(level);
        self.end();
    }

    /// Sets the feed in a block of its own.
    pub(super) fn set_feed(&mut self, feed: f64) {
        self.letter(b'F', feed);
        self.end();
    }

    /// Executes an M function in a block of its own.
    pub(super) fn function(&mut self, number: f64) {
        self.letter(b'M', number);
        self.end();
    }

    /// Stops the master spindle at an angle.
    pub(super) fn orient_spindle(&mut self, angle: f64) {
        self.siemens.held.spindle = Some(angle);
        self.letter(b'M', 19.0);
        self.named("SPOS", angle);
        self.end();
    }

    /// Dwells for a time in seconds, or for revolutions of the spindle if it is negative; 0 adds no block.
    pub(super) fn dwell(&mut self, time: f64) {
        if time == 0.0 {
            return;
        }
        self.letter(b'G', 4.0);
        self.letter(if time > 0.0 { b'F' } else { b'S' }, time.abs());
        self.end();
    }
}
