"""Array functions and loops in which the equations are written, run by JAX or by NumPy."""
