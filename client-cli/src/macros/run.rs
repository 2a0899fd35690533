//! `macro run`: a macro without a machine.

use std::cell::RefCell;
use std::rc::Rc;

use counterpoint_lang::vm::MacroLimits;
use counterpoint_lang_standalone::{self as standalone, RunOptions};

use super::arguments::MacroRunArgs;
use super::sandbox::MacroSandbox;
use crate::error::Error;

pub(super) fn run(arguments: &MacroRunArgs) -> Result<u8, Error> {
    let files = super::read(&arguments.files)?;
    let mut limits = MacroLimits::default();
    if let Some(ticks) = arguments.ticks {
        limits.ticks = ticks;
    }
    let broken = Rc::new(RefCell::new(None));
    let mut host = super::standalone::standalone();
    host.attach(Box::new(MacroSandbox::here()?.telling(Rc::clone(&broken))));
    let options = RunOptions { trace: arguments.trace, strong: arguments.strong.into(), limits };
    let failed = standalone::run(&files, &mut host, options);
    match broken.take() {
        Some(error) => Err(error),
        None => Ok(u8::from(failed)),
    }
}
