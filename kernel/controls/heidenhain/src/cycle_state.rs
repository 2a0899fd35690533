//! The cycles of a program: the defined one, the running one, and the data that they keep.

use std::sync::Arc;

use counterpoint_event::FileId;
use counterpoint_program::shape::ProgramRange;

use super::drilling::HoleWords;
use super::old;
use super::patterns::PointPattern;
use super::q_parameter::QParameter;
use super::sl_contours::Contours;
use super::words::EvaluatedWord;

/// The cycle that a call executes, if that is a program.
#[derive(Debug, Clone, Default)]
pub(super) struct DefinedCycle {
    pub(super) program: Option<Arc<str>>,
    /// The program is one of the control, not of the job.
    pub(super) stored: bool,
    /// Every position calls it since M89.
    pub(super) modal: bool,
    /// Where the last call has found the program, from the file that called.
    pub(super) found: Option<(FileId, FoundProgram)>,
}

/// The place of a program, if there is one.
type FoundProgram = Option<(FileId, ProgramRange)>;

/// The program of a running cycle.
#[derive(Debug, Default)]
pub(super) struct RunningCycle {
    /// Programs and labels that run with it, 0 for none.
    pub(super) depth: usize,
    /// Feed of the program that has called it.
    pub(super) feed: Option<EvaluatedWord>,
    /// The main program counts in inches.
    pub(super) main_in_inches: bool,
    /// Parameters that the call has changed, with their previous values.
    pub(super) changed: Vec<(QParameter, f64)>,
}

/// The cycle of a program.
#[derive(Debug, Default)]
pub(super) struct HeidenhainCycles {
    pub(super) defined: DefinedCycle,
    pub(super) running: RunningCycle,
    /// The values of the last definition of an old cycle.
    pub(super) old: old::Data,
    /// Parameters of GLOBAL DEF, for definitions that say PREDEF.
    pub(super) global: Vec<(QParameter, f64)>,
    /// Contours of the last cycle 14.
    pub(super) contours: Contours,
    /// Points of the last PATTERN DEF.
    pub(super) pattern: PointPattern,
    /// Words of the machine for holes, once they have been looked up.
    pub(super) holes: Option<HoleWords>,
}
