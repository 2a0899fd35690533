//! The diagnostics of the kernel: stable numbers, severities, and whether the control stops on them.
//!
//! Numbers up to 02 899 999 are those of the emulated system, from 02 900 001 this project's own (reference
//! control-emulator.md 7.5). *Invariant:* every entry has a page `docs/diagnostics/<number, 8 digits>.md` whose head
//! names its word, and no word has two numbers, those of the macro language included.

pub mod language;

mod halt;

pub use halt::{Acted, Halt, StopCode};
use language::TABLE;

/// Facts of one diagnostic number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DiagnosticFacts {
    /// Stable number.
    pub number: u32,
    /// Stable word that people use for the number.
    pub name: &'static str,
    /// 0–3 message, 4–7 warning, 8–15 error, 16–99 fatal.
    pub severity: u8,
    /// A real control stops the channel here (an alarm); whether the machine does: `[control] stops` and `stops` of the
    /// number.
    pub alarm: bool,
    /// Its subject, for the index of the pages.
    pub title: &'static str,
}

macro_rules! diagnostics {
    ($($constant:ident $number:literal $name:literal $severity:literal $alarm:literal $title:literal;)*) => {
        $(#[doc = $title] pub const $constant: DiagnosticFacts = DiagnosticFacts { number: $number, name: $name, severity: $severity, alarm: $alarm, title: $title };)*
        /// Every diagnostic.
        pub const ALL: &[DiagnosticFacts] = &[$($constant),*];
    };
}

diagnostics! {
    NOT_RECOGNISED 2001005 "text-not-recognised" 4 false "text that is in no table of the machine";
    ARC_RADIUS 2007020 "arc-not-possible" 8 false "arc not possible with this radius, centre or end point";
    ARC_PLANE 2007001 "arc-without-plane" 8 false "arc without an active plane";
    POSITION_MODE_UNKNOWN 2008031 "no-positioning-mode" 4 false "neither absolute nor incremental positioning is active";
    DWELL_NOT_POSITIVE 2009002 "dwell-not-positive" 4 false "dwell time zero or negative";
    COMP_ON_RAPID 2018003 "compensation-on-at-rapid" 8 false "cutter compensation started by a rapid move";
    COMP_OFF_RAPID 2018004 "compensation-off-at-rapid" 8 false "cutter compensation cancelled by a rapid move";
    COMP_ON_ARC 2018005 "compensation-on-at-arc" 8 false "cutter compensation started by an arc";
    COMP_OFF_ARC 2018006 "compensation-off-at-arc" 8 false "cutter compensation cancelled by an arc";
    NO_FEED 2019001 "no-feed" 8 false "no feed rate programmed";
    FEED_NOT_POSITIVE 2019002 "feed-not-positive" 8 false "feed rate zero or negative";
    DATA_NOT_USED 2900001 "unused-word" 8 false "unused word";
    NO_ACTION 2900002 "code-without-action" 8 false "code without an action";
    CODE_WITHOUT_PROCESSING 2900003 "code-not-processed" 0 false "code without built-in processing";
    DATA_OUT_OF_RANGE 2900004 "value-out-of-range" 8 false "value out of range";
    DATA_MISSING 2900005 "missing-word" 8 false "required word missing";
    TOO_MANY_DIGITS 2900006 "too-many-digits" 4 false "too many digits for the register";
    DATA_REFUSED 2900007 "word-not-processed" 8 false "required word not processed by the machine definition";
    TAPE_RULE 2900008 "tape-rule-too-slow" 8 false "tape editor rule needs too many steps on a block";
    WORD_TWICE 2900009 "word-twice" 4 false "address written twice in a block";
    COMMENT_OPEN 2900010 "comment-not-closed" 4 false "comment or message not closed";
    NO_REWIND_STOP 2900012 "no-rewind-stop" 0 false "expected rewind-stop missing";
    REWIND_STOP_INSIDE 2900013 "rewind-stop-inside" 4 false "rewind-stop inside the program";
    BLOCK_TOO_LONG 2900014 "block-too-long" 8 true "block longer than the limit";
    BAD_BYTES 2900015 "control-characters" 4 false "control characters in a block";
    NO_PROGRAM_END 2900016 "no-program-end" 4 false "no end code at the end of the program";
    MAIN_RETURN 2900017 "return-in-main-program" 0 false "return code in the main program";
    TOO_MANY_DIAGNOSTICS 2900018 "too-many-diagnostics" 4 false "diagnostic limit of the channel reached";
    FILE_UNREADABLE 2900019 "file-unreadable" 12 true "file of the job not readable";
    ARC_END_OFF 2900020 "arc-end-off-circle" 8 false "arc end point not on the circle";
    SPINDLE_STANDS 2900021 "spindle-stopped" 8 false "feed per revolution with the spindle stopped";
    SPINDLE_CONFLICT 2900022 "spindle-conflict" 4 false "spindle commanded by two channels without a sync point between";
    SPEED_CHANGED 2900690 "speed-changed-during-move" 4 false "spindle speed changed during a move of another channel";
    OVER_TRAVEL 2900023 "over-travel" 8 false "position beyond the travel limits of an axis";
    FUNCTIONS_IGNORED 2900691 "functions-ignored" 0 false "M functions without an effect";
    NO_OFFSET 2900024 "no-offset-value" 4 false "offset number without a value";
    NO_REFERENCE 2900025 "no-reference-point" 8 false "reference point not defined";
    SPINDLE_LIMIT 2900026 "spindle-over-speed" 4 false "spindle speed above the maximum";
    NO_MOTION_MODE 2900027 "no-motion-code" 8 false "axis word without an active motion code";
    AXIS_NOT_IN_CHANNEL 2900028 "axis-not-in-channel" 8 true "axis not in this channel";
    RETURN_WITHOUT_HOME 2900029 "no-intermediate-point" 8 false "return from the reference point without an intermediate point";
    NO_SPINDLE 2900030 "no-spindle" 8 false "spindle code in a channel without a spindle";
    SUBPROGRAM_MISSING 2900040 "subprogram-not-found" 12 true "subprogram not found";
    NESTING 2900041 "subprograms-too-deep" 8 true "subprograms nested too deeply";
    JUMP_TARGET 2900042 "jump-target-not-found" 12 true "jump target not found";
    WAIT_MISMATCH 2900050 "wait-mismatch" 12 true "waiting codes do not match (PS0160)";
    WAIT_ILLEGAL 2900051 "wait-illegal-channels" 12 true "illegal channel list of a waiting code (PS0161)";
    MACRO_SYNTAX 2900060 "statement-syntax" 12 true "syntax error in a macro statement";
    MACRO_DIVISION 2900061 "division-by-zero" 12 true "division by zero in a macro expression";
    MACRO_DOMAIN 2900062 "argument-outside-domain" 12 true "function argument out of its domain";
    MACRO_VARIABLE 2900063 "illegal-variable" 12 true "variable not defined or write-protected";
    MACRO_LOOP 2900064 "loop-not-paired" 12 true "WHILE, DO and END not paired";
    MACRO_ALARM 2900065 "program-alarm" 12 true "alarm raised by the program";
    MACRO_CALL 2900066 "illegal-macro-call" 12 true "illegal macro call";
    LIMIT_REACHED 2900070 "limit-reached" 16 false "job limit reached";
    DEADLOCK 2900071 "deadlock" 16 false "deadlock: channels cannot continue";
    CODE_NOT_HERE 2900080 "code-not-on-machine" 8 false "code of a macro not in the code table";
    EXEC_QUEUE 2900081 "too-many-exec-blocks" 8 false "too many EXEC/NEXT blocks pending";
    MACRO_RESULT 2900082 "macro-result-type" 8 false "wrong type of value returned by a macro";
    MODAL_STACK 2900083 "modal-stack-unbalanced" 8 false "modal states restored without being saved, or saved too often";
    EMBEDDED_CODE 2900084 "embedded-code-invalid" 8 false "embedded macro code not valid";
    START_ONLY 2900085 "startup-only-variable" 4 false "variable can be set during Machine Startup only";
    MACRO_FILES 2900086 "macro-files-limit" 8 false "files written by macros exceed the limit";
    TOOL_TABLE 2900087 "tool-table-full" 8 false "tool table full";
    NO_RESTART 2900120 "restart-not-possible" 8 false "restart by Machine Shutdown not possible";
    PREPROCESSOR_ASKS 2900121 "block-for-busy-preprocessor" 8 false "block issued while the pre-processor waits for a macro";
    SIEMENS_TYPE 2900200 "type-not-compatible" 12 true "type not compatible with the variable, operator or function";
    SIEMENS_DEFINITION 2900201 "illegal-definition" 12 true "illegal variable definition";
    SIEMENS_ARGUMENTS 2900202 "illegal-arguments" 12 true "arguments do not match the subprogram";
    SIEMENS_FRAME 2900203 "frame-not-possible" 8 false "frame cannot be expressed by the machine's codes";
    SIEMENS_ALARM 2900204 "setal-message" 4 false "alarm set by the program, display only";
    SIEMENS_IGNORED 2900205 "statement-part-ignored" 4 false "part of a statement ignored";
    SIEMENS_FILE 2900206 "definition-file-not-found" 4 false "definition file not found";
    SIEMENS_STATE 2900207 "statement-not-possible-here" 12 true "statement not possible here";
    SIEMENS_DEFINITION_LINE 2900208 "definition-left-out" 8 false "line of a definition file left out";
    STATEMENT_UNKNOWN 2900240 "unknown-statement" 8 true "statement not supported by the pre-processor";
    PARAMETER_UNSET 2900241 "parameter-not-set" 4 false "Q parameter read before it has a value";
    PATH_NOT_MADE 2900242 "path-not-possible" 4 false "path that may differ from the path of the control (TNC)";
    TOOL_NAME 2900243 "tool-name-without-number" 8 false "tool name without a number";
    SYSTEM_DATA_UNKNOWN 2900244 "unknown-system-data" 8 false "system data not available";
    PRINT_MASK 2900245 "print-mask-not-found" 4 false "print mask not found";
    CYCLE_NOT_CANCELLED 2900090 "cycle-not-cancelled" 4 false "previous cycle not cancelled";
    NO_CYCLE 2900091 "no-cycle-defined" 8 false "no cycle defined";
    CYCLE_STEPS 2900092 "cycle-too-many-steps" 8 false "too many steps in a cycle";
    CYCLE_AXIS 2900093 "cycle-axis-not-in-channel" 8 false "cycle axis not in this channel";
    ARC_DIRECTION 2900110 "arc-without-direction" 8 false "arc without a direction";
    ARC_HELIX 2900111 "helix-not-available" 8 false "helix not available on this control";
    THREAD_LEAD 2900112 "thread-lead-vanishes" 8 false "thread lead reaches zero before the end";
    THREAD_PASSES 2900113 "thread-too-many-passes" 8 false "too many passes in a thread";
    PROBE_MISSED 2900114 "probe-missed" 8 false "probing move without contact";
    FRAME_REFUSED 2900130 "illegal-local-frame" 8 false "illegal local coordinate system";
    FRAME_AXIS 2900131 "frame-axis-not-in-channel" 8 false "local coordinate system moves an axis that is not in this channel";
    ARC_SCALED 2900132 "arc-with-unequal-scales" 8 false "arc under unequal scale factors";
    CUTTER_INTERFERENCE 2900133 "cutter-interference" 8 false "tool interferes with the contour";
    CYCLE_BESIDE_MOTION 2900640 "cycle-beside-motion" 4 false "canned cycle and motion code in one block";
    CORNER_OVERCUT 2900630 "inside-corner-overcut" 4 false "inside corner cut into because the next move was not known";
    EMPTY_BLOCKS 2900660 "too-many-empty-blocks" 12 true "too many blocks without a move under compensation";
    CYCLE_SPINDLE 2900662 "cycle-without-spindle" 12 true "machining cycle with the spindle off";
    COMPENSATION_TOOL 2900661 "compensation-without-tool" 12 true "compensation without a tool";
    CUTTER_PLANE 2900134 "compensation-without-plane" 8 false "cutter compensation without an active plane";
    OFFSET_NOT_KEPT 2900135 "offset-not-kept" 8 false "offset set by the program not kept";
    COOLANT_PRESSURE 2900160 "illegal-coolant-pressure" 4 false "coolant pressure out of range";
    NO_HEAD 2900161 "no-head" 8 false "head not on this machine";
    CLAMPED 2900162 "axis-clamped" 8 false "motion of a clamped axis";
    NO_POLAR_AXES 2900163 "no-polar-axes" 8 false "axes for polar interpolation missing";
    TIP_UNREACHABLE 2900164 "tool-direction-unreachable" 8 false "tool direction out of reach of the rotary axes";
    NO_TIP_AXES 2900165 "no-tool-tip-axes" 8 false "axes for tool centre point control missing";
    TIP_WORDS_ALONE 2900166 "tool-direction-alone" 8 false "tool direction without tool centre point control";
    TIP_WORDS_MIXED 2900167 "tool-direction-and-angles" 8 false "tool direction and angles of rotary axes in one block";
    NO_CYLINDER 2900168 "no-cylinder" 12 true "cylindrical interpolation without a cylinder (PS0175)";
    ARC_ON_CYLINDER 2900169 "arc-off-the-cylinder" 12 true "circle that is not on the surface of the cylinder";
    SECOND_CALL 2900170 "second-call" 8 false "second call, return or end code in a block with a call";
    TEXT_OF_NO_PROGRAM 2900171 "text-outside-program" 4 false "text outside of any program";
    RUNS_INTO_DEFINITION 2900172 "runs-into-definition" 4 false "program runs into the next program definition";
    PLANE_UNDEFINED 2900173 "tilted-plane-undefined" 12 true "tilted plane not defined by the block";
    PLANE_UNREACHABLE 2900174 "tilted-plane-unreachable" 12 true "tilted plane out of reach of the rotary axes";
    OKUMA_UNKNOWN 2900180 "unknown-okuma-name" 8 false "unknown variable or function (Okuma)";
    CODE_NEEDS 2900501 "code-needs-word" 12 true "required word of a code missing";
    WORK_AREA 2900500 "working-area" 12 true "position beyond the working area of the program";
    OKUMA_CONTINUED 2900181 "continuation-without-block" 8 false "continuation line without a block above it (Okuma)";
    UNKNOWN_CODE 2900320 "unknown-code" 12 true "unknown code";
    UNKNOWN_TEXT 2900321 "unknown-text" 12 true "unknown address or statement";
    UNKNOWN_MOVES 2900322 "unknown-code-moves" 8 false "unknown code ignored in a block that moves";
    ALARM_SOFTENED 2900323 "alarm-softened" 8 false "alarm with reduced severity";
    NO_RADIUS 2900324 "no-tool-radius" 4 false "compensation with an offset without a radius";
    VARIABLE_VALUE 2900460 "variable-value" 12 true "value not possible for a system variable (PS0032)";
    DATA_BLOCKS 2900461 "data-blocks-passed" 4 false "data blocks of the program not kept";
    REFUSED 2900380 "block-refused" 12 true "block refused by a rule of the control";
    MINUS_SIGN 2900381 "negative-value" 8 false "negative value not allowed at this address";
    DECIMAL_POINT 2900382 "illegal-decimal-point" 8 false "decimal point not allowed at this address";
    NO_LEAD 2900383 "no-thread-lead" 8 false "thread without a lead";
    CHANNEL_RESET 2900370 "channel-reset" 12 true "channel reset by the operator";
    WAIT_IMPOSSIBLE 2900385 "wait-impossible" 12 true "wait, signal or release not possible";
    WAIT_LISTS 2900386 "wait-lists" 4 false "channels name different partners at one mark (16949)";
    STATEMENT_ARGUMENTS 2900387 "illegal-mark-or-channel" 12 true "mark or channel of a statement not possible";
    CHANNEL_NOT_STARTED 2900388 "channel-not-started" 12 true "program of a channel cannot be selected or started";
    AXIS_NOT_HELD 2900389 "axis-not-held" 12 true "axis that another channel holds, or none";
    CORNER_ALONE 2900395 "corner-without-next-line" 8 false "corner without a line after it";
    CORNER_NEXT 2900396 "corner-before-other-move" 8 false "corner before a move that has none";
    CORNER_TWICE 2900397 "corner-twice" 8 false "two corners in one block";
    CORNER_TAPER 2900398 "corner-of-taper" 8 false "corner of axis-parallel lines at a taper";
    CORNER_TOO_LONG 2900399 "corner-too-large" 8 false "corner larger than its lines";
    LINE_WITHOUT_END 2900400 "line-without-end" 8 false "line by its angle without an end point";
    LINE_NOT_COMPUTED 2900401 "line-not-computed" 8 false "end of a line not given by its angle";
    CORNER_AT_COMPENSATION 2900402 "corner-at-compensation-switch" 8 false "corner where compensation starts or ends";
    TANGENT_IMPOSSIBLE 2900403 "tangent-impossible" 8 false "circle in the direction of the last move not possible";
    CORNER_REFUSED 2900404 "corner-not-possible" 8 false "corner or angle word that cannot act";
    CONTOUR_RANGE 2900405 "contour-numbers-missing" 8 true "turning cycle without the numbers of its contour blocks";
    CONTOUR_DEPTH 2900406 "contour-depth" 8 true "depth of a turning cycle zero or negative";
    CONTOUR_BLOCKS 2900407 "contour-blocks-not-found" 8 true "contour blocks of a turning cycle not found";
    CONTOUR_BACK 2900408 "contour-turns-back" 8 true "contour of a turning cycle turns back along the cut";
    CONTOUR_FIRST 2900409 "contour-first-block" 8 true "first contour block without a straight move";
    CONTOUR_CODE 2900410 "contour-code" 8 true "code not possible in a contour";
    CONTOUR_BEYOND 2900411 "contour-beyond-start" 8 true "contour reaches beyond the start of the cycle";
    PECK_STEP 2900412 "peck-step-negative" 8 true "peck or shift of a turning cycle negative";
    CONTOUR_REPEATS 2900413 "contour-repeats" 8 true "number of repetitions of a contour zero or negative";
    CONTOUR_APPROACH 2900414 "contour-approach" 12 true "approach to a contour or retraction from it not possible";
    TAP_SPEED 2900642 "rigid-tap-without-speed" 8 true "rigid tap without a speed";
    NOSE_ANGLE 2900641 "nose-angle" 8 true "nose angle that the control does not have";
    THREAD_AMOUNTS 2900480 "thread-amounts" 8 true "allowance or smallest cut greater than the height of the thread";
    PROGRAM_TWICE 2900590 "program-twice" 4 false "program number twice in one file";
    SEPARATE_VARIABLE 2900481 "separate-variable" 4 false "variable that only another channel writes";
    STORED_LIMIT 2900482 "stored-limit" 8 true "move into a forbidden area, or out of the allowed one";
    COUNT_WITHOUT_PARTNER 2900420 "count-without-partner" 4 false "counted wait without a partner";
    SHARED_RACE 2900440 "shared-variable-race" 4 false "shared variable reached by two channels in no fixed order";
    LINT_LOST 2900441 "lint-ends-early" 4 false "waits of a channel judged up to a block only";
    LINT_TARGET 2900442 "lint-jump-target" 8 false "jump in a condition to a block that is not there";
    LINT_UNREADABLE 2900443 "lint-unreadable" 12 true "block that the control cannot read";
    LINT_ORDER 2900444 "lint-order" 4 false "outcome of waits that depends on who comes first";
    LINT_MACROS 2900445 "lint-macros" 0 false "macros of the machine not executed";
    LINT_LOOPS 2900446 "lint-loops" 0 false "loops without waits taken to end";
    SIGNALS_FULL 2900435 "signals-full" 12 true "more signals and waits than the control can keep (250001)";
    SIGNAL_STATEMENT 2900436 "signal-statement" 12 true "statement of signals that is not possible (ISG)";
    SIGNAL_ORDER 2900437 "signal-order" 4 false "wait for a signal before an older one of the same channel (250002)";
    EXTERNAL_VARIABLE 2900438 "external-variable" 12 true "external variable not there, or not accessible so (ISG)";
    SIGNAL_VALUE 2900439 "signal-values" 12 true "values of a signal that are not taken over (21549)";
    NOT_AT_REFERENCE 2900490 "not-at-reference" 12 true "axis not at its reference point (PS0092)";
    FIGURE_NESTED 2900491 "figure-nested" 12 true "figure copy nested in a copy of the same kind (PS0900, PS0901)";
    MEASURE_ASSUMED 2900492 "measuring-assumed" 4 false "tool measurement assumed to confirm the offset";
    BALANCE_ILLEGAL 2900421 "balance-cut-illegal" 12 true "balance cutting commanded wrongly (PS0163)";
    COUPLING_ILLEGAL 2900447 "axis-coupling-illegal" 12 true "axes coupled wrongly (PS5339, PS0352, PS0357, PS0362)";
    COUPLED_AXIS 2900448 "coupled-axis-moved" 12 true "move that a coupled axis cannot make (PS0353, PS0363, PS0364)";
    CYCLE_REFUSED 2900450 "cycle-refused" 12 true "cycle that the control refuses";
    OKUMA_DRAWING 2900451 "drawing-ignored" 0 false "statements for the screen that change neither path nor time (Okuma)";
    OKUMA_BLANK 2900452 "blank-ignored" 4 false "shape of the blank before a contour that the cycle ignores (Okuma)";
    OKUMA_WORD 2900510 "word-of-another-machine" 12 true "word that belongs to equipment this machine does not have (Okuma)";
    PATH_REFUSED 2900512 "path-refused" 12 true "path block that cannot be made (TNC)";
    OKUMA_UNREAD 2900511 "variable-never-read" 4 false "local variable set next to other words and never read (Okuma)";
    ARC_STRAIGHT 2900462 "arc-is-straight" 4 false "arc without a centre or radius that is a straight line";
    ARC_INCOMPLETE 2900384 "arc-incomplete" 8 false "arc without a centre or radius";
    AXIS_WORD_OWNED 2900520 "axis-word-not-taken" 8 false "axis word that the code of the block does not take";
    FREE_CONTOUR 2900652 "free-contour-not-determined" 8 true "element of a free contour not determined";
    SPINDLE_FOLLOWS 2900654 "spindle-follows" 4 false "command for a following spindle";
    SPINDLE_COUPLING 2900655 "spindle-coupling-illegal" 12 true "spindles cannot be coupled";
    CHUCK_SPEED 2900656 "chuck-at-other-speed" 12 true "chucks hold a part at different speeds";
    CHUCK_PHASE 2900657 "chuck-without-phase" 12 true "chuck closes on a turning part out of phase";
    PART_NOT_HELD 2900658 "part-not-held" 12 true "no chuck holds the part";
    CHUCK_NOT_OPEN 2900659 "chuck-not-open" 12 true "sub-spindle fed against the part with its chuck closed";
    SLIDE_HELD 2900673 "slide-with-held-part" 12 true "sub-spindle moved while both chucks hold the part";
    FIXED_STOP_UNKNOWN 2900674 "fixed-stop-unknown" 12 true "position of a fixed stop is not known";
    FIXED_STOP_MISSED 2900675 "fixed-stop-missed" 12 true "move to a fixed stop did not meet the stop";
    FIXED_STOP_KIND 2900676 "fixed-stop-not-at-feed" 12 true "move past a fixed stop is not a straight feed move";
    PART_DATA_UNIT 2900653 "part-data-unit" 4 false "data of the part may be in the other unit";
    REPEATS_NOT_WHOLE 2900651 "repeats-not-whole" 4 false "number of repeats is not whole";
    MODAL_CALL_OPEN 2900650 "modal-call-open" 8 true "modal call not cancelled";
    OKUMA_NO_MODAL 2900182 "no-modal-call" 4 false "no modal call active (Okuma)";
    GROUP_TWICE 2900350 "group-twice" 4 false "G code overridden by a later one of the same group";
    MACHINE_INCREMENTAL 2900351 "machine-coordinates-incremental" 4 false "machine coordinates in incremental mode";
    CALL_LEVELS 2900352 "too-many-call-levels" 12 true "too many call levels (PS0077)";
    MACRO_LEVELS 2900353 "too-many-macro-levels" 12 true "too many macro call levels (PS0122)";
    BRACKETS 2900354 "too-many-bracket-levels" 12 true "too many bracket levels (PS0118)";
    LOOP_ENTERED 2900355 "jump-into-loop" 12 true "jump into a loop (PS0124)";
    CALL_G_WORD 2900356 "g-code-as-argument" 12 true "G word as an argument of a macro call (PS0129)";
    PRINT_CLOSED 2900358 "print-not-open" 4 false "print statement outside POPEN and PCLOS";
    MACRO_OVERFLOW 2900359 "number-overflow" 12 true "numeric overflow (PS0111)";
    CALL_NOT_FIRST 2900357 "macro-call-not-first" 12 true "macro call not first in the block (PS0127)";
    SIEMENS_STOP 2900365 "setal-alarm" 12 true "alarm set by the program";
    NO_TEETH 2900366 "no-teeth" 12 true "number of teeth unknown for feed per tooth";
    OKUMA_ALARM 2900367 "user-alarm" 12 true "user alarm (Okuma)";
    NOT_UTF8 2900540 "not-utf-text" 4 false "program text is not valid UTF-8";
    NO_FEED_PER_TURN 2900368 "no-feed-per-revolution" 12 true "feed per revolution on a machine without M136";

    LONG_DWELL 2900570 "long-dwell" 4 false "dwell longer than an hour";
    LONG_MOVE 2900671 "long-move" 4 false "move at feed longer than an hour";
    THREAD_RATE 2900571 "thread-above-rate" 4 false "thread faster than its axis";
    NO_NEXT_BLOCK 2900670 "no-next-block" 4 false "command for the next block after the program";
    FEED_RATE 2900680 "feed-above-rates" 4 false "feed above the rate of every axis";
    SPINDLE_OFF 2900681 "feed-without-spindle" 4 false "move at feed while the spindle is off";
    SPEED_OF_FUNCTION 2900672 "speed-beside-function" 12 true "speed beside a function that may turn another spindle";
    UNIT_NOT_NAMED 2900682 "unit-not-named" 4 false "program looks like inches and names no unit";
    SENDER_LINE 2900710 "line-for-sender" 4 false "line for the sender of the program";
    VALUE_WITHHELD 2900530 "value-withheld" 4 false "value removed by a data macro";
}

/// The word of a number, `None` for numbers that only a machine or its macros have.
#[must_use]
pub fn name(number: u32) -> Option<&'static str> {
    let own = ALL.iter().find(|facts| facts.number == number).map(|facts| facts.name);
    own.or_else(|| TABLE.iter().find(|row| row.number.0 == number).map(|row| row.name))
}

/// The severity of a diagnostic unless the machine changes it.
#[must_use]
pub fn severity(number: u32) -> Option<u8> {
    let own = ALL.iter().find(|facts| facts.number == number).map(|facts| facts.severity);
    own.or_else(|| TABLE.iter().find(|row| row.number.0 == number).map(|row| row.severity))
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
