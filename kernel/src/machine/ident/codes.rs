//! All code identifiers with their default group, order and whether a built-in action is documented.
//!
//! Facts: reference code-identifiers.tsv; the rows after them are this project's own. Sorted by name within each
//! part; `CodeId(n)` is the position in [`TABLE`].

use super::{CodeFacts, CodeId};

/// Facts of every identifier, indexed by `CodeId`.
pub const TABLE: &[CodeFacts] = &[
    CodeFacts { name: "CODE_AIR_OFF", group: 51, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_AIR_ON", group: 51, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_AMCYC_CANCEL", group: 0, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_AM_OFF", group: 800, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_AM_ON", group: 800, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_APPLY_CONTOUR", group: 0, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_APPLY_MILL", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_APPLY_PUNCH", group: 0, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_APPLY_TURN", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_ASSIST_AIR", group: 52, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_ASSIST_ARGON", group: 52, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_ASSIST_NITROGEN", group: 52, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_ASSIST_OFF", group: 52, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_ASSIST_OXYGEN", group: 52, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_C2P_CART_OFF", group: 26, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_C2P_CART_ON", group: 26, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_C2P_POLAR_OFF", group: 26, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_C2P_POLAR_ON", group: 26, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_CALSUB_ID", group: 0, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_CALSUB_ID_OFF", group: 0, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_CALSUB_RANGE", group: 0, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_CALSUB_RETURN", group: 0, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_CLAMP_AH", group: 79, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_CLAMP_AT", group: 76, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_CLAMP_BH", group: 80, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_CLAMP_BT", group: 77, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_CLAMP_CH", group: 81, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_CLAMP_CT", group: 78, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_CLAMP_CT2", group: 85, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_CLAMP_E", group: 82, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_CLAMP_N", group: 83, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_CLAMP_N2", group: 84, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_CLAMP_U", group: 73, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_CLAMP_V", group: 74, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_CLAMP_W", group: 75, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_CLAMP_X", group: 70, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_CLAMP_Y", group: 71, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_CLAMP_Z", group: 72, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COMMENT", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_COMP_3D_LEFT", group: 7, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_COMP_3D_RIGHT", group: 7, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_COMP_3D_VECTOR", group: 7, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_COMP_CORNER_ARC", group: 107, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_COMP_CORNER_LINEAR", group: 107, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_COMP_DIAM_LEFT", group: 7, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_COMP_DIAM_OFF", group: 7, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_COMP_DIAM_RIGHT", group: 7, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_COMP_DYN_FIXT_OFF", group: 14, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_COMP_DYN_FIXT_ON", group: 14, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_COMP_EXTFIXT", group: 14, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_COMP_EXTFIXT_RANGE", group: 14, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_COMP_LENGTH2_ON", group: 8, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_COMP_LENGTH3_ON", group: 8, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_COMP_LENGTH4_ON", group: 8, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_COMP_LENGTH_OFF", group: 8, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_COMP_LENGTH_ON", group: 8, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_COMP_LENGTH_ON_NEG", group: 8, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_COMP_WORKP_OFF", group: 14, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_COMP_WORKP_ON", group: 14, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_COMP_X_OFF", group: 14, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_COMP_X_ON", group: 14, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_COMP_Y_OFF", group: 14, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_COMP_Y_ON", group: 14, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_COMP_Z_OFF", group: 14, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_COMP_Z_ON", group: 14, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_CONTOURING", group: 0, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_COOLANT_DEV1_OFF", group: 541, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_DEV1_ON", group: 541, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_DEV2_OFF", group: 542, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_DEV2_ON", group: 542, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_DEV3_OFF", group: 543, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_DEV3_ON", group: 543, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_DEV4_OFF", group: 544, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_DEV4_ON", group: 544, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_DEV5_OFF", group: 545, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_DEV5_ON", group: 545, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_DEV6_OFF", group: 546, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_DEV6_ON", group: 546, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_DEV7_OFF", group: 547, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_DEV7_ON", group: 547, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_DEV8_OFF", group: 548, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_DEV8_ON", group: 548, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_DEV9_OFF", group: 549, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_DEV9_ON", group: 549, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_FLOOD", group: 54, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_FLOOD_SIDE", group: 540, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_MIST", group: 54, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_MIST_SIDE", group: 540, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_OFF", group: 54, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_OFF_SIDE", group: 540, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_ON", group: 54, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_PRESSURE", group: 0, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_PRESSURE_0", group: 550, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_PRESSURE_1", group: 550, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_PRESSURE_2", group: 550, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_PRESSURE_3", group: 550, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_PRESSURE_4", group: 550, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_PRESSURE_5", group: 550, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_PRESSURE_6", group: 550, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_PRESSURE_7", group: 550, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_PRESSURE_8", group: 550, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_PRESSURE_9", group: 550, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_TAPKUL", group: 54, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_TAPKUL_SIDE", group: 540, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_THRU", group: 54, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_THRU_SIDE", group: 540, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_TYPE5", group: 54, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_TYPE5_SIDE", group: 540, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_TYPE6", group: 54, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_TYPE6_SIDE", group: 540, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_TYPE7", group: 54, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_TYPE7_SIDE", group: 540, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_TYPE8", group: 54, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_TYPE8_SIDE", group: 540, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_TYPE9", group: 54, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_COOLANT_TYPE9_SIDE", group: 540, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_CUTTING_OFF", group: 61, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_CUTTING_ON", group: 61, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_CYCLE_BORE", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_BORE_BACK", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_BORE_DWELL", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_BORE_ORIENT", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_BRKCHP", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_DEEP", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_DRILL", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_DRILL_DWELL", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_OFF", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_ON", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_REAM", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_REAM_DWELL", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_RETRACT_INITIAL", group: 10, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_RETRACT_R", group: 10, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_RIGID", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_RIGID_BRKCHP", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_RIGID_BRKCHP_CCLW", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_RIGID_CCLW", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_RIGID_DEEP", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_RIGID_DEEP_CCLW", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_TAP", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_TAP_CCLW", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_CYCLE_THRU", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_DELAY", group: 0, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_DELAY_REV", group: 0, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_DISPLY", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_END", group: 0, order: 900, built_in: true, own: false },
    CodeFacts { name: "CODE_EXACTSTOP", group: 15, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_EXACTSTOP_CCLW", group: 15, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_EXACTSTOP_CLW", group: 15, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_EXACTSTOP_LINEAR", group: 15, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_EXACTSTOP_OFF", group: 15, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_EXACTSTOP_ON", group: 15, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_FEED_1T", group: 5, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_FEED_1T_GEAR_1", group: 503, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_FEED_1T_GEAR_2", group: 503, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_FEED_1T_GEAR_3", group: 503, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_FEED_1T_GEAR_4", group: 503, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_FEED_1T_GEAR_5", group: 503, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_FEED_MAXUPM", group: 0, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_FEED_UPM", group: 5, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_FEED_UPM_GEAR_1", group: 501, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_FEED_UPM_GEAR_2", group: 501, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_FEED_UPM_GEAR_3", group: 501, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_FEED_UPM_GEAR_4", group: 501, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_FEED_UPM_GEAR_5", group: 501, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_FEED_UPR", group: 5, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_FEED_UPR_GEAR_1", group: 502, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_FEED_UPR_GEAR_2", group: 502, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_FEED_UPR_GEAR_3", group: 502, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_FEED_UPR_GEAR_4", group: 502, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_FEED_UPR_GEAR_5", group: 502, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_GOHOME", group: 0, order: 450, built_in: true, own: false },
    CodeFacts { name: "CODE_GOHOME_RETURN", group: 0, order: 450, built_in: true, own: false },
    CodeFacts { name: "CODE_HEAD_CHAIN_CCLW", group: 160, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_CHAIN_CLW", group: 160, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_CHAIN_SHORTEST", group: 160, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_DOWN", group: 58, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_EXCHANGE", group: 0, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_EXCHANGE_MANUAL", group: 0, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_GRIPPER_LARGE", group: 159, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_GRIPPER_SMALL", group: 159, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_ID", group: 68, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_HEAD_LOAD", group: 0, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_LOAD_ACTIVATE", group: 0, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_LOAD_HIGHCODE", group: 0, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_LOAD_LOWCODE", group: 0, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_LOAD_MANUAL", group: 0, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_LOAD_POINT", group: 0, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_LOAD_RETURN", group: 0, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_MAIN", group: 68, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_HEAD_PICKUP", group: 0, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_PICKUP_FIRST", group: 0, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_PICKUP_MANUAL", group: 0, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_RETURN", group: 0, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_RETURN_MANUAL", group: 0, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_SELECT", group: 0, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_SELECT_FIRST", group: 0, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_SELECT_MANUAL", group: 0, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_HEAD_SIDE", group: 68, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_HEAD_UP", group: 58, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_INDEX_ROTARY", group: 0, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_INDEX_ROTARY_CCLW", group: 0, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_INDEX_ROTARY_CLW", group: 0, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_INTERP_ARC_3D", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_ARC_CCLW", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_ARC_CENTER", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_ARC_CLW", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_ARC_RADIUS", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_DEF_CCLW", group: 0, order: 600, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_DEF_CENTER", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_DEF_CLW", group: 0, order: 600, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_DEF_RADIUS", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_HELIX", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_HELIX_CCLW", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_HELIX_CLW", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_LINEAR", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_LINEAR_X10", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_LINEAR_X100", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_SKIP", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_THREAD", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_THREAD_OFF", group: 1, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_THREAD_ON", group: 1, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_THREAD_VAR", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_THREAD_VAR_DEC", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_INTERP_THREAD_VAR_INC", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_LCS_MIRROR_ADD", group: 18, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_LCS_MIRROR_OFF", group: 18, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_LCS_MIRROR_ON", group: 18, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_LCS_ROTATE_ADD", group: 16, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_LCS_ROTATE_OFF", group: 16, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_LCS_ROTATE_ON", group: 16, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_LCS_SCALE_ADD", group: 11, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_LCS_SCALE_OFF", group: 11, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_LCS_SCALE_ON", group: 11, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_LCS_TRANSLATE_ADD", group: 17, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_LCS_TRANSLATE_OFF", group: 17, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_LCS_TRANSLATE_ON", group: 17, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_LOCATE", group: 0, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_LOCATE_OFF", group: 0, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_NIBBLE_ARC", group: 0, order: 400, built_in: false, own: false },
    CodeFacts { name: "CODE_NIBBLE_ARC_THICK", group: 0, order: 400, built_in: false, own: false },
    CodeFacts { name: "CODE_NIBBLE_LINEAR", group: 0, order: 400, built_in: false, own: false },
    CodeFacts { name: "CODE_NIBBLE_LINEAR_THICK", group: 0, order: 400, built_in: false, own: false },
    CodeFacts { name: "CODE_NIBBLE_OFF", group: 0, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_NIBBLE_ON", group: 0, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_OPSTOP", group: 0, order: 900, built_in: true, own: false },
    CodeFacts { name: "CODE_PATTERN_ARC", group: 0, order: 400, built_in: false, own: false },
    CodeFacts { name: "CODE_PATTERN_BOLT_HOLE", group: 0, order: 400, built_in: false, own: false },
    CodeFacts { name: "CODE_PATTERN_GRID_X", group: 0, order: 400, built_in: false, own: false },
    CodeFacts { name: "CODE_PATTERN_GRID_Y", group: 0, order: 400, built_in: false, own: false },
    CodeFacts { name: "CODE_PATTERN_LINE", group: 0, order: 400, built_in: false, own: false },
    CodeFacts { name: "CODE_PATTERN_REFERENCE", group: 0, order: 400, built_in: false, own: false },
    CodeFacts { name: "CODE_PLANE_E", group: 2, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_PLANE_XY", group: 2, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_PLANE_YZ", group: 2, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_PLANE_ZX", group: 2, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_POSITION_ABSOLUTE", group: 3, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_POSITION_RELATIVE", group: 3, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_POWER_CONSTWAVE", group: 62, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_POWER_OFF", group: 62, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_POWER_ON", group: 62, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_POWER_PULSE", group: 62, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_PUNCH_OFF", group: 0, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_PUNCH_ON", group: 0, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_RAPID", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_REWIND", group: 0, order: 900, built_in: true, own: false },
    CodeFacts { name: "CODE_RIGID_OFF", group: 101, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_RIGID_ON", group: 101, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_ROTARY_CCLW", group: 50, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_ROTARY_CLW", group: 50, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_ROTARY_SHORTEST", group: 50, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_RTCP2_ON", group: 20, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_RTCP_OFF", group: 20, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_RTCP_ON", group: 20, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_RTCP_ORIENT_2PT", group: 20, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_RTCP_ORIENT_AXES", group: 20, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_RTCP_ORIENT_CUSTOM", group: 20, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_RTCP_ORIENT_EULER", group: 20, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_RTCP_ORIENT_RPY", group: 20, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_RTCP_ORIENT_VECTOR", group: 20, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_SHEET_REPOS", group: 53, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_SHEET_REPOS_OFF", group: 53, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_SHEET_REPOS_ON", group: 53, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_SHUTTR_OFF", group: 63, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_SHUTTR_ON", group: 63, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_SKIP_ALARM_SIGNAL", group: 86, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_SKIP_ALARM_SILENT", group: 86, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE01_CCLW", group: 641, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE01_CCLW_COOLNT", group: 641, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE01_CLW", group: 641, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE01_CLW_COOLNT", group: 641, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE01_LOCK", group: 641, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE01_NEUTRAL", group: 641, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE01_OFF", group: 641, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE01_OFF_COOLNT", group: 641, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE01_ORIENT", group: 641, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE02_CCLW", group: 642, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE02_CCLW_COOLNT", group: 642, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE02_CLW", group: 642, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE02_CLW_COOLNT", group: 642, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE02_LOCK", group: 642, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE02_NEUTRAL", group: 642, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE02_OFF", group: 642, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE02_OFF_COOLNT", group: 642, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE02_ORIENT", group: 642, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE03_CCLW", group: 643, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE03_CCLW_COOLNT", group: 643, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE03_CLW", group: 643, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE03_CLW_COOLNT", group: 643, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE03_LOCK", group: 643, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE03_NEUTRAL", group: 643, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE03_OFF", group: 643, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE03_OFF_COOLNT", group: 643, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE03_ORIENT", group: 643, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE04_CCLW", group: 644, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE04_CCLW_COOLNT", group: 644, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE04_CLW", group: 644, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE04_CLW_COOLNT", group: 644, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE04_LOCK", group: 644, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE04_NEUTRAL", group: 644, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE04_OFF", group: 644, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE04_OFF_COOLNT", group: 644, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE04_ORIENT", group: 644, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE05_CCLW", group: 645, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE05_CCLW_COOLNT", group: 645, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE05_CLW", group: 645, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE05_CLW_COOLNT", group: 645, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE05_LOCK", group: 645, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE05_NEUTRAL", group: 645, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE05_OFF", group: 645, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE05_OFF_COOLNT", group: 645, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE05_ORIENT", group: 645, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE_CCLW", group: 64, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE_CCLW_COOLNT", group: 64, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE_CLW", group: 64, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE_CLW_COOLNT", group: 64, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE_CSS", group: 13, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE_CSS_ID", group: 96, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE_CSS_MAIN", group: 96, order: 200, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE_CSS_RADIAL", group: 0, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE_CSS_SIDE", group: 96, order: 199, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE_FRONT", group: 67, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE_GEAR_1", group: 65, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_SPINDLE_GEAR_10", group: 65, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_SPINDLE_GEAR_2", group: 65, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_SPINDLE_GEAR_3", group: 65, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_SPINDLE_GEAR_4", group: 65, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_SPINDLE_GEAR_5", group: 65, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_SPINDLE_GEAR_6", group: 65, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_SPINDLE_GEAR_7", group: 65, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_SPINDLE_GEAR_8", group: 65, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_SPINDLE_GEAR_9", group: 65, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_SPINDLE_GEAR_AUTO", group: 65, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_SPINDLE_LOCK", group: 64, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE_MAXRPM", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE_NEUTRAL", group: 64, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE_OFF", group: 64, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE_OFF_COOLNT", group: 64, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE_ORIENT", group: 64, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE_REAR", group: 67, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_SPINDLE_RPM", group: 13, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_STOP", group: 0, order: 900, built_in: true, own: false },
    CodeFacts { name: "CODE_SYNC_HALT", group: 0, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_SYNC_REG", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_SYNC_REG_MAIN", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_SYNC_REG_SIDE", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_SYNC_REG_START", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_SYNC_REG_STOP", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_SYNC_START_MAIN", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_SYNC_START_SIDE", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_THREAD_CHAMFER_OFF", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_THREAD_CHAMFER_ON", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_THREAD_EDGE_SINGLE", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_THREAD_EDGE_ZIGZAG", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_THREAD_MULTI", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_THREAD_MULTI_FACE", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_THREAD_OFF", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_THREAD_SINGLE", group: 1, order: 500, built_in: true, own: false },
    CodeFacts { name: "CODE_THREAD_SINGLE_FACE", group: 9, order: 400, built_in: true, own: false },
    CodeFacts { name: "CODE_THREAD_STEP_AMOUNT", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_THREAD_STEP_DEPTH", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_TOOL_CHAIN_CCLW", group: 60, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_TOOL_CHAIN_CLW", group: 60, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_TOOL_CHAIN_SHORTEST", group: 60, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_TOOL_EXCHANGE", group: 0, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_TOOL_EXCHANGE_MANUAL", group: 0, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_TOOL_GRIPPER_LARGE", group: 59, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_TOOL_GRIPPER_SMALL", group: 59, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_TOOL_LOAD", group: 0, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_TOOL_LOAD_ACTIVATE", group: 0, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_TOOL_LOAD_MANUAL", group: 0, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_TOOL_LOAD_POINT", group: 0, order: 450, built_in: true, own: false },
    CodeFacts { name: "CODE_TOOL_LOAD_RETURN", group: 0, order: 450, built_in: true, own: false },
    CodeFacts { name: "CODE_TOOL_PICKUP", group: 0, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_TOOL_PICKUP_FIRST", group: 0, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_TOOL_PICKUP_MANUAL", group: 0, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_TOOL_RETURN", group: 0, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_TOOL_RETURN_MANUAL", group: 0, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_TOOL_SELECT", group: 0, order: 300, built_in: true, own: false },
    CodeFacts { name: "CODE_TOOL_SELECT_FIRST", group: 0, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_TOOL_SELECT_MANUAL", group: 0, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_TORCH_OFF", group: 66, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_TORCH_ON", group: 66, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_UNCLAMP_AH", group: 79, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_UNCLAMP_AT", group: 76, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_UNCLAMP_BH", group: 80, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_UNCLAMP_BT", group: 77, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_UNCLAMP_CH", group: 81, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_UNCLAMP_CT", group: 78, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_UNCLAMP_CT2", group: 85, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_UNCLAMP_E", group: 82, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_UNCLAMP_N", group: 83, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_UNCLAMP_N2", group: 84, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_UNCLAMP_U", group: 73, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_UNCLAMP_V", group: 74, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_UNCLAMP_W", group: 75, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_UNCLAMP_X", group: 70, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_UNCLAMP_Y", group: 71, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_UNCLAMP_Z", group: 72, order: 700, built_in: true, own: false },
    CodeFacts { name: "CODE_UNITS_PRIMARY", group: 6, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_UNITS_SECONDARY", group: 6, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_UNWIND_ROTARY", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_UNWIND_ROTARY_AH", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_UNWIND_ROTARY_AT", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_UNWIND_ROTARY_BH", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_UNWIND_ROTARY_BT", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_UNWIND_ROTARY_CH", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_UNWIND_ROTARY_CT", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_UNWIND_ROTARY_N", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_UNWIND_ROTARY_N2", group: 0, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_WIRE_CUT", group: 0, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_WIRE_POWER_OFF", group: 64, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_WIRE_POWER_ON", group: 64, order: 300, built_in: false, own: false },
    CodeFacts { name: "CODE_WIRE_THREAD", group: 0, order: 700, built_in: false, own: false },
    CodeFacts { name: "CODE_XAXIS_DIAMETER", group: 109, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_XAXIS_RADIUS", group: 109, order: 100, built_in: true, own: false },
    CodeFacts { name: "CODE_ZEROTRACK_ABSOLUTE", group: 0, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_ZEROTRACK_RELATIVE", group: 0, order: 100, built_in: false, own: false },
    CodeFacts { name: "CODE_POSITION_PRESET", group: 0, order: 450, built_in: true, own: true },
    CodeFacts { name: "CODE_GOHOME_NTH", group: 0, order: 450, built_in: true, own: true },
    CodeFacts { name: "CODE_FUNCTION", group: 0, order: 300, built_in: true, own: true },
    CodeFacts { name: "CODE_POSITION_MACHINE", group: 0, order: 100, built_in: true, own: true },
    CodeFacts { name: "CODE_OFFSET_SET", group: 0, order: 100, built_in: true, own: true },
];

/// `CODE_AIR_OFF`.
pub const AIR_OFF: CodeId = CodeId(0);
/// `CODE_AIR_ON`.
pub const AIR_ON: CodeId = CodeId(1);
/// `CODE_AMCYC_CANCEL`.
pub const AMCYC_CANCEL: CodeId = CodeId(2);
/// `CODE_AM_OFF`.
pub const AM_OFF: CodeId = CodeId(3);
/// `CODE_AM_ON`.
pub const AM_ON: CodeId = CodeId(4);
/// `CODE_APPLY_CONTOUR`.
pub const APPLY_CONTOUR: CodeId = CodeId(5);
/// `CODE_APPLY_MILL`.
pub const APPLY_MILL: CodeId = CodeId(6);
/// `CODE_APPLY_PUNCH`.
pub const APPLY_PUNCH: CodeId = CodeId(7);
/// `CODE_APPLY_TURN`.
pub const APPLY_TURN: CodeId = CodeId(8);
/// `CODE_ASSIST_AIR`.
pub const ASSIST_AIR: CodeId = CodeId(9);
/// `CODE_ASSIST_ARGON`.
pub const ASSIST_ARGON: CodeId = CodeId(10);
/// `CODE_ASSIST_NITROGEN`.
pub const ASSIST_NITROGEN: CodeId = CodeId(11);
/// `CODE_ASSIST_OFF`.
pub const ASSIST_OFF: CodeId = CodeId(12);
/// `CODE_ASSIST_OXYGEN`.
pub const ASSIST_OXYGEN: CodeId = CodeId(13);
/// `CODE_C2P_CART_OFF`.
pub const C2P_CART_OFF: CodeId = CodeId(14);
/// `CODE_C2P_CART_ON`.
pub const C2P_CART_ON: CodeId = CodeId(15);
/// `CODE_C2P_POLAR_OFF`.
pub const C2P_POLAR_OFF: CodeId = CodeId(16);
/// `CODE_C2P_POLAR_ON`.
pub const C2P_POLAR_ON: CodeId = CodeId(17);
/// `CODE_CALSUB_ID`.
pub const CALSUB_ID: CodeId = CodeId(18);
/// `CODE_CALSUB_ID_OFF`.
pub const CALSUB_ID_OFF: CodeId = CodeId(19);
/// `CODE_CALSUB_RANGE`.
pub const CALSUB_RANGE: CodeId = CodeId(20);
/// `CODE_CALSUB_RETURN`.
pub const CALSUB_RETURN: CodeId = CodeId(21);
/// `CODE_CLAMP_AH`.
pub const CLAMP_AH: CodeId = CodeId(22);
/// `CODE_CLAMP_AT`.
pub const CLAMP_AT: CodeId = CodeId(23);
/// `CODE_CLAMP_BH`.
pub const CLAMP_BH: CodeId = CodeId(24);
/// `CODE_CLAMP_BT`.
pub const CLAMP_BT: CodeId = CodeId(25);
/// `CODE_CLAMP_CH`.
pub const CLAMP_CH: CodeId = CodeId(26);
/// `CODE_CLAMP_CT`.
pub const CLAMP_CT: CodeId = CodeId(27);
/// `CODE_CLAMP_CT2`.
pub const CLAMP_CT2: CodeId = CodeId(28);
/// `CODE_CLAMP_E`.
pub const CLAMP_E: CodeId = CodeId(29);
/// `CODE_CLAMP_N`.
pub const CLAMP_N: CodeId = CodeId(30);
/// `CODE_CLAMP_N2`.
pub const CLAMP_N2: CodeId = CodeId(31);
/// `CODE_CLAMP_U`.
pub const CLAMP_U: CodeId = CodeId(32);
/// `CODE_CLAMP_V`.
pub const CLAMP_V: CodeId = CodeId(33);
/// `CODE_CLAMP_W`.
pub const CLAMP_W: CodeId = CodeId(34);
/// `CODE_CLAMP_X`.
pub const CLAMP_X: CodeId = CodeId(35);
/// `CODE_CLAMP_Y`.
pub const CLAMP_Y: CodeId = CodeId(36);
/// `CODE_CLAMP_Z`.
pub const CLAMP_Z: CodeId = CodeId(37);
/// `CODE_COMMENT`.
pub const COMMENT: CodeId = CodeId(38);
/// `CODE_COMP_3D_LEFT`.
pub const COMP_3D_LEFT: CodeId = CodeId(39);
/// `CODE_COMP_3D_RIGHT`.
pub const COMP_3D_RIGHT: CodeId = CodeId(40);
/// `CODE_COMP_3D_VECTOR`.
pub const COMP_3D_VECTOR: CodeId = CodeId(41);
/// `CODE_COMP_CORNER_ARC`.
pub const COMP_CORNER_ARC: CodeId = CodeId(42);
/// `CODE_COMP_CORNER_LINEAR`.
pub const COMP_CORNER_LINEAR: CodeId = CodeId(43);
/// `CODE_COMP_DIAM_LEFT`.
pub const COMP_DIAM_LEFT: CodeId = CodeId(44);
/// `CODE_COMP_DIAM_OFF`.
pub const COMP_DIAM_OFF: CodeId = CodeId(45);
/// `CODE_COMP_DIAM_RIGHT`.
pub const COMP_DIAM_RIGHT: CodeId = CodeId(46);
/// `CODE_COMP_DYN_FIXT_OFF`.
pub const COMP_DYN_FIXT_OFF: CodeId = CodeId(47);
/// `CODE_COMP_DYN_FIXT_ON`.
pub const COMP_DYN_FIXT_ON: CodeId = CodeId(48);
/// `CODE_COMP_EXTFIXT`.
pub const COMP_EXTFIXT: CodeId = CodeId(49);
/// `CODE_COMP_EXTFIXT_RANGE`.
pub const COMP_EXTFIXT_RANGE: CodeId = CodeId(50);
/// `CODE_COMP_LENGTH2_ON`.
pub const COMP_LENGTH2_ON: CodeId = CodeId(51);
/// `CODE_COMP_LENGTH3_ON`.
pub const COMP_LENGTH3_ON: CodeId = CodeId(52);
/// `CODE_COMP_LENGTH4_ON`.
pub const COMP_LENGTH4_ON: CodeId = CodeId(53);
/// `CODE_COMP_LENGTH_OFF`.
pub const COMP_LENGTH_OFF: CodeId = CodeId(54);
/// `CODE_COMP_LENGTH_ON`.
pub const COMP_LENGTH_ON: CodeId = CodeId(55);
/// `CODE_COMP_LENGTH_ON_NEG`.
pub const COMP_LENGTH_ON_NEG: CodeId = CodeId(56);
/// `CODE_COMP_WORKP_OFF`.
pub const COMP_WORKP_OFF: CodeId = CodeId(57);
/// `CODE_COMP_WORKP_ON`.
pub const COMP_WORKP_ON: CodeId = CodeId(58);
/// `CODE_COMP_X_OFF`.
pub const COMP_X_OFF: CodeId = CodeId(59);
/// `CODE_COMP_X_ON`.
pub const COMP_X_ON: CodeId = CodeId(60);
/// `CODE_COMP_Y_OFF`.
pub const COMP_Y_OFF: CodeId = CodeId(61);
/// `CODE_COMP_Y_ON`.
pub const COMP_Y_ON: CodeId = CodeId(62);
/// `CODE_COMP_Z_OFF`.
pub const COMP_Z_OFF: CodeId = CodeId(63);
/// `CODE_COMP_Z_ON`.
pub const COMP_Z_ON: CodeId = CodeId(64);
/// `CODE_CONTOURING`.
pub const CONTOURING: CodeId = CodeId(65);
/// `CODE_COOLANT_DEV1_OFF`.
pub const COOLANT_DEV1_OFF: CodeId = CodeId(66);
/// `CODE_COOLANT_DEV1_ON`.
pub const COOLANT_DEV1_ON: CodeId = CodeId(67);
/// `CODE_COOLANT_DEV2_OFF`.
pub const COOLANT_DEV2_OFF: CodeId = CodeId(68);
/// `CODE_COOLANT_DEV2_ON`.
pub const COOLANT_DEV2_ON: CodeId = CodeId(69);
/// `CODE_COOLANT_DEV3_OFF`.
pub const COOLANT_DEV3_OFF: CodeId = CodeId(70);
/// `CODE_COOLANT_DEV3_ON`.
pub const COOLANT_DEV3_ON: CodeId = CodeId(71);
/// `CODE_COOLANT_DEV4_OFF`.
pub const COOLANT_DEV4_OFF: CodeId = CodeId(72);
/// `CODE_COOLANT_DEV4_ON`.
pub const COOLANT_DEV4_ON: CodeId = CodeId(73);
/// `CODE_COOLANT_DEV5_OFF`.
pub const COOLANT_DEV5_OFF: CodeId = CodeId(74);
/// `CODE_COOLANT_DEV5_ON`.
pub const COOLANT_DEV5_ON: CodeId = CodeId(75);
/// `CODE_COOLANT_DEV6_OFF`.
pub const COOLANT_DEV6_OFF: CodeId = CodeId(76);
/// `CODE_COOLANT_DEV6_ON`.
pub const COOLANT_DEV6_ON: CodeId = CodeId(77);
/// `CODE_COOLANT_DEV7_OFF`.
pub const COOLANT_DEV7_OFF: CodeId = CodeId(78);
/// `CODE_COOLANT_DEV7_ON`.
pub const COOLANT_DEV7_ON: CodeId = CodeId(79);
/// `CODE_COOLANT_DEV8_OFF`.
pub const COOLANT_DEV8_OFF: CodeId = CodeId(80);
/// `CODE_COOLANT_DEV8_ON`.
pub const COOLANT_DEV8_ON: CodeId = CodeId(81);
/// `CODE_COOLANT_DEV9_OFF`.
pub const COOLANT_DEV9_OFF: CodeId = CodeId(82);
/// `CODE_COOLANT_DEV9_ON`.
pub const COOLANT_DEV9_ON: CodeId = CodeId(83);
/// `CODE_COOLANT_FLOOD`.
pub const COOLANT_FLOOD: CodeId = CodeId(84);
/// `CODE_COOLANT_FLOOD_SIDE`.
pub const COOLANT_FLOOD_SIDE: CodeId = CodeId(85);
/// `CODE_COOLANT_MIST`.
pub const COOLANT_MIST: CodeId = CodeId(86);
/// `CODE_COOLANT_MIST_SIDE`.
pub const COOLANT_MIST_SIDE: CodeId = CodeId(87);
/// `CODE_COOLANT_OFF`.
pub const COOLANT_OFF: CodeId = CodeId(88);
/// `CODE_COOLANT_OFF_SIDE`.
pub const COOLANT_OFF_SIDE: CodeId = CodeId(89);
/// `CODE_COOLANT_ON`.
pub const COOLANT_ON: CodeId = CodeId(90);
/// `CODE_COOLANT_PRESSURE`.
pub const COOLANT_PRESSURE: CodeId = CodeId(91);
/// `CODE_COOLANT_PRESSURE_0`.
pub const COOLANT_PRESSURE_0: CodeId = CodeId(92);
/// `CODE_COOLANT_PRESSURE_1`.
pub const COOLANT_PRESSURE_1: CodeId = CodeId(93);
/// `CODE_COOLANT_PRESSURE_2`.
pub const COOLANT_PRESSURE_2: CodeId = CodeId(94);
/// `CODE_COOLANT_PRESSURE_3`.
pub const COOLANT_PRESSURE_3: CodeId = CodeId(95);
/// `CODE_COOLANT_PRESSURE_4`.
pub const COOLANT_PRESSURE_4: CodeId = CodeId(96);
/// `CODE_COOLANT_PRESSURE_5`.
pub const COOLANT_PRESSURE_5: CodeId = CodeId(97);
/// `CODE_COOLANT_PRESSURE_6`.
pub const COOLANT_PRESSURE_6: CodeId = CodeId(98);
/// `CODE_COOLANT_PRESSURE_7`.
pub const COOLANT_PRESSURE_7: CodeId = CodeId(99);
/// `CODE_COOLANT_PRESSURE_8`.
pub const COOLANT_PRESSURE_8: CodeId = CodeId(100);
/// `CODE_COOLANT_PRESSURE_9`.
pub const COOLANT_PRESSURE_9: CodeId = CodeId(101);
/// `CODE_COOLANT_TAPKUL`.
pub const COOLANT_TAPKUL: CodeId = CodeId(102);
/// `CODE_COOLANT_TAPKUL_SIDE`.
pub const COOLANT_TAPKUL_SIDE: CodeId = CodeId(103);
/// `CODE_COOLANT_THRU`.
pub const COOLANT_THRU: CodeId = CodeId(104);
/// `CODE_COOLANT_THRU_SIDE`.
pub const COOLANT_THRU_SIDE: CodeId = CodeId(105);
/// `CODE_COOLANT_TYPE5`.
pub const COOLANT_TYPE5: CodeId = CodeId(106);
/// `CODE_COOLANT_TYPE5_SIDE`.
pub const COOLANT_TYPE5_SIDE: CodeId = CodeId(107);
/// `CODE_COOLANT_TYPE6`.
pub const COOLANT_TYPE6: CodeId = CodeId(108);
/// `CODE_COOLANT_TYPE6_SIDE`.
pub const COOLANT_TYPE6_SIDE: CodeId = CodeId(109);
/// `CODE_COOLANT_TYPE7`.
pub const COOLANT_TYPE7: CodeId = CodeId(110);
/// `CODE_COOLANT_TYPE7_SIDE`.
pub const COOLANT_TYPE7_SIDE: CodeId = CodeId(111);
/// `CODE_COOLANT_TYPE8`.
pub const COOLANT_TYPE8: CodeId = CodeId(112);
/// `CODE_COOLANT_TYPE8_SIDE`.
pub const COOLANT_TYPE8_SIDE: CodeId = CodeId(113);
/// `CODE_COOLANT_TYPE9`.
pub const COOLANT_TYPE9: CodeId = CodeId(114);
/// `CODE_COOLANT_TYPE9_SIDE`.
pub const COOLANT_TYPE9_SIDE: CodeId = CodeId(115);
/// `CODE_CUTTING_OFF`.
pub const CUTTING_OFF: CodeId = CodeId(116);
/// `CODE_CUTTING_ON`.
pub const CUTTING_ON: CodeId = CodeId(117);
/// `CODE_CYCLE_BORE`.
pub const CYCLE_BORE: CodeId = CodeId(118);
/// `CODE_CYCLE_BORE_BACK`.
pub const CYCLE_BORE_BACK: CodeId = CodeId(119);
/// `CODE_CYCLE_BORE_DWELL`.
pub const CYCLE_BORE_DWELL: CodeId = CodeId(120);
/// `CODE_CYCLE_BORE_ORIENT`.
pub const CYCLE_BORE_ORIENT: CodeId = CodeId(121);
/// `CODE_CYCLE_BRKCHP`.
pub const CYCLE_BRKCHP: CodeId = CodeId(122);
/// `CODE_CYCLE_DEEP`.
pub const CYCLE_DEEP: CodeId = CodeId(123);
/// `CODE_CYCLE_DRILL`.
pub const CYCLE_DRILL: CodeId = CodeId(124);
/// `CODE_CYCLE_DRILL_DWELL`.
pub const CYCLE_DRILL_DWELL: CodeId = CodeId(125);
/// `CODE_CYCLE_OFF`.
pub const CYCLE_OFF: CodeId = CodeId(126);
/// `CODE_CYCLE_ON`.
pub const CYCLE_ON: CodeId = CodeId(127);
/// `CODE_CYCLE_REAM`.
pub const CYCLE_REAM: CodeId = CodeId(128);
/// `CODE_CYCLE_REAM_DWELL`.
pub const CYCLE_REAM_DWELL: CodeId = CodeId(129);
/// `CODE_CYCLE_RETRACT_INITIAL`.
pub const CYCLE_RETRACT_INITIAL: CodeId = CodeId(130);
/// `CODE_CYCLE_RETRACT_R`.
pub const CYCLE_RETRACT_R: CodeId = CodeId(131);
/// `CODE_CYCLE_RIGID`.
pub const CYCLE_RIGID: CodeId = CodeId(132);
/// `CODE_CYCLE_RIGID_BRKCHP`.
pub const CYCLE_RIGID_BRKCHP: CodeId = CodeId(133);
/// `CODE_CYCLE_RIGID_BRKCHP_CCLW`.
pub const CYCLE_RIGID_BRKCHP_CCLW: CodeId = CodeId(134);
/// `CODE_CYCLE_RIGID_CCLW`.
pub const CYCLE_RIGID_CCLW: CodeId = CodeId(135);
/// `CODE_CYCLE_RIGID_DEEP`.
pub const CYCLE_RIGID_DEEP: CodeId = CodeId(136);
/// `CODE_CYCLE_RIGID_DEEP_CCLW`.
pub const CYCLE_RIGID_DEEP_CCLW: CodeId = CodeId(137);
/// `CODE_CYCLE_TAP`.
pub const CYCLE_TAP: CodeId = CodeId(138);
/// `CODE_CYCLE_TAP_CCLW`.
pub const CYCLE_TAP_CCLW: CodeId = CodeId(139);
/// `CODE_CYCLE_THRU`.
pub const CYCLE_THRU: CodeId = CodeId(140);
/// `CODE_DELAY`.
pub const DELAY: CodeId = CodeId(141);
/// `CODE_DELAY_REV`.
pub const DELAY_REV: CodeId = CodeId(142);
/// `CODE_DISPLY`.
pub const DISPLY: CodeId = CodeId(143);
/// `CODE_END`.
pub const END: CodeId = CodeId(144);
/// `CODE_EXACTSTOP`.
pub const EXACTSTOP: CodeId = CodeId(145);
/// `CODE_EXACTSTOP_CCLW`.
pub const EXACTSTOP_CCLW: CodeId = CodeId(146);
/// `CODE_EXACTSTOP_CLW`.
pub const EXACTSTOP_CLW: CodeId = CodeId(147);
/// `CODE_EXACTSTOP_LINEAR`.
pub const EXACTSTOP_LINEAR: CodeId = CodeId(148);
/// `CODE_EXACTSTOP_OFF`.
pub const EXACTSTOP_OFF: CodeId = CodeId(149);
/// `CODE_EXACTSTOP_ON`.
pub const EXACTSTOP_ON: CodeId = CodeId(150);
/// `CODE_FEED_1T`.
pub const FEED_1T: CodeId = CodeId(151);
/// `CODE_FEED_1T_GEAR_1`.
pub const FEED_1T_GEAR_1: CodeId = CodeId(152);
/// `CODE_FEED_1T_GEAR_2`.
pub const FEED_1T_GEAR_2: CodeId = CodeId(153);
/// `CODE_FEED_1T_GEAR_3`.
pub const FEED_1T_GEAR_3: CodeId = CodeId(154);
/// `CODE_FEED_1T_GEAR_4`.
pub const FEED_1T_GEAR_4: CodeId = CodeId(155);
/// `CODE_FEED_1T_GEAR_5`.
pub const FEED_1T_GEAR_5: CodeId = CodeId(156);
/// `CODE_FEED_MAXUPM`.
pub const FEED_MAXUPM: CodeId = CodeId(157);
/// `CODE_FEED_UPM`.
pub const FEED_UPM: CodeId = CodeId(158);
/// `CODE_FEED_UPM_GEAR_1`.
pub const FEED_UPM_GEAR_1: CodeId = CodeId(159);
/// `CODE_FEED_UPM_GEAR_2`.
pub const FEED_UPM_GEAR_2: CodeId = CodeId(160);
/// `CODE_FEED_UPM_GEAR_3`.
pub const FEED_UPM_GEAR_3: CodeId = CodeId(161);
/// `CODE_FEED_UPM_GEAR_4`.
pub const FEED_UPM_GEAR_4: CodeId = CodeId(162);
/// `CODE_FEED_UPM_GEAR_5`.
pub const FEED_UPM_GEAR_5: CodeId = CodeId(163);
/// `CODE_FEED_UPR`.
pub const FEED_UPR: CodeId = CodeId(164);
/// `CODE_FEED_UPR_GEAR_1`.
pub const FEED_UPR_GEAR_1: CodeId = CodeId(165);
/// `CODE_FEED_UPR_GEAR_2`.
pub const FEED_UPR_GEAR_2: CodeId = CodeId(166);
/// `CODE_FEED_UPR_GEAR_3`.
pub const FEED_UPR_GEAR_3: CodeId = CodeId(167);
/// `CODE_FEED_UPR_GEAR_4`.
pub const FEED_UPR_GEAR_4: CodeId = CodeId(168);
/// `CODE_FEED_UPR_GEAR_5`.
pub const FEED_UPR_GEAR_5: CodeId = CodeId(169);
/// `CODE_GOHOME`.
pub const GOHOME: CodeId = CodeId(170);
/// `CODE_GOHOME_RETURN`.
pub const GOHOME_RETURN: CodeId = CodeId(171);
/// `CODE_HEAD_CHAIN_CCLW`.
pub const HEAD_CHAIN_CCLW: CodeId = CodeId(172);
/// `CODE_HEAD_CHAIN_CLW`.
pub const HEAD_CHAIN_CLW: CodeId = CodeId(173);
/// `CODE_HEAD_CHAIN_SHORTEST`.
pub const HEAD_CHAIN_SHORTEST: CodeId = CodeId(174);
/// `CODE_HEAD_DOWN`.
pub const HEAD_DOWN: CodeId = CodeId(175);
/// `CODE_HEAD_EXCHANGE`.
pub const HEAD_EXCHANGE: CodeId = CodeId(176);
/// `CODE_HEAD_EXCHANGE_MANUAL`.
pub const HEAD_EXCHANGE_MANUAL: CodeId = CodeId(177);
/// `CODE_HEAD_GRIPPER_LARGE`.
pub const HEAD_GRIPPER_LARGE: CodeId = CodeId(178);
/// `CODE_HEAD_GRIPPER_SMALL`.
pub const HEAD_GRIPPER_SMALL: CodeId = CodeId(179);
/// `CODE_HEAD_ID`.
pub const HEAD_ID: CodeId = CodeId(180);
/// `CODE_HEAD_LOAD`.
pub const HEAD_LOAD: CodeId = CodeId(181);
/// `CODE_HEAD_LOAD_ACTIVATE`.
pub const HEAD_LOAD_ACTIVATE: CodeId = CodeId(182);
/// `CODE_HEAD_LOAD_HIGHCODE`.
pub const HEAD_LOAD_HIGHCODE: CodeId = CodeId(183);
/// `CODE_HEAD_LOAD_LOWCODE`.
pub const HEAD_LOAD_LOWCODE: CodeId = CodeId(184);
/// `CODE_HEAD_LOAD_MANUAL`.
pub const HEAD_LOAD_MANUAL: CodeId = CodeId(185);
/// `CODE_HEAD_LOAD_POINT`.
pub const HEAD_LOAD_POINT: CodeId = CodeId(186);
/// `CODE_HEAD_LOAD_RETURN`.
pub const HEAD_LOAD_RETURN: CodeId = CodeId(187);
/// `CODE_HEAD_MAIN`.
pub const HEAD_MAIN: CodeId = CodeId(188);
/// `CODE_HEAD_PICKUP`.
pub const HEAD_PICKUP: CodeId = CodeId(189);
/// `CODE_HEAD_PICKUP_FIRST`.
pub const HEAD_PICKUP_FIRST: CodeId = CodeId(190);
/// `CODE_HEAD_PICKUP_MANUAL`.
pub const HEAD_PICKUP_MANUAL: CodeId = CodeId(191);
/// `CODE_HEAD_RETURN`.
pub const HEAD_RETURN: CodeId = CodeId(192);
/// `CODE_HEAD_RETURN_MANUAL`.
pub const HEAD_RETURN_MANUAL: CodeId = CodeId(193);
/// `CODE_HEAD_SELECT`.
pub const HEAD_SELECT: CodeId = CodeId(194);
/// `CODE_HEAD_SELECT_FIRST`.
pub const HEAD_SELECT_FIRST: CodeId = CodeId(195);
/// `CODE_HEAD_SELECT_MANUAL`.
pub const HEAD_SELECT_MANUAL: CodeId = CodeId(196);
/// `CODE_HEAD_SIDE`.
pub const HEAD_SIDE: CodeId = CodeId(197);
/// `CODE_HEAD_UP`.
pub const HEAD_UP: CodeId = CodeId(198);
/// `CODE_INDEX_ROTARY`.
pub const INDEX_ROTARY: CodeId = CodeId(199);
/// `CODE_INDEX_ROTARY_CCLW`.
pub const INDEX_ROTARY_CCLW: CodeId = CodeId(200);
/// `CODE_INDEX_ROTARY_CLW`.
pub const INDEX_ROTARY_CLW: CodeId = CodeId(201);
/// `CODE_INTERP_ARC_3D`.
pub const INTERP_ARC_3D: CodeId = CodeId(202);
/// `CODE_INTERP_ARC_CCLW`.
pub const INTERP_ARC_CCLW: CodeId = CodeId(203);
/// `CODE_INTERP_ARC_CENTER`.
pub const INTERP_ARC_CENTER: CodeId = CodeId(204);
/// `CODE_INTERP_ARC_CLW`.
pub const INTERP_ARC_CLW: CodeId = CodeId(205);
/// `CODE_INTERP_ARC_RADIUS`.
pub const INTERP_ARC_RADIUS: CodeId = CodeId(206);
/// `CODE_INTERP_DEF_CCLW`.
pub const INTERP_DEF_CCLW: CodeId = CodeId(207);
/// `CODE_INTERP_DEF_CENTER`.
pub const INTERP_DEF_CENTER: CodeId = CodeId(208);
/// `CODE_INTERP_DEF_CLW`.
pub const INTERP_DEF_CLW: CodeId = CodeId(209);
/// `CODE_INTERP_DEF_RADIUS`.
pub const INTERP_DEF_RADIUS: CodeId = CodeId(210);
/// `CODE_INTERP_HELIX`.
pub const INTERP_HELIX: CodeId = CodeId(211);
/// `CODE_INTERP_HELIX_CCLW`.
pub const INTERP_HELIX_CCLW: CodeId = CodeId(212);
/// `CODE_INTERP_HELIX_CLW`.
pub const INTERP_HELIX_CLW: CodeId = CodeId(213);
/// `CODE_INTERP_LINEAR`.
pub const INTERP_LINEAR: CodeId = CodeId(214);
/// `CODE_INTERP_LINEAR_X10`.
pub const INTERP_LINEAR_X10: CodeId = CodeId(215);
/// `CODE_INTERP_LINEAR_X100`.
pub const INTERP_LINEAR_X100: CodeId = CodeId(216);
/// `CODE_INTERP_SKIP`.
pub const INTERP_SKIP: CodeId = CodeId(217);
/// `CODE_INTERP_THREAD`.
pub const INTERP_THREAD: CodeId = CodeId(218);
/// `CODE_INTERP_THREAD_OFF`.
pub const INTERP_THREAD_OFF: CodeId = CodeId(219);
/// `CODE_INTERP_THREAD_ON`.
pub const INTERP_THREAD_ON: CodeId = CodeId(220);
/// `CODE_INTERP_THREAD_VAR`.
pub const INTERP_THREAD_VAR: CodeId = CodeId(221);
/// `CODE_INTERP_THREAD_VAR_DEC`.
pub const INTERP_THREAD_VAR_DEC: CodeId = CodeId(222);
/// `CODE_INTERP_THREAD_VAR_INC`.
pub const INTERP_THREAD_VAR_INC: CodeId = CodeId(223);
/// `CODE_LCS_MIRROR_ADD`.
pub const LCS_MIRROR_ADD: CodeId = CodeId(224);
/// `CODE_LCS_MIRROR_OFF`.
pub const LCS_MIRROR_OFF: CodeId = CodeId(225);
/// `CODE_LCS_MIRROR_ON`.
pub const LCS_MIRROR_ON: CodeId = CodeId(226);
/// `CODE_LCS_ROTATE_ADD`.
pub const LCS_ROTATE_ADD: CodeId = CodeId(227);
/// `CODE_LCS_ROTATE_OFF`.
pub const LCS_ROTATE_OFF: CodeId = CodeId(228);
/// `CODE_LCS_ROTATE_ON`.
pub const LCS_ROTATE_ON: CodeId = CodeId(229);
/// `CODE_LCS_SCALE_ADD`.
pub const LCS_SCALE_ADD: CodeId = CodeId(230);
/// `CODE_LCS_SCALE_OFF`.
pub const LCS_SCALE_OFF: CodeId = CodeId(231);
/// `CODE_LCS_SCALE_ON`.
pub const LCS_SCALE_ON: CodeId = CodeId(232);
/// `CODE_LCS_TRANSLATE_ADD`.
pub const LCS_TRANSLATE_ADD: CodeId = CodeId(233);
/// `CODE_LCS_TRANSLATE_OFF`.
pub const LCS_TRANSLATE_OFF: CodeId = CodeId(234);
/// `CODE_LCS_TRANSLATE_ON`.
pub const LCS_TRANSLATE_ON: CodeId = CodeId(235);
/// `CODE_LOCATE`.
pub const LOCATE: CodeId = CodeId(236);
/// `CODE_LOCATE_OFF`.
pub const LOCATE_OFF: CodeId = CodeId(237);
/// `CODE_NIBBLE_ARC`.
pub const NIBBLE_ARC: CodeId = CodeId(238);
/// `CODE_NIBBLE_ARC_THICK`.
pub const NIBBLE_ARC_THICK: CodeId = CodeId(239);
/// `CODE_NIBBLE_LINEAR`.
pub const NIBBLE_LINEAR: CodeId = CodeId(240);
/// `CODE_NIBBLE_LINEAR_THICK`.
pub const NIBBLE_LINEAR_THICK: CodeId = CodeId(241);
/// `CODE_NIBBLE_OFF`.
pub const NIBBLE_OFF: CodeId = CodeId(242);
/// `CODE_NIBBLE_ON`.
pub const NIBBLE_ON: CodeId = CodeId(243);
/// `CODE_OPSTOP`.
pub const OPSTOP: CodeId = CodeId(244);
/// `CODE_PATTERN_ARC`.
pub const PATTERN_ARC: CodeId = CodeId(245);
/// `CODE_PATTERN_BOLT_HOLE`.
pub const PATTERN_BOLT_HOLE: CodeId = CodeId(246);
/// `CODE_PATTERN_GRID_X`.
pub const PATTERN_GRID_X: CodeId = CodeId(247);
/// `CODE_PATTERN_GRID_Y`.
pub const PATTERN_GRID_Y: CodeId = CodeId(248);
/// `CODE_PATTERN_LINE`.
pub const PATTERN_LINE: CodeId = CodeId(249);
/// `CODE_PATTERN_REFERENCE`.
pub const PATTERN_REFERENCE: CodeId = CodeId(250);
/// `CODE_PLANE_E`.
pub const PLANE_E: CodeId = CodeId(251);
/// `CODE_PLANE_XY`.
pub const PLANE_XY: CodeId = CodeId(252);
/// `CODE_PLANE_YZ`.
pub const PLANE_YZ: CodeId = CodeId(253);
/// `CODE_PLANE_ZX`.
pub const PLANE_ZX: CodeId = CodeId(254);
/// `CODE_POSITION_ABSOLUTE`.
pub const POSITION_ABSOLUTE: CodeId = CodeId(255);
/// `CODE_POSITION_RELATIVE`.
pub const POSITION_RELATIVE: CodeId = CodeId(256);
/// `CODE_POWER_CONSTWAVE`.
pub const POWER_CONSTWAVE: CodeId = CodeId(257);
/// `CODE_POWER_OFF`.
pub const POWER_OFF: CodeId = CodeId(258);
/// `CODE_POWER_ON`.
pub const POWER_ON: CodeId = CodeId(259);
/// `CODE_POWER_PULSE`.
pub const POWER_PULSE: CodeId = CodeId(260);
/// `CODE_PUNCH_OFF`.
pub const PUNCH_OFF: CodeId = CodeId(261);
/// `CODE_PUNCH_ON`.
pub const PUNCH_ON: CodeId = CodeId(262);
/// `CODE_RAPID`.
pub const RAPID: CodeId = CodeId(263);
/// `CODE_REWIND`.
pub const REWIND: CodeId = CodeId(264);
/// `CODE_RIGID_OFF`.
pub const RIGID_OFF: CodeId = CodeId(265);
/// `CODE_RIGID_ON`.
pub const RIGID_ON: CodeId = CodeId(266);
/// `CODE_ROTARY_CCLW`.
pub const ROTARY_CCLW: CodeId = CodeId(267);
/// `CODE_ROTARY_CLW`.
pub const ROTARY_CLW: CodeId = CodeId(268);
/// `CODE_ROTARY_SHORTEST`.
pub const ROTARY_SHORTEST: CodeId = CodeId(269);
/// `CODE_RTCP2_ON`.
pub const RTCP2_ON: CodeId = CodeId(270);
/// `CODE_RTCP_OFF`.
pub const RTCP_OFF: CodeId = CodeId(271);
/// `CODE_RTCP_ON`.
pub const RTCP_ON: CodeId = CodeId(272);
/// `CODE_RTCP_ORIENT_2PT`.
pub const RTCP_ORIENT_2PT: CodeId = CodeId(273);
/// `CODE_RTCP_ORIENT_AXES`.
pub const RTCP_ORIENT_AXES: CodeId = CodeId(274);
/// `CODE_RTCP_ORIENT_CUSTOM`.
pub const RTCP_ORIENT_CUSTOM: CodeId = CodeId(275);
/// `CODE_RTCP_ORIENT_EULER`.
pub const RTCP_ORIENT_EULER: CodeId = CodeId(276);
/// `CODE_RTCP_ORIENT_RPY`.
pub const RTCP_ORIENT_RPY: CodeId = CodeId(277);
/// `CODE_RTCP_ORIENT_VECTOR`.
pub const RTCP_ORIENT_VECTOR: CodeId = CodeId(278);
/// `CODE_SHEET_REPOS`.
pub const SHEET_REPOS: CodeId = CodeId(279);
/// `CODE_SHEET_REPOS_OFF`.
pub const SHEET_REPOS_OFF: CodeId = CodeId(280);
/// `CODE_SHEET_REPOS_ON`.
pub const SHEET_REPOS_ON: CodeId = CodeId(281);
/// `CODE_SHUTTR_OFF`.
pub const SHUTTR_OFF: CodeId = CodeId(282);
/// `CODE_SHUTTR_ON`.
pub const SHUTTR_ON: CodeId = CodeId(283);
/// `CODE_SKIP_ALARM_SIGNAL`.
pub const SKIP_ALARM_SIGNAL: CodeId = CodeId(284);
/// `CODE_SKIP_ALARM_SILENT`.
pub const SKIP_ALARM_SILENT: CodeId = CodeId(285);
/// `CODE_SPINDLE01_CCLW`.
pub const SPINDLE01_CCLW: CodeId = CodeId(286);
/// `CODE_SPINDLE01_CCLW_COOLNT`.
pub const SPINDLE01_CCLW_COOLNT: CodeId = CodeId(287);
/// `CODE_SPINDLE01_CLW`.
pub const SPINDLE01_CLW: CodeId = CodeId(288);
/// `CODE_SPINDLE01_CLW_COOLNT`.
pub const SPINDLE01_CLW_COOLNT: CodeId = CodeId(289);
/// `CODE_SPINDLE01_LOCK`.
pub const SPINDLE01_LOCK: CodeId = CodeId(290);
/// `CODE_SPINDLE01_NEUTRAL`.
pub const SPINDLE01_NEUTRAL: CodeId = CodeId(291);
/// `CODE_SPINDLE01_OFF`.
pub const SPINDLE01_OFF: CodeId = CodeId(292);
/// `CODE_SPINDLE01_OFF_COOLNT`.
pub const SPINDLE01_OFF_COOLNT: CodeId = CodeId(293);
/// `CODE_SPINDLE01_ORIENT`.
pub const SPINDLE01_ORIENT: CodeId = CodeId(294);
/// `CODE_SPINDLE02_CCLW`.
pub const SPINDLE02_CCLW: CodeId = CodeId(295);
/// `CODE_SPINDLE02_CCLW_COOLNT`.
pub const SPINDLE02_CCLW_COOLNT: CodeId = CodeId(296);
/// `CODE_SPINDLE02_CLW`.
pub const SPINDLE02_CLW: CodeId = CodeId(297);
/// `CODE_SPINDLE02_CLW_COOLNT`.
pub const SPINDLE02_CLW_COOLNT: CodeId = CodeId(298);
/// `CODE_SPINDLE02_LOCK`.
pub const SPINDLE02_LOCK: CodeId = CodeId(299);
/// `CODE_SPINDLE02_NEUTRAL`.
pub const SPINDLE02_NEUTRAL: CodeId = CodeId(300);
/// `CODE_SPINDLE02_OFF`.
pub const SPINDLE02_OFF: CodeId = CodeId(301);
/// `CODE_SPINDLE02_OFF_COOLNT`.
pub const SPINDLE02_OFF_COOLNT: CodeId = CodeId(302);
/// `CODE_SPINDLE02_ORIENT`.
pub const SPINDLE02_ORIENT: CodeId = CodeId(303);
/// `CODE_SPINDLE03_CCLW`.
pub const SPINDLE03_CCLW: CodeId = CodeId(304);
/// `CODE_SPINDLE03_CCLW_COOLNT`.
pub const SPINDLE03_CCLW_COOLNT: CodeId = CodeId(305);
/// `CODE_SPINDLE03_CLW`.
pub const SPINDLE03_CLW: CodeId = CodeId(306);
/// `CODE_SPINDLE03_CLW_COOLNT`.
pub const SPINDLE03_CLW_COOLNT: CodeId = CodeId(307);
/// `CODE_SPINDLE03_LOCK`.
pub const SPINDLE03_LOCK: CodeId = CodeId(308);
/// `CODE_SPINDLE03_NEUTRAL`.
pub const SPINDLE03_NEUTRAL: CodeId = CodeId(309);
/// `CODE_SPINDLE03_OFF`.
pub const SPINDLE03_OFF: CodeId = CodeId(310);
/// `CODE_SPINDLE03_OFF_COOLNT`.
pub const SPINDLE03_OFF_COOLNT: CodeId = CodeId(311);
/// `CODE_SPINDLE03_ORIENT`.
pub const SPINDLE03_ORIENT: CodeId = CodeId(312);
/// `CODE_SPINDLE04_CCLW`.
pub const SPINDLE04_CCLW: CodeId = CodeId(313);
/// `CODE_SPINDLE04_CCLW_COOLNT`.
pub const SPINDLE04_CCLW_COOLNT: CodeId = CodeId(314);
/// `CODE_SPINDLE04_CLW`.
pub const SPINDLE04_CLW: CodeId = CodeId(315);
/// `CODE_SPINDLE04_CLW_COOLNT`.
pub const SPINDLE04_CLW_COOLNT: CodeId = CodeId(316);
/// `CODE_SPINDLE04_LOCK`.
pub const SPINDLE04_LOCK: CodeId = CodeId(317);
/// `CODE_SPINDLE04_NEUTRAL`.
pub const SPINDLE04_NEUTRAL: CodeId = CodeId(318);
/// `CODE_SPINDLE04_OFF`.
pub const SPINDLE04_OFF: CodeId = CodeId(319);
/// `CODE_SPINDLE04_OFF_COOLNT`.
pub const SPINDLE04_OFF_COOLNT: CodeId = CodeId(320);
/// `CODE_SPINDLE04_ORIENT`.
pub const SPINDLE04_ORIENT: CodeId = CodeId(321);
/// `CODE_SPINDLE05_CCLW`.
pub const SPINDLE05_CCLW: CodeId = CodeId(322);
/// `CODE_SPINDLE05_CCLW_COOLNT`.
pub const SPINDLE05_CCLW_COOLNT: CodeId = CodeId(323);
/// `CODE_SPINDLE05_CLW`.
pub const SPINDLE05_CLW: CodeId = CodeId(324);
/// `CODE_SPINDLE05_CLW_COOLNT`.
pub const SPINDLE05_CLW_COOLNT: CodeId = CodeId(325);
/// `CODE_SPINDLE05_LOCK`.
pub const SPINDLE05_LOCK: CodeId = CodeId(326);
/// `CODE_SPINDLE05_NEUTRAL`.
pub const SPINDLE05_NEUTRAL: CodeId = CodeId(327);
/// `CODE_SPINDLE05_OFF`.
pub const SPINDLE05_OFF: CodeId = CodeId(328);
/// `CODE_SPINDLE05_OFF_COOLNT`.
pub const SPINDLE05_OFF_COOLNT: CodeId = CodeId(329);
/// `CODE_SPINDLE05_ORIENT`.
pub const SPINDLE05_ORIENT: CodeId = CodeId(330);
/// `CODE_SPINDLE_CCLW`.
pub const SPINDLE_CCLW: CodeId = CodeId(331);
/// `CODE_SPINDLE_CCLW_COOLNT`.
pub const SPINDLE_CCLW_COOLNT: CodeId = CodeId(332);
/// `CODE_SPINDLE_CLW`.
pub const SPINDLE_CLW: CodeId = CodeId(333);
/// `CODE_SPINDLE_CLW_COOLNT`.
pub const SPINDLE_CLW_COOLNT: CodeId = CodeId(334);
/// `CODE_SPINDLE_CSS`.
pub const SPINDLE_CSS: CodeId = CodeId(335);
/// `CODE_SPINDLE_CSS_ID`.
pub const SPINDLE_CSS_ID: CodeId = CodeId(336);
/// `CODE_SPINDLE_CSS_MAIN`.
pub const SPINDLE_CSS_MAIN: CodeId = CodeId(337);
/// `CODE_SPINDLE_CSS_RADIAL`.
pub const SPINDLE_CSS_RADIAL: CodeId = CodeId(338);
/// `CODE_SPINDLE_CSS_SIDE`.
pub const SPINDLE_CSS_SIDE: CodeId = CodeId(339);
/// `CODE_SPINDLE_FRONT`.
pub const SPINDLE_FRONT: CodeId = CodeId(340);
/// `CODE_SPINDLE_GEAR_1`.
pub const SPINDLE_GEAR_1: CodeId = CodeId(341);
/// `CODE_SPINDLE_GEAR_10`.
pub const SPINDLE_GEAR_10: CodeId = CodeId(342);
/// `CODE_SPINDLE_GEAR_2`.
pub const SPINDLE_GEAR_2: CodeId = CodeId(343);
/// `CODE_SPINDLE_GEAR_3`.
pub const SPINDLE_GEAR_3: CodeId = CodeId(344);
/// `CODE_SPINDLE_GEAR_4`.
pub const SPINDLE_GEAR_4: CodeId = CodeId(345);
/// `CODE_SPINDLE_GEAR_5`.
pub const SPINDLE_GEAR_5: CodeId = CodeId(346);
/// `CODE_SPINDLE_GEAR_6`.
pub const SPINDLE_GEAR_6: CodeId = CodeId(347);
/// `CODE_SPINDLE_GEAR_7`.
pub const SPINDLE_GEAR_7: CodeId = CodeId(348);
/// `CODE_SPINDLE_GEAR_8`.
pub const SPINDLE_GEAR_8: CodeId = CodeId(349);
/// `CODE_SPINDLE_GEAR_9`.
pub const SPINDLE_GEAR_9: CodeId = CodeId(350);
/// `CODE_SPINDLE_GEAR_AUTO`.
pub const SPINDLE_GEAR_AUTO: CodeId = CodeId(351);
/// `CODE_SPINDLE_LOCK`.
pub const SPINDLE_LOCK: CodeId = CodeId(352);
/// `CODE_SPINDLE_MAXRPM`.
pub const SPINDLE_MAXRPM: CodeId = CodeId(353);
/// `CODE_SPINDLE_NEUTRAL`.
pub const SPINDLE_NEUTRAL: CodeId = CodeId(354);
/// `CODE_SPINDLE_OFF`.
pub const SPINDLE_OFF: CodeId = CodeId(355);
/// `CODE_SPINDLE_OFF_COOLNT`.
pub const SPINDLE_OFF_COOLNT: CodeId = CodeId(356);
/// `CODE_SPINDLE_ORIENT`.
pub const SPINDLE_ORIENT: CodeId = CodeId(357);
/// `CODE_SPINDLE_REAR`.
pub const SPINDLE_REAR: CodeId = CodeId(358);
/// `CODE_SPINDLE_RPM`.
pub const SPINDLE_RPM: CodeId = CodeId(359);
/// `CODE_STOP`.
pub const STOP: CodeId = CodeId(360);
/// `CODE_SYNC_HALT`.
pub const SYNC_HALT: CodeId = CodeId(361);
/// `CODE_SYNC_REG`.
pub const SYNC_REG: CodeId = CodeId(362);
/// `CODE_SYNC_REG_MAIN`.
pub const SYNC_REG_MAIN: CodeId = CodeId(363);
/// `CODE_SYNC_REG_SIDE`.
pub const SYNC_REG_SIDE: CodeId = CodeId(364);
/// `CODE_SYNC_REG_START`.
pub const SYNC_REG_START: CodeId = CodeId(365);
/// `CODE_SYNC_REG_STOP`.
pub const SYNC_REG_STOP: CodeId = CodeId(366);
/// `CODE_SYNC_START_MAIN`.
pub const SYNC_START_MAIN: CodeId = CodeId(367);
/// `CODE_SYNC_START_SIDE`.
pub const SYNC_START_SIDE: CodeId = CodeId(368);
/// `CODE_THREAD_CHAMFER_OFF`.
pub const THREAD_CHAMFER_OFF: CodeId = CodeId(369);
/// `CODE_THREAD_CHAMFER_ON`.
pub const THREAD_CHAMFER_ON: CodeId = CodeId(370);
/// `CODE_THREAD_EDGE_SINGLE`.
pub const THREAD_EDGE_SINGLE: CodeId = CodeId(371);
/// `CODE_THREAD_EDGE_ZIGZAG`.
pub const THREAD_EDGE_ZIGZAG: CodeId = CodeId(372);
/// `CODE_THREAD_MULTI`.
pub const THREAD_MULTI: CodeId = CodeId(373);
/// `CODE_THREAD_MULTI_FACE`.
pub const THREAD_MULTI_FACE: CodeId = CodeId(374);
/// `CODE_THREAD_OFF`.
pub const THREAD_OFF: CodeId = CodeId(375);
/// `CODE_THREAD_SINGLE`.
pub const THREAD_SINGLE: CodeId = CodeId(376);
/// `CODE_THREAD_SINGLE_FACE`.
pub const THREAD_SINGLE_FACE: CodeId = CodeId(377);
/// `CODE_THREAD_STEP_AMOUNT`.
pub const THREAD_STEP_AMOUNT: CodeId = CodeId(378);
/// `CODE_THREAD_STEP_DEPTH`.
pub const THREAD_STEP_DEPTH: CodeId = CodeId(379);
/// `CODE_TOOL_CHAIN_CCLW`.
pub const TOOL_CHAIN_CCLW: CodeId = CodeId(380);
/// `CODE_TOOL_CHAIN_CLW`.
pub const TOOL_CHAIN_CLW: CodeId = CodeId(381);
/// `CODE_TOOL_CHAIN_SHORTEST`.
pub const TOOL_CHAIN_SHORTEST: CodeId = CodeId(382);
/// `CODE_TOOL_EXCHANGE`.
pub const TOOL_EXCHANGE: CodeId = CodeId(383);
/// `CODE_TOOL_EXCHANGE_MANUAL`.
pub const TOOL_EXCHANGE_MANUAL: CodeId = CodeId(384);
/// `CODE_TOOL_GRIPPER_LARGE`.
pub const TOOL_GRIPPER_LARGE: CodeId = CodeId(385);
/// `CODE_TOOL_GRIPPER_SMALL`.
pub const TOOL_GRIPPER_SMALL: CodeId = CodeId(386);
/// `CODE_TOOL_LOAD`.
pub const TOOL_LOAD: CodeId = CodeId(387);
/// `CODE_TOOL_LOAD_ACTIVATE`.
pub const TOOL_LOAD_ACTIVATE: CodeId = CodeId(388);
/// `CODE_TOOL_LOAD_MANUAL`.
pub const TOOL_LOAD_MANUAL: CodeId = CodeId(389);
/// `CODE_TOOL_LOAD_POINT`.
pub const TOOL_LOAD_POINT: CodeId = CodeId(390);
/// `CODE_TOOL_LOAD_RETURN`.
pub const TOOL_LOAD_RETURN: CodeId = CodeId(391);
/// `CODE_TOOL_PICKUP`.
pub const TOOL_PICKUP: CodeId = CodeId(392);
/// `CODE_TOOL_PICKUP_FIRST`.
pub const TOOL_PICKUP_FIRST: CodeId = CodeId(393);
/// `CODE_TOOL_PICKUP_MANUAL`.
pub const TOOL_PICKUP_MANUAL: CodeId = CodeId(394);
/// `CODE_TOOL_RETURN`.
pub const TOOL_RETURN: CodeId = CodeId(395);
/// `CODE_TOOL_RETURN_MANUAL`.
pub const TOOL_RETURN_MANUAL: CodeId = CodeId(396);
/// `CODE_TOOL_SELECT`.
pub const TOOL_SELECT: CodeId = CodeId(397);
/// `CODE_TOOL_SELECT_FIRST`.
pub const TOOL_SELECT_FIRST: CodeId = CodeId(398);
/// `CODE_TOOL_SELECT_MANUAL`.
pub const TOOL_SELECT_MANUAL: CodeId = CodeId(399);
/// `CODE_TORCH_OFF`.
pub const TORCH_OFF: CodeId = CodeId(400);
/// `CODE_TORCH_ON`.
pub const TORCH_ON: CodeId = CodeId(401);
/// `CODE_UNCLAMP_AH`.
pub const UNCLAMP_AH: CodeId = CodeId(402);
/// `CODE_UNCLAMP_AT`.
pub const UNCLAMP_AT: CodeId = CodeId(403);
/// `CODE_UNCLAMP_BH`.
pub const UNCLAMP_BH: CodeId = CodeId(404);
/// `CODE_UNCLAMP_BT`.
pub const UNCLAMP_BT: CodeId = CodeId(405);
/// `CODE_UNCLAMP_CH`.
pub const UNCLAMP_CH: CodeId = CodeId(406);
/// `CODE_UNCLAMP_CT`.
pub const UNCLAMP_CT: CodeId = CodeId(407);
/// `CODE_UNCLAMP_CT2`.
pub const UNCLAMP_CT2: CodeId = CodeId(408);
/// `CODE_UNCLAMP_E`.
pub const UNCLAMP_E: CodeId = CodeId(409);
/// `CODE_UNCLAMP_N`.
pub const UNCLAMP_N: CodeId = CodeId(410);
/// `CODE_UNCLAMP_N2`.
pub const UNCLAMP_N2: CodeId = CodeId(411);
/// `CODE_UNCLAMP_U`.
pub const UNCLAMP_U: CodeId = CodeId(412);
/// `CODE_UNCLAMP_V`.
pub const UNCLAMP_V: CodeId = CodeId(413);
/// `CODE_UNCLAMP_W`.
pub const UNCLAMP_W: CodeId = CodeId(414);
/// `CODE_UNCLAMP_X`.
pub const UNCLAMP_X: CodeId = CodeId(415);
/// `CODE_UNCLAMP_Y`.
pub const UNCLAMP_Y: CodeId = CodeId(416);
/// `CODE_UNCLAMP_Z`.
pub const UNCLAMP_Z: CodeId = CodeId(417);
/// `CODE_UNITS_PRIMARY`.
pub const UNITS_PRIMARY: CodeId = CodeId(418);
/// `CODE_UNITS_SECONDARY`.
pub const UNITS_SECONDARY: CodeId = CodeId(419);
/// `CODE_UNWIND_ROTARY`.
pub const UNWIND_ROTARY: CodeId = CodeId(420);
/// `CODE_UNWIND_ROTARY_AH`.
pub const UNWIND_ROTARY_AH: CodeId = CodeId(421);
/// `CODE_UNWIND_ROTARY_AT`.
pub const UNWIND_ROTARY_AT: CodeId = CodeId(422);
/// `CODE_UNWIND_ROTARY_BH`.
pub const UNWIND_ROTARY_BH: CodeId = CodeId(423);
/// `CODE_UNWIND_ROTARY_BT`.
pub const UNWIND_ROTARY_BT: CodeId = CodeId(424);
/// `CODE_UNWIND_ROTARY_CH`.
pub const UNWIND_ROTARY_CH: CodeId = CodeId(425);
/// `CODE_UNWIND_ROTARY_CT`.
pub const UNWIND_ROTARY_CT: CodeId = CodeId(426);
/// `CODE_UNWIND_ROTARY_N`.
pub const UNWIND_ROTARY_N: CodeId = CodeId(427);
/// `CODE_UNWIND_ROTARY_N2`.
pub const UNWIND_ROTARY_N2: CodeId = CodeId(428);
/// `CODE_WIRE_CUT`.
pub const WIRE_CUT: CodeId = CodeId(429);
/// `CODE_WIRE_POWER_OFF`.
pub const WIRE_POWER_OFF: CodeId = CodeId(430);
/// `CODE_WIRE_POWER_ON`.
pub const WIRE_POWER_ON: CodeId = CodeId(431);
/// `CODE_WIRE_THREAD`.
pub const WIRE_THREAD: CodeId = CodeId(432);
/// `CODE_XAXIS_DIAMETER`.
pub const XAXIS_DIAMETER: CodeId = CodeId(433);
/// `CODE_XAXIS_RADIUS`.
pub const XAXIS_RADIUS: CodeId = CodeId(434);
/// `CODE_ZEROTRACK_ABSOLUTE`.
pub const ZEROTRACK_ABSOLUTE: CodeId = CodeId(435);
/// `CODE_ZEROTRACK_RELATIVE`.
pub const ZEROTRACK_RELATIVE: CodeId = CodeId(436);
/// `CODE_POSITION_PRESET`: preset of the work frame (Fanuc G50/G92 with axis words).
pub const POSITION_PRESET: CodeId = CodeId(437);
/// `CODE_GOHOME_NTH`: return to the 2nd, 3rd or 4th reference point (Fanuc G30).
pub const GOHOME_NTH: CodeId = CodeId(438);
/// `CODE_FUNCTION`: machine function that only takes time (M codes of the machine's own table).
pub const FUNCTION: CodeId = CodeId(439);
/// `CODE_POSITION_MACHINE`: this block's positions are in the machine frame (Fanuc G53).
pub const POSITION_MACHINE: CodeId = CodeId(440);
/// `CODE_OFFSET_SET`: sets an offset of the control (Fanuc G10).
pub const OFFSET_SET: CodeId = CodeId(441);
