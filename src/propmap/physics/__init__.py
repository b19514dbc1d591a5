"""The paper's equations (1)-(15) as pure functions of arrays, one file per group.

Every function follows the caller's floating-point setting and is safe under ``jit``,
``vmap``, ``jvp`` and ``vjp``.  Arrays carry the blade station on the first axis and the
operating point on the last one, because XLA on a CPU vectorises over the last axis.

Source: R. Gill, R. D'Andrea, "Propeller Thrust and Drag in Forward Flight", IEEE CCTA
2017, doi 10.1109/CCTA.2017.8062443 ("the paper"; its equation numbers are used).
"""
