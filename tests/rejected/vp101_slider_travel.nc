(expect: VP101 line 3, options: --tool-length 50)
G0 X0 Y0 Z50 A0 C0
G0 Z800
M2
