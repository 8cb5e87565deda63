(expect: VP005 line 2 column 1)
G4
G0 X1
M2
