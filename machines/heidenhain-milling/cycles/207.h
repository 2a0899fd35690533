; Rigid tapping with the pitch Q239: feed is speed by pitch; the spindle turns the other way for the retract.
; The hole: clearance Q200, depth Q201, surface Q203, second clearance Q204.
; The control makes its moves; a file of this name in a machine of your own replaces it.
BEGIN PGM 207 MM
END PGM 207 MM
