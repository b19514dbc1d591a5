"""Small hand-made geometry files in the layouts that the readers know."""

from __future__ import annotations

PE0_HEADER = """5x4T                              (5x4T.dat)
v2022-0915

       ----- AIRFOIL SUMMARY DATA -----

     DEFINITIONS:
         CHORD IS THE LENGTH BETWEEN (MOLD) LE AND TE PARTING LINES.

      STATION     CHORD       PITCH       SWEEP    THICKNESS      TWIST      CGY
       (IN)       (IN)       (QUOTED)      (IN)     RATIO         (DEG)      (IN)

"""

PE0_ROWS = """      0.5000      0.4000      4.0000      0.1000      0.1500     44.0000      0.0100
      1.0000      0.6000      4.0000      0.1200      0.1300     32.0000      0.0100
      1.5000      0.6500      4.0000      0.1300      0.1200     23.0000     -0.0100
      2.0000      0.5000      4.0000      0.0800      0.1000     17.0000     -0.0100
      2.5000      0.0100      4.0000     -0.1000      0.1000     14.0000      0.0000
"""

PE0_TRAILER = """

 RADIUS:  2.50    PROPELLER RADIUS (IN)
 HUBTRA:  0.50    HUB TRANSITION (IN)
 BLADES:  2       NUMBER OF BLADES

       ----- INERTIA AND AREA DATA -----
"""

PE0 = PE0_HEADER + PE0_ROWS + PE0_TRAILER

UIUC = """r/R    c/R     beta
0.20   0.150   38.00
0.40   0.210   30.00
0.60   0.220   21.00
0.80   0.170   15.00
1.00   0.040   10.00
"""

CSV = """# name: hand-made
# blades: 3
radius_m,chord_m,twist_deg
0.02,0.015,38
0.04,0.021,30
0.06,0.022,21
0.08,0.017,15
0.10,0.004,10
"""

TOML = """schema = 1
name = "hand-made"
title = "Hand-made"
family = "hand"
blades = 2
radius_m = 0.1
source = "written for a test"
citation = ""
station_m = [0.02, 0.04, 0.06, 0.08, 0.1]
chord_m = [0.015, 0.021, 0.022, 0.017, 0.004]
twist_rad = [0.6, 0.5, 0.4, 0.3, 0.2]
"""
