(expect: VP007 line 2 column 1)
T1.5 M6
M2
