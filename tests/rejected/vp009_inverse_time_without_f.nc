(expect: VP009 line 3, options: --tool-length 50)
G93 G1 X10 F5
X20
M2
