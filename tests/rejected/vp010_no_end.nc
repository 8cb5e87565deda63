(expect: VP010 line 2, options: --tool-length 50)
G0 X10
