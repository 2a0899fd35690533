; Drilling: infeeds Q202, out to the clearance after each, dwell Q210 at the top and Q211 at the bottom. Without an
; infeed it drills in one go. Q395 = 1: the depth is that of the full diameter, by the tip angle of the tool table.
; The control makes its moves; a file of this name in a machine of your own replaces it.
BEGIN PGM 200 MM
END PGM 200 MM
