"""What is done about the time that programs take to compile, and all that callers know of it.

Settings of XLA and JAX for a whole process, such as the command line's, and how derivatives are
taken so that fewer programs are compiled.
"""

from __future__ import annotations

import importlib.metadata
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

LOOPS_AS_FUNCTIONS = "xla_cpu_small_while_loop_byte_threshold=100000000"
"""XLA option: a loop that touches at most so many bytes becomes one function, not many kernels."""

LOOPS_NOT_UNROLLED = "xla_cpu_disable_loop_unrolling"
"""XLA option.  For the few points of a fit, unrolled loops over stations are no faster."""

KNOWN_JAXLIB = "0.10."
"""Versions that know these options; an unknown option would end the process."""

FEW = 512
"""Operating points below which a batch shares programs, in order to compile fewer of them."""

DIFFERENCES_UP_TO = {True: 0, False: 128}
"""Operating points up to which differences by NumPy are done before a compiler would be, by whether
the rotor's programs are compiled anyway."""


class Thrift(NamedTuple):
    """How ``Rotor.gradients`` saves compiling.

    Attributes
    ----------
    alike : bool
        Whether any number of points gets the same nodes, so that one pair of programs serves all.
    coarse : bool
        Whether fewer nodes do, as for standard deviations.
    scales : sequence of float
        By how much each parameter may differ, in its unit, above 0, for differences by NumPy.
    few : int
        Points up to which such differences are taken.
    """

    alike: bool = False
    coarse: bool = False
    scales: Sequence[float] = ()
    few: int = 0


NO_THRIFT = Thrift()
"""Each number of points gets the nodes that suit it."""


def for_deviations(scales: Sequence[float], *, compiled: bool, few: int | None = None) -> Thrift:
    """For derivatives that make standard deviations; ``few`` is by default that of
    ``DIFFERENCES_UP_TO``."""
    at_most = DIFFERENCES_UP_TO[compiled] if few is None else few
    return Thrift(alike=True, coarse=True, scales=scales, few=at_most)


def compile_quickly() -> None:
    """Make XLA compile faster, in the whole process.

    Programs for few points and for axial flow compile in a third less time, those for oblique
    batches in a seventh less, and do not note which lines of Python they come from. Programs for
    few points also run faster, large batches as fast, see docs/performance.md. All JAX programs of
    the process are affected, so call this only where the process is yours, as the command line
    does, and before JAX first computes something. Nothing is done to XLA if ``XLA_FLAGS`` has
    ``xla_backend_extra_options``, or for other jaxlib than ``KNOWN_JAXLIB``.
    """
    flags, jaxlib = os.environ.get("XLA_FLAGS", ""), importlib.metadata.version("jaxlib")
    if "xla_backend_extra_options" not in flags and jaxlib.startswith(KNOWN_JAXLIB):
        options = f"--xla_backend_extra_options={LOOPS_AS_FUNCTIONS},{LOOPS_NOT_UNROLLED}"
        os.environ["XLA_FLAGS"] = f"{flags} {options}".strip()
    # Which lines of Python an operation comes from is noted in programs otherwise.
    os.environ.setdefault("JAX_TRACEBACK_IN_LOCATIONS_LIMIT", "0")


def keep_compiled(folder: Path | None = None) -> None:
    """Keep compiled programs on disk, so that later processes start in half the time.

    They go to ``folder``, by default the user's cache folder; the environment variable
    ``JAX_COMPILATION_CACHE_DIR`` takes precedence.  The whole process is affected, so call this
    only where it is yours, as the command line does.
    """
    if os.environ.get("JAX_COMPILATION_CACHE_DIR"):
        return
    import jax
    from platformdirs import user_cache_path

    update: Any = jax.config.update  # untyped in JAX
    place = folder or user_cache_path("propmap") / "compiled"
    update("jax_compilation_cache_dir", str(place))
    update("jax_persistent_cache_min_compile_time_secs", 0.3)
    update("jax_persistent_cache_min_entry_size_bytes", 0)
