(VIOLATES ON PURPOSE: TILT RANGE)
(The table's range is -95 to 95 degrees. A 97 on line 9 is legal, because the platform leans by -4.6 degrees)
(and the table only turns to A + alpha = 92.4. A 101 on line 10 is not.)
(Expected: exit 1, nothing written, VP102 on lines 10 and 11.)
(set-up: violates_tilt.nc.toml)
G21 G90 G94 G17 G40 G49 G80
G0 X0 Y0 Z120 A0 C0
G1 Z100 A60 F2000
G1 A97
G1 A101
G1 A60
G0 Z160 A0
M2
