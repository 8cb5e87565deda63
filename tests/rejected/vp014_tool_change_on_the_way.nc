(expect: VP014 line 5, options: --tool-length 50)
T1 M6
G0 X0 Y0 Z50 A0 C0
X10
M6
X0
M2
