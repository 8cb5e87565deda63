(expect: VP006 line 2 column 8)
G0 X10 P3
M2
