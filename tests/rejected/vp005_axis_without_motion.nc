(expect: VP005 line 2 column 1)
X10
M2
