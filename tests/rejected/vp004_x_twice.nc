(expect: VP004 line 3 column 8)
G21
G0 X10 X20
M2
