(expect: VP002 line 2 column 1, options: --tool-length 50)
G38.2 Z40
M2
