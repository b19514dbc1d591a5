"""Install a wheel outside the checkout; print sizes, hashes and times; test the installation.

Usage: python tools/try_wheel.py DIST

DIST contains one wheel and one sdist.  The script installs the wheel without extras into a new
environment in a temporary folder.  There it runs commands, of which some need an extra, and the
getting-started page.  It runs the tests of the sdist that depend on the installed files (builds of
the core, bundled data, loads).  Then it installs two extras and runs the commands that need them.
Finally it deletes the folder.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tarfile
import tempfile
import time
import venv
from hashlib import sha256
from pathlib import Path

LARGEST = 300.0  # maximum size of the environment without extras [MB]
EXTRAS = "figures,netcdf"
PAGE = "tests/docs/test_getting_started.py"
TESTS = (
    "-m 'not slow' tests/core/test_build.py tests/catalogue/test_catalogue.py "
    "tests/catalogue/test_measurements.py tests/oracle"
)
COMMANDS = {
    "--version": 0,
    "predict 'APC 8x6E' --rpm 6000 --speed 10 --beta 60": 0,
    "demo": 0,
    "table apc-8x6e --rpm 5000:7000 --speed 0:10 --beta 0:90 --tolerance 2% -o a.npz": 0,
    "show a.npz": 0,
    "export a.npz --to c -o c": 0,
    "props show apc-8x6e": 0,
    "sweep apc-8x6e --rpm 6000,7000 --speed 1 --beta 20 -o a.csv": 0,
    "trim {source}/examples/px4/vehicle.toml --speed 0,5": 0,
    "explore --help": 0,
    "explore apc-8x6e": 2,
}
"""Commands and their exit codes without extras."""
NEED_EXTRAS = (
    "plot planform apc-8x6e -o a.png",
    "sweep apc-8x6e --rpm 6000,7000 --speed 1 --beta 20 -o a.nc",
)
"""Commands that need ``EXTRAS``."""


def size(folder: Path) -> float:
    """Return the disk space of the files of a folder [MB]."""
    found = [path.stat() for path in folder.rglob("*") if not path.is_symlink()]
    return sum(512 * file.st_blocks for file in found) / 1e6


def main(dist: Path) -> None:
    """Test the wheel and the sdist in ``dist``; the first failure ends the script with an error."""
    (wheel,), (sdist,) = (list(dist.resolve().glob(kind)) for kind in ("*.whl", "*.tar.gz"))
    with tempfile.TemporaryDirectory(prefix="propmap-wheel-") as name:
        folder = Path(name)
        work, place = folder / "empty", folder / "venv"
        work.mkdir()
        with tarfile.open(sdist) as archive:
            archive.extractall(folder / "sdist", filter="data")
        (source,) = (folder / "sdist").iterdir()
        (source / "src").rename(folder / "not-importable")
        venv.create(place, with_pip=True)
        others = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}
        environment = {**others, "PATH": os.pathsep.join([str(place / "bin"), os.environ["PATH"]])}

        def run(command: str, where: Path, code: int = 0) -> str:
            begin = time.monotonic()
            done = subprocess.run(
                ["bash", "-c", command], cwd=where, env=environment, capture_output=True, text=True
            )
            print(f"exit {done.returncode}, {time.monotonic() - begin:5.1f} s: {command}")
            if done.returncode != code:
                sys.exit(f"expected exit {code}\n{done.stdout}\n{done.stderr}")
            if code:
                (line,) = done.stderr.splitlines()
                print(f"    {line}")
            return done.stdout

        def test(what: str) -> None:
            print(f"    {run(f'python -m pytest {what}', source).splitlines()[-1]}")

        pip = f"python -m pip install --quiet --constraint {source / 'constraints.txt'}"
        for file in (sdist, wheel):
            content = file.read_bytes()
            print(f"{file.name}: {len(content) / 1e6:.1f} MB, sha256 {sha256(content).hexdigest()}")
        before = size(place)
        run(f"{pip} {wheel}", work)
        base = size(place)
        print(f"    the environment takes {base:.0f} MB, {before:.0f} before")
        if base > LARGEST:
            sys.exit(f"expected {LARGEST:.0f} MB at most; move new dependencies to an extra")
        for command, code in (COMMANDS | dict.fromkeys(NEED_EXTRAS, 2)).items():
            run(f"propmap {command.format(source=source)}", work, code)
        where = run("python -c 'import propmap; print(propmap.__file__)'", work)
        assert str(place) in where, where
        run(f"{pip} pytest hypothesis", work)
        test(PAGE)
        test(TESTS)
        run(f"{pip} '{wheel}[{EXTRAS}]'", work)
        print(f"    the environment takes {size(place):.0f} MB")
        for command in NEED_EXTRAS:
            run(f"propmap {command}", work)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
