(expect: VP001 line 2 column 1)
#1 = 5
G0 X#1
M2
