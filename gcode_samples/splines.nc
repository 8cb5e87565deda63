(THREE-AXIS SPLINES: A CUBIC AND ITS CONTINUATION, A QUADRATIC, NURBS OF ORDER 3 AND 4 WITH WEIGHTS)
(shows: G5, G5 without I and J, G5.1, G5.2 with G5.3; the curves themselves are followed, not chords)
(Expected: converts, every limit held.)
(set-up: splines.nc.toml)
G21 G90 G94 G17 G40 G49 G80
G64
T1 M6
S12000 M3
M8
G54
G0 X-40 Y-30 Z20
Z2
G1 Z-3 F600
(a wave of two cubics: the second goes on in the direction of the first)
G5 X-10 Y-30 I8 J18 P-8 Q18 F3000
G5 X20 Y-30 P-8 Q-18
(a parabola)
G5.1 X40 Y-10 I20 J0
(order 3: four pieces, whose curvature jumps from one to the next)
G5.2 X40 Y10 P1 L3
X25 Y20 P2
X10 Y5 P1
X-5 Y20 P0.7
X-20 Y10 P1
G5.3
(order 4: a closed loop that flows through its knots)
G5.2 X-45 Y-5 P1 L4
X-50 Y30 P1.5
X-15 Y45 P1
X10 Y40 P0.6
X15 Y5 P1
X-8 Y0 P1.2
X-20 Y10 P1
G5.3
G0 Z20
M9
M5
M30
