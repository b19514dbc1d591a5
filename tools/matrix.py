"""Test the sdist with several Pythons, dependencies and compilers; print a table.

Usage: python -m tools.matrix DIST [PYTHON ...]

DIST contains one sdist.  Each PYTHON is a version or the path of an interpreter, in ascending
order (default: 3.11 to 3.14, from PATH or pyenv).  Each Python is tested with the oldest and with
the newest dependencies that ``pyproject.toml`` allows and that have wheels.  The first and the last
Python are also tested with a core compiled by clang (from PATH) and by Zig.  The tests are those
that need no extra.  The table names the environments that were not available.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tarfile
import tempfile
import tomllib
from pathlib import Path

PYTHONS = ("3.11", "3.12", "3.13", "3.14")
AGES = {"oldest": "lowest-direct", "newest": "highest"}
"""Age of the dependencies, and the resolution of uv that selects them."""

TESTS = (
    "tests/core/test_core.py",
    "tests/core/test_elementary.py",
    "tests/model",
    "tests/catalogue",
    "tests/table",
    "tests/rotor/test_limits.py",
    "tests/oracle/test_extended_reference.py",
    "tests/cli/test_demo.py",
    "tests/cli/test_predict.py",
    "--ignore=tests/table/test_backward.py",
    "--ignore=tests/table/test_deviations.py",
    "--ignore=tests/table/test_jax_query.py",
)
VERSIONS = """\
import platform
from importlib.metadata import version
print(platform.python_version(), version("numpy"), version("scipy"))"""
ZIG = '#!/bin/sh\nexec "{python}" -m ziglang {name} "$@"\n'


class Matrix:
    """The environments in which the sdist of a folder is tested, and a folder for their files."""

    def __init__(self, dist: Path, folder: Path) -> None:
        (self.sdist,), self.folder = dist.resolve().glob("*.tar.gz"), folder
        with tarfile.open(self.sdist) as archive:
            archive.extractall(folder, filter="data")
        (self.source,) = (path.parent for path in folder.glob("*/pyproject.toml"))
        (self.source / "src").rename(folder / "not-importable")
        project = tomllib.loads((self.source / "pyproject.toml").read_text(encoding="utf-8"))
        self.dependencies = project["project"]["dependencies"]
        self.zig = folder / "zig"
        self.zig.mkdir()
        for name in ("ar", "c++", "cc", "ranlib"):
            (self.zig / name).write_text(ZIG.format(python=sys.executable, name=name))
            (self.zig / name).chmod(0o755)
        self.wheels: dict[str, Path] = {}

    def run(self, *command: object, **variables: str) -> str:
        """Return the output of a command, which must succeed."""
        pyenv = map(str, Path.home().glob(".pyenv/versions/3.1[1-9]*/bin"))
        path = os.pathsep.join([*pyenv, os.environ["PATH"]])
        return subprocess.run(
            [str(part) for part in command],
            cwd=self.source,
            env=os.environ | {"PATH": path} | variables,
            capture_output=True,
            check=True,
            text=True,
        ).stdout.strip()

    def uv(self, *command: object, **variables: str) -> str:
        """Run uv without downloads of Python."""
        uv = (sys.executable, "-m", "uv", "--quiet", "--no-python-downloads")
        return self.run(*uv, *command, **variables)

    def compilers(self, name: str) -> dict[str, str]:
        """Return the environment variables that select a compiler."""
        if name == "zig":
            return {"CC": str(self.zig / "cc"), "CXX": str(self.zig / "c++")}
        folders = map(Path, os.get_exec_path())
        found = [path for folder in folders for path in sorted(folder.glob(f"{name}*"))]
        if not found:
            raise LookupError(f"{name} was not found")
        return {"CXX": str(found[0])}

    def wheel(self, python: str, compiler: str) -> Path:
        """Return the wheel for a Python; an abi3 wheel also serves the later Pythons."""
        earlier = self.wheels.get(compiler)
        if earlier and "abi3" in earlier.name:
            return earlier
        out = Path(tempfile.mkdtemp(dir=self.folder))
        variables = self.compilers(compiler)
        self.uv("build", "--wheel", "--python", python, "--out-dir", out, self.sdist, **variables)
        (self.wheels[compiler],) = out.glob("*.whl")
        return self.wheels[compiler]

    def test(self, python: str, compiler: str, age: str) -> tuple[str, ...]:
        """Return the versions of compiler, Python, NumPy and SciPy, and the counts of tests."""
        place = Path(tempfile.mkdtemp(dir=self.folder))
        self.uv("venv", "--clear", "--python", python, place)
        wheel = self.wheel(python, compiler)
        version = self.run(self.compilers(compiler)["CXX"], "--version").splitlines()[0]
        install = ("pip", "install", "--python", place, "--only-binary", ":all:")
        self.uv(*install, "--resolution", AGES[age], *self.dependencies)
        self.uv(*install, "--no-deps", wheel)
        self.uv(*install, "pytest", "hypothesis")
        versions = self.run(place / "bin" / "python", "-c", VERSIONS).split()
        result = self.run(place / "bin" / "python", "-m", "pytest", "-m", "not slow", *TESTS)
        return (version, *versions, result.splitlines()[-1])


def main(dist: Path, pythons: tuple[str, ...]) -> None:
    """Test and print all environments; end with an error if tests failed in one of them."""
    cases = [(python, "c++", age) for python in pythons for age in AGES]
    # Builds for Python 3.12 and later use the stable ABI, whose headers include fewer headers of
    # the C library.  A missing header may fail only there.
    for python in dict.fromkeys((pythons[0], pythons[-1])):
        cases += [(python, compiler, "newest") for compiler in ("clang++", "zig")]
    heads = (
        "requested",
        "compiler",
        "dependencies",
        "version",
        "Python",
        "NumPy",
        "SciPy",
        "tests",
    )
    print(f"| {' | '.join(heads)} |\n{'|---' * len(heads)}|")
    failed = False
    with tempfile.TemporaryDirectory(prefix="propmap-matrix-") as name:
        matrix = Matrix(dist, Path(name))
        for case in cases:
            try:
                found = matrix.test(*case)
            except LookupError as missing:
                found = ("", "", "", "", f"not run: {missing}")
            except subprocess.CalledProcessError as error:
                tested = "pytest" in error.cmd and "-m" in error.cmd
                failed |= tested or "build" in error.cmd
                lines = (error.stdout + error.stderr).strip().splitlines()
                reason = next((line for line in lines if "error: " in line), lines[-1])
                found = ("", "", "", "", lines[-1] if tested else f"not tested: {reason}")
            print(f"| {' | '.join((*case, *found))} |", flush=True)
    sys.exit(failed)


if __name__ == "__main__":
    main(Path(sys.argv[1]), tuple(sys.argv[2:]) or PYTHONS)
