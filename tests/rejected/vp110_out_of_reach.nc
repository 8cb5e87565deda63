(expect: VP110 line 3, options: --tool-length 50)
G0 X0 Y0 Z50 A0 C0
G1 Y600 F1000
M2
