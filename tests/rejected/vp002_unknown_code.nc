(expect: VP002 line 2 column 5)
G21 G12
G0 X1
M2
