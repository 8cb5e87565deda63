(expect: VP012 line 2)
G1 X10 F500
M2
