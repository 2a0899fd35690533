//! Queries whose answers differ with and without macros: the scanner of the current block, and the call as macros see
//! it.
//!
//! *Invariant:* nothing here runs a macro. Facts: reference control-emulator.md 4, 5.3.

use std::sync::Arc;

use counterpoint_channel::callee::Callee;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::flow::CallRecord;
use counterpoint_channel::macros::runtime::Runtime;
use counterpoint_channel::text;
use counterpoint_machine::macros::model::Hook;
use counterpoint_program::scan::LineScanner;

use crate::channel::plan::ExecutionPlan;

/// The scanner for the text of the block in process, if not the plan's: text made by the pre-processor undergoes no
/// block delete.
#[inline]
pub fn block_scanner(plan: &ExecutionPlan, channel: &ChannelContext<'_>, macros: &Runtime) -> Option<Arc<LineScanner>> {
    plan.hooks?;
    match &channel.tables.unmarked {
        Some(scanner) if channel.context.made => Some(Arc::clone(scanner)),
        _ => macros.reading.switched.clone(),
    }
}

/// The call of the current block.
pub fn call_record(plan: &ExecutionPlan, channel: &ChannelContext<'_>, what: Callee, passes: u32) -> CallRecord {
    let macros = channel.env.machine.macros.as_deref().filter(|_| plan.hooks.is_some());
    let hooks = [Hook::SubprogramStartup, Hook::SubprogramShutdown];
    let asks = macros.is_some_and(|macros| hooks.into_iter().any(|hook| macros.hook(hook).is_some()));
    let block = asks.then(|| String::from_utf8_lossy(&text::preprocessed_bytes(channel)).trim().into());
    CallRecord { what, passes, block }
}
