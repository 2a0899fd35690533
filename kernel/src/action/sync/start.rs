//! A start by one side: one code in both programs. The head that it is named after lets the other one go on and does not
//! wait; the other one waits there for it.
//!
//! Facts: reference channel-synchronisation.md 1.0; the reading is ours, told in docs/emulation.md, "Spindles".

use super::{heads, pass, passes, stand, woken};
use crate::channel::Kernel;
use crate::log::event::{Kind, Release};
use crate::machine::model::SyncDialect;
use crate::multi::order::Wake;
use crate::multi::waits::{Set, Spec, Waiting};
use counterpoint_fault::Acted;

/// Carries out the start by a head.
pub(super) fn start(kernel: &mut Kernel<'_>, by: u16) -> Acted {
    let heads = heads(kernel);
    // The code names a head by its place: the first or the second channel.
    let by = heads.iter().nth(usize::from(by).saturating_sub(1)).unwrap_or(by);
    let gives = kernel.channel.at.channel == by && kernel.channel.env.machine.sync.dialect != SyncDialect::None;
    if !heads.has(kernel.channel.at.channel)
        || kernel.channel.env.machine.channels.len() < 2
        || !gives && passes(kernel)
    {
        return pass(kernel);
    }
    kernel.flow.pass.effects = true;
    if gives { give(kernel, heads) } else { wait(kernel, by, heads) }
}

fn tell(kernel: &mut Kernel<'_>, spec: &Spec, what: &str) {
    kernel.emit(0, Kind::mode(format!("sync mark={} {what}", spec.text())));
}

/// Lets the other head go on, now or when it comes.
fn give(kernel: &mut Kernel<'_>, heads: Set) -> Acted {
    tell(kernel, &Spec::start(kernel.channel.at.channel, heads), "set");
    let tag = kernel.tag();
    kernel.shared(|order| {
        if let Some(released) = order.waits.start(tag, heads) {
            let meeting = order.count_meeting(Set::default().with(tag.rank).with(released.rank));
            order.resume(released.rank, Wake::Released { tag: released, meeting, all: false });
        }
    })
}

/// Waits for the other head, unless it has been here before.
fn wait(kernel: &mut Kernel<'_>, by: u16, heads: Set) -> Acted {
    let spec = Spec::start(by, heads);
    let (since_ns, tag) = (kernel.channel.at.clock, kernel.tag());
    let (file, line, info) = (kernel.channel.at.file, kernel.channel.at.line, kernel.channel.env.info);
    let waiting = Waiting { spec: spec.clone(), tag, file, line };
    let stands = kernel.shared(|order| {
        if order.waits.started(by) {
            return None;
        }
        order.waits.stand(waiting);
        let verdict = if order.waits.hopeful(tag.rank) { None } else { order.judge(tag.t, info) };
        order.block(tag.rank);
        Some(verdict)
    })?;
    let Some(verdict) = stands else {
        tell(kernel, &spec, "go");
        return Ok(());
    };
    let wait = kernel.channel.reports.waits.wait(&spec);
    kernel.channel.burden.result(crate::state::burden::RESULT);
    kernel.emit(0, Kind::Wait(wait.clone()));
    if let Some(verdict) = verdict {
        kernel.emit_verdict(verdict);
    }
    let wake = stand(kernel, tag, &wait);
    let release = |meeting| Release { key: wait.key.clone(), primitive: wait.primitive, since_ns, meeting };
    woken(kernel, wake, release)
}
