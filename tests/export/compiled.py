"""The exported C header behind ctypes."""

from __future__ import annotations

import ctypes
import functools
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from propmap.export import export_table
from propmap.loads import LOADS
from propmap.table import LoadTable

from .needed import program

FLAGS = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O1"]

FIELDS = (*LOADS, "power")

WRAPPER = """
#include "{name}.h"
#include <stddef.h>
typedef {name}_real real;

void loads(size_t n, const real *w, const real *v, const real *b, real *to, int *status)
{{
    size_t i;
    for (i = 0; i < n; ++i, to += {count}) {{
        const {name}_loads_t f = {name}_loads(w[i], v[i], b[i]);
        {fill}
        status[i] = f.status;
    }}
}}

void loads_at_velocity(size_t n, const real *w, const real *x, const real *y, const real *z,
                       real *to, int *status)
{{
    size_t i;
    for (i = 0; i < n; ++i, to += {count}) {{
        const {name}_loads_t f = {name}_loads_at_velocity(w[i], x[i], y[i], z[i]);
        {fill}
        status[i] = f.status;
    }}
}}

void gradient(size_t n, const real *w, const real *x, const real *y, const real *z, real *to,
              int *status)
{{
    size_t i;
    int k;
    for (i = 0; i < n; ++i, to += 4 * {count}) {{
        const {name}_gradient_t f = {name}_gradient(w[i], x[i], y[i], z[i]);
        for (k = 0; k < 4; ++k) {{
            {fill_slopes}
        }}
        status[i] = f.status;
    }}
}}

void omega_for(size_t n, const real *quantity, const real *value, const real *v, const real *b,
               real *to, int *solutions)
{{
    size_t i;
    for (i = 0; i < n; ++i, to += 2) {{
        const {name}_inverse_t f = {name}_omega_for((int)quantity[i], value[i], v[i], b[i]);
        to[0] = f.omega; to[1] = f.least;
        solutions[i] = f.solutions == 0 ? f.status == {upper}_NONE ? 0 : -1
            : f.solutions == 1 ? f.status == {upper}_ONE ? 1 : -1
            : f.status == {upper}_SEVERAL ? f.solutions : -1;
    }}
}}
"""


def shared_library(folder: Path, source: str, name: str = "caller", *options: str) -> ctypes.CDLL:
    """A C source, compiled without a warning and loaded."""
    (folder / f"{name}.c").write_text(source)
    command = [program("gcc"), *FLAGS, *options, "-fPIC", "-shared", f"{name}.c", "-lm"]
    subprocess.run([*command, "-o", f"{name}.so"], cwd=folder, check=True)
    return ctypes.CDLL(str(folder / f"{name}.so"))


def printed(folder: Path, source: str, *options: str) -> str:
    """The output of a C program that compiles without a warning."""
    (folder / "main.c").write_text(source)
    command = [program("gcc"), *FLAGS, *options, "main.c", "-o", "main", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return subprocess.run([folder / "main"], capture_output=True, text=True, check=True).stdout


def addresses(*arrays: np.ndarray) -> list[ctypes.c_void_p]:
    return [ctypes.c_void_p(array.ctypes.data) for array in arrays]


class Compiled:
    """The header of a table, compiled; its functions take arrays (n,)."""

    def __init__(self, table: LoadTable, folder: Path, *, single: bool = False) -> None:
        (header, _) = export_table(table, "c", folder, replace=True)
        upper, fields = header.stem.upper(), list(enumerate(FIELDS))
        text = WRAPPER.format(
            name=header.stem,
            upper=upper,
            fill=" ".join(f"to[{k}] = f.{field};" for k, field in fields),
            fill_slopes=" ".join(f"to[{4 * k} + k] = f.{field}[k];" for k, field in fields),
            count=len(FIELDS),
        )
        define = [f"-D{upper}_FLOAT"] if single else []
        self._library = shared_library(folder, text, "wrapper", *define)
        self._type = np.float32 if single else np.float64

    def __call__(
        self, function: str, width: int, *arguments: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Values (n, width) and the int beside them (n,)."""
        arrays = [np.ascontiguousarray(a, self._type) for a in np.broadcast_arrays(*arguments)]
        count = arrays[0].size
        values, numbers = np.empty((count, width), self._type), np.empty(count, np.intc)
        call = getattr(self._library, function)
        call(ctypes.c_size_t(count), *addresses(*arrays, values, numbers))
        return values.astype(np.float64), numbers


@functools.cache
def compiled_of(table: LoadTable, *, single: bool = False) -> Compiled:
    """The header of a table, which is compiled once."""
    with tempfile.TemporaryDirectory() as folder:
        return Compiled(table, Path(folder) / "c", single=single)
