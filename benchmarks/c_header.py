"""How fast the exported C header answers; needs gcc."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from propmap.export import export_table
from propmap.table import LoadTable

POINTS = 100_000

PROGRAM = """
#define _POSIX_C_SOURCE 199309L
#include "{name}.h"
#include <stdio.h>
#include <time.h>

static {name}_real point[{points}][3];

int main(void)
{{
    {name}_real sum = 0;
    double best = 1e9;
    int i, k, repeat;
    for (i = 0; i < {points}; ++i) {{
        double x;
        for (k = 0; k < 3; ++k) {{
            if (scanf("%lf", &x) != 1) {{
                return 1;
            }}
            point[i][k] = ({name}_real)x;
        }}
    }}
    for (repeat = 0; repeat < 20; ++repeat) {{
        struct timespec from, to;
        double spent;
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &from);
        for (i = 0; i < {points}; ++i) {{
            sum += {name}_loads(point[i][0], point[i][1], point[i][2]).thrust;
        }}
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &to);
        spent = (double)(to.tv_sec - from.tv_sec) + 1e-9 * (double)(to.tv_nsec - from.tv_nsec);
        best = spent < best ? spent : best;
    }}
    fprintf(stderr, "%g", (double)sum);
    printf("%.17g", best / {points});
    return 0;
}}
"""


def c_nanoseconds(table: LoadTable, *, single: bool = False) -> float | None:
    """Least processor time per point [ns], random points of the envelope, -O2; None without gcc."""
    gcc = shutil.which("gcc")
    if gcc is None:
        return None
    low, high = np.array(list(table.envelope.values())).T
    points = low + (high - low) * np.random.default_rng(0).random((POINTS, 3))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        header, _ = export_table(table, "c", folder)
        (folder / "main.c").write_text(PROGRAM.format(name=header.stem, points=POINTS))
        define = [f"-D{header.stem.upper()}_FLOAT"] if single else []
        command = [gcc, "-std=c99", "-O2", *define, "main.c", "-o", "main", "-lm"]
        subprocess.run(command, cwd=folder, check=True)
        text = "\n".join(" ".join(map(repr, row)) for row in points.tolist())
        done = subprocess.run(
            [folder / "main"], input=text, capture_output=True, text=True, check=True
        )
    return 1e9 * float(done.stdout)
