(expect: VP003 line 2 column 9)
M3 S100 M5
M2
