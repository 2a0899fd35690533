//! Where lines go and where files are.
//!
//! *Invariant:* without an [`HostEnvironment`] nothing but memory is touched.

use counterpoint_lang::diag::MacroDiagnostic;
use counterpoint_lang::host::Shelf;

/// Kinds of lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputStream {
    /// The output of PPRINT.
    Printed,
    /// The macro trace.
    Traced,
    /// The output on the console.
    Console,
}

/// A console, and files below one folder.
pub trait HostEnvironment: Shelf + std::fmt::Debug {
    /// Takes a line; false if it takes no more lines, which ends the run.
    fn line(&mut self, stream: OutputStream, text: &str) -> bool;

    /// Takes a diagnostic.
    fn report(&mut self, diagnostic: &MacroDiagnostic);

    /// One line from the console.
    fn console(&mut self) -> Option<String>;

    /// Now: seconds since 1970-01-01 00:00, offset of the local zone in seconds, its name.
    fn now(&self) -> (f64, i32, String);

    /// Value of an environment variable.
    fn environment(&self, name: &str) -> Option<String>;
}
