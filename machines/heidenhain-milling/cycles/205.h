; Universal pecking: infeeds Q202 that shrink by Q212 down to Q205, out to the clearance after each and back to a stop
; above the last depth, Q258 at the first return and Q259 at the last; in an infeed a chip break by Q256 every Q257.
; Q379 is where the hole begins, reached with the feed Q253. Q208 of 99999 and more is rapid, 0 is Q206. Q395 as in
; cycle 200.
; The hole: clearance Q200, depth Q201, surface Q203, second clearance Q204.
; Also the feed Q206 and the dwell Q211.
; The control makes its moves; a file of this name in a machine of your own replaces it.
BEGIN PGM 205 MM
END PGM 205 MM
