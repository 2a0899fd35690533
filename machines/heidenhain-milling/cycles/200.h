; Drilling: infeeds Q202, out to the clearance after each, dwell Q210 at the top and Q211 at the bottom. Without an
; infeed it drills in one go. Q395 = 1: the depth is that of the full diameter, by the tip angle of the tool table.
; The hole: clearance Q200, depth Q201, surface Q203, second clearance Q204.
; Also the feed Q206.
; The control makes its moves; a file of this name in a machine of your own replaces it.
BEGIN PGM 200 MM
END PGM 200 MM
