(INCH PROGRAM: G20, FEED IN INCHES PER MINUTE, ROTARY WORDS IN DEGREES ALL THE SAME)
(Expected: converts; 1 inch is 25.4 mm in every column.)
(set-up: inch.nc.toml)
G20 G90 G94 G17 G40 G49 G80
S8000 M3
G0 X0. Y0. Z1.5 A0. C0.
Z.1
G1 Z-.05 F20.
X1.25 F60.
G3 X1.5 Y.25 R.25
G1 Y1.
G3 X1.25 Y1.25 I-.25
G1 X-.5
G2 X-.75 Y1.5 J.25
G1 Y1.75 A15. C-20.
X-1. Y1.5 Z.1 A25. C-45.
(rotary only: F is degrees per minute, whatever the units)
G1 A10. F600.
G0 Z1.5
G21
G0 X0 Y0 A0 C0
M5
M2
