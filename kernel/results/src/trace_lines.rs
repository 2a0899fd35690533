//! The lines of a trace.
//!
//! *Invariant:* columns are exact. Facts: reference listing-and-trace.md 3, 4, 6; statements are not indented.

use counterpoint_lang::format::wildcard_text;

/// A stage that changes the text of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TextStage {
    /// Tape editor.
    TapeEditor,
    /// Block delete, an active level: without the skipped part.
    DeleteOn,
    /// Block delete, no active level: without the mark.
    DeleteOff,
    /// Pre-processor.
    PreProcessor,
    /// Embedded macro code.
    EmbeddedMacro,
    /// Block startup macro.
    BlockMacro,
}

/// `·TapEdt·:·text`.
#[must_use]
pub fn edited(stage: TextStage, text: &str) -> String {
    let header = match stage {
        TextStage::TapeEditor => "TapEdt",
        TextStage::DeleteOn => "DelOn",
        TextStage::DeleteOff => "DelOff",
        TextStage::PreProcessor => "PrePrc",
        TextStage::EmbeddedMacro => "EmbMac",
        TextStage::BlockMacro => "BlkMac",
    };
    format!(" {header:<6} : {text}")
}

/// `·X:12.`.
#[must_use]
pub fn word(register: &str, value: &str) -> String {
    format!(" {register}:{value}")
}

/// `····reg_seqno·50`.
#[must_use]
pub fn sequence(number: u32) -> String {
    format!("    reg_seqno {number}")
}

/// `··code_rapid`.
#[must_use]
pub fn code(name: &str) -> String {
    format!("  {}", name.to_lowercase())
}

/// `··code_comment·(ignored)`.
#[must_use]
pub fn ignored(name: &str) -> String {
    format!("  {} (ignored)", name.to_lowercase())
}

/// `····reg_axis_x·30`.
#[must_use]
pub fn data(name: &str, value: f64) -> String {
    format!("    {} {}", name.to_lowercase(), wildcard_text(value))
}

/// `·Macro:*·Entering name (CODE_…)`; `matching` is empty for other macros than code and data macros.
#[must_use]
pub fn entering(name: &str, matching: &str) -> String {
    format!(" Macro:* Entering {}", named(name, matching))
}

/// `·Macro:··statement`, before it is executed.
#[must_use]
pub fn statement(text: &str) -> String {
    format!(" Macro:  {}", text.trim())
}

/// `·Macro:*·Leaving name (CODE_…), Returning to regular processing`; `outer` is the macro it returns to.
#[must_use]
pub fn leaving(name: &str, matching: &str, outer: Option<&str>) -> String {
    format!(" Macro:* Leaving {}, Returning to {}", named(name, matching), outer.unwrap_or("regular processing"))
}

fn named(name: &str, matching: &str) -> String {
    if matching.is_empty() { name.to_owned() } else { format!("{name} ({matching})") }
}

/// `······|·action`.
#[must_use]
pub fn action(text: &str) -> String {
    format!("      | {text}")
}

/// `exec:·parameters`.
#[must_use]
pub fn exec(parameters: &str) -> String {
    format!("exec: {parameters}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_the_documented_ones() {
        assert_eq!(edited(TextStage::TapeEditor, "G1"), " TapEdt : G1");
        assert_eq!(edited(TextStage::DeleteOn, "G1"), " DelOn  : G1");
        assert_eq!(word("X", "12."), " X:12.");
        assert_eq!(sequence(50), "    reg_seqno 50");
        assert_eq!(code("CODE_SPINDLE_CLW"), "  code_spindle_clw");
        assert_eq!(ignored("CODE_COMMENT"), "  code_comment (ignored)");
        assert_eq!(data("REG_FEED_UPR", 0.2), "    reg_feed_upr .2");
        assert_eq!(entering("Spindle guard", "CODE_SPINDLE_CLW"), " Macro:* Entering Spindle guard (CODE_SPINDLE_CLW)");
        assert_eq!(statement("  IF/$S.GT.3000"), " Macro:  IF/$S.GT.3000");
        assert_eq!(
            leaving("Spindle guard", "CODE_SPINDLE_CLW", None),
            " Macro:* Leaving Spindle guard (CODE_SPINDLE_CLW), Returning to regular processing"
        );
        assert_eq!(exec("NOW,CODE_RAPID"), "exec: NOW,CODE_RAPID");
        assert_eq!(action("home x, z"), "      | home x, z");
    }
}
