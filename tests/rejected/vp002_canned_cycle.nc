(expect: VP002 line 4 column 1, options: --tool-length 50)
G0 X0 Y0 Z50 A0 C0
F100
G81 X10 Z-5 R2
M2
