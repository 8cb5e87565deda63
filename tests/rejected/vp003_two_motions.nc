(expect: VP003 line 2 column 4)
G0 G1 X1 F100
M2
