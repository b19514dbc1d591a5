"""Whether a recording can be what it is said to be: the place where such checks meet."""

from __future__ import annotations

from propmap.vehicle.logs.consistency import check_consistency
from propmap.vehicle.logs.recording import Recording
from propmap.vehicle.logs.sensor_faults import sensor_faults


def check_recording(recording: Recording) -> list[str]:
    """Look for mistakes in frames, units, columns and clocks, and for sensors that failed.

    What needs the vehicle, its rotors, is in ``propmap.flight.plausible_rpm`` and
    ``propmap.flight.plausible_rotors``.

    Parameters
    ----------
    recording : Recording
        As it was read.

    Returns
    -------
    list of str
        Warnings.

    Raises
    ------
    InputError
        For a mistake that is certain; the line names it and what to do.
    """
    return [*sensor_faults(recording), *check_consistency(recording)]
