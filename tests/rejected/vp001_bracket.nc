(expect: VP001 line 2 column 10)
#1 = [5 +
M2
