(expect: VP011 line 2 column 8, options: --tool-length 50)
G0 X10 B30
M2
