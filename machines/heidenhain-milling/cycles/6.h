; Rough-out of the contours of cycle 14, as old programs say it.
BEGIN PGM 6 MM
FN 18: SYSREAD QL90 = ID20 NR9
SL READ
SL OLD ROUGH
F+QL90
END PGM 6 MM
