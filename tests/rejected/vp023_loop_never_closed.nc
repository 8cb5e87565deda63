(expect: VP023 line 3 column 1, options: --tool-length 50)
o1 while [#1 LT 3]
o2 endwhile
M2
