(expect: VP027 line 3, options: --tool-length 50)
G0 X0 Y0 Z50 A0 C0
(ABORT, this program is for the other fixture)
M2
