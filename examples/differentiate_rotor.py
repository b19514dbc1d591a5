"""Derivatives of a rotor's loads with JAX: by the flight state and by the section's constants."""

import jax
import jax.numpy as jnp
import numpy as np

import propmap
from propmap.solve.rotor_loads import rotor_loads

rotor = propmap.Rotor(propmap.Model(propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc")))
omega = 6000 * np.pi / 30  # rad/s


@jax.jit
def thrust(law, omega, velocity):
    """Thrust [N] for a velocity (axial, in-plane) [m/s]."""
    arrays = rotor.arrays._replace(law=law)
    # The solver works on batches: here a batch of one.
    omega, axial, inplane = (jnp.reshape(x, 1) for x in (omega, *velocity))
    return rotor_loads(arrays, omega, axial, inplane).loads.thrust[0]


with jax.enable_x64(True):
    law, velocity = rotor.arrays.law, jnp.array([3.0, 8.0])
    derivatives = jax.jacfwd(thrust, argnums=(0, 1, 2))
    by_law, by_omega, by_velocity = derivatives(law, omega, velocity)
    print("d thrust / d omega    ", float(by_omega), "N s/rad")
    print("d thrust / d velocity ", np.asarray(by_velocity), "N s/m, axial and in-plane")
    print("d thrust / d c_l1     ", float(by_law.c_l1), "N rad")
    print("d thrust / d alpha_0  ", float(by_law.alpha_0), "N/rad")

    # The same by differences of the computed thrust.
    ahead, behind = (thrust(law, omega, velocity.at[0].add(h)) for h in (1e-3, -1e-3))
    print("by differences, axial ", float(ahead - behind) / 2e-3, "N s/m")
