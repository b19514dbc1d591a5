"""What the paper states, to compare with."""

CITATION = (
    "R. Gill, R. D'Andrea, Propeller Thrust and Drag in Forward Flight, IEEE CCTA 2017, "
    "doi 10.1109/CCTA.2017.8062443"
)
RIBNER = (
    "H. S. Ribner, Formulas for Propellers in Yaw and Charts of the Side-Force Derivative, "
    "NACA TR 819, and Propellers in Yaw, NACA TR 820, 1945"
)

TABLE_1 = {
    "paper-soft": "soft: AR.Drone 2.0",
    "paper-stiff": "stiff: HQP 8x4.5",
    "paper-apc": "APC 8x6",
}
"""The rows of Table I by the names of the parameter sets."""

FLOWN = {"paper-soft": "soft", "paper-stiff": "stiff"}
"""The sets that were flown, and a short name of each propeller."""

RADIUS = 0.1
"""[m] of all three propellers."""

TETHER = 1.7
"""[m], radius of the level circles."""

FASTEST = 14.5
"""[m/s] of the level circles."""

FLIGHTS = 20
"""Level flights of one identification, with four rotors."""

HOVER_FAILS = {"paper-soft": 7.0, "paper-stiff": 9.0}
"""[m/s], flight speed from which the hover model fails."""

SIGN_CHANGES = 7.0
"""[m/s]: below, the hover model's vertical force is too small, above too large."""

TUNNEL_ERROR = 0.09
"""Largest relative error of the model in the tunnel."""

HOVER_TUNNEL_ERROR = 1.0
"""The same of the hover model."""

ONE_POINT = 3.0
"""[s] for one operating point."""

IDENTIFICATION = (2.0 * 3600.0, 10.0 * 3600.0)
"""[s], range of the times for one identification."""
