"""Small hand-made files in the layouts of other programs and instruments: one blade, one polar."""

from __future__ import annotations

import re

import numpy as np

BLADE = [(0.2, 0.15, 38.0), (0.4, 0.21, 30.0), (0.6, 0.22, 21.0), (0.8, 0.17, 15.0)]
BLADE += [(1.0, 0.04, 10)]
RADIUS = 0.1
UIUC = "r/R c/R beta\n" + "".join(f"{r:.2f} {c:.3f} {b:.2f}\n" for r, c, b in BLADE)
CSV = "# blades: 2\nradius_m,chord_m,twist_deg\n" + "".join(
    f"{r * RADIUS!r},{c * RADIUS!r},{b}\n" for r, c, b in BLADE
)
QPROP = """
Hand-made 8x6

 2        ! Nblades  [ R ]

 0.50   5.8   ! CL0     CL_a
-0.3    1.2   ! CLmin   CLmax

 0.028  0.050  0.020  0.5  ! CD0 CD2u CD2l CLCD0
 70000  -0.7               ! REref  REexp

 0.0254  0.0254  1.0  ! Rfac   Cfac   Bfac
 0.0     0.0     0.0  ! Radd   Cadd   Badd

#  r    chord   beta
""" + "".join(f" {r * RADIUS / 0.0254!r}  {c * RADIUS / 0.0254!r}  {b}\n" for r, c, b in BLADE)
XROTOR = """XROTOR VERSION:   7.55
hand-made
!         Rho          Vso          Rmu           Alt
   1.2260       340.00      0.17800E-04  0.99900E+03
!         Rad          Vel          Adv          Rake
  0.10000       1.0000      0.15000       0.0000
!         XI0          XIW
  0.15000       0.0000
!  Naero
           1
!   Xisection
   0.0000
!       A0deg        dCLdA        CLmax         CLmin
  -4.0000       6.2800       1.2000      -0.5000
!   #stations    #blades
     5    2
!     r/R         C/R       Beta0deg        Ubody
""" + "".join(f"  {r:.2f}  {c:.3f}  {b}  0.0\n" for r, c, b in BLADE)
BEM = (
    """...BEM Propeller...
Num_Sections: 5
Num_Blade: 2
Diameter: 0.2
Beta 3/4 (deg): 16.7
Normal: -1.0, 0.0, 0.0

Radius/R, Chord/R, Twist (deg), Rake/R, Skew/R, Sweep, t/c, CLi, Axial, Tangential
"""
    + "".join(f"{r:.2f}, {c:.3f}, {b}, 0, 0, 0, 0.1, 0.5, 0, 0\n" for r, c, b in BLADE)
    + ("\nSection 0 X, Y\n1.00, 0.001\n0.5, 0.05\n0.0, 0.0\n")
)
PERFILE = """
         8x6E                        (8x6E.dat)

         PROP RPM =       4000

         V          J           Pe         Ct         Cp          PWR         Torque      Thrust
       (mph)     (Adv Ratio)    -           -           -         (Hp)       (In-Lbf)     (Lbf)
        0.0        0.0000      0.0000      0.0990      0.0490      0.013       0.200      0.190
       10.0        0.3300      0.5000      0.0850      0.0500      0.013       0.200      0.160
       20.0        0.6600      0.7000      0.0500      0.0430      0.011       0.170      0.100

         PROP RPM =       6000

         V          J           Pe         Ct         Cp          PWR         Torque      Thrust
       (mph)     (Adv Ratio)    -           -           -         (Hp)       (In-Lbf)     (Lbf)
        0.0        0.0000      0.0000      0.1000      0.0480      0.043       0.450      0.430
       15.0        0.3300      0.5000      0.0860      0.0490      0.043       0.450      0.370
"""
_NEW = "PWR         Torque      Thrust      THR/PWR        Mach        Reyn        FOM"
PERFILE_OF_2022 = re.sub(
    r"^(\s+\d+\.0 .*)$",
    r"\1  10.0   0.02   0.8   8.0   0.12   5.0E+04   -NaN",
    PERFILE.replace("Thrust\n", f"Thrust      {_NEW}\n").replace("(Adv Ratio)", "(Adv_Ratio)"),
    flags=re.MULTILINE,
)
POLAR = [
    *((-8, -0.5, 0.05), (-4, -0.2, 0.02), (0, 0.3, 0.02), (4, 0.7, 0.02)),
    *((8, 1.0, 0.03), (12, 1.2, 0.05), (16, 1.0, 0.15), (20, 0.9, 0.25)),
]
POLARS = {
    "without Re": "alpha_deg,cl,cd\n" + "".join(f"{a},{c},{d}\n" for a, c, d in POLAR),
    "other names": "Alpha;Cl;Cd;Cm\n" + "".join(f"{a};{c};{d};0.1\n" for a, c, d in POLAR),
    "airfoiltools": "Xfoil polar. Reynolds number fixed. Mach number fixed\nPolar key,xf-x-50000\n"
    "Airfoil,x\nReynolds number,50000\nNcrit,9\nMach,0\nMax Cl/Cd,20\n\n"
    "Alpha,Cl,Cd,Cdp,Cm,Top_Xtr,Bot_Xtr\n"
    + "".join(f"{a},{c},{d},0.01,-0.1,0.5,0.9\n" for a, c, d in POLAR),
    "XFOIL without Re": " x\n\n  alpha    CL        CD\n ------ -------- ---------\n"
    + "".join(f" {a} {c} {d}\n" for a, c, d in POLAR),
    "XFLR5": "xflr5 v6.47\n\n Mach = 0.000     Re =     0.050 e 6     Ncrit = 9.000\n\n"
    "   alpha,  CL,  CD,  CDp\n" + "".join(f" {a}, {c}, {d}, 0.01\n" for a, c, d in POLAR),
    "CCBlade": "hand-made\n50000.0\n0.0\n"
    + "".join(f"{np.radians(a):.12f} {c} {d}\n" for a, c, d in POLAR),
    "CCBlade in degrees": "hand-made\n5e4\n0.0\n"
    + "".join(f"{a:.2f} {c} {d} -0.1\n" for a, c, d in POLAR),
}
STAND_NAMES = (
    "Time (s),ESC signal (\u00b5s),Torque (N\u00b7m),Thrust (gf),Voltage (V),Current (A),"
    "Motor Electrical Speed (RPM),Motor Optical Speed (RPM),Electrical Power (W),Vibration (g)"
)


def stand(rows: list[tuple[float, float, float]]) -> str:
    """Return the file of a thrust stand for rows of rpm, thrust [N] and torque [N m]."""
    lines = (
        f"{k},1500,{q!r},{t / 9.80665e-3!r},11.1,5,{rpm!r},0,60,0.1"
        for k, (rpm, t, q) in enumerate(rows)
    )
    return "\n".join([STAND_NAMES, *lines]) + "\n"
