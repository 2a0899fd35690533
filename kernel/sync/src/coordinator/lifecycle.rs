//! Start and end of a kernel, and the end of the job.

use super::{ABORT, Coordinator};
use crate::merge::MergerMessage;
use crate::order::Order;
use crate::wait::{Finish, Terminal};

impl Coordinator {
    /// A channel that never runs.
    pub fn never_started(&self, channel: u16) {
        let mut inner = self.lock();
        inner.order.waits.finish(channel, Finish { how: Terminal::NeverStarted, file: 0, line: 0 });
        inner.order.done(channel);
        self.apply(&mut inner);
        inner.send(MergerMessage::Done(channel));
    }

    /// A channel without a program, which others may start; its kernel has not begun yet.
    pub fn idle(&self, channel: u16) {
        let mut inner = self.lock();
        inner.order.waits.finish(channel, Finish { how: Terminal::NeverStarted, file: 0, line: 0 });
        inner.order.rest_idle(channel);
        self.apply(&mut inner);
    }

    /// The kernel is finished, and all its events are sent. `last` is done before: its end may concern others.
    pub fn done(&self, channel: u16, last: impl FnOnce(&mut Order)) {
        let mut inner = self.lock();
        last(&mut inner.order);
        inner.order.done(channel);
        // A kernel that continues because of this end does so in the log before the merger stops waiting for this
        // channel.
        self.apply(&mut inner);
        inner.send(MergerMessage::Done(channel));
        if self.limited {
            self.release_permit(&mut inner);
        }
        self.settle(&mut inner);
    }

    /// Stops the job at any place (cancel, full log): the caller has cut the log.
    pub fn abort(&self) {
        let mut inner = self.lock();
        inner.order.stop(ABORT);
        self.apply(&mut inner);
    }
}
