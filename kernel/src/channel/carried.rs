//! What a kernel carries on when the machine is started again with another file.
//!
//! Facts: reference control-emulator.md 5.8. Invariant: only a kernel whose program came to its end is carried on, and
//! only on a machine whose Machine Shutdown may start it again; everything that belongs to one run of all kernels
//! (clock of the coordinator, waits, streams) begins anew.

use super::flow::Flow;
use super::state::{Modal, Place, SpindleState};
use super::variables::ChannelVariables;
use super::{Acted, Halt, Kernel, tape};
use crate::dialect::Interpreter;
use crate::log::event::FileId;
use crate::macros::model::Hook;
use crate::macros::runtime::Runtime;
use crate::mcd::program::Range;

/// How the life of a kernel ended.
pub(crate) struct Lived {
    pub(crate) rank: u16,
    pub(crate) halt: Halt,
    /// What it carries on, if it may be started again.
    pub(crate) left: Option<Box<Carried>>,
}

/// Says once what is carried on and what is not, so that a new part of a kernel has to be in one list or the other.
macro_rules! carried {
    (on: { $($field:ident: $type:ty,)* } anew: { $($other:ident,)* }) => {
        /// State of a kernel between two runs.
        pub(crate) struct Carried {
            pub(crate) rank: u16,
            clock: i64,
            events: u64,
            $($field: $type,)*
        }

        impl Kernel<'_> {
            fn into_carried(self) -> Carried {
                let events = self.emitter.count();
                let Self { rank, clock, $($field,)* $($other: _,)* } = self;
                Carried { rank, clock, events, $($field,)* }
            }

            fn put_back(&mut self, carried: Carried) {
                $(self.$field = carried.$field;)*
                self.emitter.go_on_from(carried.events);
            }
        }
    };
}

carried! {
    on: {
        modal: Modal,
        place: Place,
        spindle: SpindleState,
        flow: Flow,
        variables: ChannelVariables,
        interpreter: Option<Box<dyn Interpreter>>,
        secondary: bool,
        blocks: u64,
        idle_blocks: u64,
        diagnostics: u32,
        burden: super::burden::Burden,
        macros: Option<Box<Runtime>>,
        raised: rustc_hash::FxHashMap<u32, u32>,
        cycle: crate::action::cycle::State,
        arcs: crate::action::arc::State,
        threads: Box<crate::action::thread::State>,
        skip: Box<crate::action::skip::State>,
        states: Box<crate::action::states::States>,
        tape: (tape::Rules, counterpoint_lang::pattern::Memory),
    }
    anew: {
        machine,
        info,
        options,
        files,
        plan,
        coordinator,
        control,
        progress,
        emitter,
        micro,
        file,
        line,
        block,
        as_data,
        mode_changed,
        meetings,
        stripped,
        trace,
        edited,
    }
}

impl Kernel<'_> {
    /// The end of its life.
    pub(super) fn lived(self, halt: Halt) -> Lived {
        let hook = self.machine.macros.as_deref().and_then(|macros| macros.hook(Hook::MachineShutdown));
        let rank = self.rank;
        let left = (hook.is_some() && matches!(halt, Halt::End(_))).then(|| Box::new(self.into_carried()));
        Lived { rank, halt, left }
    }

    /// Takes over what it was before; from its end to now it stood idle.
    pub(crate) fn take_over(&mut self, carried: Carried) {
        let idle = self.clock.saturating_sub(carried.clock);
        self.put_back(carried);
        if idle > 0 {
            self.idle_blocks = 0;
        }
        if let Some(runtime) = self.macros.as_deref_mut() {
            runtime.store.idle = runtime.store.idle.saturating_add(idle);
        }
    }

    /// Begins another program. It counts as a block, so that a macro that restarts for ever comes to a limit.
    pub(super) fn begin_again(&mut self, file: FileId, range: Range, name: Box<str>, reset: bool) -> Acted {
        if let Some(runtime) = self.macros.as_deref_mut() {
            runtime.closing = false;
        }
        self.blocks += 1;
        self.idle_blocks += 1;
        self.check_limits()?;
        self.load(file)?;
        self.start_over(file, range, name, reset)
    }
}
