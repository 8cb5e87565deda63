(expect: VP024 line 3 column 1, options: --tool-length 50)
G0 X0 Y0 Z50 A0 C0
M99
