"""Use the exported polynomial as a CasADi expression, with its gradient."""

import casadi
from apc_8x6e_multinomial import force

state = casadi.SX.sym("omega_x_y_z", 4)  # rad/s, m/s
forces = casadi.vertcat(*force(*casadi.vertsplit(state), 1))  # counter-clockwise
function = casadi.Function("force", [state], [forces, casadi.jacobian(forces, state)])
print(function([628.0, 6.0, 0.0, 1.0]))
