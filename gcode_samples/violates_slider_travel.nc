(VIOLATES ON PURPOSE: SLIDER TRAVEL)
(The part sits 420 mm over the table face, so the sliders would have to go above their upper end.)
(Expected: exit 1, nothing written, VP101 for rho2 and rho3 from line 8 on.)
(set-up: violates_slider_travel.nc.toml)
G21 G90 G94 G17 G40 G49 G80
G0 X0 Y0 Z50
G1 Z20 F1000
G1 Z260
X40
Y40
G0 Z50
M2
