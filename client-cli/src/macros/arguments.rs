//! The part of the command line that is about macros.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use counterpoint_lang::compile;
use counterpoint_lang::layout;

#[derive(Debug, Subcommand)]
pub(crate) enum MacroCommand {
    /// Check macro files without running them
    Check(MacroCheckArgs),
    /// Reformat macro files
    Fmt(Fmt),
    /// Run the last of several macro files without a machine; the other files define functions
    Run(MacroRunArgs),
    /// Explain a diagnostic by its word or number, an alarm, or a word of the macro language
    Explain {
        /// Explain this word or number, such as no-feed, 02910011, $FSIN, DECLAR, $TLTAB or CODE_RAPID
        #[arg(value_name = "WORD|NUMBER")]
        what: String,
    },
}

#[derive(Debug, Args)]
pub(crate) struct MacroCheckArgs {
    /// Check these files together; with --strong the last file is an ordinary macro and the files before it are the
    /// declaration macro; - reads standard input, once
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Print one JSON document
    #[arg(long)]
    pub(crate) json: bool,
    /// Require declarations of these variables
    #[arg(long, value_enum, default_value = "off")]
    pub(crate) strong: StrongDeclaration,
}

#[derive(Debug, Args)]
pub(crate) struct Fmt {
    /// Reformat these files; - reads standard input and writes standard output
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Write in this style
    #[arg(long, value_enum, default_value = "standard")]
    pub(crate) style: MacroStyle,
    /// Only list the files that would change; exit with code 1 if a file would change
    #[arg(long)]
    pub(crate) check: bool,
    /// Print the result instead of writing files
    #[arg(long, conflicts_with = "check")]
    pub(crate) stdout: bool,
}

#[derive(Debug, Args)]
pub(crate) struct MacroRunArgs {
    /// Load these macro files and run the last one; - reads standard input, once
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Also print the macro trace
    #[arg(long)]
    pub(crate) trace: bool,
    /// Require declarations of these variables
    #[arg(long, value_enum, default_value = "off")]
    pub(crate) strong: StrongDeclaration,
    /// End the run after this many steps
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) ticks: Option<u64>,
}

/// Strong declaration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum StrongDeclaration {
    /// No declarations required
    Off,
    /// GLOBAL and OBJECT variables, in the declaration macro
    Partial,
    /// Local variables, too
    Full,
}

impl From<StrongDeclaration> for compile::DeclarationStrictness {
    fn from(strong: StrongDeclaration) -> Self {
        match strong {
            StrongDeclaration::Off => Self::Off,
            StrongDeclaration::Partial => Self::Partial,
            StrongDeclaration::Full => Self::Full,
        }
    }
}

/// Styles of writing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MacroStyle {
    /// Upper case, .EQ.
    Standard,
    /// Lower case, ==
    C,
}

impl From<MacroStyle> for layout::SourceStyle {
    fn from(style: MacroStyle) -> Self {
        match style {
            MacroStyle::Standard => Self::Standard,
            MacroStyle::C => Self::C,
        }
    }
}
