"""A DataFlash log as ArduPilot 4.6 writes it: FMT messages, then the rest in order of time.

By the published format, https://ardupilot.org/dev/docs/code-overview-adding-a-new-log-message.html,
and the layouts of that release's LogStructure.h.  It shares no code with the reader.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np

from propmap.vehicle.log import FlightLog
from tests.flight.commands import Commands

from .write_logs import RPM, InFrames

CODES = {"Q": "Q", "B": "B", "H": "H", "h": "h", "I": "I", "f": "f", "c": "h", "C": "H", "e": "i"}
TEXTS = {"n": 4, "N": 16, "Z": 64}
LAYOUTS = {
    "FMT": (128, "BBnNZ", "Type,Length,Name,Format,Columns"),
    "PARM": (64, "QNff", "TimeUS,Name,Value,Default"),
    "ATT": (65, "QffffffB", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw,AEKF"),
    "IMU": (66, "QBffffffIIfBBHH", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz"),
    "XKF1": (67, "QBccCfffffffccce", "TimeUS,C,Roll,Pitch,Yaw,VN,VE,VD,dPD,PN,PE,PD,GX,GY,GZ,OH"),
    "ESC": (68, "QBffffcfcf", "TimeUS,Instance,RPM,RawRPM,Volt,Curr,Temp,CTot,MotTemp,Err"),
    "RPM": (69, "QBffB", "TimeUS,I,RPM,Qual,H"),
    "RCOU": (70, "QHHHHHHHHHHHHHH", "TimeUS,C1,C2,C3,C4,C5,C6,C7,C8,C9,C10,C11,C12,C13,C14"),
    "BAT": (71, "QBfffffcfBBB", "TimeUS,Inst,Volt,VoltR,Curr,CurrTot,EnrgTot,Temp,Res,RemPct,H,SH"),
}


def _message(kind: str, values: list[Any]) -> bytes:
    number, letters, _ = LAYOUTS[kind]
    body = bytes([0xA3, 0x95, number])
    for letter, value in zip(letters, values, strict=True):
        if letter in TEXTS:
            body += str(value).encode().ljust(TEXTS[letter], b"\0")
        else:
            scaled = round(100.0 * value) if letter in "cCe" else value
            body += struct.pack(f"<{CODES[letter]}", scaled)
    return body


def write_dataflash(
    log: FlightLog,
    path: Path,
    *,
    leave_out: tuple[str, ...] = (),
    outputs: dict[int, int | None] | None = None,
    speeds: str = "ESC",
    silent: tuple[int, float, float] = (0, 0.0, 0.0),
    driven: Commands | None = None,
) -> str:
    """Write a ``log``, beside a second IMU and filter that are off.  Gives the ``[log]`` table.

    outputs : by the number of the output, from 1, the motor that it turns, or None for a servo;
    by default outputs 1 to 4 turn motors 1 to 4.  speeds : the message that has them.
    silent : output that does not report, and from when to when [s].  driven : what outputs and the
    first of two batteries have, else the outputs are trimmed and there is no battery.
    """
    seen = InFrames(log, "frd", "ned")
    turns = np.degrees(seen.rotation.as_euler("ZYX")[:, ::-1])
    turns[:, 2] %= 360.0
    outputs = outputs or {k: k for k in range(1, log.rotor_speed.shape[1] + 1)}
    rows: list[bytes] = []
    for kind, (number, letters, columns) in LAYOUTS.items():
        length = len(_message(kind, ["" if c in TEXTS else 0 for c in letters]))
        if kind not in leave_out:
            rows.append(_message("FMT", [number, length, kind, letters, columns]))
    for output, motor in outputs.items():
        function = 32 + motor if motor else 7
        rows.append(_message("PARM", [0, f"SERVO{output}_FUNCTION", function, 0.0]))
    first = min(output for output, motor in outputs.items() if motor)
    before = 8 if first > 8 else 0
    for i, stamp in enumerate(np.round(log.time * 1e6).astype(int).tolist()):
        stamp += 1_000_000
        roll, pitch, yaw = turns[i].tolist()
        written = {"ATT": [[stamp, 0.0, roll, 0.0, pitch, 0.0, yaw, 3]], "IMU": [], "XKF1": []}
        for unit, off in ((1, 0.3), (0, 0.0)):
            motion = [*(seen.rates[i] + off).tolist(), *(seen.specific_force[i] + off).tolist()]
            written["IMU"].append([stamp, unit, *motion, 0, 0, 40.0, 1, 1, 2000, 2000])
            speed = [*(seen.world_velocity[i] + off).tolist(), 0.0]
            place = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
            written["XKF1"].append([stamp, unit, roll, pitch, yaw, *speed, *place])
        pulses = [1500] * 14
        if driven:
            for output, motor in outputs.items():
                if motor:
                    pulses[output - 1] = round(1000.0 + 1000.0 * driven.share[i, motor - 1])
            rest = [9.0, 100.0, 1.5, 0.0, 0.01, 90, 1, 100]
            volts = float(driven.voltage[i])
            written["BAT"] = [[stamp, k, v, v, *rest] for k, v in ((0, volts), (1, 0.0))]
        written["RCOU"] = [[stamp, *pulses]]
        written[speeds] = []
        for output, motor in outputs.items():
            if output == silent[0] and silent[1] < log.time[i] < silent[2]:
                continue
            rpm = float(log.rotor_speed[i, motor - 1] / RPM) if motor else 0.0
            if speeds == "RPM":
                written["RPM"].append([stamp, output - 1, rpm, 1.0, 1])
            else:
                rest = [rpm, 15.2, 4.0, 35.0, 10.0, 40.0, 0.0]
                written["ESC"].append([stamp, output - 1 - before, rpm, *rest])
        for kind, several in written.items():
            if kind not in leave_out:
                rows += [_message(kind, values) for values in several]
    path.write_bytes(b"".join(rows))
    return "[log]\n"
