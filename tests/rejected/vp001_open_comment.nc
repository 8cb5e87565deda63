(expect: VP001 line 2 column 7)
G0 X1 (never closed
M2
