"""Fits that run while the page goes on: each under a name that its tab alone knows."""

from __future__ import annotations

import logging
import secrets
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from propmap.errors import InputError

MOST = 50
"""Jobs that are remembered."""


@dataclass
class Job:
    """A fit under way or done.

    Attributes
    ----------
    told : str
        How far it is, or what came of it.
    found : mapping of str to float
        Constants, once it is done.
    done, failed : bool
        Whether it has ended, and without a result.
    begun : float
        When it began, by ``time.monotonic``.
    """

    told: str = "waiting for its turn"
    found: Mapping[str, float] = field(default_factory=dict)
    done: bool = False
    failed: bool = False
    begun: float = field(default_factory=time.monotonic)

    @property
    def line(self) -> str:
        """What is told of it, with the time it has taken so far."""
        return self.told if self.done else f"{self.told} ({time.monotonic() - self.begun:.0f} s)"


Work = Callable[[Job], Mapping[str, float]]


class Jobs:
    """All fits of a server, one at a time."""

    def __init__(self) -> None:
        self._kept: OrderedDict[str, Job] = OrderedDict()
        self._lock = threading.Lock()
        self._turn = threading.Lock()

    def begin(self, work: Work) -> str:
        """Do ``work`` in a thread of its own; the name under which it is asked for."""
        name, job = secrets.token_urlsafe(12), Job()
        with self._lock:
            waiting = sum(not other.done for other in self._kept.values())
            if waiting >= MOST:
                raise InputError("too many fits are under way", "wait for one to end")
            self._kept[name] = job
            for old in [k for k, other in self._kept.items() if other.done][: -MOST // 2]:
                del self._kept[old]
        threading.Thread(target=self._run, args=(job, work), daemon=True).start()
        return name

    def get(self, name: str) -> Job | None:
        """A fit by its name; None where there is none of it."""
        with self._lock:
            return self._kept.get(name)

    def _run(self, job: Job, work: Work) -> None:
        with self._turn:
            try:
                job.found = work(job)
            except InputError as error:
                job.told, job.failed = str(error), True
            except Exception:
                logging.getLogger(__name__).exception("a fit failed")
                job.told, job.failed = "the fit failed; the terminal says more", True
        job.done = True
