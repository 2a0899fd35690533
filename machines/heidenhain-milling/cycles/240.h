; Centring: to the depth, dwell Q211. A depth by the diameter Q344 (Q343 = 1) counts for the tip angle of the tool
; table, without one for 90 degrees.
; The hole: clearance Q200, depth Q201, surface Q203, second clearance Q204.
; Also the feed Q206.
; The control makes its moves; a file of this name in a machine of your own replaces it.
BEGIN PGM 240 MM
END PGM 240 MM
