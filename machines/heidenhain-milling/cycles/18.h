; Thread cutting: from where the tool stands by the depth, at speed by pitch; the cycle starts the spindle, and stops it at the depth. The way back is
; the program's.
BEGIN PGM 18 MM
FN 18: SYSREAD QL21 = ID30 NR2
FN 18: SYSREAD QL22 = ID30 NR13
FN 9: IF +QL21 EQU +0 GOTO LBL 98
FN 18: SYSREAD QL90 = ID20 NR9
FN 18: SYSREAD QL94 = ID20 NR4
FN 18: SYSREAD QL1 = ID270 NR1 IDX3
QL4 = QL1 + QL21
QL8 = QL94 * ABS QL22 * ( 1 + 9 * Q113 )
FN 12: IF +QL22 LT +0 GOTO LBL 30
M3
FN 9: IF +0 EQU +0 GOTO LBL 31
LBL 30
M4
LBL 31
L Z+QL4 F+QL8
M5
F+QL90
LBL 98
END PGM 18 MM
