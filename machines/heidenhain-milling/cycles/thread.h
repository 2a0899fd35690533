; A thread of the pitch Q239 about Q1101, Q1102 from the height Q1129 over the length Q1128, with the way of the tool of the radius Q1104 from Q1126: against the clock with Q1107
; = 1. Q1130 = 0: one turn at Q1129; 1: all in one go; more: a turn every Q1130 pitches.
BEGIN PGM THREAD MM
QL1 = ABS Q239
; A right-hand thread rises against the clock.
QL2 = SGN Q239 * Q1107
QL3 = 1
QL5 = 1
FN 9: IF +Q1130 EQU +0 GOTO LBL 1
QL3 = INT ( Q1128 / ( QL1 * Q1130 ) + 0.9999 )
FN 11: IF +Q1130 GT +1 GOTO LBL 1
QL5 = QL3
QL3 = 1
LBL 1
QL6 = Q1129
LBL 2
Q1113 = QL5
Q1111 = QL6
Q1112 = QL6 + QL5 * QL1
FN 11: IF +QL2 GT +0 GOTO LBL 3
Q1111 = Q1112
Q1112 = QL6
LBL 3
CALL PGM HELIX
QL6 = QL6 + QL1 * Q1130
QL3 = QL3 - 1
FN 11: IF +QL3 GT +0.5 GOTO LBL 2
END PGM THREAD MM
