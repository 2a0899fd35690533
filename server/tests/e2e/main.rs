//! The server through its wire contract, over loopback, with a scripted runner.

#![allow(missing_docs, unreachable_pub)]

mod life;
mod submit;
mod support;
mod watch;
