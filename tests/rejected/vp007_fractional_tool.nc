(expect: VP007 line 2 column 1)
T1.5 M6
G0 X1
M2
