//! Polar words `@` (radius) and `^` (angle) of a motion.
//!
//! Facts: LinuxCNC documentation, "Polar Coordinates". In absolute mode a missing radius or angle is that of the
//! current point; in incremental mode both are added to it. *Invariant:* a converted block has X and Y instead.

use counterpoint_fault as diag;
use counterpoint_machine::ident::codes as ids;

use super::Outcome;
use super::block::{BlockWord, BlockWords};
use super::system::axis;
use super::text::Rs274Mistake;
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_control_api::numeric::{cosine, sine};

fn refused(error: u8, text: &str) -> Rs274Mistake {
    Rs274Mistake::new(&diag::REFUSED, error, text)
}

/// The block with X and Y instead of polar words; `None` if it has none. In incremental mode, each pass of a repeated
/// cycle adds the words to the point of the previous pass; the first pass is 0.
pub(super) fn without_polar(host: &dyn InterpreterHost, words: &BlockWords, pass: u32) -> Outcome<Option<BlockWords>> {
    if !words.has_polar() {
        return Ok(None);
    }
    if !host.is_active(ids::PLANE_XY) {
        return Err(refused(20, "polar words need the plane of G17: write G17, or X, Y and Z").into());
    }
    if words.has_g(530) {
        return Err(refused(20, "polar words cannot be in one block with G53: write X and Y").into());
    }
    let (places, relative) = (host.axes(), host.relative());
    let here = [0, 1].map(|at| axis(&places, at).map_or(0.0, |place| place.work));
    let [x, y] = here;
    let (distance, angle) = (words.get(b'@'), words.get(b'^'));
    let at_origin = x == 0.0 && y == 0.0;
    if at_origin && (relative || angle.is_none()) {
        return Err(refused(20, "the angle of the current point is not defined, because it is the origin").into());
    }
    let (now, turned) = (libm::hypot(x, y), libm::atan2(y, x).to_degrees());
    let point = |radius: f64, degrees: f64| [radius * cosine(degrees), radius * sine(degrees)];
    let (more, turn) = (distance.unwrap_or(0.0), angle.unwrap_or(0.0));
    let after = |passes: u32| point(now + more * f64::from(passes), turned + turn * f64::from(passes));
    let to = if relative { after(pass + 1) } else { point(distance.unwrap_or(now), angle.unwrap_or(turned)) };
    let here = if pass > 0 { after(pass) } else { here };
    let span = words.word(b'@').or(words.word(b'^')).map_or(words.whole, |word| word.span);
    let mut made = words.clone();
    made.words.retain(|word| !matches!(word.letter, b'@' | b'^'));
    for ((letter, to), here) in b"xy".iter().zip(to).zip(here) {
        let value = if relative { to - here } else { to };
        made.words.push(BlockWord { letter: *letter, value, spelled: None, span });
    }
    Ok(Some(made))
}
