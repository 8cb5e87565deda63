(expect: VP017 line 3, options: --tool-length 50)
G0 X0 Y0 Z60 A20 C0 F500
G81 X10 Z20 R40
M2
