(BOUND BY THE SLIDERS, NOT BY THE TABLE: FAST MOVES ALONG X AT Y 0, WHERE THE PLATFORM DOES NOT LEAN)
(Rapids and a feed above what the sliders can do; A and C stand still.)
(Expected: converts; the worst ratios are those of rho1, rho2, rho3.)
(set-up: slider_bound.nc.toml)
G21 G90 G94 G17 G40 G49 G80
G0 X-150 Y0 Z0
X150
X-150
G1 X150 F60000
X-150 Z40
X150 Z0
Z120
Z0
X-150
G0 Z60
M2
