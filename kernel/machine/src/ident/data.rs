//! All data identifiers and whether a built-in action takes them.
//!
//! Facts: reference data-identifiers.tsv; the rows after them are this project's own.

use super::{DataFacts, DataId};

/// Facts of every identifier, indexed by `DataId`.
pub const TABLE: &[DataFacts] = &[
    DataFacts { name: "REG_AIR", built_in: false, own: false },
    DataFacts { name: "REG_AM", built_in: true, own: false },
    DataFacts { name: "REG_ARC_3D_POINT_X", built_in: true, own: false },
    DataFacts { name: "REG_ARC_3D_POINT_Y", built_in: true, own: false },
    DataFacts { name: "REG_ARC_3D_POINT_Z", built_in: true, own: false },
    DataFacts { name: "REG_ARC_ANGLE", built_in: true, own: false },
    DataFacts { name: "REG_ARC_CENTER_U", built_in: false, own: false },
    DataFacts { name: "REG_ARC_CENTER_V", built_in: false, own: false },
    DataFacts { name: "REG_ARC_CENTER_W", built_in: false, own: false },
    DataFacts { name: "REG_ARC_CENTER_X", built_in: true, own: false },
    DataFacts { name: "REG_ARC_CENTER_Y", built_in: true, own: false },
    DataFacts { name: "REG_ARC_CENTER_Z", built_in: true, own: false },
    DataFacts { name: "REG_ARC_RADIUS", built_in: true, own: false },
    DataFacts { name: "REG_ARC_RADIUS_UPPER", built_in: false, own: false },
    DataFacts { name: "REG_ARC_TURNS", built_in: true, own: false },
    DataFacts { name: "REG_AXIS_AH", built_in: true, own: false },
    DataFacts { name: "REG_AXIS_AT", built_in: true, own: false },
    DataFacts { name: "REG_AXIS_BH", built_in: true, own: false },
    DataFacts { name: "REG_AXIS_BT", built_in: true, own: false },
    DataFacts { name: "REG_AXIS_CH", built_in: true, own: false },
    DataFacts { name: "REG_AXIS_CT", built_in: true, own: false },
    DataFacts { name: "REG_AXIS_CT2", built_in: true, own: false },
    DataFacts { name: "REG_AXIS_E", built_in: true, own: false },
    DataFacts { name: "REG_AXIS_N", built_in: true, own: false },
    DataFacts { name: "REG_AXIS_N2", built_in: true, own: false },
    DataFacts { name: "REG_AXIS_Q", built_in: false, own: false },
    DataFacts { name: "REG_AXIS_R", built_in: false, own: false },
    DataFacts { name: "REG_AXIS_U", built_in: true, own: false },
    DataFacts { name: "REG_AXIS_V", built_in: true, own: false },
    DataFacts { name: "REG_AXIS_W", built_in: true, own: false },
    DataFacts { name: "REG_AXIS_X", built_in: true, own: false },
    DataFacts { name: "REG_AXIS_Y", built_in: true, own: false },
    DataFacts { name: "REG_AXIS_Z", built_in: true, own: false },
    DataFacts { name: "REG_C2P_INTERP_PLRX", built_in: true, own: false },
    DataFacts { name: "REG_C2P_INTERP_PLRY", built_in: false, own: false },
    DataFacts { name: "REG_C2P_INTERP_X", built_in: true, own: false },
    DataFacts { name: "REG_C2P_INTERP_Y", built_in: true, own: false },
    DataFacts { name: "REG_C2P_INTERP_Z", built_in: false, own: false },
    DataFacts { name: "REG_C2P_TRANSL_X", built_in: false, own: false },
    DataFacts { name: "REG_C2P_TRANSL_Y", built_in: false, own: false },
    DataFacts { name: "REG_CALSUB_BLOCK_END", built_in: true, own: false },
    DataFacts { name: "REG_CALSUB_BLOCK_START", built_in: true, own: false },
    DataFacts { name: "REG_CALSUB_ID", built_in: true, own: false },
    DataFacts { name: "REG_CALSUB_OTHER", built_in: false, own: false },
    DataFacts { name: "REG_CALSUB_PARAM", built_in: false, own: false },
    DataFacts { name: "REG_CALSUB_REPEAT", built_in: true, own: false },
    DataFacts { name: "REG_COMP_DIAM", built_in: true, own: false },
    DataFacts { name: "REG_COMP_DIAM_P", built_in: true, own: false },
    DataFacts { name: "REG_COMP_DIAM_Q", built_in: true, own: false },
    DataFacts { name: "REG_COMP_DIAM_R", built_in: true, own: false },
    DataFacts { name: "REG_COMP_EXTFIXT_RANGE", built_in: true, own: false },
    DataFacts { name: "REG_COMP_EXTFIXT_REG", built_in: true, own: false },
    DataFacts { name: "REG_COMP_LENGTH", built_in: true, own: false },
    DataFacts { name: "REG_COMP_WORKP", built_in: true, own: false },
    DataFacts { name: "REG_COOLANT_PRESSURE", built_in: true, own: false },
    DataFacts { name: "REG_CYCLE_BORE_JOG", built_in: true, own: false },
    DataFacts { name: "REG_CYCLE_BORE_JOG_X", built_in: true, own: false },
    DataFacts { name: "REG_CYCLE_BORE_JOG_Y", built_in: true, own: false },
    DataFacts { name: "REG_CYCLE_BORE_JOG_Z", built_in: true, own: false },
    DataFacts { name: "REG_CYCLE_BOTTOM", built_in: true, own: false },
    DataFacts { name: "REG_CYCLE_CLEAR", built_in: true, own: false },
    DataFacts { name: "REG_CYCLE_DEPTH_E", built_in: false, own: false },
    DataFacts { name: "REG_CYCLE_DEPTH_X", built_in: true, own: false },
    DataFacts { name: "REG_CYCLE_DEPTH_Y", built_in: true, own: false },
    DataFacts { name: "REG_CYCLE_DEPTH_Z", built_in: true, own: false },
    DataFacts { name: "REG_CYCLE_DWELL", built_in: true, own: false },
    DataFacts { name: "REG_CYCLE_ORIENT", built_in: true, own: false },
    DataFacts { name: "REG_CYCLE_RETRACT", built_in: true, own: false },
    DataFacts { name: "REG_CYCLE_RIGID_ORIENT", built_in: true, own: false },
    DataFacts { name: "REG_CYCLE_STEP_BACK", built_in: true, own: false },
    DataFacts { name: "REG_CYCLE_TAP_TYPE", built_in: true, own: false },
    DataFacts { name: "REG_CYCLE_TPU", built_in: true, own: false },
    DataFacts { name: "REG_CYCLE_UPM", built_in: true, own: false },
    DataFacts { name: "REG_CYCLE_UPR", built_in: true, own: false },
    DataFacts { name: "REG_DEFSUB_ID", built_in: true, own: false },
    DataFacts { name: "REG_DEFSUB_OTHER", built_in: false, own: false },
    DataFacts { name: "REG_DEFSUB_PARAM", built_in: false, own: false },
    DataFacts { name: "REG_DELAY", built_in: true, own: false },
    DataFacts { name: "REG_DELAY_REV", built_in: true, own: false },
    DataFacts { name: "REG_DPM", built_in: false, own: false },
    DataFacts { name: "REG_FEED_1T", built_in: true, own: false },
    DataFacts { name: "REG_FEED_UPM", built_in: true, own: false },
    DataFacts { name: "REG_FEED_UPM_MAX", built_in: false, own: false },
    DataFacts { name: "REG_FEED_UPR", built_in: true, own: false },
    DataFacts { name: "REG_G", built_in: false, own: false },
    DataFacts { name: "REG_HEAD", built_in: false, own: false },
    DataFacts { name: "REG_HEAD_ID", built_in: true, own: false },
    DataFacts { name: "REG_INTERP_THREAD_ANGLE", built_in: true, own: false },
    DataFacts { name: "REG_INTERP_THREAD_PITCH", built_in: true, own: false },
    DataFacts { name: "REG_INTERP_THREAD_PITCH_VAR", built_in: true, own: false },
    DataFacts { name: "REG_INTERP_THREAD_PITCH_X", built_in: true, own: false },
    DataFacts { name: "REG_INTERP_THREAD_PITCH_Z", built_in: true, own: false },
    DataFacts { name: "REG_INTERP_THREAD_STARTS", built_in: true, own: false },
    DataFacts { name: "REG_INTERP_THREAD_START_CURRENT", built_in: true, own: false },
    DataFacts { name: "REG_INTERP_THREAD_START_TOTAL", built_in: true, own: false },
    DataFacts { name: "REG_LABEL", built_in: true, own: false },
    DataFacts { name: "REG_LABEL_END", built_in: true, own: false },
    DataFacts { name: "REG_LCS_ROT_ANGLE", built_in: true, own: false },
    DataFacts { name: "REG_LCS_ROT_ANGLE_1", built_in: true, own: false },
    DataFacts { name: "REG_LCS_ROT_ANGLE_2", built_in: true, own: false },
    DataFacts { name: "REG_LCS_ROT_ANGLE_3", built_in: true, own: false },
    DataFacts { name: "REG_LCS_ROT_ANGLE_X", built_in: true, own: false },
    DataFacts { name: "REG_LCS_ROT_ANGLE_Y", built_in: true, own: false },
    DataFacts { name: "REG_LCS_ROT_ANGLE_Z", built_in: true, own: false },
    DataFacts { name: "REG_LCS_ROT_CENTER_X", built_in: true, own: false },
    DataFacts { name: "REG_LCS_ROT_CENTER_Y", built_in: true, own: false },
    DataFacts { name: "REG_LCS_ROT_CENTER_Z", built_in: true, own: false },
    DataFacts { name: "REG_LCS_SCALE", built_in: true, own: false },
    DataFacts { name: "REG_LCS_SCALE_CENTER_X", built_in: true, own: false },
    DataFacts { name: "REG_LCS_SCALE_CENTER_Y", built_in: true, own: false },
    DataFacts { name: "REG_LCS_SCALE_CENTER_Z", built_in: true, own: false },
    DataFacts { name: "REG_LCS_SCALE_X", built_in: true, own: false },
    DataFacts { name: "REG_LCS_SCALE_Y", built_in: true, own: false },
    DataFacts { name: "REG_LCS_SCALE_Z", built_in: true, own: false },
    DataFacts { name: "REG_LCS_TRANS_X", built_in: true, own: false },
    DataFacts { name: "REG_LCS_TRANS_Y", built_in: true, own: false },
    DataFacts { name: "REG_LCS_TRANS_Z", built_in: true, own: false },
    DataFacts { name: "REG_M", built_in: false, own: false },
    DataFacts { name: "REG_NIBBLE_ARC_ANGLE_END", built_in: false, own: false },
    DataFacts { name: "REG_NIBBLE_ARC_ANGLE_START", built_in: false, own: false },
    DataFacts { name: "REG_NIBBLE_DIAMCOMP", built_in: false, own: false },
    DataFacts { name: "REG_NIBBLE_LINE_ANGLE", built_in: false, own: false },
    DataFacts { name: "REG_NIBBLE_LINE_LENGTH", built_in: false, own: false },
    DataFacts { name: "REG_NIBBLE_STEP", built_in: false, own: false },
    DataFacts { name: "REG_NIBBLE_THICK", built_in: false, own: false },
    DataFacts { name: "REG_OPSKIP", built_in: true, own: false },
    DataFacts { name: "REG_PATTERN_ARC_ANGLE", built_in: false, own: false },
    DataFacts { name: "REG_PATTERN_ARC_COUNT", built_in: false, own: false },
    DataFacts { name: "REG_PATTERN_ARC_RADIUS", built_in: false, own: false },
    DataFacts { name: "REG_PATTERN_ARC_STEP", built_in: false, own: false },
    DataFacts { name: "REG_PATTERN_GRID_COUNT_X", built_in: false, own: false },
    DataFacts { name: "REG_PATTERN_GRID_COUNT_Y", built_in: false, own: false },
    DataFacts { name: "REG_PATTERN_GRID_STEP_X", built_in: false, own: false },
    DataFacts { name: "REG_PATTERN_GRID_STEP_Y", built_in: false, own: false },
    DataFacts { name: "REG_PATTERN_LINE_ANGLE", built_in: false, own: false },
    DataFacts { name: "REG_PATTERN_LINE_COUNT", built_in: false, own: false },
    DataFacts { name: "REG_PATTERN_LINE_STEP", built_in: false, own: false },
    DataFacts { name: "REG_POWER_FLOW", built_in: false, own: false },
    DataFacts { name: "REG_POWER_PULSE_FREQ", built_in: false, own: false },
    DataFacts { name: "REG_POWER_PULSE_WIDTH", built_in: false, own: false },
    DataFacts { name: "REG_RADIAL_DIST", built_in: false, own: false },
    DataFacts { name: "REG_RANGE_OTHER", built_in: false, own: false },
    DataFacts { name: "REG_RANGE_PARAM", built_in: false, own: false },
    DataFacts { name: "REG_RANGE_REPEAT", built_in: true, own: false },
    DataFacts { name: "REG_RAPID_FEED", built_in: true, own: false },
    DataFacts { name: "REG_RTCP_2PT_X", built_in: true, own: false },
    DataFacts { name: "REG_RTCP_2PT_Y", built_in: true, own: false },
    DataFacts { name: "REG_RTCP_2PT_Z", built_in: true, own: false },
    DataFacts { name: "REG_RTCP_CUSTOM_1", built_in: true, own: false },
    DataFacts { name: "REG_RTCP_CUSTOM_2", built_in: true, own: false },
    DataFacts { name: "REG_RTCP_CUSTOM_3", built_in: true, own: false },
    DataFacts { name: "REG_RTCP_EULER_1", built_in: true, own: false },
    DataFacts { name: "REG_RTCP_EULER_2", built_in: true, own: false },
    DataFacts { name: "REG_RTCP_EULER_3", built_in: true, own: false },
    DataFacts { name: "REG_RTCP_RPY_X", built_in: true, own: false },
    DataFacts { name: "REG_RTCP_RPY_Y", built_in: true, own: false },
    DataFacts { name: "REG_RTCP_RPY_Z", built_in: true, own: false },
    DataFacts { name: "REG_RTCP_VECTOR_X", built_in: true, own: false },
    DataFacts { name: "REG_RTCP_VECTOR_Y", built_in: true, own: false },
    DataFacts { name: "REG_RTCP_VECTOR_Z", built_in: true, own: false },
    DataFacts { name: "REG_SEQNO", built_in: true, own: false },
    DataFacts { name: "REG_SEQNO_MAIN", built_in: true, own: false },
    DataFacts { name: "REG_SEQNO_SIDE", built_in: true, own: false },
    DataFacts { name: "REG_SPINDLE_CSS", built_in: true, own: false },
    DataFacts { name: "REG_SPINDLE_CSS_ID", built_in: true, own: false },
    DataFacts { name: "REG_SPINDLE_CSS_RADIAL", built_in: true, own: false },
    DataFacts { name: "REG_SPINDLE_ORIENT", built_in: true, own: false },
    DataFacts { name: "REG_SPINDLE_RPM", built_in: true, own: false },
    DataFacts { name: "REG_SPINDLE_RPM_MAX", built_in: true, own: false },
    DataFacts { name: "REG_SYNC", built_in: true, own: false },
    DataFacts { name: "REG_SYNC_MAIN", built_in: true, own: false },
    DataFacts { name: "REG_SYNC_SIDE", built_in: true, own: false },
    DataFacts { name: "REG_SYNC_START", built_in: true, own: false },
    DataFacts { name: "REG_SYNC_STOP", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_CHAMFER_ANGLE", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_CHAMFER_LENGTH", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_ANGLE", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_CUTS", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_CUTS_FINISH", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_END_X", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_END_Z", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_FINISH_X", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_FINISH_Z", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_HEIGHT_X", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_HEIGHT_Z", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_INFEED", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_OFFSET_X", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_OFFSET_Z", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_PITCH", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_PITCH_VAR", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_PWORD", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_STARTS", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_START_X", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_START_Z", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_STEP_MIN", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_STEP_X", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_STEP_Z", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_TAPER_X", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_MULTI_TAPER_Z", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_SINGLE_END_X", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_SINGLE_END_Z", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_SINGLE_OFFSET_X", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_SINGLE_OFFSET_Z", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_SINGLE_PITCH", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_SINGLE_PITCH_VAR", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_SINGLE_START_X", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_SINGLE_START_Z", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_SINGLE_TAPER_X", built_in: true, own: false },
    DataFacts { name: "REG_THREAD_SINGLE_TAPER_Z", built_in: true, own: false },
    DataFacts { name: "REG_TOOL", built_in: true, own: false },
    DataFacts { name: "REG_TURRET", built_in: false, own: false },
    DataFacts { name: "REG_SYNC_PATHS", built_in: true, own: true },
    DataFacts { name: "REG_GOHOME_NTH", built_in: true, own: true },
    DataFacts { name: "REG_FUNCTION", built_in: true, own: true },
    DataFacts { name: "REG_CYCLE_STEP", built_in: true, own: true },
    DataFacts { name: "REG_CYCLE_STEP_DECR", built_in: true, own: true },
    DataFacts { name: "REG_CYCLE_REPEAT", built_in: true, own: true },
    DataFacts { name: "REG_CYCLE_WEB_START_2", built_in: true, own: true },
    DataFacts { name: "REG_CYCLE_WEB_DEPTH_2", built_in: true, own: true },
    DataFacts { name: "REG_CYCLE_WEB_START_3", built_in: true, own: true },
    DataFacts { name: "REG_CYCLE_WEB_DEPTH_3", built_in: true, own: true },
    DataFacts { name: "REG_CYCLE_WEB_START_4", built_in: true, own: true },
    DataFacts { name: "REG_CYCLE_WEB_DEPTH_4", built_in: true, own: true },
    DataFacts { name: "REG_OFFSET_KIND", built_in: true, own: true },
    DataFacts { name: "REG_OFFSET_NUMBER", built_in: true, own: true },
    DataFacts { name: "REG_OFFSET_VALUE", built_in: true, own: true },
];

/// `REG_AIR`.
pub const AIR: DataId = DataId(0);
/// `REG_AM`.
pub const AM: DataId = DataId(1);
/// `REG_ARC_3D_POINT_X`.
pub const ARC_3D_POINT_X: DataId = DataId(2);
/// `REG_ARC_3D_POINT_Y`.
pub const ARC_3D_POINT_Y: DataId = DataId(3);
/// `REG_ARC_3D_POINT_Z`.
pub const ARC_3D_POINT_Z: DataId = DataId(4);
/// `REG_ARC_ANGLE`.
pub const ARC_ANGLE: DataId = DataId(5);
/// `REG_ARC_CENTER_U`.
pub const ARC_CENTER_U: DataId = DataId(6);
/// `REG_ARC_CENTER_V`.
pub const ARC_CENTER_V: DataId = DataId(7);
/// `REG_ARC_CENTER_W`.
pub const ARC_CENTER_W: DataId = DataId(8);
/// `REG_ARC_CENTER_X`.
pub const ARC_CENTER_X: DataId = DataId(9);
/// `REG_ARC_CENTER_Y`.
pub const ARC_CENTER_Y: DataId = DataId(10);
/// `REG_ARC_CENTER_Z`.
pub const ARC_CENTER_Z: DataId = DataId(11);
/// `REG_ARC_RADIUS`.
pub const ARC_RADIUS: DataId = DataId(12);
/// `REG_ARC_RADIUS_UPPER`.
pub const ARC_RADIUS_UPPER: DataId = DataId(13);
/// `REG_ARC_TURNS`.
pub const ARC_TURNS: DataId = DataId(14);
/// `REG_AXIS_AH`.
pub const AXIS_AH: DataId = DataId(15);
/// `REG_AXIS_AT`.
pub const AXIS_AT: DataId = DataId(16);
/// `REG_AXIS_BH`.
pub const AXIS_BH: DataId = DataId(17);
/// `REG_AXIS_BT`.
pub const AXIS_BT: DataId = DataId(18);
/// `REG_AXIS_CH`.
pub const AXIS_CH: DataId = DataId(19);
/// `REG_AXIS_CT`.
pub const AXIS_CT: DataId = DataId(20);
/// `REG_AXIS_CT2`.
pub const AXIS_CT2: DataId = DataId(21);
/// `REG_AXIS_E`.
pub const AXIS_E: DataId = DataId(22);
/// `REG_AXIS_N`.
pub const AXIS_N: DataId = DataId(23);
/// `REG_AXIS_N2`.
pub const AXIS_N2: DataId = DataId(24);
/// `REG_AXIS_Q`.
pub const AXIS_Q: DataId = DataId(25);
/// `REG_AXIS_R`.
pub const AXIS_R: DataId = DataId(26);
/// `REG_AXIS_U`.
pub const AXIS_U: DataId = DataId(27);
/// `REG_AXIS_V`.
pub const AXIS_V: DataId = DataId(28);
/// `REG_AXIS_W`.
pub const AXIS_W: DataId = DataId(29);
/// `REG_AXIS_X`.
pub const AXIS_X: DataId = DataId(30);
/// `REG_AXIS_Y`.
pub const AXIS_Y: DataId = DataId(31);
/// `REG_AXIS_Z`.
pub const AXIS_Z: DataId = DataId(32);
/// `REG_C2P_INTERP_PLRX`.
pub const C2P_INTERP_PLRX: DataId = DataId(33);
/// `REG_C2P_INTERP_PLRY`.
pub const C2P_INTERP_PLRY: DataId = DataId(34);
/// `REG_C2P_INTERP_X`.
pub const C2P_INTERP_X: DataId = DataId(35);
/// `REG_C2P_INTERP_Y`.
pub const C2P_INTERP_Y: DataId = DataId(36);
/// `REG_C2P_INTERP_Z`.
pub const C2P_INTERP_Z: DataId = DataId(37);
/// `REG_C2P_TRANSL_X`.
pub const C2P_TRANSL_X: DataId = DataId(38);
/// `REG_C2P_TRANSL_Y`.
pub const C2P_TRANSL_Y: DataId = DataId(39);
/// `REG_CALSUB_BLOCK_END`.
pub const CALSUB_BLOCK_END: DataId = DataId(40);
/// `REG_CALSUB_BLOCK_START`.
pub const CALSUB_BLOCK_START: DataId = DataId(41);
/// `REG_CALSUB_ID`.
pub const CALSUB_ID: DataId = DataId(42);
/// `REG_CALSUB_OTHER`.
pub const CALSUB_OTHER: DataId = DataId(43);
/// `REG_CALSUB_PARAM`.
pub const CALSUB_PARAM: DataId = DataId(44);
/// `REG_CALSUB_REPEAT`.
pub const CALSUB_REPEAT: DataId = DataId(45);
/// `REG_COMP_DIAM`.
pub const COMP_DIAM: DataId = DataId(46);
/// `REG_COMP_DIAM_P`.
pub const COMP_DIAM_P: DataId = DataId(47);
/// `REG_COMP_DIAM_Q`.
pub const COMP_DIAM_Q: DataId = DataId(48);
/// `REG_COMP_DIAM_R`.
pub const COMP_DIAM_R: DataId = DataId(49);
/// `REG_COMP_EXTFIXT_RANGE`.
pub const COMP_EXTFIXT_RANGE: DataId = DataId(50);
/// `REG_COMP_EXTFIXT_REG`.
pub const COMP_EXTFIXT_REG: DataId = DataId(51);
/// `REG_COMP_LENGTH`.
pub const COMP_LENGTH: DataId = DataId(52);
/// `REG_COMP_WORKP`.
pub const COMP_WORKP: DataId = DataId(53);
/// `REG_COOLANT_PRESSURE`.
pub const COOLANT_PRESSURE: DataId = DataId(54);
/// `REG_CYCLE_BORE_JOG`.
pub const CYCLE_BORE_JOG: DataId = DataId(55);
/// `REG_CYCLE_BORE_JOG_X`.
pub const CYCLE_BORE_JOG_X: DataId = DataId(56);
/// `REG_CYCLE_BORE_JOG_Y`.
pub const CYCLE_BORE_JOG_Y: DataId = DataId(57);
/// `REG_CYCLE_BORE_JOG_Z`.
pub const CYCLE_BORE_JOG_Z: DataId = DataId(58);
/// `REG_CYCLE_BOTTOM`.
pub const CYCLE_BOTTOM: DataId = DataId(59);
/// `REG_CYCLE_CLEAR`.
pub const CYCLE_CLEAR: DataId = DataId(60);
/// `REG_CYCLE_DEPTH_E`.
pub const CYCLE_DEPTH_E: DataId = DataId(61);
/// `REG_CYCLE_DEPTH_X`.
pub const CYCLE_DEPTH_X: DataId = DataId(62);
/// `REG_CYCLE_DEPTH_Y`.
pub const CYCLE_DEPTH_Y: DataId = DataId(63);
/// `REG_CYCLE_DEPTH_Z`.
pub const CYCLE_DEPTH_Z: DataId = DataId(64);
/// `REG_CYCLE_DWELL`.
pub const CYCLE_DWELL: DataId = DataId(65);
/// `REG_CYCLE_ORIENT`.
pub const CYCLE_ORIENT: DataId = DataId(66);
/// `REG_CYCLE_RETRACT`.
pub const CYCLE_RETRACT: DataId = DataId(67);
/// `REG_CYCLE_RIGID_ORIENT`.
pub const CYCLE_RIGID_ORIENT: DataId = DataId(68);
/// `REG_CYCLE_STEP_BACK`.
pub const CYCLE_STEP_BACK: DataId = DataId(69);
/// `REG_CYCLE_TAP_TYPE`.
pub const CYCLE_TAP_TYPE: DataId = DataId(70);
/// `REG_CYCLE_TPU`.
pub const CYCLE_TPU: DataId = DataId(71);
/// `REG_CYCLE_UPM`.
pub const CYCLE_UPM: DataId = DataId(72);
/// `REG_CYCLE_UPR`.
pub const CYCLE_UPR: DataId = DataId(73);
/// `REG_DEFSUB_ID`.
pub const DEFSUB_ID: DataId = DataId(74);
/// `REG_DEFSUB_OTHER`.
pub const DEFSUB_OTHER: DataId = DataId(75);
/// `REG_DEFSUB_PARAM`.
pub const DEFSUB_PARAM: DataId = DataId(76);
/// `REG_DELAY`.
pub const DELAY: DataId = DataId(77);
/// `REG_DELAY_REV`.
pub const DELAY_REV: DataId = DataId(78);
/// `REG_DPM`.
pub const DPM: DataId = DataId(79);
/// `REG_FEED_1T`.
pub const FEED_1T: DataId = DataId(80);
/// `REG_FEED_UPM`.
pub const FEED_UPM: DataId = DataId(81);
/// `REG_FEED_UPM_MAX`.
pub const FEED_UPM_MAX: DataId = DataId(82);
/// `REG_FEED_UPR`.
pub const FEED_UPR: DataId = DataId(83);
/// `REG_G`.
pub const G: DataId = DataId(84);
/// `REG_HEAD`.
pub const HEAD: DataId = DataId(85);
/// `REG_HEAD_ID`.
pub const HEAD_ID: DataId = DataId(86);
/// `REG_INTERP_THREAD_ANGLE`.
pub const INTERP_THREAD_ANGLE: DataId = DataId(87);
/// `REG_INTERP_THREAD_PITCH`.
pub const INTERP_THREAD_PITCH: DataId = DataId(88);
/// `REG_INTERP_THREAD_PITCH_VAR`.
pub const INTERP_THREAD_PITCH_VAR: DataId = DataId(89);
/// `REG_INTERP_THREAD_PITCH_X`.
pub const INTERP_THREAD_PITCH_X: DataId = DataId(90);
/// `REG_INTERP_THREAD_PITCH_Z`.
pub const INTERP_THREAD_PITCH_Z: DataId = DataId(91);
/// `REG_INTERP_THREAD_STARTS`.
pub const INTERP_THREAD_STARTS: DataId = DataId(92);
/// `REG_INTERP_THREAD_START_CURRENT`.
pub const INTERP_THREAD_START_CURRENT: DataId = DataId(93);
/// `REG_INTERP_THREAD_START_TOTAL`.
pub const INTERP_THREAD_START_TOTAL: DataId = DataId(94);
/// `REG_LABEL`.
pub const LABEL: DataId = DataId(95);
/// `REG_LABEL_END`.
pub const LABEL_END: DataId = DataId(96);
/// `REG_LCS_ROT_ANGLE`.
pub const LCS_ROT_ANGLE: DataId = DataId(97);
/// `REG_LCS_ROT_ANGLE_1`.
pub const LCS_ROT_ANGLE_1: DataId = DataId(98);
/// `REG_LCS_ROT_ANGLE_2`.
pub const LCS_ROT_ANGLE_2: DataId = DataId(99);
/// `REG_LCS_ROT_ANGLE_3`.
pub const LCS_ROT_ANGLE_3: DataId = DataId(100);
/// `REG_LCS_ROT_ANGLE_X`.
pub const LCS_ROT_ANGLE_X: DataId = DataId(101);
/// `REG_LCS_ROT_ANGLE_Y`.
pub const LCS_ROT_ANGLE_Y: DataId = DataId(102);
/// `REG_LCS_ROT_ANGLE_Z`.
pub const LCS_ROT_ANGLE_Z: DataId = DataId(103);
/// `REG_LCS_ROT_CENTER_X`.
pub const LCS_ROT_CENTER_X: DataId = DataId(104);
/// `REG_LCS_ROT_CENTER_Y`.
pub const LCS_ROT_CENTER_Y: DataId = DataId(105);
/// `REG_LCS_ROT_CENTER_Z`.
pub const LCS_ROT_CENTER_Z: DataId = DataId(106);
/// `REG_LCS_SCALE`.
pub const LCS_SCALE: DataId = DataId(107);
/// `REG_LCS_SCALE_CENTER_X`.
pub const LCS_SCALE_CENTER_X: DataId = DataId(108);
/// `REG_LCS_SCALE_CENTER_Y`.
pub const LCS_SCALE_CENTER_Y: DataId = DataId(109);
/// `REG_LCS_SCALE_CENTER_Z`.
pub const LCS_SCALE_CENTER_Z: DataId = DataId(110);
/// `REG_LCS_SCALE_X`.
pub const LCS_SCALE_X: DataId = DataId(111);
/// `REG_LCS_SCALE_Y`.
pub const LCS_SCALE_Y: DataId = DataId(112);
/// `REG_LCS_SCALE_Z`.
pub const LCS_SCALE_Z: DataId = DataId(113);
/// `REG_LCS_TRANS_X`.
pub const LCS_TRANS_X: DataId = DataId(114);
/// `REG_LCS_TRANS_Y`.
pub const LCS_TRANS_Y: DataId = DataId(115);
/// `REG_LCS_TRANS_Z`.
pub const LCS_TRANS_Z: DataId = DataId(116);
/// `REG_M`.
pub const M: DataId = DataId(117);
/// `REG_NIBBLE_ARC_ANGLE_END`.
pub const NIBBLE_ARC_ANGLE_END: DataId = DataId(118);
/// `REG_NIBBLE_ARC_ANGLE_START`.
pub const NIBBLE_ARC_ANGLE_START: DataId = DataId(119);
/// `REG_NIBBLE_DIAMCOMP`.
pub const NIBBLE_DIAMCOMP: DataId = DataId(120);
/// `REG_NIBBLE_LINE_ANGLE`.
pub const NIBBLE_LINE_ANGLE: DataId = DataId(121);
/// `REG_NIBBLE_LINE_LENGTH`.
pub const NIBBLE_LINE_LENGTH: DataId = DataId(122);
/// `REG_NIBBLE_STEP`.
pub const NIBBLE_STEP: DataId = DataId(123);
/// `REG_NIBBLE_THICK`.
pub const NIBBLE_THICK: DataId = DataId(124);
/// `REG_OPSKIP`.
pub const OPSKIP: DataId = DataId(125);
/// `REG_PATTERN_ARC_ANGLE`.
pub const PATTERN_ARC_ANGLE: DataId = DataId(126);
/// `REG_PATTERN_ARC_COUNT`.
pub const PATTERN_ARC_COUNT: DataId = DataId(127);
/// `REG_PATTERN_ARC_RADIUS`.
pub const PATTERN_ARC_RADIUS: DataId = DataId(128);
/// `REG_PATTERN_ARC_STEP`.
pub const PATTERN_ARC_STEP: DataId = DataId(129);
/// `REG_PATTERN_GRID_COUNT_X`.
pub const PATTERN_GRID_COUNT_X: DataId = DataId(130);
/// `REG_PATTERN_GRID_COUNT_Y`.
pub const PATTERN_GRID_COUNT_Y: DataId = DataId(131);
/// `REG_PATTERN_GRID_STEP_X`.
pub const PATTERN_GRID_STEP_X: DataId = DataId(132);
/// `REG_PATTERN_GRID_STEP_Y`.
pub const PATTERN_GRID_STEP_Y: DataId = DataId(133);
/// `REG_PATTERN_LINE_ANGLE`.
pub const PATTERN_LINE_ANGLE: DataId = DataId(134);
/// `REG_PATTERN_LINE_COUNT`.
pub const PATTERN_LINE_COUNT: DataId = DataId(135);
/// `REG_PATTERN_LINE_STEP`.
pub const PATTERN_LINE_STEP: DataId = DataId(136);
/// `REG_POWER_FLOW`.
pub const POWER_FLOW: DataId = DataId(137);
/// `REG_POWER_PULSE_FREQ`.
pub const POWER_PULSE_FREQ: DataId = DataId(138);
/// `REG_POWER_PULSE_WIDTH`.
pub const POWER_PULSE_WIDTH: DataId = DataId(139);
/// `REG_RADIAL_DIST`.
pub const RADIAL_DIST: DataId = DataId(140);
/// `REG_RANGE_OTHER`.
pub const RANGE_OTHER: DataId = DataId(141);
/// `REG_RANGE_PARAM`.
pub const RANGE_PARAM: DataId = DataId(142);
/// `REG_RANGE_REPEAT`.
pub const RANGE_REPEAT: DataId = DataId(143);
/// `REG_RAPID_FEED`.
pub const RAPID_FEED: DataId = DataId(144);
/// `REG_RTCP_2PT_X`.
pub const RTCP_2PT_X: DataId = DataId(145);
/// `REG_RTCP_2PT_Y`.
pub const RTCP_2PT_Y: DataId = DataId(146);
/// `REG_RTCP_2PT_Z`.
pub const RTCP_2PT_Z: DataId = DataId(147);
/// `REG_RTCP_CUSTOM_1`.
pub const RTCP_CUSTOM_1: DataId = DataId(148);
/// `REG_RTCP_CUSTOM_2`.
pub const RTCP_CUSTOM_2: DataId = DataId(149);
/// `REG_RTCP_CUSTOM_3`.
pub const RTCP_CUSTOM_3: DataId = DataId(150);
/// `REG_RTCP_EULER_1`.
pub const RTCP_EULER_1: DataId = DataId(151);
/// `REG_RTCP_EULER_2`.
pub const RTCP_EULER_2: DataId = DataId(152);
/// `REG_RTCP_EULER_3`.
pub const RTCP_EULER_3: DataId = DataId(153);
/// `REG_RTCP_RPY_X`.
pub const RTCP_RPY_X: DataId = DataId(154);
/// `REG_RTCP_RPY_Y`.
pub const RTCP_RPY_Y: DataId = DataId(155);
/// `REG_RTCP_RPY_Z`.
pub const RTCP_RPY_Z: DataId = DataId(156);
/// `REG_RTCP_VECTOR_X`.
pub const RTCP_VECTOR_X: DataId = DataId(157);
/// `REG_RTCP_VECTOR_Y`.
pub const RTCP_VECTOR_Y: DataId = DataId(158);
/// `REG_RTCP_VECTOR_Z`.
pub const RTCP_VECTOR_Z: DataId = DataId(159);
/// `REG_SEQNO`.
pub const SEQNO: DataId = DataId(160);
/// `REG_SEQNO_MAIN`.
pub const SEQNO_MAIN: DataId = DataId(161);
/// `REG_SEQNO_SIDE`.
pub const SEQNO_SIDE: DataId = DataId(162);
/// `REG_SPINDLE_CSS`.
pub const SPINDLE_CSS: DataId = DataId(163);
/// `REG_SPINDLE_CSS_ID`.
pub const SPINDLE_CSS_ID: DataId = DataId(164);
/// `REG_SPINDLE_CSS_RADIAL`.
pub const SPINDLE_CSS_RADIAL: DataId = DataId(165);
/// `REG_SPINDLE_ORIENT`.
pub const SPINDLE_ORIENT: DataId = DataId(166);
/// `REG_SPINDLE_RPM`.
pub const SPINDLE_RPM: DataId = DataId(167);
/// `REG_SPINDLE_RPM_MAX`.
pub const SPINDLE_RPM_MAX: DataId = DataId(168);
/// `REG_SYNC`.
pub const SYNC: DataId = DataId(169);
/// `REG_SYNC_MAIN`.
pub const SYNC_MAIN: DataId = DataId(170);
/// `REG_SYNC_SIDE`.
pub const SYNC_SIDE: DataId = DataId(171);
/// `REG_SYNC_START`.
pub const SYNC_START: DataId = DataId(172);
/// `REG_SYNC_STOP`.
pub const SYNC_STOP: DataId = DataId(173);
/// `REG_THREAD_CHAMFER_ANGLE`.
pub const THREAD_CHAMFER_ANGLE: DataId = DataId(174);
/// `REG_THREAD_CHAMFER_LENGTH`.
pub const THREAD_CHAMFER_LENGTH: DataId = DataId(175);
/// `REG_THREAD_MULTI_ANGLE`.
pub const THREAD_MULTI_ANGLE: DataId = DataId(176);
/// `REG_THREAD_MULTI_CUTS`.
pub const THREAD_MULTI_CUTS: DataId = DataId(177);
/// `REG_THREAD_MULTI_CUTS_FINISH`.
pub const THREAD_MULTI_CUTS_FINISH: DataId = DataId(178);
/// `REG_THREAD_MULTI_END_X`.
pub const THREAD_MULTI_END_X: DataId = DataId(179);
/// `REG_THREAD_MULTI_END_Z`.
pub const THREAD_MULTI_END_Z: DataId = DataId(180);
/// `REG_THREAD_MULTI_FINISH_X`.
pub const THREAD_MULTI_FINISH_X: DataId = DataId(181);
/// `REG_THREAD_MULTI_FINISH_Z`.
pub const THREAD_MULTI_FINISH_Z: DataId = DataId(182);
/// `REG_THREAD_MULTI_HEIGHT_X`.
pub const THREAD_MULTI_HEIGHT_X: DataId = DataId(183);
/// `REG_THREAD_MULTI_HEIGHT_Z`.
pub const THREAD_MULTI_HEIGHT_Z: DataId = DataId(184);
/// `REG_THREAD_MULTI_INFEED`.
pub const THREAD_MULTI_INFEED: DataId = DataId(185);
/// `REG_THREAD_MULTI_OFFSET_X`.
pub const THREAD_MULTI_OFFSET_X: DataId = DataId(186);
/// `REG_THREAD_MULTI_OFFSET_Z`.
pub const THREAD_MULTI_OFFSET_Z: DataId = DataId(187);
/// `REG_THREAD_MULTI_PITCH`.
pub const THREAD_MULTI_PITCH: DataId = DataId(188);
/// `REG_THREAD_MULTI_PITCH_VAR`.
pub const THREAD_MULTI_PITCH_VAR: DataId = DataId(189);
/// `REG_THREAD_MULTI_PWORD`.
pub const THREAD_MULTI_PWORD: DataId = DataId(190);
/// `REG_THREAD_MULTI_STARTS`.
pub const THREAD_MULTI_STARTS: DataId = DataId(191);
/// `REG_THREAD_MULTI_START_X`.
pub const THREAD_MULTI_START_X: DataId = DataId(192);
/// `REG_THREAD_MULTI_START_Z`.
pub const THREAD_MULTI_START_Z: DataId = DataId(193);
/// `REG_THREAD_MULTI_STEP_MIN`.
pub const THREAD_MULTI_STEP_MIN: DataId = DataId(194);
/// `REG_THREAD_MULTI_STEP_X`.
pub const THREAD_MULTI_STEP_X: DataId = DataId(195);
/// `REG_THREAD_MULTI_STEP_Z`.
pub const THREAD_MULTI_STEP_Z: DataId = DataId(196);
/// `REG_THREAD_MULTI_TAPER_X`.
pub const THREAD_MULTI_TAPER_X: DataId = DataId(197);
/// `REG_THREAD_MULTI_TAPER_Z`.
pub const THREAD_MULTI_TAPER_Z: DataId = DataId(198);
/// `REG_THREAD_SINGLE_END_X`.
pub const THREAD_SINGLE_END_X: DataId = DataId(199);
/// `REG_THREAD_SINGLE_END_Z`.
pub const THREAD_SINGLE_END_Z: DataId = DataId(200);
/// `REG_THREAD_SINGLE_OFFSET_X`.
pub const THREAD_SINGLE_OFFSET_X: DataId = DataId(201);
/// `REG_THREAD_SINGLE_OFFSET_Z`.
pub const THREAD_SINGLE_OFFSET_Z: DataId = DataId(202);
/// `REG_THREAD_SINGLE_PITCH`.
pub const THREAD_SINGLE_PITCH: DataId = DataId(203);
/// `REG_THREAD_SINGLE_PITCH_VAR`.
pub const THREAD_SINGLE_PITCH_VAR: DataId = DataId(204);
/// `REG_THREAD_SINGLE_START_X`.
pub const THREAD_SINGLE_START_X: DataId = DataId(205);
/// `REG_THREAD_SINGLE_START_Z`.
pub const THREAD_SINGLE_START_Z: DataId = DataId(206);
/// `REG_THREAD_SINGLE_TAPER_X`.
pub const THREAD_SINGLE_TAPER_X: DataId = DataId(207);
/// `REG_THREAD_SINGLE_TAPER_Z`.
pub const THREAD_SINGLE_TAPER_Z: DataId = DataId(208);
/// `REG_TOOL`.
pub const TOOL: DataId = DataId(209);
/// `REG_TURRET`.
pub const TURRET: DataId = DataId(210);
/// `REG_SYNC_PATHS`: channels that take part in a meeting (Fanuc P of a waiting M code).
pub const SYNC_PATHS: DataId = DataId(211);
/// `REG_GOHOME_NTH`: number of the reference point (Fanuc G30 P).
pub const GOHOME_NTH: DataId = DataId(212);
/// `REG_FUNCTION`: number of a machine function.
pub const FUNCTION: DataId = DataId(213);
/// `REG_CYCLE_STEP`: named by the variable pages, missing in the annex.
pub const CYCLE_STEP: DataId = DataId(214);
/// `REG_CYCLE_STEP_DECR`: named by the variable pages, missing in the annex.
pub const CYCLE_STEP_DECR: DataId = DataId(215);
/// `REG_CYCLE_REPEAT`: how often a cycle is carried out (Fanuc K or L).
pub const CYCLE_REPEAT: DataId = DataId(216);
/// `REG_CYCLE_WEB_START_2`: where a further web of a hole begins.
pub const CYCLE_WEB_START_2: DataId = DataId(217);
/// `REG_CYCLE_WEB_DEPTH_2`: where it ends.
pub const CYCLE_WEB_DEPTH_2: DataId = DataId(218);
/// `REG_CYCLE_WEB_START_3`: where a further web of a hole begins.
pub const CYCLE_WEB_START_3: DataId = DataId(219);
/// `REG_CYCLE_WEB_DEPTH_3`: where it ends.
pub const CYCLE_WEB_DEPTH_3: DataId = DataId(220);
/// `REG_CYCLE_WEB_START_4`: where a further web of a hole begins.
pub const CYCLE_WEB_START_4: DataId = DataId(221);
/// `REG_CYCLE_WEB_DEPTH_4`: where it ends.
pub const CYCLE_WEB_DEPTH_4: DataId = DataId(222);
/// `REG_OFFSET_KIND`: which table an offset is set in (Fanuc G10 L).
pub const OFFSET_KIND: DataId = DataId(223);
/// `REG_OFFSET_NUMBER`: which offset is set (Fanuc G10 P).
pub const OFFSET_NUMBER: DataId = DataId(224);
/// `REG_OFFSET_VALUE`: length or radius that is set (Fanuc G10 R).
pub const OFFSET_VALUE: DataId = DataId(225);
