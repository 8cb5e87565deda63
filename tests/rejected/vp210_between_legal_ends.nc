(expect: VP210 line 3, options: --tool-length 50)
G0 X-50 Y0 Z10 A0 C0
G18 G2 X50 Z10 I50 K50 F1000
M2
