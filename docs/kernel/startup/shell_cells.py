"""``%%bash`` cells whose output arrives whole.

IPython's own hands it on in pieces of a hundred bytes, between which myst-nb breaks the line.
"""

import os
import subprocess

# ipykernel asks commands for colours, which a page would show as escape codes.
os.environ.pop("FORCE_COLOR", None)


def run(line: str, cell: str) -> None:
    """Run a cell in bash, print what it says in order, and fail where it fails."""
    command = ["bash", *line.split(), "-c", cell]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    print(done.stdout, end="")
    if done.returncode != 0:
        raise RuntimeError(f"bash ended with {done.returncode}")


get_ipython().register_magic_function(run, "cell", "bash")  # type: ignore[name-defined] # noqa: F821
