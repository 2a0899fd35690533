//! The diagnostics of the kernel: stable numbers, severities, and whether the control stops on them.
//!
//! Numbers up to 02 899 999 are those of the emulated system, from 02 900 001 this project's own (reference
//! control-emulator.md 7.5). Invariant: every entry has a page `docs/diagnostics/<number, 8 digits>.md`.

mod halt;

pub use halt::{Acted, Halt, Stop};

/// Facts of one diagnostic number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Facts {
    /// Stable number.
    pub number: u32,
    /// 0–3 message, 4–7 warning, 8–15 error, 16–99 fatal.
    pub severity: u8,
    /// A real control stops the channel here (an alarm); whether the machine does: `[control] stops` and `stops` of the
    /// number.
    pub alarm: bool,
    /// What it is about, for the index of the pages.
    pub title: &'static str,
}

macro_rules! diagnostics {
    ($($name:ident $number:literal $severity:literal $alarm:literal $title:literal;)*) => {
        $(#[doc = $title] pub const $name: Facts = Facts { number: $number, severity: $severity, alarm: $alarm, title: $title };)*
        /// Every diagnostic.
        pub const ALL: &[Facts] = &[$($name),*];
    };
}

diagnostics! {
    NOT_RECOGNISED 2001005 4 false "text of a block that no table knows";
    ARC_RADIUS 2007020 8 false "arc that cannot be made from its radius, centre and end";
    ARC_PLANE 2007001 8 false "arc without a known plane";
    POSITION_MODE_UNKNOWN 2008031 4 false "neither absolute nor incremental positioning is active";
    DWELL_NOT_POSITIVE 2009002 4 false "dwell of zero or less";
    COMP_ON_RAPID 2018003 8 false "cutter compensation switched on by a rapid move";
    COMP_OFF_RAPID 2018004 8 false "cutter compensation switched off by a rapid move";
    COMP_ON_ARC 2018005 8 false "cutter compensation switched on by a circle";
    COMP_OFF_ARC 2018006 8 false "cutter compensation switched off by a circle";
    NO_FEED 2019001 8 false "feed move before any feed was programmed";
    FEED_NOT_POSITIVE 2019002 8 false "feed of zero or less";
    DATA_NOT_USED 2900001 8 false "word that nothing on its block uses";
    NO_ACTION 2900002 8 false "code that is in the table but has no action";
    CODE_WITHOUT_PROCESSING 2900003 0 false "code without built-in processing";
    DATA_OUT_OF_RANGE 2900004 8 false "value outside the range of its table row";
    DATA_MISSING 2900005 8 false "code without a value it needs";
    TOO_MANY_DIGITS 2900006 4 false "more digits than the register's format";
    DATA_REFUSED 2900007 8 false "word that an action asks for and whose row is not processed";
    TAPE_RULE 2900008 8 false "rule of the tape editor that needs too many steps on a block";
    COMMENT_OPEN 2900010 4 false "comment or message without its end";
    NO_REWIND_STOP 2900012 0 false "program without the expected rewind-stop";
    REWIND_STOP_INSIDE 2900013 4 false "rewind-stop inside the program";
    BLOCK_TOO_LONG 2900014 8 true "block longer than the limit";
    BAD_BYTES 2900015 4 false "control characters in a block";
    NO_PROGRAM_END 2900016 4 false "program without an end code";
    MAIN_RETURN 2900017 0 false "return code in the main program";
    TOO_MANY_DIAGNOSTICS 2900018 4 false "further diagnostics of a channel are only counted";
    FILE_UNREADABLE 2900019 12 true "file of the job that cannot be read";
    ARC_END_OFF 2900020 8 false "arc whose end is not on its circle";
    SPINDLE_STANDS 2900021 8 false "feed per revolution while the spindle stands";
    SPINDLE_CONFLICT 2900022 4 false "two channels command one spindle without a meeting between them";
    OVER_TRAVEL 2900023 8 false "position beyond the travel limits of an axis";
    NO_OFFSET 2900024 4 false "offset number without a value in the machine";
    NO_REFERENCE 2900025 8 false "reference point that the machine does not define";
    SPINDLE_LIMIT 2900026 4 false "spindle speed above the machine's largest";
    NO_MOTION_MODE 2900027 8 false "axis word while no motion code is active";
    AXIS_NOT_IN_CHANNEL 2900028 8 true "word of an axis that the channel does not have";
    RETURN_WITHOUT_HOME 2900029 8 false "return from reference without an intermediate point";
    NO_SPINDLE 2900030 8 false "spindle code in a channel without a spindle";
    SUBPROGRAM_MISSING 2900040 12 true "subprogram that is nowhere to be found";
    NESTING 2900041 8 true "subprograms nested too deeply";
    JUMP_TARGET 2900042 12 true "sequence number of a jump is not in the program";
    WAIT_MISMATCH 2900050 12 true "waiting codes that do not match (PS0160)";
    WAIT_ILLEGAL 2900051 12 true "illegal channel list of a waiting code (PS0161)";
    MACRO_SYNTAX 2900060 12 true "macro statement that cannot be read";
    MACRO_DIVISION 2900061 12 true "division by zero in a macro expression";
    MACRO_DOMAIN 2900062 12 true "function argument outside its domain";
    MACRO_VARIABLE 2900063 12 true "variable that does not exist or cannot be written";
    MACRO_LOOP 2900064 12 true "WHILE, DO and END that do not pair";
    MACRO_ALARM 2900065 12 true "alarm raised by the program";
    MACRO_CALL 2900066 12 true "macro call that cannot be made";
    LIMIT_REACHED 2900070 16 false "limit of the job";
    DEADLOCK 2900071 16 false "channels that can never go on";
    CODE_NOT_HERE 2900080 8 false "code of a macro that the machine does not have";
    EXEC_QUEUE 2900081 8 false "too many blocks of EXEC/NEXT waiting";
    MACRO_RESULT 2900082 8 false "value of a wrong type returned by a macro";
    MODAL_STACK 2900083 8 false "modal states restored without being saved, or saved too often";
    EMBEDDED_CODE 2900084 8 false "embedded macro code that cannot be compiled";
    START_ONLY 2900085 4 false "variable set after Machine Startup";
    MACRO_FILES 2900086 8 false "too many or too large files written by macros";
    TOOL_TABLE 2900087 8 false "more tools than the tool table has rows";
    NO_RESTART 2900120 8 false "machine that Machine Shutdown cannot start again";
    PREPROCESSOR_ASKS 2900121 8 false "block for the pre-processor while it asks a macro";
    SIEMENS_TYPE 2900200 12 true "value that does not fit its variable, operator or function";
    SIEMENS_DEFINITION 2900201 12 true "variable that cannot be defined";
    SIEMENS_ARGUMENTS 2900202 12 true "arguments that do not fit the subprogram";
    SIEMENS_FRAME 2900203 8 false "frame that the machine has no words for";
    SIEMENS_ALARM 2900204 4 false "alarm of the program that is only shown";
    SIEMENS_IGNORED 2900205 4 false "part of a statement that is not carried out";
    SIEMENS_FILE 2900206 4 false "definition file that does not exist";
    STATEMENT_UNKNOWN 2900240 8 true "statement of a control that its pre-processor does not understand";
    PARAMETER_UNSET 2900241 4 false "Q parameter that is read before it has a value";
    PATH_NOT_MADE 2900242 8 false "path block of a pre-processor that cannot be made";
    TOOL_NAME 2900243 8 false "tool name without a number";
    SYSTEM_DATA_UNKNOWN 2900244 8 false "system data that the control does not tell";
    PRINT_MASK 2900245 4 false "mask of a print that is not there";
    CYCLE_NOT_CANCELLED 2900090 4 false "cycle that should have been cancelled before";
    NO_CYCLE 2900091 8 false "cycle switched on before any was defined";
    CYCLE_STEPS 2900092 8 false "cycle with too many steps";
    CYCLE_AXIS 2900093 8 false "cycle along an axis that the channel does not have";
    ARC_DIRECTION 2900110 8 false "circle without a direction";
    ARC_HELIX 2900111 8 false "helix on a control without it";
    THREAD_LEAD 2900112 8 false "thread whose lead falls to nothing before its end";
    THREAD_PASSES 2900113 8 false "thread with too many passes";
    PROBE_MISSED 2900114 8 false "probing move that touched nothing";
    FRAME_REFUSED 2900130 8 false "local frame that cannot be";
    FRAME_AXIS 2900131 8 false "local frame that would move an axis the channel does not have";
    ARC_SCALED 2900132 8 false "circle under unequal scales";
    CUTTER_INTERFERENCE 2900133 8 false "tool that does not fit into the contour";
    CUTTER_PLANE 2900134 8 false "cutter compensation without its plane";
    OFFSET_NOT_KEPT 2900135 8 false "offset that the program sets and the control does not keep";
    COOLANT_PRESSURE 2900160 4 false "coolant pressure that is not possible";
    NO_HEAD 2900161 8 false "head that the machine does not have";
    CLAMPED 2900162 8 false "motion of a clamped axis";
    NO_POLAR_AXES 2900163 8 false "polar interpolation without its axes";
    TIP_UNREACHABLE 2900164 8 false "direction of the tool that the rotary axes cannot reach";
    NO_TIP_AXES 2900165 8 false "tool tip control without its axes";
    SECOND_CALL 2900170 8 false "call on a block with another call, a return or an end code";
    TEXT_OF_NO_PROGRAM 2900171 4 false "text of a file that belongs to no program";
    RUNS_INTO_DEFINITION 2900172 4 false "program that runs into the definition behind it";
    OKUMA_UNKNOWN 2900180 8 false "variable or function that nobody knows (Okuma)";
    OKUMA_CONTINUED 2900181 8 false "line that goes on with a block that is not above it (Okuma)";
    UNKNOWN_CODE 2900320 12 true "code that the control does not have";
    UNKNOWN_TEXT 2900321 12 true "address or statement that the control does not know";
    UNKNOWN_MOVES 2900322 8 false "unknown code on a block that moves by the active one";
    ALARM_SOFTENED 2900323 8 false "alarm that is not among the errors of its channel";
    NO_RADIUS 2900324 4 false "compensation by an offset without a radius";
    REFUSED 2900380 12 true "block that a rule of the control refuses";
    MINUS_SIGN 2900381 8 false "negative value at an address that takes none";
    DECIMAL_POINT 2900382 8 false "decimal point at an address that takes none";
    NO_LEAD 2900383 8 false "thread without a lead";
    ARC_INCOMPLETE 2900384 8 false "circle without a centre and without a radius";
    OKUMA_NO_MODAL 2900182 4 false "end of a modal call that was not begun (Okuma)";
    GROUP_TWICE 2900350 4 false "G code overridden by a later one of its group";
    MACHINE_INCREMENTAL 2900351 4 false "machine coordinates in incremental mode";
    CALL_LEVELS 2900352 12 true "more levels of calls than the control has (PS0077)";
    MACRO_LEVELS 2900353 12 true "more levels of macro calls than the control has (PS0122)";
    BRACKETS 2900354 12 true "more levels of brackets than the control has (PS0118)";
    LOOP_ENTERED 2900355 12 true "loop that a jump leads into (PS0124)";
    CALL_G_WORD 2900356 12 true "G word among the arguments of a macro call (PS0129)";
    PRINT_CLOSED 2900358 4 false "printing statement outside of POPEN and PCLOS";
    MACRO_OVERFLOW 2900359 12 true "value beyond the range of numbers (PS0111)";
    CALL_NOT_FIRST 2900357 12 true "words before a macro call (PS0127)";
    SIEMENS_STOP 2900365 12 true "alarm of the program that stops the channel";
    NO_TEETH 2900366 12 true "feed per tooth without the number of teeth";
    OKUMA_ALARM 2900367 12 true "alarm of the user (Okuma)";
    NO_FEED_PER_TURN 2900368 12 true "feed per revolution on a machine without M136";
}

#[cfg(test)]
mod tests {
    use super::ALL;

    #[test]
    fn numbers_are_unique() {
        let mut numbers: Vec<u32> = ALL.iter().map(|f| f.number).collect();
        numbers.sort_unstable();
        let count = numbers.len();
        numbers.dedup();
        assert_eq!(numbers.len(), count);
    }

    #[test]
    fn every_number_has_a_page() {
        let docs = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/diagnostics");
        for facts in ALL {
            let page = docs.join(format!("{:08}.md", facts.number));
            assert!(page.is_file(), "no page for {:08}: {}", facts.number, facts.title);
        }
    }
}
