"""Which request of a tab is its newest."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Mapping
from typing import Any

MOST_TABS = 1000
"""That are remembered."""


class Newest:
    """Which request of a tab is its newest: others need no answer that takes long."""

    def __init__(self) -> None:
        self.in_turn = threading.Lock()
        self._serials: OrderedDict[str, Any] = OrderedDict()
        self._lock = threading.Lock()

    def told(self, asked: Mapping[str, Any]) -> None:
        """Take note of the request that was ``asked``."""
        with self._lock:
            self._serials[_tab(asked)] = asked.get("serial")
            self._serials.move_to_end(_tab(asked))
            while len(self._serials) > MOST_TABS:
                self._serials.popitem(last=False)

    def is_it(self, asked: Mapping[str, Any]) -> bool:
        """Whether none has come from the same tab since this one was ``asked``."""
        return bool(self._serials.get(_tab(asked)) == asked.get("serial"))


def _tab(asked: Mapping[str, Any]) -> str:
    return str(asked.get("tab"))[:40]
