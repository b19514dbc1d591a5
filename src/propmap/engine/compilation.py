"""Settings of XLA and JAX for a whole process, such as the command line's: faster compilation."""

from __future__ import annotations

import importlib.metadata
import os
from pathlib import Path
from typing import Any

LOOPS_AS_FUNCTIONS = "xla_cpu_small_while_loop_byte_threshold=100000000"
"""XLA option: a loop that touches at most so many bytes becomes one function, not many kernels."""

LOOPS_NOT_UNROLLED = "xla_cpu_disable_loop_unrolling"
"""XLA option.  For the few points of a fit, unrolled loops over stations are no faster."""

KNOWN_JAXLIB = "0.10."
"""Versions that know these options; an unknown option would end the process."""


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
