"""``%%bash`` cells that print their output in one piece.

IPython's own cells print pieces of a hundred bytes, and myst-nb breaks the line between them.
"""

import os
import subprocess

# ipykernel asks commands for colors, which a page would show as escape codes.
os.environ.pop("FORCE_COLOR", None)


def run(line: str, cell: str) -> None:
    """Run a cell in bash, print its output, and raise if it fails."""
    command = ["bash", *line.split(), "-c", cell]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    print(done.stdout, end="")
    if done.returncode != 0:
        raise RuntimeError(f"bash ended with status {done.returncode}")


get_ipython().register_magic_function(run, "cell", "bash")  # type: ignore[name-defined] # noqa: F821
