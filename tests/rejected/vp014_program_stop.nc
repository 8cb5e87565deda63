(expect: VP014 line 4, options: --tool-length 50)
G0 X0 Y0 Z50 A0 C0
G1 X10 F500
M0
M2
