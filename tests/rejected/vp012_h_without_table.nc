(expect: VP012 line 3 column 5)
G0 X0 Y0 Z50 A0 C0
G43 H1
G1 X10 F500
M2
