//! Feeds of the path blocks into which one block of the program is converted.
//!
//! Facts: programming manuals of the control (F AUTO, feeds of corners, FMAX for one block). Invariant: a feed of a
//! corner ends with it; the feed before it returns in the next block that moves.

use super::path_state::{PathBlockKind, PathBuilder, axis};
use super::words::{EvaluatedWord, LeftBlock};

impl PathBuilder<'_> {
    /// Feeds of the lines: that of TOOL CALL, and the feed before a corner with its own.
    pub(super) fn feeds(&mut self, lines: &mut [LeftBlock]) {
        let is_corner = matches!(self.step.shape, PathBlockKind::Chamfer | PathBlockKind::Round);
        let own = self.step.seen.iter().find(|word| word.is("F") && word.value.is_some());
        let moves = self.step.seen.iter().any(|word| axis(&word.name).is_some() && word.value.is_some());
        let has = own.is_some() || self.step.seen.iter().any(|word| word.is("FAUTO") || word.is("FMAX"));
        match own {
            Some(_) if is_corner => self.path.rates.gives_back = true,
            Some(word) => (self.path.rates.last, self.path.rates.gives_back) = (Some(word.apart()), false),
            None if !has && moves && std::mem::take(&mut self.path.rates.gives_back) => {
                if let (Some(feed), Some(line)) = (&self.path.rates.last, lines.first_mut()) {
                    line.push(feed.clone());
                }
            }
            None => {}
        }
        let positions = match self.step.shape {
            PathBlockKind::Pole | PathBlockKind::FreePole | PathBlockKind::FreeSelect => false,
            PathBlockKind::Line | PathBlockKind::Iso | PathBlockKind::Chamfer | PathBlockKind::Round => moves,
            _ => true,
        };
        if positions {
            self.path.rates.rapid_before = self.step.seen.iter().any(|word| word.is("FMAX"));
        }
        if let Some(rapid) = &self.step.rapid {
            // A rapid of the machine is straight.
            for word in lines.iter_mut().flatten().filter(|word| word.is("FMAX")) {
                word.clone_from(rapid);
            }
            self.path.rates.gives_back = self.path.rates.last.is_some();
        }
        if self.step.seen.iter().any(|word| word.is("FAUTO")) {
            let feed = self.path.rates.of_tool.clone();
            if feed.is_none() {
                self.refuse("F AUTO needs a feed in TOOL CALL");
            }
            for line in lines {
                let from_tool = |word: EvaluatedWord| if word.is("FAUTO") { feed.clone() } else { Some(word) };
                *line = std::mem::take(line).into_iter().filter_map(from_tool).collect();
            }
            self.path.rates.last = feed;
        }
    }
}
