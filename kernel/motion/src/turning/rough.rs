//! Rough turning and facing: levels down to the contour, then pockets, then one pass along the contour.
//!
//! The open stretch of each level is cut first, from the top; then each pocket, deepest branch first, in the direction
//! of the cut. *Invariant:* a rapid move across the stock goes no deeper than the last level cut there.

use super::blank::Blank;
use super::cut::ToolCursor;
use super::lap::LapSettings;
use super::levels::CutLevels;
use super::parts::{ContourParts, ContourPosition, LevelStretch};
use super::view::CutView;
use super::{ContourError, CycleMove, MoveSink, NOISE, ProgrammedContour, along, moved};
use crate::contour::element::{Element, Spot};

/// Settings of a rough cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoughSettings {
    /// The cut runs along X.
    pub face: bool,
    /// Depth of a level, above 0.
    pub depth: f64,
    /// Retraction at the end of a cut.
    pub retract: f64,
    /// Allowance on the contour, along Z and X.
    pub allowance: Spot,
    /// The additional allowance of the levels along Z and X; the last pass removes it.
    pub semi: Spot,
    /// Pockets are cut level by level, not by the last pass alone.
    pub pockets: bool,
    /// It is a cycle of LAP: allowances are amounts, levels count from where the tool is and stay above the contour.
    pub lap: Option<LapSettings>,
}

/// A rough cycle, ready to be cut.
#[derive(Debug)]
pub struct RoughCycle<'c> {
    contour: &'c ProgrammedContour,
    settings: RoughSettings,
    view: CutView,
    parts: ContourParts,
    levels: CutLevels,
    /// Where levels count from, as seen.
    origin: Spot,
    blank: Option<Blank>,
}

/// A pocket below a level that is open.
#[derive(Debug, Clone, Copy)]
struct RoughPocket {
    begin: ContourPosition,
    end: ContourPosition,
    /// Number of its first level.
    level: u64,
    /// How the tool comes to it.
    entry: PocketEntry,
}

#[derive(Debug, Clone, Copy)]
enum PocketEntry {
    /// From the start of the cycle, over stock that was cut down to this height.
    Start(f64),
    /// Down the flank of the stretch above, from this place.
    Flank(ContourPosition),
    /// Beside another one, over a stretch cut down to this height.
    Beside(f64),
}

impl<'c> RoughCycle<'c> {
    /// The cycle of a contour.
    ///
    /// # Errors
    /// The contour cannot be cut.
    pub fn new(contour: &'c ProgrammedContour, settings: RoughSettings) -> Result<Self, ContourError> {
        let plain = CutView { face: settings.face, signs: [1.0; 2] };
        let (start, first, last) = (plain.see(contour.start), plain.see(contour.first()), plain.see(contour.last()));
        let sign = |way: f64, or: f64| if way.abs() > NOISE { way.signum() } else { or };
        let toward = sign(last[0] - start[0], -1.0);
        let stock = sign(start[1] - first[1], sign(start[1] - last[1], 1.0));
        let view = CutView { signs: [toward, stock], ..plain };
        let mut settings = settings;
        if settings.lap.is_some() {
            settings.allowance = view.away(settings.allowance);
        }
        let left = [settings.allowance[0] + settings.semi[0], settings.allowance[1] + settings.semi[1]];
        let elements: Vec<_> = contour.elements.iter().map(|element| moved(element, left)).collect();
        let parts = ContourParts::of(&elements, &view);
        let [z, x] = contour.start;
        let away = view.see([z + left[0], x + left[1]]);
        let origin = if settings.lap.is_some() { view.see(contour.start) } else { away };
        let copies = settings.lap.is_some_and(|lap| lap.copies);
        let first = elements.first().filter(|_| copies);
        let low = first.map_or(parts.lowest(), |first| view.see(first.from)[1]);
        // Programs of bores go off the part beyond the start.
        parts.check([away[0].min(origin[0]), origin[1]], settings.lap.is_none())?;
        let blank = Blank::of(&contour.blank, &view);
        let levels = match &settings.lap {
            Some(lap) => {
                let top = blank.as_ref().map_or(origin[1], |blank| blank.highest().max(parts.highest()));
                CutLevels::of_lap(top, settings.depth, low, lap, &view)
            }
            None => CutLevels::even(origin[1], settings.depth, low),
        };
        Ok(Self { contour, settings, view, parts, levels, origin, blank })
    }

    /// Height of a level; none below the last one.
    fn level(&self, number: u64) -> Option<f64> {
        self.levels.height(number)
    }

    /// Gives the moves.
    ///
    /// # Errors
    /// The sink takes no more.
    pub fn run<S: MoveSink>(&self, sink: &mut S) -> Result<(), S::Stop> {
        if self.settings.lap.is_some_and(|lap| lap.copies) {
            return self.copy(sink);
        }
        let mut cut = ToolCursor { sink, view: self.view, at: self.origin };
        cut.rapid(self.origin)?;
        let mut pockets = self.open_levels(&mut cut)?;
        if self.settings.pockets {
            pockets.sort_by(|a, b| a.begin.along.total_cmp(&b.begin.along));
            for pocket in pockets {
                self.pocket(&mut cut, pocket)?;
            }
        }
        self.contour_pass(&mut cut)
    }

    /// Goes along the whole contour, each time nearer: away from it along the line from its first point to the start.
    fn copy<S: MoveSink>(&self, sink: &mut S) -> Result<(), S::Stop> {
        let mut cut = ToolCursor { sink, view: self.view, at: self.origin };
        let [z, x] = self.contour.elements.first().map_or(self.contour.start, |first| first.from);
        let first = [z + self.settings.allowance[0], x + self.settings.allowance[1]];
        let to_start = [self.contour.start[0] - first[0], self.contour.start[1] - first[1]];
        let height = self.origin[1] - self.levels.low();
        for number in 1.. {
            let Some(level) = self.level(number) else { break };
            cut.sink.use_feed(self.levels.feed(number));
            let part = (level - self.levels.low()) / height;
            let end = self.view.see(self.along_contour(&mut cut, [to_start[0] * part, to_start[1] * part])?);
            cut.rapid([self.origin[0], end[1]])?;
        }
        let end = self.view.see(self.along_contour(&mut cut, [0.0; 2])?);
        if self.settings.lap.is_some_and(|lap| lap.stays) {
            return Ok(());
        }
        cut.rapid([self.origin[0], end[1]])?;
        cut.sink.go(CycleMove::Rapid(self.contour.start))
    }

    /// Cuts the open stretches of all levels. Returns the pockets beside them.
    fn open_levels<S: MoveSink>(&self, cut: &mut ToolCursor<'_, S>) -> Result<Vec<RoughPocket>, S::Stop> {
        let mut pockets = Vec::new();
        let [start, top] = self.origin;
        let retract = self.settings.retract;
        let (mut above, mut height, mut begun) = (None, top, start);
        for number in 1.. {
            let Some(level) = self.level(number) else { break };
            cut.sink.pass()?;
            cut.sink.use_feed(self.levels.feed(number));
            let stretches = self.parts.stretches(level);
            let within =
                |begin: &ContourPosition| above.is_none_or(|end: ContourPosition| begin.along <= end.along + NOISE);
            for stretch in &stretches {
                if let Some(begin) = stretch.begin.filter(within) {
                    pockets.push(RoughPocket {
                        begin,
                        end: stretch.end,
                        level: number,
                        entry: PocketEntry::Start(height),
                    });
                }
            }
            let open = stretches.first().filter(|stretch| stretch.begin.is_none());
            let Some(open) = open.filter(|open| open.end.along > start + NOISE) else { break };
            if let Some(blank) = &self.blank {
                let cuts = blank.cuts(level, [start, open.end.along]);
                if let Some([first, _]) = cuts.first().copied() {
                    self.cut_blank(cut, &cuts, (begun, level))?;
                    begun = first;
                }
                (above, height) = (Some(open.end), level);
                continue;
            }
            let begin = self.view.place([start, level]);
            let infeed = if self.settings.lap.is_some() { CycleMove::Rapid(begin) } else { self.contour.infeed(begin) };
            cut.sink.go(infeed)?;
            cut.feed([open.end.along, level])?;
            cut.rapid([open.end.along - retract, level + retract])?;
            cut.rapid([start, level + retract])?;
            (above, height) = (Some(open.end), level);
        }
        if self.blank.is_some() {
            cut.rapid([start, cut.at[1]])?;
        }
        Ok(pockets)
    }

    /// Cuts a level where the blank has material: in from the clearance before it, at rapid where there is none. Before
    /// it the tool is in front of where it has begun on the level before.
    fn cut_blank<S: MoveSink>(
        &self,
        cut: &mut ToolCursor<'_, S>,
        cuts: &[[f64; 2]],
        (begun, level): (f64, f64),
    ) -> Result<(), S::Stop> {
        let retract = self.settings.retract;
        let aside = cuts.first().map_or(begun, |[first, _]| first.min(begun));
        cut.rapid([aside, cut.at[1]])?;
        cut.rapid([aside, level])?;
        for [from, to] in cuts {
            cut.rapid([*from, level])?;
            cut.feed([*to, level])?;
        }
        cut.rapid([cut.at[0] - retract, level + retract])
    }

    /// Cuts a pocket, and leaves it.
    fn pocket<S: MoveSink>(&self, cut: &mut ToolCursor<'_, S>, root: RoughPocket) -> Result<(), S::Stop> {
        let mut open = vec![root];
        while let Some(pocket) = open.pop() {
            let Some(level) = self.level(pocket.level) else { continue };
            cut.sink.pass()?;
            cut.sink.use_feed(self.levels.feed(pocket.level));
            self.enter(cut, &pocket, level)?;
            let length = pocket.end.along - pocket.begin.along;
            let retract = self.settings.retract.min(length / 2.0).max(0.0);
            if length > NOISE {
                cut.feed([pocket.end.along, level])?;
                cut.rapid([pocket.end.along - retract, level + retract])?;
            }
            let Some(next) = self.level(pocket.level + 1) else { continue };
            let below = self.parts.stretches(next).into_iter().filter_map(|stretch| inside(&pocket, &stretch));
            let mut below: Vec<_> = below.collect();
            for (index, child) in below.iter_mut().enumerate() {
                let flank = index == 0 && self.parts.falls(pocket.begin.part, child.begin.part);
                child.entry = if flank { PocketEntry::Flank(pocket.begin) } else { PocketEntry::Beside(level) };
            }
            open.extend(below.into_iter().rev());
        }
        let [start, top] = self.origin;
        cut.rapid([cut.at[0], top])?;
        cut.rapid([start, top])
    }

    /// Takes the tool to the beginning of a stretch.
    fn enter<S: MoveSink>(&self, cut: &mut ToolCursor<'_, S>, pocket: &RoughPocket, level: f64) -> Result<(), S::Stop> {
        let place = pocket.begin.part;
        let (height, from) = match pocket.entry {
            PocketEntry::Flank(above) => {
                let height = self.level(pocket.level - 1).unwrap_or(level);
                let aside = (cut.at[1] - height).max(0.0);
                cut.rapid([above.along + aside, cut.at[1]])?;
                cut.feed([above.along, height])?;
                return self.flank(cut, above.part, place, [pocket.begin.along, level]);
            }
            PocketEntry::Start(height) => {
                if cut.at[1] < height - NOISE {
                    cut.rapid([cut.at[0], self.origin[1]])?;
                }
                (height, self.parts.descent(place))
            }
            PocketEntry::Beside(height) => {
                let above = height + self.settings.retract;
                if cut.at[1] < above - NOISE {
                    cut.rapid([cut.at[0], above])?;
                }
                (height, self.parts.descent(place))
            }
        };
        let vertex = self.parts.all.get(from).map_or([pocket.begin.along, level], |part| part.from);
        cut.rapid([vertex[0], cut.at[1]])?;
        cut.rapid([vertex[0], (vertex[1] + self.settings.retract).max(height)])?;
        cut.feed(vertex)?;
        self.flank(cut, from, place, [pocket.begin.along, level])
    }

    /// Feeds along the contour from within one part to a point of another one.
    fn flank<S: MoveSink>(
        &self,
        cut: &mut ToolCursor<'_, S>,
        from: usize,
        to: usize,
        end: Spot,
    ) -> Result<(), S::Stop> {
        for (index, part) in self.parts.all.iter().enumerate().take(to + 1).skip(from) {
            let target = if index == to { end } else { part.to };
            cut.part(part, target)?;
        }
        Ok(())
    }

    /// Cuts along the contour, and returns to where the cycle began.
    fn contour_pass<S: MoveSink>(&self, cut: &mut ToolCursor<'_, S>) -> Result<(), S::Stop> {
        self.along_contour(cut, [0.0; 2])?;
        if self.settings.lap.is_some_and(|lap| lap.stays) {
            return Ok(());
        }
        cut.sink.go(CycleMove::Rapid(self.contour.start))
    }

    /// Cuts along the contour, moved by an amount in addition to the allowance. Returns where it ends.
    fn along_contour<S: MoveSink>(&self, cut: &mut ToolCursor<'_, S>, away: Spot) -> Result<Spot, S::Stop> {
        cut.sink.pass()?;
        let by = [self.settings.allowance[0] + away[0], self.settings.allowance[1] + away[1]];
        let mut end = self.contour.start;
        let mut elements = self.contour.elements.iter().map(|element| moved(element, by)).peekable();
        if let Some(first) = elements.peek() {
            cut.sink.go(self.contour.infeed(self.begin(first)))?;
        }
        for (index, element) in elements.enumerate() {
            end = element.to;
            cut.sink.piece(index);
            cut.sink.go(along(&element))?;
        }
        Ok(end)
    }

    /// Where a pass along the contour begins. Under LAP a first line along the cut begins no further out than the
    /// cycle.
    fn begin(&self, first: &Element) -> Spot {
        let ([along, height], to) = (self.view.see(first.from), self.view.see(first.to));
        let level = first.arc.is_none() && (to[1] - height).abs() < NOISE;
        if self.settings.lap.is_some() && level {
            return self.view.place([along.max(self.origin[0]), height]);
        }
        first.from
    }
}

/// The part of a pocket one level deeper.
fn inside(pocket: &RoughPocket, stretch: &LevelStretch) -> Option<RoughPocket> {
    let begin = stretch.begin?;
    let within = begin.along >= pocket.begin.along - NOISE && stretch.end.along <= pocket.end.along + NOISE;
    let part = begin.part >= pocket.begin.part && stretch.end.part <= pocket.end.part;
    (within && part).then_some(RoughPocket { begin, end: stretch.end, level: pocket.level + 1, ..*pocket })
}
