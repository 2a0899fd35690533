; Reaming: to the depth with the feed Q206, dwell Q211, back with the feed Q208.
; The hole: clearance Q200, depth Q201, surface Q203, second clearance Q204.
; The control makes its moves; a file of this name in a machine of your own replaces it.
BEGIN PGM 201 MM
END PGM 201 MM
