"""Reader of ArduPilot's DataFlash logs (.bin), whose frames are FRD and NED."""

from __future__ import annotations

import contextlib
import io
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from propmap.errors import InputError
from propmap.typing import Floats
from propmap.units import MICROSECOND
from propmap.vehicle.files import LogMap
from propmap.vehicle.log import Recording, Signal, known_at, motor_slots, quaternion_of_angles
from propmap.vehicle.throttle import PULSES, share_of_full, worth_of_throttle

# Fields by message; the reader uses the first message of each group that the log contains.  Units:
# deg, m/s, rad/s, m/s^2, rpm; see https://ardupilot.org/copter/docs/logmessages.html.
ANGLES = dict.fromkeys(("ATT", "AHR2"), ("Roll", "Pitch", "Yaw"))
VELOCITY = dict.fromkeys(("XKF1", "NKF1"), ("VN", "VE", "VD"))
INERTIAL = {"IMU": ("GyrX", "GyrY", "GyrZ", "AccX", "AccY", "AccZ")}
SPEEDS = {"ESC": ("RPM",), "RPM": ("RPM",)}
BATTERY = dict.fromkeys(("BAT", "CURR"), ("Volt",))
FIELDS = {**ANGLES, **VELOCITY, **INERTIAL, **SPEEDS, **BATTERY}
INSTANCES = ("I", "C", "Inst", "Instance")
"""Fields with the number of the sensor, filter or motor controller, from 0."""

COMMANDS = "RCOU"
LIMITS = ("MOT_PWM_MIN", "MOT_PWM_MAX")
"""Message with the motor pulses, for logs without rotor speeds, and parameters with their range."""

MOTORS = {
    **{32 + number: number for number in range(1, 9)},
    **{73 + number: number for number in range(9, 13)},
}
"""Motor number by ``SERVOn_FUNCTION``."""

ON_COPROCESSOR = 8
"""Number of outputs of a coprocessor.  On boards with one, controller 0 may drive output 9."""

HEAD = b"\xa3\x95"  # first bytes of each message
AS_WRITTEN = "give the original .bin file of ArduPilot"

Samples = Mapping[tuple[str, int], Floats]
"""Rows of time [s] and fields, (n, 1 + fields), by message and instance."""


def read_dataflash(path: Path, log: LogMap) -> Recording:
    """Read a DataFlash log of ArduPilot.

    - Attitude: ATT, or AHR2.
    - Velocity: XKF1, or NKF1.
    - Rates and specific force: IMU.
    - Rotor speeds: ESC, or RPM, in rpm unless the ``log`` map specifies "erpm".
      ``SERVOn_FUNCTION`` assigns controllers to motors; other controllers are left out.
    - Without rotor speeds: the commands of RCOU, assigned in the same way, with the voltage of BAT,
      or CURR.

    Of several sensors or filters the first one is read.  The frames are always FRD and NED.
    """
    samples, parameters = _messages(path)

    def first(sources: Mapping[str, tuple[str, ...]]) -> tuple[str, Floats]:
        key = min(
            (key for key in samples if key[0] in sources),
            key=lambda key: ([*sources].index(key[0]), key[1]),
        )
        return key[0], samples[key]

    attitude, angles = first(ANGLES)
    filtered, velocity = first(VELOCITY)
    _, inertial = first(INERTIAL)
    roll, pitch, yaw = np.radians(angles[:, 1:].T)
    commanded, supply = (COMMANDS, 0) in samples, None
    notes: tuple[str, ...] = ()
    if commanded:
        rotor_speed = _commands(samples[COMMANDS, 0], parameters, log.throttle_range)
        if any(kind in BATTERY for kind, _ in samples):
            name, rows = first(BATTERY)
            worth = worth_of_throttle(rows[:, 1:], f"voltage ({name})", inverse=False)
            supply = Signal(f"voltage ({name})", rows[:, 0], worth)
    else:
        turned, notes = _rotor_speed(samples, parameters)
        factor = log.rotor_factor("erpm" if log.rotor_unit == "erpm" else "rpm")
        rotor_speed = Signal(turned.name, turned.time, turned.values * factor)
    return Recording(
        source=str(path),
        body_frame="frd",
        world_frame="ned",
        velocity_in="world",
        attitude=Signal(
            f"attitude ({attitude})", angles[:, 0], quaternion_of_angles(roll, pitch, yaw)
        ),
        velocity=Signal(f"velocity ({filtered})", velocity[:, 0], velocity[:, 1:]),
        rates=Signal("rates (IMU)", inertial[:, 0], inertial[:, 1:4]),
        rotor_speed=rotor_speed,
        specific_force=Signal("specific force (IMU)", inertial[:, 0], inertial[:, 4:]),
        commanded=commanded,
        supply=supply,
        notes=notes,
    )


def _messages(path: Path) -> tuple[Samples, dict[str, float]]:
    """Return the samples of the required messages, and the parameters."""
    from pymavlink.DFReader import DFReader_binary

    class Reader(DFReader_binary):  # type: ignore[misc]
        def init_arrays_fast(self, progress_callback: Any = None) -> None:
            """Find the messages in Python: the C code would print to stderr despite redirection."""
            try:
                self.init_arrays(progress_callback)
            except Exception:
                self.close()
                raise

    samples: dict[tuple[str, int], Floats] = {}
    with path.open("rb") as start:
        if start.read(len(HEAD)) != HEAD:
            raise InputError("not a DataFlash log: the first bytes are wrong", AS_WRITTEN)
    try:
        # pymavlink prints a message for bytes that it skips, such as the rest of the last sector.
        quiet = io.StringIO()
        with contextlib.redirect_stdout(quiet), contextlib.redirect_stderr(quiet):
            file = Reader(str(path))
        with contextlib.closing(file):
            kinds = {name: file.counts[number] for name, number in file.name_to_id.items()}
            _check_present({name for name, count in kinds.items() if count > 0})
            wanted = dict(FIELDS)
            if not any(kinds.get(kind, 0) for kind in SPEEDS):
                outputs = file.formats[file.name_to_id[COMMANDS]].columns
                wanted[COMMANDS] = tuple(name for name in outputs if name != "TimeUS")
            for kind, fields in wanted.items():
                if kinds.get(kind, 0) > 0:
                    columns = _columns(file, kind, ("TimeUS", *fields))
                    rows = np.array([*columns.values()][: 1 + len(fields)], dtype=np.float64).T
                    rows[:, 0] *= MICROSECOND
                    numbers = next((columns[name] for name in INSTANCES if name in columns), None)
                    which = np.zeros(len(rows)) if numbers is None else np.array(numbers)
                    samples |= {(kind, int(k)): rows[which == k] for k in np.unique(which)}
            stated = _columns(file, "PARM", ("Name", "Value")) if kinds.get("PARM") else {}
    except InputError:
        raise
    # Damaged bytes make the parser of pymavlink raise undocumented exceptions.
    except Exception as error:
        found = f"not a DataFlash log: {str(error) or type(error).__name__}"
        raise InputError(found, AS_WRITTEN) from None
    names = [name.rstrip(b"\0").decode(errors="replace") for name in stated.get("Name", ())]
    return samples, dict(zip(names, stated.get("Value", ()), strict=True))


def _columns(file: Any, kind: str, fields: tuple[str, ...]) -> dict[str, list[Any]]:
    """Return these ``fields`` and the instance field of all messages of a kind.

    The result equals that of pymavlink, which unpacks messages one by one in three times the time.
    """
    layout = file.formats[file.name_to_id[kind]]
    if not {*fields} <= {*layout.columns}:
        fault = f"message {kind} has the fields {', '.join(layout.columns)}, expected "
        fault += f"{', '.join(fields)}"
        raise InputError(fault, "give a log of a later ArduPilot release")
    unpack = struct.Struct(layout.msg_struct).unpack_from
    whole = file.data_len - layout.len
    rows = [unpack(file.data_map, at + 3) for at in file.offsets[layout.type] if at <= whole]
    found = {}
    for name in (*fields, *INSTANCES):
        if name in layout.columns:
            place = layout.columns.index(name)
            scale = layout.msg_mults[place]
            found[name] = [row[place] if scale is None else row[place] * scale for row in rows]
    return found


def _check_present(present: set[str]) -> None:
    """Raise ``InputError`` with all missing messages of a log that has ``present`` kinds."""
    wanted = ([*ANGLES], [*VELOCITY], [*INERTIAL], [*SPEEDS, COMMANDS])
    missing = [" or ".join(kinds) for kinds in wanted if not present & {*kinds}]
    if missing:
        found = ", ".join(sorted(present & {*FIELDS, COMMANDS})) or "no required message"
        fault = f"no message {', no '.join(missing)}; found {found}"
        raise InputError(fault, "set LOG_BITMASK to log the missing messages")


def _commands(
    rows: Floats, parameters: Mapping[str, float], limits: tuple[float, float] | None
) -> Signal:
    """Return the motor commands (n, m) among all outputs, as fractions of full throttle."""
    outputs = rows[:, 1:]
    functions = [int(parameters.get(f"SERVO{k + 1}_FUNCTION", 0)) for k in range(outputs.shape[1])]
    slots = motor_slots(functions, MOTORS) or np.flatnonzero(np.ptp(outputs, axis=0))
    low, high = (parameters.get(name, usual) for name, usual in zip(LIMITS, PULSES, strict=True))
    name = f"throttle ({COMMANDS})"
    shares = share_of_full(
        outputs[:, slots], limits or ((low, high) if high > low else PULSES), name
    )
    return Signal(name, rows[:, 0], shares)


def _rotor_speed(
    samples: Samples, parameters: Mapping[str, float]
) -> tuple[Signal, tuple[str, ...]]:
    """Return rotor speeds in the unit of the log, and notes on controllers that are left out.

    Controllers report at different times: all speeds are interpolated to the times of the
    controller with the fewest samples, except times in a gap of any controller.
    """
    kind = next(kind for kind in SPEEDS if any(key[0] == kind for key in samples))
    instances = sorted(number for name, number in samples if name == kind)
    notes: tuple[str, ...] = ()
    if kind == "ESC":
        for before in (0, ON_COPROCESSOR):
            outputs = [f"SERVO{before + k + 1}_FUNCTION" for k in instances]
            slots = motor_slots([int(parameters.get(name, 0)) for name in outputs], MOTORS)
            if slots:
                left = [str(k) for place, k in enumerate(instances) if place not in slots]
                if left:
                    notes = (
                        f"ESC has {len(instances)} instances; those of motors 1 to {len(slots)} "
                        f"are read; instances without a motor are left out: {', '.join(left)}",
                    )
                instances = [instances[place] for place in slots]
                break
    each = [samples[kind, number] for number in instances]
    start, end = max(r[0, 0] for r in each), min(r[-1, 0] for r in each)
    time = min(each, key=len)[:, 0]
    known = [(time >= start) & (time <= end), *(known_at(time, rows[:, 0]) for rows in each)]
    time = time[np.all(known, axis=0)]
    speeds = np.stack([np.interp(time, rows[:, 0], rows[:, 1]) for rows in each], axis=1)
    return Signal(f"rotor speed ({kind})", time, speeds), notes
