(expect: VP027 line 2, options: --tool-length 50)
(ABORT, this program is for the other fixture)
M2
