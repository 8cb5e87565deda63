(expect: VP001 line 2 column 10)
#1 = [5 +
G0 X#1
M2
