; A piece of a thread about Q1101, Q1102 from the height Q1111 to Q1112 in Q1113 turns of the radius Q1104, against the clock with Q1107 = 1; the tool comes from Q1126
; towards +X of the centre (0: the centre) and goes back there, each on a semicircle that is a quarter of a pitch high. Q1108 is the feed of the tool's centre.
BEGIN PGM HELIX MM
QL1 = ( Q1112 - Q1111 ) / Q1113 / 4
QL2 = Q1111 - QL1
QL3 = Q1112 + QL1
QL10 = Q1101 + Q1126
QL11 = Q1101 + Q1104
QL5 = ABS ( Q1104 - Q1126 ) / 2
QL6 = 360 * Q1113
; A way from outside turns the other way.
QL7 = Q1107
FN 11: IF +Q1104 GT +Q1126 GOTO LBL 1
QL7 = 0 - Q1107
LBL 1
L X+QL10 Y+Q1102 R0 FMAX
L Z+QL2 F+Q253
FN 12: IF +QL7 LT +0 GOTO LBL 2
CR X+QL11 Y+Q1102 Z+Q1111 R+QL5 DR+ F+Q1108
FN 9: IF +0 EQU +0 GOTO LBL 3
LBL 2
CR X+QL11 Y+Q1102 Z+Q1111 R+QL5 DR- F+Q1108
LBL 3
CC X+Q1101 Y+Q1102
FN 12: IF +Q1107 LT +0 GOTO LBL 4
CP IPA+QL6 Z+Q1112 DR+
FN 9: IF +0 EQU +0 GOTO LBL 5
LBL 4
CP IPA-QL6 Z+Q1112 DR-
LBL 5
FN 12: IF +QL7 LT +0 GOTO LBL 6
CR X+QL10 Y+Q1102 Z+QL3 R+QL5 DR+
FN 9: IF +0 EQU +0 GOTO LBL 7
LBL 6
CR X+QL10 Y+Q1102 Z+QL3 R+QL5 DR-
LBL 7
END PGM HELIX MM
