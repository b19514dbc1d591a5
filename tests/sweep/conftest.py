from __future__ import annotations

import pytest

from .small_sweep import swept


@pytest.fixture(scope="session")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Files of the small sweep, run in one go in this process."""
    return swept(tmp_path_factory.mktemp("whole") / "map.zarr")
