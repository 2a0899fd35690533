; Tapping with a floating holder: to the depth with the feed Q206, the spindle turns the other way, dwell, back.
; The hole: clearance Q200, depth Q201, surface Q203, second clearance Q204.
; Also the dwell Q211.
; The control makes its moves; a file of this name in a machine of your own replaces it.
BEGIN PGM 206 MM
END PGM 206 MM
