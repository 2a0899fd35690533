//! Specification pages in Markdown: prose that explains a behaviour, examples that show it, one test an example.
//!
//! A page is read into examples with their fences ([`Page`]), an example is compared with its result ([`Check`]), and a
//! suite runs every example of its pages as a test with a name ([`Suite`]). `UPDATE=1` in the environment writes the
//! results into the pages.
//!
//! *Invariant:* this crate knows no control, no machine and no macro language; which fences there are is data
//! ([`Fences`]).

mod check;
mod marks;
mod page;
mod suite;
mod update;

pub use check::Check;
pub use marks::{ARROW, Marked, counted, severity_name};
pub use page::{Example, Fault, Fence, Fences, Named, Page, Role};
pub use suite::Suite;
pub use update::{Edit, rewritten};
