//! The area that a pen has already painted, so that lines without an effect are not drawn again.
//!
//! *Invariant:* a line is left out only if every place of it is painted within half a pixel, or, for long ones, if the
//! same line has been drawn before.

use rustc_hash::FxHashSet;

/// Cells of a pixel in each direction.
const FINE: f64 = 2.0;
/// Cells across and down: the largest view.
const ACROSS: usize = 2400;
const DOWN: usize = 1800;
/// Lines up to this length are looked at cell by cell.
const SHORT: f64 = 48.0;

/// Sample points per pixel of a dashed line.
const SAMPLES: f64 = 4.0;
/// Maximum sample points of a line.
const MOST_SAMPLES: f64 = 20_000.0;
/// Painted parts up to this length are crossings, px.
const CROSSING: f64 = 6.0;

/// The painted cells of one pen.
pub(super) struct Canvas {
    cells: Vec<u64>,
    /// Rows of cells.
    down: usize,
    long: FxHashSet<[i32; 4]>,
}

impl Canvas {
    pub(super) fn new() -> Self {
        Self::of(DOWN)
    }

    /// A canvas for all views, one below the other.
    pub(super) fn tall() -> Self {
        Self::of(2 * DOWN)
    }

    fn of(down: usize) -> Self {
        Self { cells: vec![0; (ACROSS * down).div_ceil(64)], down, long: FxHashSet::default() }
    }

    /// Paints a line; `false` when it was painted already.
    pub(super) fn line(&mut self, from: [f64; 2], to: [f64; 2]) -> bool {
        let way = [to[0] - from[0], to[1] - from[1]];
        let length = (way[0] * way[0] + way[1] * way[1]).sqrt();
        if length > SHORT {
            let cell = |v: f64| (v * FINE).round() as i32;
            return self.long.insert([cell(from[0]), cell(from[1]), cell(to[0]), cell(to[1])]);
        }
        let parts = length.ceil().max(1.0);
        let mut fresh = false;
        for n in 0..=parts as u32 {
            let share = f64::from(n) / parts;
            fresh |= self.paint([from[0] + way[0] * share, from[1] + way[1] * share]);
        }
        fresh
    }

    /// Paints a line; returns the parts of it that were not yet painted, as shares of its length. Crossings are not
    /// gaps.
    pub(super) fn parts(&mut self, from: [f64; 2], to: [f64; 2]) -> Vec<[f64; 2]> {
        let way = [to[0] - from[0], to[1] - from[1]];
        let length = (way[0] * way[0] + way[1] * way[1]).sqrt();
        let steps = (length * SAMPLES).ceil().clamp(1.0, MOST_SAMPLES);
        let at = |n: u32| {
            let share = f64::from(n) / steps;
            [from[0] + way[0] * share, from[1] + way[1] * share]
        };
        let fresh: Vec<bool> = (0..=steps as u32).map(|n| !self.is_painted(at(n))).collect();
        (0..=steps as u32).for_each(|n| {
            self.paint(at(n));
        });
        let crossing = (CROSSING * SAMPLES) as usize;
        let (mut parts, mut end): (Vec<[usize; 2]>, usize) = (Vec::new(), 0);
        for run in fresh.chunk_by(|a, b| a == b) {
            let start = end;
            end += run.len();
            if run.first() != Some(&true) {
                continue;
            }
            match parts.last_mut().filter(|last| start - last[1] <= crossing) {
                Some(last) => last[1] = end,
                None => parts.push([start, end]),
            }
        }
        let least = fresh.len().min(crossing / 4);
        let share = |n: usize| (n as f64 / steps).min(1.0);
        let long = parts.into_iter().filter(|[start, end]| end - start >= least.max(1));
        long.map(|[start, end]| [share(start), if end >= fresh.len() { 1.0 } else { share(end) }]).collect()
    }

    /// Whether a point is painted, or one at most half a pixel from it.
    fn is_painted(&self, at: [f64; 2]) -> bool {
        const BESIDE: f64 = 0.5;
        let places = [[0.0, 0.0], [BESIDE, 0.0], [-BESIDE, 0.0], [0.0, BESIDE], [0.0, -BESIDE]];
        places.into_iter().any(|[x, y]| {
            let (x, y) = ((at[0] + x) * FINE, (at[1] + y) * FINE);
            if x < 0.0 || y < 0.0 || x >= ACROSS as f64 || y >= self.down as f64 {
                return false;
            }
            let cell = y as usize * ACROSS + x as usize;
            self.cells.get(cell / 64).is_some_and(|word| word & (1 << (cell % 64)) != 0)
        })
    }

    /// Paints a place; `false` when it was painted already. Places outside the largest view need no painting.
    pub(super) fn paint(&mut self, at: [f64; 2]) -> bool {
        let (x, y) = (at[0] * FINE, at[1] * FINE);
        if x < 0.0 || y < 0.0 || x >= ACROSS as f64 || y >= self.down as f64 {
            return false;
        }
        let cell = y as usize * ACROSS + x as usize;
        let bit = 1_u64 << (cell % 64);
        match self.cells.get_mut(cell / 64) {
            Some(word) => {
                let fresh = *word & bit == 0;
                *word |= bit;
                fresh
            }
            None => false,
        }
    }
}
