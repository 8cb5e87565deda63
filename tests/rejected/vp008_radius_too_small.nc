(expect: VP008 line 3 column 11, options: --tool-length 50)
G0 X0 Y0 Z50 A0 C0
G2 X10 Y0 R4 F500
M2
