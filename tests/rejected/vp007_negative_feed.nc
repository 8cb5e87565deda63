(expect: VP007 line 2 column 1)
F-100
G0 X1
M2
