%
O1205 (BLADE EDGE, NURBS WITH TOOL AXIS)
(shows: NURBS interpolation of Fanuc controls, G6.2: P order, K knots, R weights, A and C as coordinates of the spline)
(Expected: converts, every limit held.)
(set-up: fanuc_nurbs.nc.toml)
G21 G90 G94 G17 G40 G49 G80
G54 G43.4 H1
S15000 M3
G0 X-45. Y-10. Z30. A-4. C-10.
Z5.
G1 Z0 F800.
(EDGE, CUBIC)
G6.2 P4 K0. X-45. Y-10. Z0. A-4. C-10. R1. F2500.
K0. X-35. Y0. Z0.5 A-5. C-8. R1.
K0. X-20. Y10. Z1.5 A-7. C-2. R1.
K0. X0. Y14. Z2. A-9. C4. R1.5
K1. X20. Y12. Z1.8 A-9. C12. R1.
K2.5 X35. Y4. Z1. A-7. C18. R1.
K3. X46. Y-8. Z0.5 A-5. C24. R0.8
K4. X50. Y-20. Z0. A-4. C26. R1.
K5.
K5.
K5.
K5.
(TIP: HALF A CIRCLE BY WEIGHTS, TWO QUARTERS OF ORDER 3)
G6.2 P3 K0. X50. Y-20. Z0. A-4. C26. R1.
K0. X50. Y-25. R0.707106781
K0. X45. Y-25. R1.
K1. X40. Y-25. R0.707106781
K1. X40. Y-20. R1.
K2.
K2.
K2.
G1 Z10.
G0 Z30.
M5
M30
%
