(expect: VP002 line 4 column 1, options: --tool-length 50)
G0 X0 Y0 Z50 A0 C0
F100
G38.2 Z40
M2
