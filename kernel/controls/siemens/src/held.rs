//! State that statements keep for later blocks of the channel. *Invariant:* a program begins without any of it, except
//! for actions that stay.

use std::sync::Arc;

use rustc_hash::{FxHashMap, FxHashSet};

use super::actions::ArmedAction;
use super::along::OrientationInterpolation;
use super::drilling::SiemensHoleCycle;
use super::preparation::Preparation;
use counterpoint_event::FileId;

/// The kept data.
#[derive(Debug, Default)]
pub(super) struct StatementState {
    /// Subprograms that were declared by EXTERN.
    pub(super) externals: FxHashSet<String>,
    /// Synchronised actions that wait.
    pub(super) actions: Vec<ArmedAction>,
    /// Additive part of the programmable translation, along X, Y and Z.
    pub(super) additive: [f64; 3],
    /// Feeds of axes that POS moves, by letter.
    pub(super) axis_feeds: FxHashMap<String, f64>,
    /// Angles of directions are RPY angles.
    pub(super) rpy: bool,
    /// Where SPOS has turned the master spindle to, degrees.
    pub(super) spindle: Option<f64>,
    /// Limits of speed of spindles that are not the master, by number.
    pub(super) limits: FxHashMap<i64, f64>,
    /// Ratios of COUPDEF, by the numbers of the following and the leading spindle.
    pub(super) couplings: FxHashMap<(u8, u8), f64>,
    /// How the tool turns along the path.
    pub(super) turning: OrientationInterpolation,
    /// CONTPRON without its EXECUTE.
    pub(super) preparation: Option<Preparation>,
    /// The drilling cycles among the programs that were called.
    pub(super) holes: FxHashMap<FileId, Option<Arc<SiemensHoleCycle>>>,
}
