//! Texts that are engraved (Haas G47).
//!
//! The text is the comment of the block. Its letters are those of [`counterpoint_motion::lettering`]. Facts: the manual
//! of the control; reference control-emulator.md 5.6 for comments. *Invariant:* a text that cannot be engraved as a
//! whole moves nothing.

use counterpoint_channel::modal::group;
use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::ident::{codes, data};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::contour::element::Spot;
use counterpoint_motion::lettering;
use counterpoint_motion::lettering::GAP;

use crate::context::ActionContext;
use crate::entry::ActionEntry;
use crate::motion::{feed_to_point, programmed_targets, rapid_to_point};
use crate::time::check_feed;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[ActionEntry::of(&[codes::ENGRAVE], |act, _, _| engrave(act))];

/// The variable with the number of the next part.
const SERIAL: u32 = 599;
/// Height of letters without a word for it.
const USUAL: f64 = 25.4;

/// How a text lies.
struct Lie {
    axes: [AxisSlot; 3],
    begin: Position,
    /// Cosine and sine of its direction, times its height.
    along: [f64; 2],
    depth: f64,
    clear: f64,
}

fn engrave(act: &mut ActionContext<'_, '_>) -> Acted {
    let value = |act: &mut ActionContext<'_, '_>, id| act.take(id).map(|datum| datum.value);
    let kind = value(act, data::ENGRAVE_KIND).unwrap_or(0.0);
    let angle = value(act, data::ENGRAVE_ANGLE).unwrap_or(0.0);
    let height = value(act, data::ENGRAVE_HEIGHT).unwrap_or(USUAL);
    let plunge = value(act, data::ENGRAVE_PLUNGE);
    let clear = value(act, data::ENGRAVE_CLEAR);
    let (feed, unit) = act.active_feed();
    let (coded, target) = programmed_targets(act);
    let Some(text) = text(act, kind)? else { return Ok(()) };
    if let Some(letter) = lettering::unknown(&text) {
        return refuse(act, &format!("there is no letter for '{letter}'"));
    }
    if act.channel().state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE) {
        return refuse(act, "incremental positions (G91) are not emulated, give absolute ones (G90)");
    }
    if !(height > 0.0 && height.is_finite()) {
        return refuse(act, &format!("the height {height} of the letters must be above 0"));
    }
    let layout = &act.channel().state.place.layout;
    let axis = |role: usize| layout.cartesian.get(role).copied().flatten();
    let (Some(x), Some(y), Some(z)) = (axis(0), axis(1), axis(2)) else {
        return refuse(act, "the machine has no axes X, Y and Z");
    };
    if coded & z.bit() == 0 {
        return refuse(act, "the depth Z is missing");
    }
    let (sin, cos) = (libm::sin(angle.to_radians()), libm::cos(angle.to_radians()));
    let clear = clear.unwrap_or_else(|| act.channel().state.place.programmed().at(z));
    let lie = Lie { axes: [x, y, z], begin: target, along: [height * cos, height * sin], depth: target.at(z), clear };
    if lie.clear <= lie.depth {
        return refuse(act, &format!("the return plane {} is not above the depth {}", lie.clear, lie.depth));
    }
    check_feed(act, feed)?;
    if kind == 1.0 {
        let number = act.common(SERIAL)?;
        act.set_common(SERIAL, number + 1.0)?;
    }
    cut(act, &lie, &text, (plunge.or(feed), feed, unit))
}

/// The text to be engraved; none if the block only sets the number of the next part.
fn text(act: &mut ActionContext<'_, '_>, kind: f64) -> Result<Option<String>, Halt> {
    if (32.0..=126.0).contains(&kind) {
        return Ok(Some(char::from(kind as u8).to_string()));
    }
    let remark = remark(counterpoint_channel::text::current_text(act.channel()));
    let Some(remark) = remark.filter(|_| kind == 0.0 || kind == 1.0) else {
        let why = match kind {
            0.0 | 1.0 => "the text in parentheses is missing".to_owned(),
            _ => format!("the kind P{kind} is not 0, 1 or a letter from 32 to 126"),
        };
        return refuse(act, &why).map(|()| None);
    };
    if kind == 0.0 {
        return Ok(Some(remark));
    }
    let places = remark.bytes().filter(|byte| *byte == b'#').count();
    if places == 0 {
        let Ok(number) = remark.trim().parse::<u32>() else {
            return refuse(act, &format!("'{remark}' is neither a number nor places for one (#)")).map(|()| None);
        };
        act.set_common(SERIAL, f64::from(number))?;
        return Ok(None);
    }
    let number = act.common(SERIAL)?;
    let digits = format!("{:0places$}", number.max(0.0) as u64);
    if digits.len() > places {
        return refuse(act, &format!("the number {digits} does not fit into '{remark}'")).map(|()| None);
    }
    let mut digits = digits.chars();
    let written = remark.chars().map(|sign| if sign == '#' { digits.next().unwrap_or('0') } else { sign }).collect();
    Ok(Some(written))
}

/// The text in the first parentheses of a block.
fn remark(block: &[u8]) -> Option<String> {
    let start = block.iter().position(|byte| *byte == b'(')? + 1;
    let rest = block.get(start..)?;
    let end = rest.iter().position(|byte| *byte == b')').unwrap_or(rest.len());
    rest.get(..end).map(|text| String::from_utf8_lossy(text).into_owned())
}

fn cut(
    act: &mut ActionContext<'_, '_>,
    lie: &Lie,
    text: &str,
    (plunge, feed, unit): (Option<f64>, Option<f64>, FeedUnit),
) -> Acted {
    let [x, y, z] = lie.axes;
    let flat = x.bit() | y.bit();
    let at = |height: f64, [along, up]: Spot| {
        let [cos, sin] = lie.along;
        let mut place = lie.begin;
        *place.at_mut(x) += along * cos - up * sin;
        *place.at_mut(y) += along * sin + up * cos;
        *place.at_mut(z) = height;
        place
    };
    let mut over = at(act.channel().state.place.programmed().at(z), [0.0; 2]);
    rapid_to_point(act, flat, over)?;
    *over.at_mut(z) = lie.clear;
    rapid_to_point(act, z.bit(), over)?;
    for stroke in lettering::strokes(text, GAP) {
        let (Some(first), Some(last)) = (stroke.first(), stroke.last()) else { continue };
        act.count_as_block()?;
        rapid_to_point(act, flat, at(lie.clear, *first))?;
        feed_to_point(act, z.bit(), at(lie.depth, *first), plunge, unit)?;
        for point in stroke.iter().skip(1) {
            feed_to_point(act, flat, at(lie.depth, *point), feed, unit)?;
        }
        rapid_to_point(act, z.bit(), at(lie.clear, *last))?;
    }
    Ok(())
}

fn refuse(act: &mut ActionContext<'_, '_>, why: &str) -> Acted {
    let text = format!("'{}' is not engraved: {why}", act.channel().block_text());
    Err(act.alarm(&diag::CYCLE_REFUSED, text))
}
