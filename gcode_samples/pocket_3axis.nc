(THREE-AXIS POCKET WITH ARCS: G2 AND G3 WITH I J AND WITH R, A HELICAL ENTRY, A FULL CIRCLE)
(On a parallel machine this is a five-axis job: the table tilts to keep the tool upright in the part.)
(Expected: converts, every limit held.)
(set-up: pocket_3axis.nc.toml)
G21 G90 G94 G17 G40 G49 G80
T1 M6
S12000 M3
M8
G54
G0 X0 Y0 Z30
Z2
(helical entry, two turns)
G1 X6 F1500
G3 X6 Y0 Z-4 I-6 J0 P2 F900
G3 X6 Y0 I-6 J0
(first contour: rounded rectangle 40 x 24, corners of radius 6)
G1 X14 Y-12 F1500
G3 X20 Y-6 R6
G1 Y6
G3 X14 Y12 R6
G1 X-14
G3 X-20 Y6 I0 J-6
G1 Y-6
G3 X-14 Y-12 I6 J0
G1 X14
(finishing contour: 48 x 32, corners of radius 10, climb)
G1 X14 Y-16 F1200
G3 X24 Y-6 R10
G1 Y6
G3 X14 Y16 R10
G1 X-14
G3 X-24 Y6 R10
G1 Y-6
G3 X-14 Y-16 R10
G1 X14
(leave on an arc)
G3 X20 Y-10 R6
G0 Z30
M9
M5
M30
