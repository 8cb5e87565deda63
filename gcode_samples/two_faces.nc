(Two inclined faces: planes computed from their angles, holes in them, finishing while the table tilts.)
(two_faces.h is the same part in Klartext, with the same setpoints.)
(Expected: exit 0.)
(set-up: two_faces.nc.toml)
o<place> sub (u, v, w of a face, tilted about X and turned about Z: its place on the part)
  #<y>=[#2*COS[#<_tilt>]-#3*SIN[#<_tilt>]]
  #<_at_x>=[#<_ox>+#1*COS[#<_turn>]-#<y>*SIN[#<_turn>]]
  #<_at_y>=[#<_oy>+#1*SIN[#<_turn>]+#<y>*COS[#<_turn>]]
  #<_at_z>=[#<_oz>+#2*SIN[#<_tilt>]+#3*COS[#<_tilt>]]
o<place> endsub
o<hole> sub (u, v)
  G61
  o<place> call [#1] [#2] [3]
  G0 X#<_at_x> Y#<_at_y> Z#<_at_z>
  o<place> call [#1] [#2] [-9]
  G1 X#<_at_x> Y#<_at_y> Z#<_at_z> F250
  G4 P0.3
  o<place> call [#1] [#2] [3]
  G0 X#<_at_x> Y#<_at_y> Z#<_at_z>
  G64
o<hole> endsub
o<face> sub (three holes, from 30 mm above the face; u, v of where the tool is)
  o<place> call [#1] [#2] [30]
  G0 X#<_at_x> Y#<_at_y> Z#<_at_z>
  o<place> call [-15] [5] [30]
  G0 X#<_at_x> Y#<_at_y> Z#<_at_z>
  o<hole> call [-15] [5]
  o<place> call [0] [5] [3]
  G0 X#<_at_x> Y#<_at_y> Z#<_at_z>
  o<hole> call [0] [5]
  o<place> call [15] [8] [3]
  G0 X#<_at_x> Y#<_at_y> Z#<_at_z>
  o<hole> call [15] [8]
  o<place> call [15] [8] [30]
  G0 X#<_at_x> Y#<_at_y> Z#<_at_z>
o<face> endsub
N10 G21 G17 G90 G94 G49
N20 T1 M6
N30 S8000
N40 M3
N50 G0 A0 C0
N60 M8
N70 G0 X-30 Y-20
N80 G0 Z40
(top: a groove in four passes)
N90 G0 Z12
#<depth>=10
o20 repeat [4]
  #<depth>=[#<depth>-1.5]
  G1 Z#<depth> F400
  G1 X30 F1200
  G0 Z12
  G0 X-30
o20 endrepeat
N100 G0 Z40
(front face: 25 degrees about X, origin 0, 10, 5)
#<_ox>=0 #<_oy>=10 #<_oz>=5 #<_tilt>=25 #<_turn>=0
N110 G0 A-25 C0
o<face> call [-30] [[-20-#<_oy>]*COS[25]+[40-#<_oz>]*SIN[25]]
N120 G0 A0 C0
(side face: 20 degrees about X, then 90 degrees about Z, origin 12, -4, 3)
#<x>=#5420 #<y>=#5421
#<_ox>=12 #<_oy>=-4 #<_oz>=3 #<_tilt>=20 #<_turn>=90
N130 G0 A-20 C-90
o<face> call [#<y>-#<_oy>] [[#<_ox>-#<x>]*COS[20]+[#5422-#<_oz>]*SIN[20]]
N140 G0 A0 C0
(finishing: the table tilts while the tool goes)
N150 G0 X30 Y20 Z30 A-20 C0
N160 G1 Z6 F600
N170 G1 X10 Y21 Z6.5 A-17 F1500
N180 G1 X-10 Y21 Z6.5 A-13
N190 G1 X-30 Y20 Z6 A-10
N200 G0 Z40
N210 G0 A0
N220 G0 Z60
N230 M9
N240 M30
