(expect: VP031 line 6, options: --tool-length 80)
(A cubic whose control legs cross: it turns back at a point in its middle.)
G21 G90 G94 G17 F1000
G0 X0 Y0 Z90
G1 Z85
G5 X10 Y0 I10 J10 P-10 Q10
M2
