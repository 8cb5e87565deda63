(expect: VP004 line 2 column 8)
G0 X10 X20
M2
