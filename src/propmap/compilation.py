"""A cache of compiled programs that outlives the process."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any


def keep_compiled(folder: Path | None = None) -> None:
    """Keep compiled programs on disk, so that later processes start in half the time.

    folder : where; by default the user's cache folder.  JAX's own setting
    ``JAX_COMPILATION_CACHE_DIR`` takes precedence.  It is a setting of the whole process,
    so only programs that own their process call this; the command line does.
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
