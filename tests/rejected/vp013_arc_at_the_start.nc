(expect: VP013 line 2 column 4, options: --tool-length 50)
G2 X10 Y0 I5 F500
M2
