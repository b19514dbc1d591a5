"""How a process that is propmap's own has its programs compiled, and keeps them."""

from __future__ import annotations

import importlib.metadata
import os
from pathlib import Path
from typing import Any

LOOPS_AS_FUNCTIONS = "xla_cpu_small_while_loop_byte_threshold=100000000"
"""Loops that touch up to so many bytes become one function each, not one per kernel in them."""

LOOPS_NOT_UNROLLED = "xla_cpu_disable_loop_unrolling"
"""Where the few points of a fit are one vector, unrolled loops over stations gain nothing."""

KNOWN_JAXLIB = "0.10."
"""Versions that take the two: one that does not would end the process."""


def compile_quickly() -> None:
    """Have XLA spend less time on compiling.

    A third less on programs for few points and those of axial flow, a seventh less on those of
    oblique batches.  Programs for few points also run faster, large batches as fast, see
    docs/performance.md.  It is a setting of the whole process, other
    programs than propmap's included, read when JAX first computes something: call it before, and
    only where the process is yours; the command line does.  The environment's own
    ``xla_backend_extra_options`` in ``XLA_FLAGS`` take precedence, and other jaxlib than
    ``KNOWN_JAXLIB`` is left alone.
    """
    flags, jaxlib = os.environ.get("XLA_FLAGS", ""), importlib.metadata.version("jaxlib")
    if "xla_backend_extra_options" not in flags and jaxlib.startswith(KNOWN_JAXLIB):
        options = f"--xla_backend_extra_options={LOOPS_AS_FUNCTIONS},{LOOPS_NOT_UNROLLED}"
        os.environ["XLA_FLAGS"] = f"{flags} {options}".strip()


def keep_compiled(folder: Path | None = None) -> None:
    """Keep compiled programs on disk, so that later processes start in half the time.

    They go to ``folder``, by default the user's cache folder; JAX's own setting
    ``JAX_COMPILATION_CACHE_DIR`` takes precedence.  It is a setting of the whole process, so only
    programs that own their process call this; the command line does.
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
