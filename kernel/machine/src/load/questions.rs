//! The questions about a control, and the identifiers that an answer names.
//!
//! Invariant: every identifier here is built in, and docs/machine-definition.md lists every key. Facts: reference
//! control-emulator.md 1.1, 1.5, 1.7.

/// Conversion of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AnswerConversion {
    /// Code rows of the words.
    Code(&'static str),
    /// Code rows that hand their value over.
    AsData(&'static str, &'static str),
    /// The same; the first word of a range hands over 1.
    Numbered(&'static str, &'static str),
    /// Data rows of the registers, for each of the identifiers.
    Data(&'static [&'static str]),
}

/// A question.
#[derive(Debug)]
pub(super) struct ControlQuestion {
    /// Key.
    pub(super) key: &'static str,
    /// The use of the answer.
    pub(super) kind: AnswerConversion,
}

/// Questions about one subject.
#[derive(Debug)]
pub(super) struct QuestionSubject {
    /// Key of its table.
    pub(super) key: &'static str,
    /// Title for findings.
    pub(super) title: &'static str,
    /// Its questions.
    pub(super) questions: &'static [ControlQuestion],
}

const fn code(key: &'static str, id: &'static str) -> ControlQuestion {
    ControlQuestion { key, kind: AnswerConversion::Code(id) }
}

const fn as_data(key: &'static str, id: &'static str, data: &'static str) -> ControlQuestion {
    ControlQuestion { key, kind: AnswerConversion::AsData(id, data) }
}

const fn numbered(key: &'static str, id: &'static str, data: &'static str) -> ControlQuestion {
    ControlQuestion { key, kind: AnswerConversion::Numbered(id, data) }
}

const fn data(key: &'static str, ids: &'static [&'static str]) -> ControlQuestion {
    ControlQuestion { key, kind: AnswerConversion::Data(ids) }
}

/// All questions.
pub(super) const SUBJECTS: &[QuestionSubject] = &[
    QuestionSubject {
        key: "motion",
        title: "[questionnaire.motion]",
        questions: &[
            code("rapid", "CODE_RAPID"),
            code("linear", "CODE_INTERP_LINEAR"),
            code("linear_10", "CODE_INTERP_LINEAR_X10"),
            code("linear_100", "CODE_INTERP_LINEAR_X100"),
            code("arc_clockwise", "CODE_INTERP_ARC_CLW"),
            code("arc_counterclockwise", "CODE_INTERP_ARC_CCLW"),
            code("helix_clockwise", "CODE_INTERP_HELIX_CLW"),
            code("helix_counterclockwise", "CODE_INTERP_HELIX_CCLW"),
            code("arc_space", "CODE_INTERP_ARC_3D"),
            code("thread", "CODE_INTERP_THREAD"),
            code("thread_changing", "CODE_INTERP_THREAD_VAR"),
            code("thread_growing", "CODE_INTERP_THREAD_VAR_INC"),
            code("thread_shrinking", "CODE_INTERP_THREAD_VAR_DEC"),
            code("thread_on", "CODE_INTERP_THREAD_ON"),
            code("thread_off", "CODE_INTERP_THREAD_OFF"),
            code("probe", "CODE_INTERP_SKIP"),
            code("probe_alarm", "CODE_SKIP_ALARM_SIGNAL"),
            code("probe_silent", "CODE_SKIP_ALARM_SILENT"),
            code("dwell", "CODE_DELAY"),
            code("dwell_revolutions", "CODE_DELAY_REV"),
            code("exact_stop", "CODE_EXACTSTOP"),
            code("exact_stop_on", "CODE_EXACTSTOP_ON"),
            code("exact_stop_off", "CODE_EXACTSTOP_OFF"),
            code("machine_frame", "CODE_POSITION_MACHINE"),
            code("preset", "CODE_POSITION_PRESET"),
        ],
    },
    QuestionSubject {
        key: "planes",
        title: "[questionnaire.planes]",
        questions: &[code("xy", "CODE_PLANE_XY"), code("zx", "CODE_PLANE_ZX"), code("yz", "CODE_PLANE_YZ")],
    },
    QuestionSubject {
        key: "position",
        title: "[questionnaire.position]",
        questions: &[
            code("absolute", "CODE_POSITION_ABSOLUTE"),
            code("incremental", "CODE_POSITION_RELATIVE"),
            code("diameter", "CODE_XAXIS_DIAMETER"),
            code("radius", "CODE_XAXIS_RADIUS"),
        ],
    },
    QuestionSubject {
        key: "feed",
        title: "[questionnaire.feed]",
        questions: &[
            code("per_minute", "CODE_FEED_UPM"),
            code("per_revolution", "CODE_FEED_UPR"),
            code("inverse_time", "CODE_FEED_1T"),
        ],
    },
    QuestionSubject {
        key: "units",
        title: "[questionnaire.units]",
        questions: &[code("primary", "CODE_UNITS_PRIMARY"), code("secondary", "CODE_UNITS_SECONDARY")],
    },
    QuestionSubject {
        key: "spindle",
        title: "[questionnaire.spindle]",
        questions: &[
            code("clockwise", "CODE_SPINDLE_CLW"),
            code("counterclockwise", "CODE_SPINDLE_CCLW"),
            code("off", "CODE_SPINDLE_OFF"),
            code("orient", "CODE_SPINDLE_ORIENT"),
            code("surface_speed", "CODE_SPINDLE_CSS"),
            code("speed", "CODE_SPINDLE_RPM"),
            code("limit", "CODE_SPINDLE_MAXRPM"),
            code("surface_main", "CODE_SPINDLE_CSS_MAIN"),
            code("surface_side", "CODE_SPINDLE_CSS_SIDE"),
        ],
    },
    QuestionSubject {
        key: "coolant",
        title: "[questionnaire.coolant]",
        questions: &[
            code("on", "CODE_COOLANT_ON"),
            code("mist", "CODE_COOLANT_MIST"),
            code("flood", "CODE_COOLANT_FLOOD"),
            code("through", "CODE_COOLANT_THRU"),
            code("off", "CODE_COOLANT_OFF"),
        ],
    },
    QuestionSubject {
        key: "tool",
        title: "[questionnaire.tool]",
        questions: &[
            as_data("select", "CODE_TOOL_SELECT", "REG_TOOL"),
            code("change", "CODE_TOOL_LOAD"),
            as_data("load", "CODE_TOOL_LOAD", "REG_TOOL"),
        ],
    },
    QuestionSubject {
        key: "compensation",
        title: "[questionnaire.compensation]",
        questions: &[
            code("left", "CODE_COMP_DIAM_LEFT"),
            code("right", "CODE_COMP_DIAM_RIGHT"),
            code("off", "CODE_COMP_DIAM_OFF"),
            code("length", "CODE_COMP_LENGTH_ON"),
            code("length_negative", "CODE_COMP_LENGTH_ON_NEG"),
            code("length_off", "CODE_COMP_LENGTH_OFF"),
        ],
    },
    QuestionSubject {
        key: "offsets",
        title: "[questionnaire.offsets]",
        questions: &[
            numbered("work", "CODE_COMP_WORKP_ON", "REG_COMP_WORKP"),
            code("work_off", "CODE_COMP_WORKP_OFF"),
            code("extended", "CODE_COMP_EXTFIXT"),
        ],
    },
    QuestionSubject {
        key: "frames",
        title: "[questionnaire.frames]",
        questions: &[
            code("translate", "CODE_LCS_TRANSLATE_ON"),
            code("translate_add", "CODE_LCS_TRANSLATE_ADD"),
            code("translate_off", "CODE_LCS_TRANSLATE_OFF"),
            code("rotate", "CODE_LCS_ROTATE_ON"),
            code("rotate_add", "CODE_LCS_ROTATE_ADD"),
            code("rotate_off", "CODE_LCS_ROTATE_OFF"),
            code("scale", "CODE_LCS_SCALE_ON"),
            code("scale_add", "CODE_LCS_SCALE_ADD"),
            code("scale_off", "CODE_LCS_SCALE_OFF"),
            code("mirror", "CODE_LCS_MIRROR_ON"),
            code("mirror_add", "CODE_LCS_MIRROR_ADD"),
            code("mirror_off", "CODE_LCS_MIRROR_OFF"),
            code("polar", "CODE_C2P_CART_ON"),
            code("polar_off", "CODE_C2P_CART_OFF"),
            code("tip", "CODE_RTCP_ON"),
            code("tip_off", "CODE_RTCP_OFF"),
        ],
    },
    QuestionSubject {
        key: "cycles",
        title: "[questionnaire.cycles]",
        questions: &[
            code("drill", "CODE_CYCLE_DRILL"),
            code("drill_dwell", "CODE_CYCLE_DRILL_DWELL"),
            code("deep", "CODE_CYCLE_DEEP"),
            code("chip_break", "CODE_CYCLE_BRKCHP"),
            code("tap", "CODE_CYCLE_TAP"),
            code("tap_left", "CODE_CYCLE_TAP_CCLW"),
            code("bore", "CODE_CYCLE_BORE"),
            code("bore_dwell", "CODE_CYCLE_BORE_DWELL"),
            code("bore_orient", "CODE_CYCLE_BORE_ORIENT"),
            code("bore_back", "CODE_CYCLE_BORE_BACK"),
            code("ream", "CODE_CYCLE_REAM"),
            code("ream_dwell", "CODE_CYCLE_REAM_DWELL"),
            code("through", "CODE_CYCLE_THRU"),
            code("rigid", "CODE_CYCLE_RIGID"),
            code("rigid_left", "CODE_CYCLE_RIGID_CCLW"),
            code("rigid_on", "CODE_RIGID_ON"),
            code("rigid_off", "CODE_RIGID_OFF"),
            code("activate", "CODE_CYCLE_ON"),
            code("off", "CODE_CYCLE_OFF"),
            code("retract_initial", "CODE_CYCLE_RETRACT_INITIAL"),
            code("retract_r", "CODE_CYCLE_RETRACT_R"),
        ],
    },
    QuestionSubject {
        key: "threads",
        title: "[questionnaire.threads]",
        questions: &[
            code("single", "CODE_THREAD_SINGLE"),
            code("single_face", "CODE_THREAD_SINGLE_FACE"),
            code("multi", "CODE_THREAD_MULTI"),
            code("multi_face", "CODE_THREAD_MULTI_FACE"),
            code("off", "CODE_THREAD_OFF"),
            code("chamfer_on", "CODE_THREAD_CHAMFER_ON"),
            code("chamfer_off", "CODE_THREAD_CHAMFER_OFF"),
            code("one_edge", "CODE_THREAD_EDGE_SINGLE"),
            code("both_edges", "CODE_THREAD_EDGE_ZIGZAG"),
            code("same_amount", "CODE_THREAD_STEP_AMOUNT"),
            code("same_step", "CODE_THREAD_STEP_DEPTH"),
        ],
    },
    QuestionSubject {
        key: "home",
        title: "[questionnaire.home]",
        questions: &[
            code("first", "CODE_GOHOME"),
            code("further", "CODE_GOHOME_NTH"),
            code("back", "CODE_GOHOME_RETURN"),
            code("tool_change", "CODE_TOOL_LOAD_POINT"),
            code("tool_change_back", "CODE_TOOL_LOAD_RETURN"),
        ],
    },
    QuestionSubject {
        key: "subprograms",
        title: "[questionnaire.subprograms]",
        questions: &[
            code("call", "CODE_CALSUB_ID"),
            code("call_range", "CODE_CALSUB_RANGE"),
            code("return", "CODE_CALSUB_RETURN"),
        ],
    },
    QuestionSubject {
        key: "stop",
        title: "[questionnaire.stop]",
        questions: &[
            code("program", "CODE_STOP"),
            code("optional", "CODE_OPSTOP"),
            code("end", "CODE_END"),
            code("rewind", "CODE_REWIND"),
        ],
    },
    QuestionSubject {
        key: "heads",
        title: "[questionnaire.heads]",
        questions: &[code("main", "CODE_HEAD_MAIN"), code("side", "CODE_HEAD_SIDE"), code("number", "CODE_HEAD_ID")],
    },
    QuestionSubject {
        key: "sync",
        title: "[questionnaire.sync]",
        questions: &[as_data("wait", "CODE_SYNC_REG", "REG_SYNC"), data("channels", &["REG_SYNC_PATHS"])],
    },
    QuestionSubject {
        key: "words",
        title: "[questionnaire.words]",
        questions: &[
            data("definition", &["REG_DEFSUB_ID"]),
            data("sequence", &["REG_SEQNO"]),
            data("x", &["REG_AXIS_X"]),
            data("y", &["REG_AXIS_Y"]),
            data("z", &["REG_AXIS_Z"]),
            data("u", &["REG_AXIS_U"]),
            data("v", &["REG_AXIS_V"]),
            data("w", &["REG_AXIS_W"]),
            data("a", &["REG_AXIS_AT"]),
            data("b", &["REG_AXIS_BT"]),
            data("c", &["REG_AXIS_CT"]),
            data("center_x", &["REG_ARC_CENTER_X"]),
            data("center_y", &["REG_ARC_CENTER_Y"]),
            data("center_z", &["REG_ARC_CENTER_Z"]),
            data("arc_radius", &["REG_ARC_RADIUS"]),
            data("feed", &["REG_FEED_UPM", "REG_FEED_UPR", "REG_FEED_1T"]),
            data("lead", &["REG_INTERP_THREAD_PITCH"]),
            data("speed", &["REG_SPINDLE_RPM", "REG_SPINDLE_CSS"]),
            data("speed_limit", &["REG_SPINDLE_RPM_MAX"]),
            data("orient_angle", &["REG_SPINDLE_ORIENT"]),
            data("dwell", &["REG_DELAY"]),
            data("dwell_revolutions", &["REG_DELAY_REV"]),
            data("tool", &["REG_TOOL"]),
            data("length_offset", &["REG_COMP_LENGTH"]),
            data("cutter_offset", &["REG_COMP_DIAM"]),
            data("reference", &["REG_GOHOME_NTH"]),
            data("head", &["REG_HEAD_ID"]),
            data("called", &["REG_CALSUB_ID"]),
            data("repeat", &["REG_CALSUB_REPEAT"]),
            data("range_first", &["REG_CALSUB_BLOCK_START"]),
            data("range_last", &["REG_CALSUB_BLOCK_END"]),
            data("range_repeat", &["REG_RANGE_REPEAT"]),
            data("clearance", &["REG_CYCLE_CLEAR"]),
            data("cycle_dwell", &["REG_CYCLE_DWELL"]),
            data("cycle_step", &["REG_CYCLE_STEP"]),
            data("cycle_step_decrement", &["REG_CYCLE_STEP_DECR"]),
            data("cycle_return", &["REG_CYCLE_RETRACT"]),
            data("cycle_bottom", &["REG_CYCLE_BOTTOM"]),
            data("cycle_shift", &["REG_CYCLE_BORE_JOG"]),
            data("cycle_repeat", &["REG_CYCLE_REPEAT"]),
        ],
    },
];
