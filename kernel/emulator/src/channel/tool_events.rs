//! Events of tools and heads: the macro of tools, if there is one, receives them first.
//!
//! *Invariant:* an event takes place once, with or without a macro. Facts: reference control-emulator.md 4.3.

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::code_time::{runs_beside, wait_for_index};
use counterpoint_event::event::{Kind, ToolAction, ToolChange};
use counterpoint_fault::Acted;
use counterpoint_machine::rows::TimeOverlap;

use super::Kernel;

impl Kernel<'_> {
    /// Selects or loads a tool, or changes its offset, through the macro of tools if there is one.
    pub fn tool_event(&mut self, action: ToolAction, tool: u32, offset: u32, ns: i64) -> Acted {
        match self.plan.hooks {
            Some(hooks) => (hooks.tool)(self, action, tool, offset, ns),
            None => self.change_tool(action, tool, offset, ns),
        }
    }

    /// Selects (1) or loads (2) a head, through the macro of tools if there is one.
    pub fn head_event(&mut self, kind: f64, id: u32) -> Acted {
        match self.plan.hooks {
            Some(hooks) => (hooks.head)(self, kind, id),
            None => load_head(&mut self.channel, kind, id),
        }
    }

    /// The tool event itself.
    pub fn change_tool(&mut self, action: ToolAction, tool: u32, offset: u32, ns: i64) -> Acted {
        if action == ToolAction::Select {
            self.channel.state.place.tools.selected = tool;
            self.channel.emit(0, Kind::Tool(ToolChange { action, tool, offset }));
            return Ok(());
        }
        let before = self.channel.state.place.tools.current;
        if tool != 0 || action == ToolAction::Load {
            self.channel.state.place.tools.current = tool;
        }
        if action == ToolAction::Load
            && let Some(hooks) = self.plan.hooks
        {
            (hooks.loaded)(self, tool, before);
        }
        let event = Kind::Tool(ToolChange { action, tool: self.channel.state.place.tools.current, offset });
        let overlap = self.channel.env.machine.time.tool_overlap;
        if ns > 0 && overlap != TimeOverlap::None {
            // A turret indexes once at a time.
            wait_for_index(&mut self.channel);
        }
        if ns > 0 && runs_beside(&mut self.channel, overlap, ('T', f64::from(tool)), ns) {
            self.channel.emit(0, event);
        } else {
            self.channel.emit(ns, event);
            self.channel.advance(ns);
        }
        Ok(())
    }
}

/// The event itself: only the listing shows it.
pub fn load_head(channel: &mut ChannelContext<'_>, kind: f64, id: u32) -> Acted {
    let verb = if kind == 1.0 { "select" } else { "load" };
    channel.emit(0, Kind::mode(format!("{verb} head n={id}")));
    Ok(())
}
