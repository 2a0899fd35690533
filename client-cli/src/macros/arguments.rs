//! The part of the command line that is about macros.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use counterpoint_lang::compile;
use counterpoint_lang::layout;

#[derive(Debug, Subcommand)]
pub(crate) enum Macro {
    /// Find every mistake in files of macros without running them
    Check(Check),
    /// Rewrite files of macros in one style
    Fmt(Fmt),
    /// Run the last of several files of macros without a machine; the others define functions
    Run(Run),
    /// Explain a diagnostic by name or number, or a function, statement, variable or identifier by name
    Explain {
        /// no-feed, 02910011, $FSIN, DECLAR, $TLTAB, CODE_RAPID
        #[arg(value_name = "NUMBER|NAME")]
        what: String,
    },
}

#[derive(Debug, Args)]
pub(crate) struct Check {
    /// Files that are used together; under strong declaration the last one is a macro, those before it declare
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Print one JSON document
    #[arg(long)]
    pub(crate) json: bool,
    /// What must be declared
    #[arg(long, value_enum, default_value = "off")]
    pub(crate) strong: Strong,
}

#[derive(Debug, Args)]
pub(crate) struct Fmt {
    /// Files to rewrite; - reads standard input and writes standard output
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// How to write
    #[arg(long, value_enum, default_value = "standard")]
    pub(crate) style: Style,
    /// Change nothing; list the files that would change and exit with 1 if there are any
    #[arg(long)]
    pub(crate) check: bool,
    /// Change nothing; print what would be written
    #[arg(long, conflicts_with = "check")]
    pub(crate) stdout: bool,
}

#[derive(Debug, Args)]
pub(crate) struct Run {
    /// Files of macros; the last one is run
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Print the macro trace, too
    #[arg(long)]
    pub(crate) trace: bool,
    /// What must be declared
    #[arg(long, value_enum, default_value = "off")]
    pub(crate) strong: Strong,
    /// Steps after which the run is ended
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) ticks: Option<u64>,
}

/// Strong declaration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Strong {
    /// Nothing
    Off,
    /// GLOBAL and OBJECT variables, in the declaration macro
    Partial,
    /// Local variables, too
    Full,
}

impl From<Strong> for compile::Strong {
    fn from(strong: Strong) -> Self {
        match strong {
            Strong::Off => Self::Off,
            Strong::Partial => Self::Partial,
            Strong::Full => Self::Full,
        }
    }
}

/// Styles of writing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Style {
    /// Upper case, .EQ.
    Standard,
    /// Lower case, ==
    C,
}

impl From<Style> for layout::Style {
    fn from(style: Style) -> Self {
        match style {
            Style::Standard => Self::Standard,
            Style::C => Self::C,
        }
    }
}
