//! The locks of the coordinator: the standard library, or a model of it that tries out schedules of threads.

#[cfg(not(all(test, feature = "shuttle")))]
mod real {
    pub(crate) use std::hint::spin_loop;
    pub(crate) use std::sync::{Condvar, Mutex, MutexGuard, PoisonError, TryLockError, atomic};
    pub(crate) use std::thread::yield_now;
}

#[cfg(all(test, feature = "shuttle"))]
mod real {
    pub(crate) use shuttle::hint::spin_loop;
    pub(crate) use shuttle::sync::{Condvar, Mutex, MutexGuard, atomic};
    pub(crate) use shuttle::thread::yield_now;
    pub(crate) use std::sync::{PoisonError, TryLockError};
}

pub(crate) use real::*;
