"""The exported C headers with numbers that count what is done with them, by a C++ compiler."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import numpy as np

from propmap.export.c_header import vehicle_c_files
from propmap.export.files import identifier, vehicle_name, write_files
from propmap.table import LoadTable
from propmap.vehicle.vehicle import Vehicle

from .needed import program

KINDS = ("sums", "products", "divisions", "roots", "functions")
"""A comparison counts as a sum, as does a change of sign; a function is any other of libm."""

COUNTED = """
#include <cmath>
#include <cstdio>
static long done[5];
struct counted {
    double x;
    counted() = default;
    constexpr counted(double value) : x(value) {}
    explicit operator int() const { return (int)x; }
};
#define COMBINE(op, kind) \\
    static inline counted operator op(counted a, counted b) { ++done[kind]; return a.x op b.x; } \\
    static inline counted &operator op##=(counted &a, counted b) { return a = a op b; }
COMBINE(+, 0) COMBINE(-, 0) COMBINE(*, 1) COMBINE(/, 2)
#define COMPARE(op) \\
    static inline bool operator op(counted a, counted b) { ++done[0]; return a.x op b.x; }
COMPARE(<) COMPARE(>) COMPARE(<=) COMPARE(>=) COMPARE(==)
static inline counted operator-(counted a) { ++done[0]; return -a.x; }
#define FUNCTION(name, kind) \\
    static inline counted name(counted a) { ++done[kind]; return std::name(a.x); }
FUNCTION(sqrt, 3) FUNCTION(fabs, 0) FUNCTION(floor, 4)
FUNCTION(sin, 4) FUNCTION(cos, 4) FUNCTION(exp, 4) FUNCTION(tanh, 4)
#define OF_TWO(name, kind) \\
    static inline counted name(counted a, counted b) { ++done[kind]; return std::name(a.x, b.x); }
OF_TWO(atan2, 4) OF_TWO(hypot, 4) OF_TWO(remainder, 4) OF_TWO(fmax, 0) OF_TWO(fmin, 0)
static inline bool isnan(counted a) { ++done[0]; return std::isnan(a.x); }
static inline bool isfinite(counted a) { ++done[0]; return std::isfinite(a.x); }
"""

MAIN = """
#include "{vehicle}.h"
int main(void)
{{
    double row[{width}];
    for (;;) {{
        counted given[{width}];
        int k;
        for (k = 0; k < {width}; ++k) {{
            if (std::scanf("%lf", &row[k]) != 1) return 0;
            given[k] = row[k];
        }}
        for (k = 0; k < 5; ++k) done[k] = 0;
        (void){vehicle}_wrench(given, given + {k}, given + {k} + 3, given + {k} + 6);
        std::printf("%ld %ld %ld %ld %ld\\n", done[0], done[1], done[2], done[3], done[4]);
    }}
}}
"""


def counts(vehicle: Vehicle, table: LoadTable, folder: Path, rows: np.ndarray) -> np.ndarray:
    """What each call does (n, 5), by ``KINDS``; rows of omega, velocity, rates, wind."""
    write_files(vehicle_c_files(vehicle, table), folder, replace=True)
    name, k = vehicle_name(vehicle, table), len(vehicle.mounts)
    rotor = folder / f"{identifier(table)}.h"
    text = re.sub(r"typedef double (\w+_real);", r"typedef counted \1;", rotor.read_text())
    rotor.write_text(text.replace("#include <math.h>", COUNTED))
    (folder / "count.cpp").write_text(MAIN.format(vehicle=name, width=k + 9, k=k))
    command = [program("g++"), "-w", "count.cpp", "-o", "count"]
    subprocess.run(command, cwd=folder, check=True)
    asked = " ".join(map(repr, rows.ravel().tolist()))
    done = subprocess.run([folder / "count"], input=asked, capture_output=True, text=True)
    return np.array(done.stdout.split(), int).reshape(-1, len(KINDS))
