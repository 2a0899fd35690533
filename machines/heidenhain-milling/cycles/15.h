; Pilot drilling of old programs, where cycle 6 plunges with the tool.
BEGIN PGM 15 MM
FN 18: SYSREAD QL90 = ID20 NR9
SL READ
SL OLD PILOT
F+QL90
END PGM 15 MM
