; From Q1121 down to Q1122 above the place where the tool stands: straight (Q1116 = 0), along a helix (1), or to and fro along Q1123 (2), by the angle
; of the tool table; without an angle straight. Q1124 is the room to both sides, Q1125 that around. Feed Q1117.
BEGIN PGM PLUNGE MM
FN 18: SYSREAD QL1 = ID50 NR14
FN 18: SYSREAD QL91 = ID270 NR1 IDX1
FN 18: SYSREAD QL92 = ID270 NR1 IDX2
FN 9: IF +Q1116 EQU +0 GOTO LBL 1
FN 9: IF +QL1 EQU +0 GOTO LBL 1
FN 11: IF +QL1 GT +89.9 GOTO LBL 1
QL2 = SIN QL1 / COS QL1
QL3 = Q1121 - Q1122
FN 9: IF +Q1116 EQU +2 GOTO LBL 2
; The helix has the radius of the tool, or what there is room for.
QL4 = Q108
FN 12: IF +QL4 LT +Q1125 GOTO LBL 3
QL4 = Q1125
LBL 3
FN 12: IF +QL4 LT +0.0001 GOTO LBL 2
QL5 = QL91 + QL4
L X+QL5 Y+QL92 F+Q1117
CC X+QL91 Y+QL92
QL6 = QL3 / QL2 / QL4 * 180 / PI
FN 12: IF +Q1107 LT +0 GOTO LBL 4
CP IPA+QL6 Z+Q1122 DR+
CP IPA+360 DR+
FN 9: IF +0 EQU +0 GOTO LBL 5
LBL 4
CP IPA-QL6 Z+Q1122 DR-
CP IPA-360 DR-
LBL 5
L X+QL91 Y+QL92
FN 9: IF +0 EQU +0 GOTO LBL 9
LBL 2
; To both sides by the radius of the tool, or what there is room for, and back to the middle.
QL4 = Q108
FN 12: IF +QL4 LT +Q1124 GOTO LBL 6
QL4 = Q1124
FN 11: IF +QL4 GT +0.0001 GOTO LBL 6
QL4 = Q1125
FN 11: IF +QL4 GT +Q108 GOTO LBL 1
FN 12: IF +QL4 LT +0.0001 GOTO LBL 1
LBL 6
QL5 = 4 * QL4 * QL2
; To one side, to the other, to the middle: the last one descends as far as is left.
QL7 = INT ( QL3 / QL5 + 0.9999 )
QL8 = QL3 / QL7 / 4
QL9 = Q1121
LBL 7
QL9 = QL9 - QL8
QL10 = QL91 + QL4 * COS Q1123
QL11 = QL92 + QL4 * SIN Q1123
L X+QL10 Y+QL11 Z+QL9 F+Q1117
QL9 = QL9 - 2 * QL8
QL10 = QL91 - QL4 * COS Q1123
QL11 = QL92 - QL4 * SIN Q1123
L X+QL10 Y+QL11 Z+QL9
QL9 = QL9 - QL8
L X+QL91 Y+QL92 Z+QL9
QL7 = QL7 - 1
FN 11: IF +QL7 GT +0 GOTO LBL 7
FN 9: IF +0 EQU +0 GOTO LBL 9
LBL 1
L Z+Q1122 F+Q1117
LBL 9
END PGM PLUNGE MM
