//! Depth of each pass of a thread.
//!
//! Facts: reference control-emulator.md 6.5. Modes: 0 steps decrease evenly; 1 and 2 the same cross-section each pass,
//! s·√k; 3 and 4 the same step, k·s. *Invariant:* depths grow from pass to pass and end exactly at the depth less the
//! finishing allowance; finishing passes go to the whole depth. There are [`MOST_PASSES`] at most.

/// Passes of a thread at most, finishing included.
pub const MOST_PASSES: usize = 1000;

/// Data that determine the passes; lengths are radius values.
#[derive(Debug, Clone, Copy)]
pub struct ThreadPassPlan {
    /// `$THMODE`
    pub mode: u8,
    /// Whole depth.
    pub depth: f64,
    /// First step, if programmed.
    pub step: Option<f64>,
    /// Smallest step.
    pub least: f64,
    /// Number of passes before finishing, if programmed.
    pub cuts: Option<u32>,
    /// Finishing passes, and their allowance.
    pub finish_cuts: u32,
    /// Depth that finishing passes remove.
    pub finish: f64,
}

/// A pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThreadPass {
    /// Counts from 1; 0 for finishing.
    pub number: u32,
    /// Depth of the pass.
    pub depth: f64,
}

impl ThreadPassPlan {
    /// The passes, and whether there are more than allowed.
    pub fn passes(&self) -> (Vec<ThreadPass>, bool) {
        let rough = (self.depth - self.finish).max(0.0);
        let mut passes = Vec::new();
        let mut cut_short = false;
        if rough > 1e-9 || self.finish_cuts == 0 {
            let (step, less) = self.steps(rough);
            let last = self.cuts.map_or(MOST_PASSES as u32, |cuts| cuts.max(1));
            let mut depth = 0.0;
            for number in 1..=last {
                let next = depth + self.step_of(number, depth, step, less).max(self.least);
                let done = next >= rough - 1e-9;
                if done || number == last || passes.len() + 1 >= MOST_PASSES {
                    cut_short = !done && self.cuts.is_none_or(|cuts| cuts > number);
                    passes.push(ThreadPass { number, depth: rough });
                    break;
                }
                depth = next;
                passes.push(ThreadPass { number, depth });
            }
        }
        let finishing = ThreadPass { number: 0, depth: self.depth };
        passes.extend(std::iter::repeat_n(finishing, self.finish_cuts as usize));
        (passes, cut_short)
    }

    /// First step, and the decrease of each further step in mode 0.
    fn steps(&self, rough: f64) -> (f64, f64) {
        let step = self.step.filter(|step| *step > 0.0 && step.is_finite());
        let count = self.cuts.map(|cuts| f64::from(cuts.max(1)));
        let even = |count: f64, step: f64| {
            if count > 1.0 { (2.0 * (count * step - rough) / (count * (count - 1.0))).max(0.0) } else { 0.0 }
        };
        match (step, count, self.mode) {
            (None, None, _) => (rough, 0.0),
            (Some(step), Some(count), 0) => (step, even(count, step)),
            (Some(step), None, 0) => {
                let count = (2.0 * rough / (step + self.least) + 1e-9).floor().max((rough / step).ceil()).max(1.0);
                (step, even(count, step))
            }
            (None, Some(count), 0) => (2.0 * rough / (count + 1.0), 2.0 * rough / (count * (count + 1.0))),
            (Some(step), ..) => (step, 0.0),
            (None, Some(count), 1 | 2) => (rough / count.sqrt(), 0.0),
            (None, Some(count), _) => (rough / count, 0.0),
        }
    }

    /// Step of a pass from the previous depth.
    fn step_of(&self, number: u32, depth: f64, step: f64, less: f64) -> f64 {
        match self.mode {
            0 => step - f64::from(number - 1) * less,
            1 | 2 => step * f64::from(number).sqrt() - depth,
            _ => step,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAN: ThreadPassPlan =
        ThreadPassPlan { mode: 1, depth: 1.0, step: Some(0.4), least: 0.0, cuts: None, finish_cuts: 0, finish: 0.0 };

    fn depths(plan: &ThreadPassPlan) -> Vec<f64> {
        plan.passes().0.iter().map(|pass| (pass.depth * 1e4).round() / 1e4).collect()
    }

    #[test]
    fn the_same_cross_section() {
        assert_eq!(depths(&PLAN), [0.4, 0.5657, 0.6928, 0.8, 0.8944, 0.9798, 1.0]);
        assert_eq!(
            depths(&ThreadPassPlan { depth: 3.0, step: None, cuts: Some(4), ..PLAN }),
            [1.5, 2.1213, 2.5981, 3.0]
        );
        assert_eq!(depths(&ThreadPassPlan { least: 0.2, ..PLAN }), [0.4, 0.6, 0.8, 1.0]);
    }

    #[test]
    fn the_same_step() {
        let plan = ThreadPassPlan { mode: 3, ..PLAN };
        assert_eq!(depths(&plan), [0.4, 0.8, 1.0]);
        assert_eq!(depths(&ThreadPassPlan { step: None, cuts: Some(4), ..plan }), [0.25, 0.5, 0.75, 1.0]);
        assert_eq!(depths(&ThreadPassPlan { cuts: Some(2), ..plan }), [0.4, 1.0]);
    }

    #[test]
    fn steps_that_fall_evenly() {
        let plan = ThreadPassPlan { mode: 0, step: Some(0.3), ..PLAN };
        assert_eq!(depths(&plan), [0.3, 0.5467, 0.74, 0.88, 0.9667, 1.0]);
        assert_eq!(depths(&ThreadPassPlan { least: 0.1, ..plan }), [0.3, 0.55, 0.75, 0.9, 1.0]);
        assert_eq!(depths(&ThreadPassPlan { step: None, cuts: Some(4), ..plan }), [0.4, 0.7, 0.9, 1.0]);
    }

    #[test]
    fn finishing_comes_last() {
        let plan = ThreadPassPlan { mode: 3, step: Some(0.5), finish: 0.1, finish_cuts: 2, ..PLAN };
        assert_eq!(depths(&plan), [0.5, 0.9, 1.0, 1.0]);
        assert_eq!(depths(&ThreadPassPlan { finish_cuts: 0, ..plan }), [0.5, 0.9]);
        assert_eq!(depths(&ThreadPassPlan { finish: 2.0, ..plan }), [1.0, 1.0]);
    }

    #[test]
    fn nonsense_ends() {
        for step in [f64::NAN, f64::INFINITY, -1.0, 0.0] {
            assert_eq!(depths(&ThreadPassPlan { step: Some(step), ..PLAN }), [1.0]);
        }
        let (passes, cut_short) = ThreadPassPlan { step: Some(1e-9), ..PLAN }.passes();
        assert!(passes.len() == MOST_PASSES && cut_short);
        for depth in [f64::NAN, f64::INFINITY, 0.0] {
            assert!(ThreadPassPlan { depth, ..PLAN }.passes().0.len() <= MOST_PASSES);
        }
    }
}
