//! The tool in space: M128 and FUNCTION TCPM with their feed, and directions of LN blocks.
//!
//! Facts: programming manuals of the control (TCPM, three-dimensional compensation): F after M128 limits the linear
//! axes that follow; a direction T counts only under M128 or TCPM; a block with a normal N but without T then has the
//! tool along N. Decision: allowances of the tool along N are an alarm.

use super::Heidenhain;
use super::words::EvaluatedWord;
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault as diag;
use counterpoint_fault::Halt;

/// Data on which blocks in space depend.
#[derive(Debug, Default)]
pub(super) struct Space {
    /// M128 or FUNCTION TCPM is active.
    follows: bool,
    /// The last TOOL CALL had allowances.
    pub(super) allowances: bool,
}

/// The number of an M function.
fn function(word: &EvaluatedWord) -> Option<f64> {
    word.value.filter(|_| word.is("M"))
}

impl Heidenhain {
    /// M128, FUNCTION TCPM: the F word after it is the rate of the axes that follow, for machines with a register for
    /// it.
    pub(super) fn follow(&mut self, host: &dyn InterpreterHost, seen: &mut [EvaluatedWord]) {
        let Some(on) = seen.iter().position(|word| function(word) == Some(128.0) || word.is("TCPM")) else { return };
        self.space.follows = !seen.iter().any(|word| word.is("RESET"));
        if !host.is_register("TIPF") {
            return;
        }
        if let Some(word) = seen.iter_mut().skip(on + 1).find(|word| word.is("F") && word.value.is_some()) {
            *word = word.renamed("TIPF");
        }
    }

    /// M129 acts at the end of its block.
    pub(super) fn after_block(&mut self, seen: &[EvaluatedWord]) {
        self.space.follows &= !seen.iter().any(|word| function(word) == Some(129.0));
    }

    /// Directions of an LN block.
    pub(super) fn directions(
        &mut self,
        host: &mut dyn InterpreterHost,
        seen: &mut Vec<EvaluatedWord>,
    ) -> Result<(), Halt> {
        const NORMAL: [&str; 3] = ["NX", "NY", "NZ"];
        const TOOL: [&str; 3] = ["TX", "TY", "TZ"];
        let is_normal = |word: &EvaluatedWord| NORMAL.contains(&&*word.name);
        if self.space.allowances && seen.iter().any(is_normal) {
            let text = format!("DL, DR and DR2 along the normal of '{}' are not emulated", host.block_text());
            return Err(host.alarm(&diag::STATEMENT_UNKNOWN, text));
        }
        if !self.space.follows || seen.iter().any(|word| TOOL.contains(&&*word.name)) {
            seen.retain(|word| !is_normal(word));
            return Ok(());
        }
        for word in seen {
            if let Some(name) = NORMAL.iter().position(|name| word.is(name)).and_then(|at| TOOL.get(at)) {
                *word = word.renamed(name);
            }
        }
        Ok(())
    }
}
