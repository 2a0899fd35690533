; Contour train at the heights of the contour.
BEGIN PGM 276 MM
FN 18: SYSREAD QL90 = ID20 NR9
SL READ
SL TRAIN 276
F+QL90
END PGM 276 MM
