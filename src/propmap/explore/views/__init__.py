"""List of all views in the order of the menu."""

from __future__ import annotations

from propmap.explore.view import View
from propmap.explore.views.aircraft import AircraftView
from propmap.explore.views.blade import BladeView
from propmap.explore.views.compare import CompareView
from propmap.explore.views.constants import ConstantsView
from propmap.explore.views.disk import DiskView
from propmap.explore.views.loads import LoadsView

CLASSES = LoadsView, DiskView, BladeView, ConstantsView, CompareView, AircraftView
VIEWS: tuple[View, ...] = tuple(view() for view in CLASSES)
