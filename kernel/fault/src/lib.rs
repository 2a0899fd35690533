//! The diagnostics of the kernel: stable numbers, severities, and whether the control stops on them.
//!
//! Numbers up to 02 899 999 are those of the emulated system, from 02 900 001 this project's own (reference
//! control-emulator.md 7.5). *Invariant:* every entry has a page `docs/diagnostics/<number, 8 digits>.md` whose head
//! names its word, and no word has two numbers, those of the macro language included.

pub mod language;

mod halt;

pub use halt::{Acted, Halt, Stop};
use language::TABLE;

/// Facts of one diagnostic number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Facts {
    /// Stable number.
    pub number: u32,
    /// Stable word that people use for the number.
    pub name: &'static str,
    /// 0–3 message, 4–7 warning, 8–15 error, 16–99 fatal.
    pub severity: u8,
    /// A real control stops the channel here (an alarm); whether the machine does: `[control] stops` and `stops` of the
    /// number.
    pub alarm: bool,
    /// What it is about, for the index of the pages.
    pub title: &'static str,
}

macro_rules! diagnostics {
    ($($constant:ident $number:literal $name:literal $severity:literal $alarm:literal $title:literal;)*) => {
        $(#[doc = $title] pub const $constant: Facts = Facts { number: $number, name: $name, severity: $severity, alarm: $alarm, title: $title };)*
        /// Every diagnostic.
        pub const ALL: &[Facts] = &[$($constant),*];
    };
}

diagnostics! {
    NOT_RECOGNISED 2001005 "text-not-recognised" 4 false "text of a block that no table knows";
    ARC_RADIUS 2007020 "arc-not-possible" 8 false "arc that cannot be made from its radius, centre and end";
    ARC_PLANE 2007001 "arc-without-plane" 8 false "arc without a known plane";
    POSITION_MODE_UNKNOWN 2008031 "no-positioning-mode" 4 false "neither absolute nor incremental positioning is active";
    DWELL_NOT_POSITIVE 2009002 "dwell-not-positive" 4 false "dwell of zero or less";
    COMP_ON_RAPID 2018003 "compensation-on-at-rapid" 8 false "cutter compensation switched on by a rapid move";
    COMP_OFF_RAPID 2018004 "compensation-off-at-rapid" 8 false "cutter compensation switched off by a rapid move";
    COMP_ON_ARC 2018005 "compensation-on-at-arc" 8 false "cutter compensation switched on by a circle";
    COMP_OFF_ARC 2018006 "compensation-off-at-arc" 8 false "cutter compensation switched off by a circle";
    NO_FEED 2019001 "no-feed" 8 false "feed move before any feed was programmed";
    FEED_NOT_POSITIVE 2019002 "feed-not-positive" 8 false "feed of zero or less";
    DATA_NOT_USED 2900001 "unused-word" 8 false "word that nothing on its block uses";
    NO_ACTION 2900002 "code-without-action" 8 false "code that is in the table but has no action";
    CODE_WITHOUT_PROCESSING 2900003 "code-not-processed" 0 false "code without built-in processing";
    DATA_OUT_OF_RANGE 2900004 "value-out-of-range" 8 false "value outside the range of its table row";
    DATA_MISSING 2900005 "missing-word" 8 false "code without a value it needs";
    TOO_MANY_DIGITS 2900006 "too-many-digits" 4 false "more digits than the register's format";
    DATA_REFUSED 2900007 "word-not-processed" 8 false "word that an action asks for and whose row is not processed";
    TAPE_RULE 2900008 "tape-rule-too-slow" 8 false "rule of the tape editor that needs too many steps on a block";
    COMMENT_OPEN 2900010 "comment-not-closed" 4 false "comment or message without its end";
    NO_REWIND_STOP 2900012 "no-rewind-stop" 0 false "program without the expected rewind-stop";
    REWIND_STOP_INSIDE 2900013 "rewind-stop-inside" 4 false "rewind-stop inside the program";
    BLOCK_TOO_LONG 2900014 "block-too-long" 8 true "block longer than the limit";
    BAD_BYTES 2900015 "control-characters" 4 false "control characters in a block";
    NO_PROGRAM_END 2900016 "no-program-end" 4 false "program without an end code";
    MAIN_RETURN 2900017 "return-in-main-program" 0 false "return code in the main program";
    TOO_MANY_DIAGNOSTICS 2900018 "too-many-diagnostics" 4 false "further diagnostics of a channel are only counted";
    FILE_UNREADABLE 2900019 "file-unreadable" 12 true "file of the job that cannot be read";
    ARC_END_OFF 2900020 "arc-end-off-circle" 8 false "arc whose end is not on its circle";
    SPINDLE_STANDS 2900021 "spindle-stopped" 8 false "feed per revolution while the spindle stands";
    SPINDLE_CONFLICT 2900022 "spindle-conflict" 4 false "two channels command one spindle without a meeting between them";
    OVER_TRAVEL 2900023 "over-travel" 8 false "position beyond the travel limits of an axis";
    NO_OFFSET 2900024 "no-offset-value" 4 false "offset number without a value in the machine";
    NO_REFERENCE 2900025 "no-reference-point" 8 false "reference point that the machine does not define";
    SPINDLE_LIMIT 2900026 "spindle-over-speed" 4 false "spindle speed above the machine's largest";
    NO_MOTION_MODE 2900027 "no-motion-code" 8 false "axis word while no motion code is active";
    AXIS_NOT_IN_CHANNEL 2900028 "axis-not-in-channel" 8 true "word of an axis that the channel does not have";
    RETURN_WITHOUT_HOME 2900029 "no-intermediate-point" 8 false "return from reference without an intermediate point";
    NO_SPINDLE 2900030 "no-spindle" 8 false "spindle code in a channel without a spindle";
    SUBPROGRAM_MISSING 2900040 "subprogram-not-found" 12 true "subprogram that is nowhere to be found";
    NESTING 2900041 "subprograms-too-deep" 8 true "subprograms nested too deeply";
    JUMP_TARGET 2900042 "jump-target-not-found" 12 true "sequence number of a jump is not in the program";
    WAIT_MISMATCH 2900050 "wait-mismatch" 12 true "waiting codes that do not match (PS0160)";
    WAIT_ILLEGAL 2900051 "wait-illegal-channels" 12 true "illegal channel list of a waiting code (PS0161)";
    MACRO_SYNTAX 2900060 "statement-syntax" 12 true "macro statement that cannot be read";
    MACRO_DIVISION 2900061 "division-by-zero" 12 true "division by zero in a macro expression";
    MACRO_DOMAIN 2900062 "argument-outside-domain" 12 true "function argument outside its domain";
    MACRO_VARIABLE 2900063 "illegal-variable" 12 true "variable that does not exist or cannot be written";
    MACRO_LOOP 2900064 "loop-not-paired" 12 true "WHILE, DO and END that do not pair";
    MACRO_ALARM 2900065 "program-alarm" 12 true "alarm raised by the program";
    MACRO_CALL 2900066 "illegal-macro-call" 12 true "macro call that cannot be made";
    LIMIT_REACHED 2900070 "limit-reached" 16 false "limit of the job";
    DEADLOCK 2900071 "deadlock" 16 false "channels that can never go on";
    CODE_NOT_HERE 2900080 "code-not-on-machine" 8 false "code of a macro that the machine does not have";
    EXEC_QUEUE 2900081 "too-many-exec-blocks" 8 false "too many blocks of EXEC/NEXT waiting";
    MACRO_RESULT 2900082 "macro-result-type" 8 false "value of a wrong type returned by a macro";
    MODAL_STACK 2900083 "modal-stack-unbalanced" 8 false "modal states restored without being saved, or saved too often";
    EMBEDDED_CODE 2900084 "embedded-code-invalid" 8 false "embedded macro code that cannot be compiled";
    START_ONLY 2900085 "startup-only-variable" 4 false "variable set after Machine Startup";
    MACRO_FILES 2900086 "macro-files-limit" 8 false "too many or too large files written by macros";
    TOOL_TABLE 2900087 "tool-table-full" 8 false "more tools than the tool table has rows";
    NO_RESTART 2900120 "restart-not-possible" 8 false "machine that Machine Shutdown cannot start again";
    PREPROCESSOR_ASKS 2900121 "block-for-busy-preprocessor" 8 false "block for the pre-processor while it asks a macro";
    SIEMENS_TYPE 2900200 "type-not-compatible" 12 true "value that does not fit its variable, operator or function";
    SIEMENS_DEFINITION 2900201 "illegal-definition" 12 true "variable that cannot be defined";
    SIEMENS_ARGUMENTS 2900202 "illegal-arguments" 12 true "arguments that do not fit the subprogram";
    SIEMENS_FRAME 2900203 "frame-not-possible" 8 false "frame that the machine has no words for";
    SIEMENS_ALARM 2900204 "setal-message" 4 false "alarm of the program that is only shown";
    SIEMENS_IGNORED 2900205 "statement-part-ignored" 4 false "part of a statement that is not carried out";
    SIEMENS_FILE 2900206 "definition-file-not-found" 4 false "definition file that does not exist";
    STATEMENT_UNKNOWN 2900240 "unknown-statement" 8 true "statement of a control that its pre-processor does not understand";
    PARAMETER_UNSET 2900241 "parameter-not-set" 4 false "Q parameter that is read before it has a value";
    PATH_NOT_MADE 2900242 "path-not-possible" 8 false "path block of a pre-processor that cannot be made";
    TOOL_NAME 2900243 "tool-name-without-number" 8 false "tool name without a number";
    SYSTEM_DATA_UNKNOWN 2900244 "unknown-system-data" 8 false "system data that the control does not tell";
    PRINT_MASK 2900245 "print-mask-not-found" 4 false "mask of a print that is not there";
    CYCLE_NOT_CANCELLED 2900090 "cycle-not-cancelled" 4 false "cycle that should have been cancelled before";
    NO_CYCLE 2900091 "no-cycle-defined" 8 false "cycle switched on before any was defined";
    CYCLE_STEPS 2900092 "cycle-too-many-steps" 8 false "cycle with too many steps";
    CYCLE_AXIS 2900093 "cycle-axis-not-in-channel" 8 false "cycle along an axis that the channel does not have";
    ARC_DIRECTION 2900110 "arc-without-direction" 8 false "circle without a direction";
    ARC_HELIX 2900111 "helix-not-available" 8 false "helix on a control without it";
    THREAD_LEAD 2900112 "thread-lead-vanishes" 8 false "thread whose lead falls to nothing before its end";
    THREAD_PASSES 2900113 "thread-too-many-passes" 8 false "thread with too many passes";
    PROBE_MISSED 2900114 "probe-missed" 8 false "probing move that touched nothing";
    FRAME_REFUSED 2900130 "illegal-local-frame" 8 false "local frame that cannot be";
    FRAME_AXIS 2900131 "frame-axis-not-in-channel" 8 false "local frame that would move an axis the channel does not have";
    ARC_SCALED 2900132 "arc-with-unequal-scales" 8 false "circle under unequal scales";
    CUTTER_INTERFERENCE 2900133 "cutter-interference" 8 false "tool that does not fit into the contour";
    CUTTER_PLANE 2900134 "compensation-without-plane" 8 false "cutter compensation without its plane";
    OFFSET_NOT_KEPT 2900135 "offset-not-kept" 8 false "offset that the program sets and the control does not keep";
    COOLANT_PRESSURE 2900160 "illegal-coolant-pressure" 4 false "coolant pressure that is not possible";
    NO_HEAD 2900161 "no-head" 8 false "head that the machine does not have";
    CLAMPED 2900162 "axis-clamped" 8 false "motion of a clamped axis";
    NO_POLAR_AXES 2900163 "no-polar-axes" 8 false "polar interpolation without its axes";
    TIP_UNREACHABLE 2900164 "tool-direction-unreachable" 8 false "direction of the tool that the rotary axes cannot reach";
    NO_TIP_AXES 2900165 "no-tool-tip-axes" 8 false "tool tip control without its axes";
    SECOND_CALL 2900170 "second-call" 8 false "call on a block with another call, a return or an end code";
    TEXT_OF_NO_PROGRAM 2900171 "text-outside-program" 4 false "text of a file that belongs to no program";
    RUNS_INTO_DEFINITION 2900172 "runs-into-definition" 4 false "program that runs into the definition behind it";
    OKUMA_UNKNOWN 2900180 "unknown-okuma-name" 8 false "variable or function that nobody knows (Okuma)";
    OKUMA_CONTINUED 2900181 "continuation-without-block" 8 false "line that goes on with a block that is not above it (Okuma)";
    UNKNOWN_CODE 2900320 "unknown-code" 12 true "code that the control does not have";
    UNKNOWN_TEXT 2900321 "unknown-text" 12 true "address or statement that the control does not know";
    UNKNOWN_MOVES 2900322 "unknown-code-moves" 8 false "unknown code on a block that moves by the active one";
    ALARM_SOFTENED 2900323 "alarm-softened" 8 false "alarm that is not among the errors of its channel";
    NO_RADIUS 2900324 "no-tool-radius" 4 false "compensation by an offset without a radius";
    REFUSED 2900380 "block-refused" 12 true "block that a rule of the control refuses";
    MINUS_SIGN 2900381 "negative-value" 8 false "negative value at an address that takes none";
    DECIMAL_POINT 2900382 "illegal-decimal-point" 8 false "decimal point at an address that takes none";
    NO_LEAD 2900383 "no-thread-lead" 8 false "thread without a lead";
    WAIT_IMPOSSIBLE 2900385 "wait-impossible" 12 true "wait, signal or release that is not possible";
    WAIT_LISTS 2900386 "wait-lists" 4 false "channels at one mark that name different partners (16949)";
    ARC_INCOMPLETE 2900384 "arc-incomplete" 8 false "circle without a centre and without a radius";
    OKUMA_NO_MODAL 2900182 "no-modal-call" 4 false "end of a modal call that was not begun (Okuma)";
    GROUP_TWICE 2900350 "group-twice" 4 false "G code overridden by a later one of its group";
    MACHINE_INCREMENTAL 2900351 "machine-coordinates-incremental" 4 false "machine coordinates in incremental mode";
    CALL_LEVELS 2900352 "too-many-call-levels" 12 true "more levels of calls than the control has (PS0077)";
    MACRO_LEVELS 2900353 "too-many-macro-levels" 12 true "more levels of macro calls than the control has (PS0122)";
    BRACKETS 2900354 "too-many-bracket-levels" 12 true "more levels of brackets than the control has (PS0118)";
    LOOP_ENTERED 2900355 "jump-into-loop" 12 true "loop that a jump leads into (PS0124)";
    CALL_G_WORD 2900356 "g-code-as-argument" 12 true "G word among the arguments of a macro call (PS0129)";
    PRINT_CLOSED 2900358 "print-not-open" 4 false "printing statement outside of POPEN and PCLOS";
    MACRO_OVERFLOW 2900359 "number-overflow" 12 true "value beyond the range of numbers (PS0111)";
    CALL_NOT_FIRST 2900357 "macro-call-not-first" 12 true "words before a macro call (PS0127)";
    SIEMENS_STOP 2900365 "setal-alarm" 12 true "alarm of the program that stops the channel";
    NO_TEETH 2900366 "no-teeth" 12 true "feed per tooth without the number of teeth";
    OKUMA_ALARM 2900367 "user-alarm" 12 true "alarm of the user (Okuma)";
    NO_FEED_PER_TURN 2900368 "no-feed-per-revolution" 12 true "feed per revolution on a machine without M136";
}

/// The word of a number, `None` for numbers that only a machine or its macros have.
#[must_use]
pub fn name(number: u32) -> Option<&'static str> {
    let own = ALL.iter().find(|facts| facts.number == number).map(|facts| facts.name);
    own.or_else(|| TABLE.iter().find(|row| row.number.0 == number).map(|row| row.name))
}

/// The number that a word stands for.
#[must_use]
pub fn number(name: &str) -> Option<u32> {
    let own = ALL.iter().find(|facts| facts.name == name).map(|facts| facts.number);
    own.or_else(|| TABLE.iter().find(|row| row.name == name).map(|row| row.number.0))
}

#[cfg(test)]
mod tests {
    use super::{ALL, TABLE, name, number};

    #[test]
    fn numbers_are_unique() {
        let mut numbers: Vec<u32> = ALL.iter().map(|f| f.number).collect();
        numbers.sort_unstable();
        let count = numbers.len();
        numbers.dedup();
        assert_eq!(numbers.len(), count);
    }

    #[test]
    fn names_are_unique_words() {
        let mut names: Vec<_> = ALL.iter().map(|facts| facts.name).chain(TABLE.iter().map(|row| row.name)).collect();
        for name in &names {
            let plain = name.split('-').all(|part| !part.is_empty() && part.chars().all(|c| c.is_ascii_lowercase()));
            assert!(plain, "{name}");
        }
        names.sort_unstable();
        let count = names.len();
        names.dedup();
        assert_eq!(names.len(), count);
        assert_eq!(number("no-feed").and_then(name), Some("no-feed"));
    }

    #[test]
    fn every_number_has_a_page_with_its_name() {
        let docs = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/diagnostics");
        let index = std::fs::read_to_string(docs.join("README.md")).unwrap();
        let own = ALL.iter().map(|facts| (facts.number, facts.name, facts.title));
        let all = own.chain(TABLE.iter().map(|row| (row.number.0, row.name, row.about)));
        for (number, name, title) in all {
            let page = std::fs::read_to_string(docs.join(format!("{number:08}.md"))).unwrap_or_default();
            let mut capital = title.chars();
            let title = capital.next().map_or_else(String::new, |c| c.to_uppercase().chain(capital).collect());
            assert_eq!(page.lines().next(), Some(&*format!("# {number:08} `{name}`: {title}")), "head of the page");
            let row = format!("| [{number:08}]({number:08}.md) | `{name}` |");
            assert!(index.lines().any(|line| line.starts_with(&row)), "no row in docs/diagnostics/README.md: {row}");
        }
    }
}
