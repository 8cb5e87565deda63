(expect: VP001 line 2 column 8)
G0 X1.2.3
M2
