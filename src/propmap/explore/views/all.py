"""All views, in the order of the menu."""

from __future__ import annotations

from propmap.explore.view import View
from propmap.explore.views.disk import DiskView
from propmap.explore.views.loads import LoadsView

VIEWS: tuple[View, ...] = (LoadsView(), DiskView())
