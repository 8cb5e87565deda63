(expect: VP021)
(the first pose is where the program starts)
G0 X0 Y0 Z50 A0 C0
M2
