//! Speeds along moves that follow each other without a stop, and the time that each takes.
//!
//! A [`LookAheadMove`] is one move: its length, the largest speed along it, and the largest speed at the corner before it. A
//! piece is timed when enough later ones are known ([`LookAhead::new`]), or when the path is known to stop after the
//! last one. Speeds change at the acceleration of each piece (trapezoids, reference channel-synchronisation.md 3).
//!
//! *Invariants:* the path can always stop at the end of the known pieces; a piece never takes less time than at its
//! largest speed; nothing is allocated once the queue has had its largest length.

use std::collections::VecDeque;

use crate::law::SpeedRamp;

/// One move. Lengths in geometry units, times in seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LookAheadMove {
    /// Length, above zero.
    pub length: f64,
    /// Largest speed, above zero.
    pub speed: f64,
    /// Largest acceleration along it; infinite: speed changes take no time.
    pub acceleration: f64,
    /// Largest jerk along it; infinite: the acceleration changes at once.
    pub jerk: f64,
    /// Largest speed at its start, where the path changes its direction.
    pub corner: f64,
}

/// Braking for less than this, seconds, takes no time.
const INSTANT: f64 = 1e-6;

impl LookAheadMove {
    /// Seconds from standstill to standstill.
    #[must_use]
    pub fn alone(&self) -> f64 {
        let profile = Profile::new(self, 0.0, 0.0);
        profile.seconds() + self.smoothing(0.0, profile.peak) * 2.0
    }

    /// Additional seconds of a change between two speeds because of the jerk.
    ///
    /// With jerk `j` a change by `d` takes `d/a + a/j` (or `2·√(d/j)` if the acceleration is never reached) in place of
    /// `d/a`. It is longer by half the sum of both speeds times that difference, which is missing from the path at the
    /// higher speed.
    fn smoothing(&self, low: f64, high: f64) -> f64 {
        let change = high - low;
        if !self.jerk.is_finite() || !self.acceleration.is_finite() || change <= 0.0 {
            return 0.0;
        }
        let rise = self.acceleration * self.acceleration / self.jerk;
        let taken = if change >= rise {
            change / self.acceleration + self.acceleration / self.jerk
        } else {
            2.0 * (change / self.jerk).sqrt()
        };
        (taken - change / self.acceleration) * change / (2.0 * high)
    }
}

/// The speed along a piece: up, steady, down.
#[derive(Debug, Clone, Copy)]
struct Profile {
    up: f64,
    steady: f64,
    down: f64,
    peak: f64,
}

impl Profile {
    /// Between two squared speeds at its ends, which the piece can reach.
    fn new(piece: &LookAheadMove, entry: f64, exit: f64) -> Self {
        let LookAheadMove { length, speed, acceleration, .. } = *piece;
        let peak = (speed * speed).min(0.5 * (entry + exit) + acceleration * length).max(entry.max(exit));
        let ramps = (2.0 * peak - entry - exit) / (2.0 * acceleration);
        let steady = (length - ramps).max(0.0);
        let peak = peak.sqrt();
        let time = |end: f64| (peak - end.sqrt()).max(0.0) / acceleration;
        Self { up: time(entry), steady: if steady > 0.0 { steady / peak } else { 0.0 }, down: time(exit), peak }
    }

    fn seconds(&self) -> f64 {
        self.up + self.steady + self.down
    }
}

/// A piece that waits for its time.
#[derive(Debug, Clone, Copy)]
struct Planned {
    piece: LookAheadMove,
    /// Largest squared speed at its start from which the path can stop at the end of the known pieces.
    entry: f64,
}

/// Moves whose times are not known yet.
#[derive(Debug, Clone)]
pub struct LookAhead {
    depth: usize,
    pieces: VecDeque<Planned>,
    /// Squared speed at the start of the first piece.
    entry: f64,
    /// Speed at which the change that is in progress began.
    ramp: Option<Ramp>,
}

/// A change of speed that may continue in the next piece.
#[derive(Debug, Clone, Copy)]
struct Ramp {
    begun: f64,
    up: bool,
}

impl LookAhead {
    /// A path at standstill that looks this many moves ahead.
    #[must_use]
    pub fn new(depth: usize) -> Self {
        Self { depth: depth.max(1), pieces: VecDeque::with_capacity(depth + 2), entry: 0.0, ramp: None }
    }

    /// Moves whose times are not known.
    #[must_use]
    pub fn len(&self) -> usize {
        self.pieces.len()
    }

    /// Whether all times are known.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.pieces.is_empty()
    }

    /// More moves are known than the control looks ahead: the first can be timed.
    #[must_use]
    pub fn is_due(&self) -> bool {
        self.pieces.len() > self.depth
    }

    /// The next move of the path.
    pub fn push(&mut self, piece: LookAheadMove) {
        let corner = match self.pieces.back() {
            Some(last) => piece.corner.min(last.piece.speed).min(piece.speed),
            // The path continues from a speed that is decided.
            None => self.entry.sqrt(),
        };
        let stop = 2.0 * piece.acceleration * piece.length;
        self.pieces.push_back(Planned { piece: LookAheadMove { corner, ..piece }, entry: (corner * corner).min(stop) });
        // Earlier moves may now end faster, back to the first that could not begin faster anyway.
        let mut next = self.pieces.back().map_or(0.0, |last| last.entry);
        for at in (0..self.pieces.len() - 1).rev() {
            let Some(planned) = self.pieces.get_mut(at) else { return };
            let LookAheadMove { corner, acceleration, length, .. } = planned.piece;
            let entry = (corner * corner).min(next + 2.0 * acceleration * length);
            if entry <= planned.entry {
                return;
            }
            planned.entry = entry;
            next = entry;
        }
    }

    /// Takes the first move off: its seconds. After the last one the path stands.
    pub fn pop(&mut self) -> Option<f64> {
        self.take().map(|(seconds, ..)| seconds)
    }

    /// Takes the first move off: its seconds, and the speed along it; `None` for a move with a jerk.
    pub fn pop_with_ramp(&mut self) -> Option<(f64, Option<SpeedRamp>)> {
        let entry = self.entry.sqrt();
        let (seconds, piece, profile) = self.take()?;
        let LookAheadMove { length, acceleration, jerk, .. } = piece;
        let ramp = SpeedRamp { length, entry, top: profile.peak, exit: self.entry.sqrt(), acceleration };
        Some((seconds, (!jerk.is_finite()).then_some(ramp)))
    }

    #[inline(always)]
    fn take(&mut self) -> Option<(f64, LookAheadMove, Profile)> {
        let Planned { piece, .. } = self.pieces.pop_front()?;
        let exit = self.pieces.front().map_or(0.0, |next| next.entry);
        let exit = exit.min(self.entry + 2.0 * piece.acceleration * piece.length);
        let profile = Profile::new(&piece, self.entry, exit);
        let seconds = profile.seconds() + self.jerks(&piece, &profile, exit);
        self.entry = exit;
        Some((seconds, piece, profile))
    }

    /// Seconds after the start of the only move at which it has to brake to stop at its end; none if braking takes no
    /// time.
    #[must_use]
    pub fn brakes_after(&self) -> Option<f64> {
        let last = self.pieces.front().filter(|_| self.pieces.len() == 1)?;
        let profile = Profile::new(&last.piece, self.entry, 0.0);
        (profile.down > INSTANT).then_some(profile.up + profile.steady)
    }

    /// Additional seconds for the changes of speed that end in a piece.
    fn jerks(&mut self, piece: &LookAheadMove, profile: &Profile, exit: f64) -> f64 {
        if !piece.jerk.is_finite() {
            self.ramp = None;
            return 0.0;
        }
        let (entry, exit, peak) = (self.entry.sqrt(), exit.sqrt(), profile.peak);
        let mut seconds = 0.0;
        let mut end = |ramp: Option<Ramp>, at: f64| {
            if let Some(Ramp { begun, .. }) = ramp {
                seconds += piece.smoothing(begun.min(at), begun.max(at));
            }
        };
        if peak > entry {
            if let Some(down) = self.ramp.take_if(|ramp| !ramp.up) {
                end(Some(down), entry);
            }
            self.ramp.get_or_insert(Ramp { begun: entry, up: true });
        }
        if profile.steady > 0.0 {
            end(self.ramp.take(), peak);
        }
        if exit < peak {
            if let Some(up) = self.ramp.take_if(|ramp| ramp.up) {
                end(Some(up), peak);
            }
            self.ramp.get_or_insert(Ramp { begun: peak, up: false });
        }
        if exit <= 0.0 {
            end(self.ramp.take(), 0.0);
        }
        seconds
    }
}

/// Largest speed at a corner between two unit vectors: a circle of the acceleration that leaves the corner by the
/// deviation.
///
/// `v² = a·δ·sin(θ/2) / (1 − sin(θ/2))`, θ the angle between the moves, half a turn where they go straight on
/// (reference channel-synchronisation.md 3). Infinite on a straight path.
#[must_use]
pub fn corner_speed(cosine: f64, acceleration: f64, deviation: f64) -> f64 {
    let half = (0.5 * (1.0 + cosine)).clamp(0.0, 1.0).sqrt();
    // A turn of less than 0.1 degrees is none.
    if half >= 1.0 - 4e-7 {
        return f64::INFINITY;
    }
    (acceleration * deviation * half / (1.0 - half)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: f64 = 1000.0;

    fn piece(length: f64, speed: f64, corner: f64) -> LookAheadMove {
        LookAheadMove { length, speed, acceleration: A, jerk: f64::INFINITY, corner }
    }

    fn times(depth: usize, pieces: &[LookAheadMove]) -> Vec<f64> {
        let mut look = LookAhead::new(depth);
        let mut times = Vec::new();
        for piece in pieces {
            look.push(*piece);
            while look.is_due() {
                times.extend(look.pop());
            }
        }
        while let Some(time) = look.pop() {
            times.push(time);
        }
        times
    }

    #[test]
    fn two_straight_moves_make_one_ramp_up_and_one_down() {
        // 100 mm at 100 mm/s and 1000 mm/s²: 10 mm of ramps, reference channel-synchronisation.md 3.
        let pieces = [piece(100.0, 100.0, 0.0), piece(100.0, 100.0, f64::INFINITY)];
        assert_eq!(times(10, &pieces), [1.05, 1.05]);
        assert_eq!(times(1, &pieces), [1.05, 1.05]);
        let stop = [piece(100.0, 100.0, 0.0), piece(100.0, 100.0, 0.0)];
        assert_eq!(times(10, &stop), [1.1, 1.1]);
    }

    #[test]
    fn short_moves_are_limited_by_what_is_known() {
        // 1 mm each: from the start 1 mm reaches √(2·1000·1) = 44.7 mm/s, and from there a stop within 1 mm is
        // possible.
        let pieces = [piece(1.0, 100.0, 0.0), piece(1.0, 100.0, f64::INFINITY), piece(1.0, 100.0, f64::INFINITY)];
        let narrow = times(1, &pieces);
        let v = 2000_f64.sqrt();
        assert!((narrow[0] - v / A).abs() < 1e-12, "{narrow:?}");
        // Up and down again to the same speed, as only one more move was known.
        let peak = (2000.0 + 1000.0_f64).sqrt();
        assert!((narrow[1] - 2.0 * (peak - v) / A).abs() < 1e-12, "{narrow:?}");
        // 3 mm as one triangle: 2·√(3/1000).
        let wide: f64 = times(3, &pieces).iter().sum();
        assert!((wide - 2.0 * (3.0_f64 / 1000.0).sqrt()).abs() < 1e-12);
        let one: f64 = narrow.iter().sum();
        assert!(wide <= one);
    }

    #[test]
    fn a_corner_slows_down_both_sides() {
        let pieces = [piece(100.0, 100.0, 0.0), piece(100.0, 50.0, 20.0)];
        let times = times(5, &pieces);
        // 0 → 100 → 20 and 20 → 50 → 0.
        let first = 0.1 + 0.08 + (100.0 - 5.0 - 4.8) / 100.0;
        let second = 0.03 + 0.05 + (100.0 - 1.05 - 1.25) / 50.0;
        assert!((times[0] - first).abs() < 1e-12 && (times[1] - second).abs() < 1e-12, "{times:?}");
    }

    #[test]
    fn without_acceleration_only_the_speed_counts() {
        let pieces = [4.0, 2.0].map(|length| LookAheadMove { acceleration: f64::INFINITY, ..piece(length, 2.0, 0.0) });
        assert_eq!(times(5, &pieces), [2.0, 1.0]);
    }

    #[test]
    fn jerk_adds_its_rise_to_each_change() {
        // L/v + v/a + a/j: 1 + 0.1 + 0.02.
        let single = LookAheadMove { jerk: 50_000.0, ..piece(100.0, 100.0, 0.0) };
        assert!((single.alone() - 1.12).abs() < 1e-12);
        // The same over many moves: a ramp over several of them is one change.
        let mut pieces = vec![single];
        pieces.extend([LookAheadMove { length: 1.0, corner: f64::INFINITY, ..single }; 100]);
        let whole: f64 = times(200, &pieces).iter().sum();
        assert!((whole - 2.12).abs() < 1e-9, "{whole}");
    }

    #[test]
    fn brakes_where_the_way_is_needed() {
        let mut look = LookAhead::new(10);
        look.push(piece(100.0, 100.0, 0.0));
        assert!((look.brakes_after().unwrap() - 1.0).abs() < 1e-12);
        look.push(piece(100.0, 100.0, f64::INFINITY));
        assert_eq!(look.brakes_after(), None);
        look.pop();
        assert!((look.brakes_after().unwrap() - 0.95).abs() < 1e-12);
    }

    #[test]
    fn corners_by_deviation() {
        // Square corner: sin 45° / (1 − sin 45°) = 2.414.
        let square = corner_speed(0.0, 1000.0, 0.01);
        assert!((square * square - 10.0 * (0.5_f64.sqrt() / (1.0 - 0.5_f64.sqrt()))).abs() < 1e-9);
        assert_eq!(corner_speed(1.0, 1000.0, 0.01), f64::INFINITY);
        assert_eq!(corner_speed(-1.0, 1000.0, 0.01), 0.0);
    }

    /// Speeds by brute force: passes over the whole path until nothing changes.
    fn model(pieces: &[LookAheadMove]) -> f64 {
        let n = pieces.len();
        let mut v = vec![0.0_f64; n + 1];
        for at in 1..n {
            v[at] = pieces[at].corner.min(pieces[at - 1].speed).min(pieces[at].speed);
        }
        loop {
            let before = v.clone();
            for at in 0..n {
                let reach = |from: f64| (from * from + 2.0 * pieces[at].acceleration * pieces[at].length).sqrt();
                v[at + 1] = v[at + 1].min(reach(v[at]));
                v[at] = v[at].min(reach(v[at + 1]));
            }
            if before == v {
                break;
            }
        }
        // The time of each piece by integrating dx/v in small steps of the squared speed.
        let mut whole = 0.0;
        for (at, piece) in pieces.iter().enumerate() {
            let steps = 20_000;
            let step = piece.length / f64::from(steps);
            let mut before = v[at];
            for k in 1..=steps {
                let x = step * f64::from(k);
                let up = (v[at] * v[at] + 2.0 * piece.acceleration * x).sqrt();
                let down = (v[at + 1] * v[at + 1] + 2.0 * piece.acceleration * (piece.length - x)).max(0.0).sqrt();
                let now = piece.speed.min(up).min(down);
                whole += 2.0 * step / (before + now);
                before = now;
            }
        }
        whole
    }

    #[test]
    fn agrees_with_a_model_of_the_whole_path() {
        let mut seed = 7_u64;
        let mut random = move || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            f64::from((seed >> 33) as u32) / f64::from(u32::MAX >> 1)
        };
        for _ in 0..40 {
            let count = 2 + (random() * 12.0) as usize;
            let pieces: Vec<LookAheadMove> = (0..count)
                .map(|_| {
                    let corner = if random() < 0.3 { f64::INFINITY } else { random() * 80.0 };
                    LookAheadMove {
                        acceleration: 200.0 + 2000.0 * random(),
                        ..piece(0.1 + 20.0 * random(), 10.0 + 90.0 * random(), corner)
                    }
                })
                .collect();
            let mine: f64 = times(100, &pieces).iter().sum();
            let other = model(&pieces);
            assert!((mine - other).abs() < 1e-3 * other, "{mine} {other} {pieces:?}");
            let least: f64 = pieces.iter().map(|piece| piece.length / piece.speed).sum();
            assert!(mine >= least);
        }
    }
}
