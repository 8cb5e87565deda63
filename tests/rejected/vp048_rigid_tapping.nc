(expect: VP048 line 7, options: --tool-length 50)
%
O0046
G54 G90 G21 G17
G43 H1 G0 X0 Y0 Z60
M29 S500
G84 Z20 R40 F500
M30
%
