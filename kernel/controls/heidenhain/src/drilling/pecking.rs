//! Cycles 200, 203 and 205: holes in several infeeds.
//!
//! Facts: see the parent module. Decision: the stop distance above the depth already reached (205) changes evenly, from
//! Q258 at the first return to Q259 at the last return.

use counterpoint_fault::Halt;

use super::{HeidenhainHoleBuilder, MOST_INFEEDS, NEGLIGIBLE};
use counterpoint_fault as diag;

/// Infeeds of a hole.
#[derive(Debug, Clone, Copy)]
struct Infeeds {
    /// Length of the next infeed; 0 or less drills the rest of the hole.
    length: f64,
    /// Decrease from one infeed to the next, and minimum infeed.
    shrink: [f64; 2],
    depth: f64,
}

impl Infeeds {
    /// Depth at the end of the next infeed.
    fn next(&self, reached: f64) -> f64 {
        let next = reached - self.length;
        if self.length > 0.0 && next > self.depth + NEGLIGIBLE { next } else { self.depth }
    }

    /// Advances to the following infeed.
    fn shorten(&mut self) {
        let [by, least] = self.shrink;
        if by != 0.0 {
            self.length -= by;
            self.length = if self.length > least { self.length } else { least };
        }
    }
}

impl HeidenhainHoleBuilder<'_> {
    fn infeeds(&self, shrinks: bool) -> Infeeds {
        let shrink = if shrinks { [self.parameter(212), self.parameter(205)] } else { [0.0; 2] };
        Infeeds { length: self.parameter(202), shrink, depth: self.levels.depth }
    }

    fn too_many(&mut self) -> Halt {
        let text = format!(
            "the hole needs more than {MOST_INFEEDS} infeeds in '{}'; make them longer",
            self.host.block_text()
        );
        self.host.alarm(&diag::CYCLE_REFUSED, text)
    }

    /// 200: infeeds Q202; after each, a retract to the clearance with the dwell Q210.
    pub(super) fn drill(&mut self) -> Result<(), Halt> {
        self.add_tip()?;
        let infeeds = self.infeeds(false);
        let mut reached = self.levels.surface;
        for _ in 0..MOST_INFEEDS {
            reached = infeeds.next(reached);
            self.line(reached, self.parameter(206));
            if reached <= self.levels.depth {
                self.dwell(self.parameter(211));
                self.rapid(self.levels.clearance);
                return Ok(());
            }
            self.rapid(self.levels.clearance);
            self.dwell(self.parameter(210));
            self.rapid(reached + self.parameter(200));
        }
        Err(self.too_many())
    }

    /// 203: decreasing infeeds Q202. After every Q213 chip breaks by Q256, the tool retracts to the clearance.
    pub(super) fn universal(&mut self) -> Result<(), Halt> {
        self.add_tip()?;
        let back = self.feed_or_drilling(208);
        let mut infeeds = self.infeeds(true);
        let (mut reached, mut breaks) = (self.levels.surface, 0.0);
        for _ in 0..MOST_INFEEDS {
            reached = infeeds.next(reached);
            self.line(reached, self.parameter(206));
            if reached <= self.levels.depth {
                self.dwell(self.parameter(211));
                self.line(self.levels.clearance, back);
                return Ok(());
            }
            if breaks < self.parameter(213) {
                self.rapid(reached + self.parameter(256));
                breaks += 1.0;
            } else {
                self.line(self.levels.clearance, back);
                self.dwell(self.parameter(210));
                self.rapid(reached + self.parameter(200));
                breaks = 0.0;
            }
            infeeds.shorten();
        }
        Err(self.too_many())
    }

    /// 205: decreasing infeeds Q202. After each, the tool retracts to the clearance and returns to a stop above the
    /// depth already reached. The hole starts at the depth Q379, approached with the feed Q253. Within an infeed, the
    /// chip is broken by Q256 every Q257.
    pub(super) fn peck(&mut self) -> Result<(), Halt> {
        self.add_tip()?;
        let back = self.feed_or_drilling(208);
        let mut reached = self.levels.surface;
        if self.parameter(379) > 0.0 {
            reached -= self.parameter(379);
            let above = reached + self.parameter(200);
            match self.parameter(253) {
                feed if feed > 0.0 => self.line(above, feed),
                _ => self.rapid(above),
            }
        }
        let mut infeeds = self.infeeds(true);
        let returns = self.returns(infeeds, reached)?;
        let (mut stop, last_stop) = (self.parameter(258), self.parameter(259));
        let change = if returns < 2 { 0.0 } else { (last_stop - stop) / f64::from(returns - 1) };
        for _ in 0..=returns {
            let from = reached;
            reached = infeeds.next(reached);
            self.in_chips(from, reached)?;
            if reached <= self.levels.depth {
                break;
            }
            self.line(self.levels.clearance, back);
            self.rapid(reached + stop);
            stop += change;
            infeeds.shorten();
        }
        self.dwell(self.parameter(211));
        self.line(self.levels.clearance, back);
        Ok(())
    }

    /// Number of retracts to the clearance before the last infeed.
    fn returns(&mut self, mut infeeds: Infeeds, mut reached: f64) -> Result<u32, Halt> {
        for returns in 0..MOST_INFEEDS {
            reached = infeeds.next(reached);
            if reached <= infeeds.depth {
                return Ok(returns);
            }
            infeeds.shorten();
        }
        Err(self.too_many())
    }

    /// Drills one infeed with its chip breaks.
    fn in_chips(&mut self, mut from: f64, to: f64) -> Result<(), Halt> {
        let (chip, feed) = (self.parameter(257), self.parameter(206));
        let mut breaks = 0_u32;
        while chip > 0.0 && from - chip > to {
            from -= chip;
            self.line(from, feed);
            self.rapid(from + self.parameter(256));
            breaks += 1;
            if breaks > MOST_INFEEDS {
                return Err(self.too_many());
            }
        }
        self.line(to, feed);
        Ok(())
    }
}
