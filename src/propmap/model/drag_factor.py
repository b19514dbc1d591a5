"""``drag_factor`` is deprecated: what is missing from the rotor drag is no share of it."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

MESSAGE = (
    "drag_factor is deprecated: use the correction mount-drag for what is mounted in the "
    "slipstream, and mount_area to fit it"
)


def warn_of_drag_factor(stacklevel: int) -> None:
    """Raise a ``DeprecationWarning``, so many calls above this one."""
    warnings.warn(MESSAGE, DeprecationWarning, stacklevel=stacklevel + 1)


@contextmanager
def drag_factor_accepted() -> Iterator[None]:
    """Silence this warning: where the factor comes from one who has been warned."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", MESSAGE, DeprecationWarning)
        yield
