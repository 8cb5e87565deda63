%
O1001 (POSTED)
(HEAD AND TAIL AS CAM POSTS WRITE THEM, WITH A TOOL TABLE BESIDE IT)
(G28 G91 Z0 at the head has no length: the machine already stands at that height; G53 G0 Z0 at the end retracts)
(along the tool axis to 550 mm over the rotary centre.)
(Expected: converts; the tool change at the head is for a person and only appears in the summary.)
(set-up: posted.nc.toml)
N10 G21 G90 G94 G17 G40 G49 G80
N20 G28 G91 Z0
N30 T1 M6
N40 G90 G54
N50 G10 L2 P1 X0 Y0 Z-500 (part zero 50 mm over the table face)
N60 G0 X40 Y-30 A0 C0
N70 S10000 M3
N80 G43.4 Z45 H1
N90 M8
N100 Z5
N110 G1 Z-1 F600
N120 X-40 F1800
N130 Y30
N140 X40 A5
N150 Y-30 A0 C90
N160 G2 X30 Y-40 I-10 J0
N170 G1 X0
N180 G0 Z45
N190 M9
N200 M5
N210 G53 G0 Z0
N220 M30
%
