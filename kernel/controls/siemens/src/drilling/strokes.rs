//! CYCLE83: deep holes, in several strokes.
//!
//! Facts: reference siemens-cycles.md 1. VARI 0 breaks the chips with a retract by _VRT; VARI 1 clears the chips with a
//! retract out of the hole.

use super::super::Outcome;
use super::super::conversions::same;
use super::super::groups;
use super::super::number_text::shown;
use super::{MOST_STROKES, NEGLIGIBLE, SiemensHoleBuilder};

/// G group of the unit of length: 1 is G70, 3 is G700.
const UNIT_GROUP: i64 = 13;

// Positions of the arguments.
const FDEP: usize = 5;
const FDPR: usize = 6;
const DAM: usize = 7;
const DTB: usize = 8;
const DTS: usize = 9;
const FRF: usize = 10;
const VARI: usize = 11;
const MDEP: usize = 13;
const VRT: usize = 14;
const DTD: usize = 15;
const DIS1: usize = 16;
const MODES: usize = 17;
const AMODE: usize = MODES + 2;

/// The strokes of a hole.
struct Strokes {
    /// Length of the next stroke.
    length: f64,
    /// Amount by which strokes decrease; a negative value is a factor.
    less: f64,
    /// Minimum length of a stroke.
    least: f64,
    /// Whether the hole ends with two strokes of the same length.
    halved: bool,
}

impl Strokes {
    /// Sets the length of the next stroke.
    ///
    /// With an amount, strokes decrease by the amount until they would be shorter than the amount. From then on each
    /// stroke is as long as the amount. The last two strokes are each half of the rest.
    fn shorten(&mut self, rest: f64) {
        if self.less < 0.0 {
            self.length *= self.less.abs();
        } else if self.less > 0.0 {
            if self.halved {
                self.length = rest;
            } else if at_most(self.less, self.length - self.less) {
                self.length -= self.less;
            } else {
                self.length = self.less;
                if at_most(rest, 2.0 * self.less) {
                    (self.length, self.halved) = (rest / 2.0, true);
                }
            }
        }
        self.length = self.length.max(self.least).min(rest);
    }
}

impl SiemensHoleBuilder<'_> {
    /// CYCLE83(RTP, RFP, SDIS, DP, DPR, FDEP, FDPR, DAM, DTB, DTS, FRF, VARI, _AXN, _MDEP, _VRT, _DTD, _DIS1, _GMODE,
    /// _DMODE, _AMODE).
    pub(super) fn deep(&mut self) -> Outcome<()> {
        if matches!(groups::active(self.host, UNIT_GROUP), Some(1 | 3)) {
            self.alarm(61002, "this cycle is not emulated in inches (G70, G700); program it in millimetres")?;
        }
        self.deep_modes()?;
        let mut levels = self.levels()?;
        if self.arguments.number(MODES) >= 10.0 {
            levels.bottom += levels.sign * self.shank_depth()?;
        }
        let clears = self.arguments.number(VARI);
        if clears != 0.0 && clears != 1.0 {
            self.alarm(61002, &format!("kind of machining is {}, expected 0 or 1", shown(clears)))?;
        }
        let clears = clears == 1.0;
        let factor = self.first_feed_factor();
        // A macro of the machine may supply this variable, so it is read only if it is needed.
        let feed = if factor == 1.0 { 0.0 } else { self.variable("$P_F")? };
        let total = levels.total();
        let mut strokes = self.strokes(levels.reference, levels.sign, total)?;
        let back = or_else(self.arguments.number(VRT), 1.0);
        let dwell = self.arguments.number(DTB);
        let mut last_dwell = self.arguments.number(DTD);
        if self.arguments.digit(AMODE, 3) == 0 {
            last_dwell = or_else(last_dwell, dwell);
        }
        let lead = self.lead_before_depth(total);
        self.rapid_absolute(levels.start);
        let mut done = 0.0;
        for _ in 0..MOST_STROKES {
            let own_feed = done == 0.0 && factor != 1.0;
            if own_feed {
                self.set_feed(feed * factor);
            } else if done > 0.0 && clears {
                self.rapid(levels.at(done - lead));
            }
            done += strokes.length;
            let is_last = done >= total - NEGLIGIBLE;
            done = if is_last { total } else { done };
            self.feed(levels.at(done));
            if own_feed {
                self.set_feed(feed);
            }
            if is_last {
                self.dwell(last_dwell);
                self.rapid(levels.retract);
                return Ok(());
            }
            self.dwell(dwell);
            if clears {
                self.rapid(levels.start);
                self.dwell(self.arguments.number(DTS));
            } else {
                self.feed(levels.at(done - back));
            }
            strokes.shorten(total - done);
        }
        self.alarm(61107, &format!("the hole needs more than {MOST_STROKES} strokes; make them longer"))
    }

    /// Applies the modes of the cycle.
    fn deep_modes(&mut self) -> Outcome<()> {
        if (MODES..=AMODE).all(|at| self.arguments.number(at) == 0.0) {
            return Ok(());
        }
        self.depth_modes(MODES, 19, Some(DTB), 12_222_222)?;
        self.unit_of_time(DTS, AMODE, 2);
        self.unit_of_time(DTD, AMODE, 3);
        let arguments = &mut self.arguments;
        match arguments.digit(AMODE, 4) {
            1 if arguments.number(FDPR) == 0.0 => arguments.set(FDPR, arguments.number(FDEP)),
            2 => arguments.set(FDPR, 0.0),
            _ => {}
        }
        let less = arguments.number(DAM).abs();
        match arguments.digit(AMODE, 5) {
            1 => arguments.set(DAM, less),
            2 => arguments.set(DAM, -less / 100.0),
            _ => {}
        }
        Ok(())
    }

    /// Feed factor of the first stroke. A factor above 1 is a percentage, regardless of the modes.
    fn first_feed_factor(&self) -> f64 {
        let factor = self.arguments.number(FRF);
        let percent = factor > 1.0 || self.arguments.number(AMODE) >= 10_000_000.0;
        let factor = if percent { factor / 100.0 } else { factor };
        if factor <= 0.0 { 1.0 } else { factor }
    }

    /// The first stroke and the rule for the following strokes.
    fn strokes(&mut self, reference: f64, sign: f64, total: f64) -> Outcome<Strokes> {
        let relative = self.arguments.number(FDPR);
        let length = if relative != 0.0 {
            relative.abs()
        } else if self.arguments.is_given(FDEP) {
            (self.arguments.number(FDEP) - reference) * sign
        } else {
            total
        };
        if length <= 0.0 || !at_most(length, total) {
            let text = format!("first depth {} of a hole {} deep", shown(length), shown(total));
            self.alarm(61107, &text)?;
        }
        let (less, least) = (self.arguments.number(DAM), self.arguments.number(MDEP));
        Ok(Strokes { length, less, least, halved: false })
    }

    /// Distance above the depth already reached at which the tool ends its rapid return.
    fn lead_before_depth(&self, total: f64) -> f64 {
        let (given, mode) = (self.arguments.number(DIS1), self.arguments.digit(AMODE, 6));
        let follows = mode == 1 || given == 0.0 && mode == 0;
        match follows {
            true if total > 30.0 => (total / 50.0).min(7.0),
            true => 0.6,
            false => given,
        }
    }
}

/// Whether `value` is at most `most`, within the tolerance of the control.
fn at_most(value: f64, most: f64) -> bool {
    value < most || same(value, most)
}

/// `value`, or `other` if it is 0.
fn or_else(value: f64, other: f64) -> f64 {
    if value == 0.0 { other } else { value }
}
