//! `$XM`, `$LZJ`, `$YW` …: where the axes of the channel stand.
//!
//! Invariant: an axis that the channel does not have stands at 0. Programmed units: a diameter on a diameter axis, degrees
//! on a rotary one. M = machine without length and work offsets, J = joint with both, W = programmed.

use crate::channel::Kernel;

/// Which value of which axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    letter: char,
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
    let kind = match rest.as_str() {
        "M" | "TM" | "HM" => 'M',
        "J" | "TJ" | "HJ" => 'J',
        "W" if "XYZ".contains(letter) => 'W',
        _ => return None,
    };
    "XYZUVWEABCND".contains(letter).then_some(Place { letter, kind, before })
}

impl Kernel<'_> {
    /// Channel axis with this letter.
    pub(crate) fn axis_of(&self, letter: char) -> Option<usize> {
        let role = "XYZ".find(letter).and_then(|at| self.place.cartesian.get(at).copied().flatten());
        role.map(usize::from).or_else(|| {
            self.place.axes.iter().position(|axis| {
                let own = self.machine.axes.get(axis.machine);
                own.is_some_and(|own| own.letter.len() == 1 && own.letter.starts_with(letter))
            })
        })
    }

    pub(super) fn position_of(&self, place: Place) -> f64 {
        let Some(axis) = self.axis_of(place.letter) else { return 0.0 };
        if place.kind == 'W' && !place.before {
            return self.programmed().get(axis).copied().unwrap_or(0.0);
        }
        let at = match self.macros.as_deref() {
            Some(runtime) if place.before => &runtime.before,
            _ => &self.place.position,
        };
        let value = |of: &crate::log::event::Position| of.get(axis).copied().unwrap_or(0.0);
        match place.kind {
            'M' => value(at) + value(&self.place.preset),
            'J' => value(&self.machine_point(at)),
            _ => value(&self.program_point(at)),
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
        let letter = |(slot, axis): (usize, Option<usize>)| {
            let axis = axis.and_then(|at| self.place.axes.get(at));
            let own = axis.and_then(|axis| self.machine.axes.get(axis.machine));
            let letter = own.and_then(|own| own.letter.chars().next()).unwrap_or('*');
            if slot == 3 || slot == 4 { letter.to_ascii_lowercase() } else { letter }
        };
        self.six_axes().into_iter().enumerate().map(letter).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_positions() {
        let of = |name: &str| place(name).map(|p| (p.letter, p.kind, p.before));
        assert_eq!(of("$XM"), Some(('X', 'M', false)));
        assert_eq!(of("$LZJ"), Some(('Z', 'J', true)));
        assert_eq!(of("$ATM"), Some(('A', 'M', false)));
        assert_eq!([of("$LW"), of("$EV"), of("$SDIR"), of("$FMODE"), of("$IW")], [None; 5]);
    }
}
