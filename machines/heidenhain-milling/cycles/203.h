; Universal drilling: infeeds Q202 that shrink by Q212 down to Q205; Q213 chip breaks by Q256, then a full retract,
; and so on. Without an infeed it drills in one go. Q395 as in cycle 200.
; The hole: clearance Q200, depth Q201, surface Q203, second clearance Q204.
; Also the feed Q206, the dwells Q210 at the top and Q211 at the bottom, the feed Q208 of the retract.
; The control makes its moves; a file of this name in a machine of your own replaces it.
BEGIN PGM 203 MM
END PGM 203 MM
