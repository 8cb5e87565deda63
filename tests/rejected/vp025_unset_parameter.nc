(expect: VP025 line 2 column 5, options: --tool-length 50)
G0 X#<width>
M2
