; Centring: to the depth, dwell Q211. A depth by the diameter Q344 (Q343 = 1) counts for the tip angle of the tool
; table, without one for 90 degrees.
; The control makes its moves; a file of this name in a machine of your own replaces it.
BEGIN PGM 240 MM
END PGM 240 MM
