(Part 1)
(---- Header ----)
G17 G90  (XY Plane, Absolute Distance Mode)
G64 P 0.0050 Q 0.0000 (Path Blending, deviation tolerance, and Naive CAM tolerance)
G20 (units in inches)
G54 (Set Work Offset)

G30 (Go to preset G30 location)
T 1 M6 G43 H 1
S 3000 (RPM)
M3 (Spindle ON, Forward)
M8 (Coolant ON)
G0 X 0.5 Y 0.5
G0 Z 0.5
F 10.0
G98
G83 Z -0.5 R 0.1 Q 0.1 
X 1.0 Y 0.5
X 1.5 Y 0.5
G80
G30 Z #5422 (Go in Z only to preset G30 location)
M9 (Coolant OFF)
M5 (Spindle OFF)
M30 (End of Program)
