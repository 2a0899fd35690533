//! Stock removal of Siemens controls (CYCLE95): levels of one section of the contour after the other.
//!
//! Facts: reference siemens-cycles.md 1.6. A section is the material above the start of the contour, or a relief cut;
//! each is divided into equal levels of at most the given depth. A level ends on the contour, goes up along it to the
//! level before, and lifts off in both axes. Finishing compensates the nose of the tool, as the control does within its
//! cycle. *Invariant:* every move lies on the stock side of the contour with its allowances; a cycle starts and ends at
//! its start point, one lift beyond the contour in both axes.

mod recess;

use super::allowance::leave;
use super::cut::ToolCursor;
use super::parts::{ContourPart, ContourParts, ContourPosition, LevelStretch};
use super::view::CutView;
use super::{MoveSink, NOISE, along};
use crate::contour::element::{Element, Spot, angle};
use crate::contour::shifted::shifted;
use recess::FlatToolEnd;

/// The work along a contour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strip {
    /// Levels are cut.
    pub rough: bool,
    /// The contour itself is cut.
    pub finish: bool,
    /// Cuts run along X.
    pub face: bool,
    /// The stock is on the side of smaller X.
    pub inside: bool,
    /// Depth of a level at most; 0 for one level.
    pub depth: f64,
    /// The allowance of levels along Z and X.
    pub allowance: Spot,
    /// The allowance perpendicular to the contour.
    pub around: f64,
    /// How far the tool lifts off in each axis.
    pub lift: f64,
    /// Levels go up along the contour.
    pub rounds: bool,
    /// Seconds of a pause in a cut, and the path after which there is one; 0 for none.
    pub pause: [f64; 2],
    /// Feed of levels, into relief cuts, along the contour.
    pub feeds: [f64; 3],
    /// Largest angle of a falling flank, degrees; 0 for any.
    pub clearance: f64,
    /// The tool plunges: how far its other edge is along the cut from the active one; 0 for a tool that cuts along.
    pub plunges: f64,
}

/// Why a contour cannot be cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StripError {
    /// It turns back along the cut.
    TurnsBack,
    /// It has no piece.
    Nothing,
    /// Its allowances do not fit into it.
    Narrow,
    /// A flank falls more steeply than the tool allows.
    Clearance,
}

/// Equal levels below a height.
#[derive(Debug, Clone, Copy)]
struct EqualLevels {
    top: f64,
    step: f64,
    count: u32,
}

impl EqualLevels {
    fn new(top: f64, low: f64, depth: f64) -> Self {
        let whole = (top - low).max(0.0);
        let count = if whole <= NOISE {
            0
        } else if depth <= 0.0 {
            1
        } else {
            (whole / depth - 1e-6).ceil().clamp(1.0, 1e9) as u32
        };
        Self { top, step: if count == 0 { 0.0 } else { whole / f64::from(count) }, count }
    }

    fn height(&self, number: u32) -> f64 {
        self.top - f64::from(number) * self.step
    }
}

/// A stretch of a level within a relief cut.
#[derive(Debug, Clone, Copy)]
struct Relief {
    begin: ContourPosition,
    end: ContourPosition,
    grid: EqualLevels,
    number: u32,
    /// Where the level before began on the same flank.
    above: Option<ContourPosition>,
    /// It is the first one of its section.
    first: bool,
}

/// Cut after the open levels.
#[derive(Debug, Clone, Copy)]
enum DeferredCut {
    /// A level that is continued by the levels below it.
    Level(Relief),
    /// A section between two places of the contour, below a height.
    Section(ContourPosition, ContourPosition, f64),
}

impl DeferredCut {
    /// Where it begins.
    fn part(&self) -> usize {
        match self {
            Self::Level(relief) => relief.begin.part,
            Self::Section(begin, ..) => begin.part,
        }
    }
}

/// A cycle, ready to be cut.
#[derive(Debug)]
pub struct Removal<'c> {
    contour: &'c [Element],
    strip: Strip,
    view: CutView,
    /// The contour with its allowances.
    parts: ContourParts,
    /// Where the cycle begins and ends, as seen.
    start: Spot,
    high: f64,
}

impl<'c> Removal<'c> {
    /// The cycle of a contour.
    ///
    /// # Errors
    /// The contour cannot be cut.
    pub fn new(contour: &'c [Element], strip: Strip) -> Result<Self, StripError> {
        let (Some(first), Some(last)) = (contour.first(), contour.last()) else { return Err(StripError::Nothing) };
        let plain = CutView { face: strip.face, signs: [1.0; 2] };
        let (from, to) = (plain.see(first.from), plain.see(last.to));
        let sign = |way: f64, or: f64| if way.abs() > NOISE { way.signum() } else { or };
        let stock = match (strip.face, strip.inside) {
            _ if strip.plunges != 0.0 => away_from_base(contour, &plain),
            (true, _) => sign(to[1] - from[1], 1.0),
            (false, true) => -1.0,
            (false, false) => 1.0,
        };
        let toward = sign(to[0] - from[0], if strip.face && strip.inside { 1.0 } else { -1.0 });
        let view = CutView { signs: [toward, stock], ..plain };
        let whole = ContourParts::of(contour, &view);
        let unbounded = [f64::NEG_INFINITY, f64::INFINITY];
        whole.check(unbounded, false).map_err(|refusal| match refusal {
            super::ContourError::Nothing => StripError::Nothing,
            _ => StripError::TurnsBack,
        })?;
        if strip.clearance > 0.0 && whole.all.iter().any(|part| steepest(part) > strip.clearance + 0.01) {
            return Err(StripError::Clearance);
        }
        let side = if view.turns_over() { -1.0 } else { 1.0 };
        let parts = if strip.around > 0.0 {
            ContourParts::of(&shifted(contour, side, strip.around).ok_or(StripError::Narrow)?, &view)
        } else {
            whole
        };
        let [z, x] = strip.allowance;
        let left = if strip.face { [x, z] } else { [z, x] };
        let parts = ContourParts::made_of(leave(parts.all, left).ok_or(StripError::Narrow)?);
        let high = parts.all.iter().fold(f64::NEG_INFINITY, |high, part| high.max(part.from[1]).max(part.to[1]));
        let begin = parts.all.first().map_or(0.0, |part| part.from[0]);
        let start = [begin - strip.lift, high + strip.lift];
        let removal = Self { contour, strip, view, parts, start, high };
        removal.end().map_or(Ok(()), |end| removal.check_recess(end))?;
        Ok(removal)
    }

    /// Gives the moves.
    ///
    /// # Errors
    /// The sink takes no more.
    pub fn run<S: MoveSink>(&self, sink: &mut S) -> Result<(), S::Stop> {
        let mut cut = ToolCursor { sink, view: self.view, at: self.start };
        cut.rapid(self.start)?;
        if let Some(end) = self.end() {
            return self.recess(&mut cut, end);
        }
        if self.strip.rough {
            self.open_section(&mut cut)?;
            self.back(&mut cut)?;
        }
        if self.strip.finish {
            self.finish(&mut cut)?;
        }
        Ok(())
    }

    /// The end of a tool that plunges.
    fn end(&self) -> Option<FlatToolEnd> {
        (self.strip.plunges != 0.0).then(|| FlatToolEnd::new(self.strip.plunges * self.view.signs[0]))
    }

    /// Axis by axis to the start.
    fn back<S: MoveSink>(&self, cut: &mut ToolCursor<'_, S>) -> Result<(), S::Stop> {
        cut.rapid([cut.at[0], self.start[1]])?;
        cut.rapid(self.start)
    }

    /// Levels above the beginning of the contour, then the relief cuts.
    fn open_section<S: MoveSink>(&self, cut: &mut ToolCursor<'_, S>) -> Result<(), S::Stop> {
        let Some(last) = self.parts.all.len().checked_sub(1) else { return Ok(()) };
        let begin = self.parts.all.first().map_or(self.high, |part| part.from[1]);
        let grid = EqualLevels::new(self.high, begin, self.strip.depth);
        let mut reliefs = Vec::new();
        let mut end = last;
        for number in 0..=grid.count {
            let level = grid.height(number);
            if number > 0 {
                cut.sink.pass()?;
                let mut stretches = self.parts.stretches(level).into_iter();
                let Some(open) = stretches.next().filter(|stretch| stretch.begin.is_none()) else { break };
                cut.rapid([self.start[0], level])?;
                cut.sink.use_feed(0);
                self.level(cut, open.end, level, grid.height(number - 1))?;
                cut.rapid([self.start[0], cut.at[1]])?;
                // Beside it, below a peak that is lower than the level before.
                let beside = stretches.filter_map(|LevelStretch { begin, end: to }| {
                    let begin = begin.filter(|_| to.part <= end)?;
                    Some(DeferredCut::Level(Relief { begin, end: to, grid, number, above: None, first: true }))
                });
                reliefs.extend(beside);
                end = open.end.part;
            }
            // Material below this level that is not reached from the start of the contour.
            for (begin, (from, to)) in self.below(level, (0, end)) {
                if begin.is_some() || number == grid.count {
                    reliefs.push(DeferredCut::Section(from, to, level));
                } else {
                    end = to.part;
                }
            }
        }
        reliefs.sort_by_key(DeferredCut::part);
        for relief in reliefs {
            match relief {
                DeferredCut::Level(relief) => self.reliefs(cut, vec![relief])?,
                DeferredCut::Section(begin, end, top) => self.relief_section(cut, (begin, end), top)?,
            }
        }
        Ok(())
    }

    /// Cuts along a level to its end on the contour, up along it to the level before, and lifts off.
    fn level<S: MoveSink>(
        &self,
        cut: &mut ToolCursor<'_, S>,
        end: ContourPosition,
        level: f64,
        before: f64,
    ) -> Result<(), S::Stop> {
        let from = cut.at[0];
        self.cut_with_pauses(cut, [end.along, level])?;
        if self.strip.rounds {
            self.round(cut, end, before)?;
        }
        let to = (cut.at[0] - self.strip.lift).max(from.min(cut.at[0]));
        cut.rapid([to, cut.at[1] + self.strip.lift])
    }

    fn cut_with_pauses<S: MoveSink>(&self, cut: &mut ToolCursor<'_, S>, to: Spot) -> Result<(), S::Stop> {
        let [seconds, way] = self.strip.pause;
        if seconds > 0.0 && way > 0.0 {
            let from = cut.at[0];
            for number in 1_u32.. {
                let at = from + f64::from(number) * way;
                if at >= to[0] - NOISE {
                    break;
                }
                cut.sink.pass()?;
                cut.feed([at, to[1]])?;
                cut.sink.pause(seconds)?;
            }
        }
        cut.feed(to)
    }

    /// Up along the contour to a height, as long as it does not fall.
    fn round<S: MoveSink>(
        &self,
        cut: &mut ToolCursor<'_, S>,
        from: ContourPosition,
        height: f64,
    ) -> Result<(), S::Stop> {
        for part in self.parts.all.iter().skip(from.part) {
            if cut.at[1] >= height - NOISE || part.to[1] < part.from[1].max(cut.at[1]) - NOISE {
                break;
            }
            let to = if part.to[1] > height + NOISE { [part.meets(height), height] } else { part.to };
            cut.part(part, to)?;
        }
        Ok(())
    }

    /// Stretches of the contour below a level, among some of its parts: where each begins (none where the parts do) and
    /// its ends.
    fn below(
        &self,
        level: f64,
        (first, last): (usize, usize),
    ) -> Vec<(Option<ContourPosition>, (ContourPosition, ContourPosition))> {
        let mut found = Vec::new();
        let mut open: Option<(Option<ContourPosition>, ContourPosition)> = None;
        for (index, part) in self.parts.all.iter().enumerate().take(last + 1).skip(first) {
            let (from, to) = (part.from[1] < level - NOISE, part.to[1] < level - NOISE);
            if index == first && from {
                open = Some((None, ContourPosition { part: index, along: part.from[0] }));
            }
            if !from && to {
                let mark = ContourPosition { part: index, along: part.meets(level) };
                let at_start = index == 0 && part.from[1] <= level + NOISE;
                open = Some(((!at_start).then_some(mark), mark));
            }
            if from
                && !to
                && let Some((begin, mark)) = open.take()
            {
                found.push((begin, (mark, ContourPosition { part: index, along: part.meets(level) })));
            }
        }
        if let Some(((begin, mark), part)) = open.zip(self.parts.all.get(last)) {
            found.push((begin, (mark, ContourPosition { part: last, along: part.to[0] })));
        }
        found
    }

    /// A relief cut below a level that was cut.
    fn relief_section<S: MoveSink>(
        &self,
        cut: &mut ToolCursor<'_, S>,
        (begin, end): (ContourPosition, ContourPosition),
        top: f64,
    ) -> Result<(), S::Stop> {
        let within = self.parts.all.get(begin.part..=end.part).unwrap_or_default();
        let low = within.iter().fold(top, |low, part| low.min(part.to[1]));
        let grid = EqualLevels::new(top, low, self.strip.depth);
        let mut open = self.stretches(grid, 1, (begin, end));
        open.reverse();
        self.reliefs(cut, open)
    }

    /// Levels of relief cuts, each with those below it; the last one is the first to be cut.
    fn reliefs<S: MoveSink>(&self, cut: &mut ToolCursor<'_, S>, mut open: Vec<Relief>) -> Result<(), S::Stop> {
        let mut sections = Vec::new();
        while let Some(relief) = open.pop() {
            let level = relief.grid.height(relief.number);
            cut.sink.pass()?;
            self.enter(cut, &relief, level)?;
            cut.sink.use_feed(0);
            self.level(cut, relief.end, level, relief.grid.height(relief.number - 1))?;
            if relief.number < relief.grid.count {
                let mut deeper = self.stretches(relief.grid, relief.number + 1, (relief.begin, relief.end));
                if let Some(first) = deeper.first_mut() {
                    first.first = false;
                    first.above = self.parts.falls(relief.begin.part, first.begin.part).then_some(relief.begin);
                }
                open.extend(deeper.into_iter().rev());
            } else {
                let deeper = self.below(level, (relief.begin.part, relief.end.part));
                sections.extend(deeper.into_iter().map(|(_, ends)| (ends, level)));
            }
        }
        sections.into_iter().try_for_each(|(ends, top)| self.relief_section(cut, ends, top))
    }

    /// The stretches of a level between two places of the contour.
    fn stretches(
        &self,
        grid: EqualLevels,
        number: u32,
        (begin, end): (ContourPosition, ContourPosition),
    ) -> Vec<Relief> {
        let level = grid.height(number);
        let found = self.parts.stretches(level).into_iter().filter_map(|LevelStretch { begin: from, end: to }| {
            let from = from
                .unwrap_or(ContourPosition { part: 0, along: self.parts.all.first().map_or(0.0, |part| part.from[0]) });
            let inside = from.part >= begin.part && to.part <= end.part;
            inside.then_some(Relief { begin: from, end: to, grid, number, above: None, first: false })
        });
        let mut found: Vec<_> = found.collect();
        if number == 1
            && let Some(first) = found.first_mut()
        {
            first.first = true;
        }
        found
    }

    /// Takes the tool to the beginning of a level of a relief cut, down along the contour.
    fn enter<S: MoveSink>(&self, cut: &mut ToolCursor<'_, S>, relief: &Relief, level: f64) -> Result<(), S::Stop> {
        let before = relief.grid.height(relief.number - 1);
        let (from, part) = match relief.above {
            Some(above) => ([above.along, before], above.part),
            None => self.descent(relief.begin, before),
        };
        let clear = if relief.first { self.start[1] } else { before + self.strip.lift };
        if cut.at[1] < clear - NOISE {
            cut.rapid([cut.at[0], clear])?;
        }
        cut.rapid([from[0], cut.at[1]])?;
        let near = from[1].max(before) + self.strip.lift;
        if cut.at[1] > near + NOISE {
            cut.rapid([from[0], near])?;
        }
        cut.sink.use_feed(1);
        cut.feed(from)?;
        for (index, piece) in self.parts.all.iter().enumerate().take(relief.begin.part + 1).skip(part) {
            let to = if index == relief.begin.part { [relief.begin.along, level] } else { piece.to };
            cut.part(piece, to)?;
        }
        Ok(())
    }

    /// Where the contour begins to fall to a place, not above a height: the point and its part.
    fn descent(&self, place: ContourPosition, height: f64) -> (Spot, usize) {
        let mut part = place.part;
        while let Some(piece) = self.parts.all.get(part) {
            let above = piece.from[1] > height + NOISE;
            if above {
                return ([piece.meets(height), height], part);
            }
            let before = part.checked_sub(1).and_then(|at| self.parts.all.get(at));
            let falls =
                before.is_some_and(|piece| piece.from[1] >= piece.to[1] - NOISE && piece.to[1] < height - NOISE);
            if !falls {
                return (piece.from, part);
            }
            part -= 1;
        }
        ([place.along, height], place.part)
    }

    /// Along the contour, and back to the start.
    fn finish<S: MoveSink>(&self, cut: &mut ToolCursor<'_, S>) -> Result<(), S::Stop> {
        cut.sink.pass()?;
        let Some(first) = self.contour.first() else { return Ok(()) };
        cut.sink.beside(Some(if self.view.turns_over() { -1.0 } else { 1.0 }))?;
        cut.rapid(self.view.see(first.from))?;
        cut.sink.use_feed(2);
        for element in self.contour {
            cut.at = self.view.see(element.to);
            cut.sink.go(along(element))?;
        }
        cut.sink.beside(None)?;
        if cut.at[1] < self.high - NOISE {
            return self.back(cut);
        }
        cut.rapid(self.start)
    }
}

/// The side of the stock of a groove: that of its ends, seen from its base.
fn away_from_base(contour: &[Element], view: &CutView) -> f64 {
    let Some(first) = contour.first().map(|first| view.see(first.from)[1]) else { return 1.0 };
    let deep = contour.iter().map(|element| first - view.see(element.to)[1]);
    let deepest = deep.fold(0.0, |most: f64, deep| if deep.abs() > most.abs() { deep } else { most });
    if deepest < 0.0 { -1.0 } else { 1.0 }
}

/// The steepest angle at which a part falls, degrees; 0 if it does not.
fn steepest(part: &ContourPart) -> f64 {
    if part.to[1] >= part.from[1] - NOISE {
        return 0.0;
    }
    let slope = |[run, drop]: Spot| libm::atan2(drop.abs(), run.abs()).to_degrees();
    match part.arc {
        None => slope([part.to[0] - part.from[0], part.to[1] - part.from[1]]),
        Some((center, _)) => {
            let tangent = |spot: Spot| {
                let at = angle(center, spot);
                slope([libm::sin(at), libm::cos(at)])
            };
            tangent(part.from).max(tangent(part.to))
        }
    }
}

#[cfg(test)]
mod tests;
