(expect: VP026 line 6, options: --tool-length 50)
G0 X-30 Y0 Z50 A0 C0 F500
G41.1 D10
G1 X0
X1
X2 Y30
M2
