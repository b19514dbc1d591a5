from __future__ import annotations

import pytest

from propmap.sweep.run import sweep_to_store

from .small_sweep import GRID, POINTS_PER_TASK, contents, rotor


@pytest.fixture(scope="session")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """Files of the small sweep, run in one go in this process."""
    path = tmp_path_factory.mktemp("whole") / "map.zarr"
    sweep_to_store(rotor(), GRID, path, points_per_task=POINTS_PER_TASK)
    return contents(path)
