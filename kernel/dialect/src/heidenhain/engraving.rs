//! Cycle 225: engraving.
//!
//! Facts: programming manuals of the control (QS500 is the text, Q513 the height of its capitals, Q514 a factor of the room between
//! characters, 0 for the usual one, Q374 turns it, Q574 is the length it may have; the tool comes down at each stroke and rises to the clearance
//! behind it; `%%` is a percent sign). Decisions: the text begins where the tool stands, at the lower left; a longer text is made smaller
//! as a whole. What is refused: arcs, other places of the text, dates and counters.

use counterpoint_motion::contour::closed::turned_by;
use counterpoint_motion::contour::element::{Spot, plus};
use counterpoint_motion::lettering;

use super::Heidenhain;
use super::clearing::Blocks;
use super::cycles::RAPID;
use super::formula::{Kind, Name};
use super::path::actual;
use super::variables::Value;
use crate::host::Host;

/// The text of the cycle.
const TEXT: Name = Name { kind: Kind::Text, index: 500 };

/// A text with its percent signs in their place.
fn plain(text: &str) -> Result<String, String> {
    let mut out = String::new();
    let mut rest = text.chars();
    while let Some(character) = rest.next() {
        if character == '%' && rest.next() != Some('%') {
            return Err(
                "dates and counters (%) in the text of cycle 225 are not emulated; write %% for a percent sign"
                    .to_owned(),
            );
        }
        out.push(character);
    }
    match lettering::unknown(&out) {
        Some(character) => Err(format!("cycle 225 has no character '{character}'")),
        None => Ok(out),
    }
}

impl Heidenhain {
    /// The blocks of cycle 225.
    pub(super) fn engrave(&self, host: &dyn Host) -> Result<Vec<String>, String> {
        let Some(Value::Text(text)) = self.variables.get(TEXT) else {
            return Err("cycle 225 has no text QS500".to_owned());
        };
        for (index, what) in [(516, "on arcs"), (367, "at other places"), (515, "in other fonts")] {
            if self.sl(index) != 0.0 {
                return Err(format!("texts {what} are not emulated in cycle 225: program Q{index}=0"));
            }
        }
        let text = plain(&text)?;
        let gap = lettering::GAP * if self.sl(514) == 0.0 { 1.0 } else { self.sl(514) };
        let length = lettering::width(text.len(), gap);
        let mut height = self.sl(513);
        let most = self.sl(574);
        if most > 0.0 && length * height > most {
            height = most / length;
        }
        let stands = actual(host);
        let begin = self.path.plane.map(|axis| stands.get(axis).copied().unwrap_or(0.0));
        let unit = host.length_factor();
        // Blocks take places in units of the machine.
        let place = |spot: Spot| plus([0.0; 2], plus(begin, turned_by(spot, self.sl(374)), height), unit);
        let clear = self.sl(203) + self.sl(200);
        let ground = self.sl(203) + self.sl(201);
        let mut blocks = Blocks::of(self, host);
        blocks.rise_to(clear, RAPID);
        for stroke in lettering::strokes(&text, gap) {
            let mut spots = stroke.into_iter().map(place);
            let Some(first) = spots.next() else { continue };
            blocks.over(first);
            blocks.rise_to(ground, self.sl(206));
            for spot in spots {
                blocks.line(spot, self.sl(207));
            }
            blocks.rise_to(clear, RAPID);
        }
        if self.sl(204) > self.sl(200) {
            blocks.rise_to(self.sl(203) + self.sl(204), RAPID);
        }
        Ok(blocks.lines)
    }
}
