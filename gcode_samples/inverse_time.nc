(INVERSE-TIME FEED G93: EVERY MOVE SAYS HOW LONG IT TAKES, F IN 1/MINUTES)
(Rotary-only moves, mixed moves and an arc with a turning table; F150 is 0.4 s.)
(Expected: converts; a move whose time the axes cannot reach takes longer, and the summary counts it.)
(set-up: inverse_time.nc.toml)
G21 G90 G17 G40 G80
S9000 M3
G0 X30 Y0 Z40 A0 C0
G93
G1 Z20 F60
G1 X30 Y10 Z18 A10 C15 F60
G1 X25 Y20 Z16 A20 C35 F60
G1 X15 Y28 Z14 A30 C60 F60
G1 X0 Y32 Z12 A35 C90 F60
G1 X-15 Y28 Z11 A38 C120 F60
G1 X-25 Y20 Z10 A40 C150 F60
(rotary only: the tip stands still in the part)
G1 A20 F30
G1 C210 F30
(a quarter circle while the table turns)
G3 X-32 Y0 I17.872713 J-17.480450 C240 F40
(this one asks for 10 ms and cannot have it)
G1 X-30 A10 C260 F6000
G94
G1 Z40 F2000
G0 Z80
M5
M30
