//! `$XM`, `$LZJ`, `$YW` …: where the axes of the channel stand.
//!
//! Invariant: an axis that the channel does not have stands at 0. Programmed units: a diameter on a diameter axis, degrees
//! on a rotary one. M = machine without length and work offsets, J = joint with both, W = programmed.

use crate::channel::Kernel;
use crate::machine::ident::{DataId, data};

/// Which value of which axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    letter: char,
    /// `T` of a table, `H` of a head, none for either.
    side: Option<char>,
    kind: char,
    /// At the start of the last motion.
    before: bool,
}

/// The place that a name means.
pub(super) fn place(name: &str) -> Option<Place> {
    let name = name.strip_prefix('$')?;
    let (before, name) = match name.strip_prefix('L') {
        Some(rest) if rest.len() > 1 => (true, rest),
        _ => (false, name),
    };
    let mut letters = name.chars();
    let letter = letters.next()?;
    let rest: String = letters.collect();
    let (side, kind) = match rest.as_str() {
        "M" => (None, 'M'),
        "TM" => (Some('T'), 'M'),
        "HM" => (Some('H'), 'M'),
        "J" => (None, 'J'),
        "TJ" => (Some('T'), 'J'),
        "HJ" => (Some('H'), 'J'),
        "W" if "XYZ".contains(letter) => (None, 'W'),
        _ => return None,
    };
    "XYZUVWEABCND".contains(letter).then_some(Place { letter, side, kind, before })
}

/// Which machine axis a data identifier is: its letter as `$AXES` shows it, lower case for a table and for the second
/// one that can be removed.
pub(in crate::macros::host) fn axis_letter(id: DataId) -> Option<char> {
    Some(match id {
        data::AXIS_AT => 'a',
        data::AXIS_BT => 'b',
        data::AXIS_CT | data::AXIS_CT2 => 'c',
        data::AXIS_AH => 'A',
        data::AXIS_BH => 'B',
        data::AXIS_CH => 'C',
        data::AXIS_N => 'N',
        data::AXIS_N2 => 'n',
        data::AXIS_U => 'U',
        data::AXIS_V => 'V',
        data::AXIS_W => 'W',
        data::AXIS_E => 'E',
        _ => return None,
    })
}

impl Kernel<'_> {
    /// Channel axis with this letter.
    pub(crate) fn axis_of(&self, letter: char) -> Option<usize> {
        self.axis_on(letter, None)
    }

    /// The same of a table or a head only; without a side the table goes first. N and D are those that can be removed.
    fn axis_on(&self, letter: char, side: Option<char>) -> Option<usize> {
        if let Some(at) = "XYZ".find(letter) {
            return self.place.cartesian.get(at).copied().flatten().map(usize::from);
        }
        let wanted: &[char] = match (letter, side) {
            ('N', _) => &['N'],
            ('D', _) => &['n'],
            (_, Some('T')) => &[letter.to_ascii_lowercase()],
            (_, Some(_)) => &[letter],
            _ => &[letter.to_ascii_lowercase(), letter],
        };
        wanted.iter().find_map(|wanted| self.place.axes.iter().position(|axis| axis_letter(axis.data) == Some(*wanted)))
    }

    pub(super) fn position_of(&self, place: Place) -> f64 {
        let Some(axis) = self.axis_on(place.letter, place.side) else { return 0.0 };
        let at = match self.macros.as_deref() {
            Some(runtime) if place.before => &runtime.before,
            _ => &self.place.position,
        };
        let value = |of: &crate::log::event::Position| of.get(axis).copied().unwrap_or(0.0);
        match place.kind {
            'M' => value(at) + value(&self.place.preset),
            'J' => value(at) + value(&self.place.shift),
            _ => value(at),
        }
    }

    /// Channel axes of the six elements of `$AXES`: X Y Z, two rotary ones, and one more.
    pub(crate) fn six_axes(&self) -> [Option<usize>; 6] {
        let mut rotary = self.place.axes.iter().enumerate().filter(|(_, axis)| axis.rotary).map(|(at, _)| at);
        let cartesian = self.place.cartesian.map(|at| at.map(usize::from));
        let [x, y, z] = cartesian;
        let (fourth, fifth) = (rotary.next(), rotary.next());
        let mut others = self.place.axes.iter().enumerate().filter(|(_, axis)| !axis.rotary).map(|(at, _)| at);
        let sixth = others.find(|at| !cartesian.contains(&Some(*at))).or_else(|| rotary.next());
        [x, y, z, fourth, fifth, sixth]
    }

    /// `$AXES`
    pub(super) fn axes_text(&self) -> String {
        let letter = |axis: Option<usize>| {
            let axis = axis.and_then(|at| self.place.axes.get(at));
            let own = axis.and_then(|axis| self.machine.axes.get(axis.machine));
            let known = axis.and_then(|axis| axis_letter(axis.data));
            known.or_else(|| own.and_then(|own| own.letter.chars().next())).unwrap_or('*')
        };
        self.six_axes().into_iter().map(letter).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_positions() {
        let of = |name: &str| place(name).map(|p| (p.letter, p.kind, p.before));
        assert_eq!(place("$BHM").and_then(|p| p.side), Some('H'));
        assert_eq!(of("$XM"), Some(('X', 'M', false)));
        assert_eq!(of("$LZJ"), Some(('Z', 'J', true)));
        assert_eq!(of("$ATM"), Some(('A', 'M', false)));
        assert_eq!([of("$LW"), of("$EV"), of("$SDIR"), of("$FMODE"), of("$IW")], [None; 5]);
    }
}
