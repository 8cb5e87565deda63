(expect: VP023 line 6 column 1, options: --tool-length 50)
G0 X0 Y0 Z50 A0 C0
#1=0
o1 while [#1 LT 3]
#1=[#1+1]
o2 endwhile
M2
