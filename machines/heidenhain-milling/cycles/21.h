; Pilot drilling: a hole wherever cycle 22 plunges with tool Q13.
BEGIN PGM 21 MM
FN 9: IF +Q1 EQU +0 GOTO LBL 98
FN 18: SYSREAD QL90 = ID20 NR9
SL READ
SL PILOT
F+QL90
LBL 98
END PGM 21 MM
