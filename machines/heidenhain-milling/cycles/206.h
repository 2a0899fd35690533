; Tapping with a floating holder: to the depth with the feed Q206, the spindle turns the other way, dwell, back.
; The control makes its moves; a file of this name in a machine of your own replaces it.
BEGIN PGM 206 MM
END PGM 206 MM
