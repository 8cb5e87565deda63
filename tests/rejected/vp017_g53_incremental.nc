(expect: VP017 line 3, options: --tool-length 50)
G0 X0 Y0 Z50 A0 C0
G91 G53 G0 Z0
M2
