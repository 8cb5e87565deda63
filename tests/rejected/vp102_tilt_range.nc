(expect: VP102 line 3, options: --tool-length 50)
G0 X0 Y0 Z100 A0 C0
G0 A98
M2
