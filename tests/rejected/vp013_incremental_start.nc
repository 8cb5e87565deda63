(expect: VP013 line 2 column 8, options: --tool-length 50)
G91 G0 X10
G90 X0 Y0 Z50
X20
M2
