(expect: VP001 line 3 column 8)
G21 G90
G0 X1.2.3
M2
