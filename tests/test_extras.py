"""What the base installs is what it needs; an extra is named where it is missing."""

from __future__ import annotations

import ast
import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Sequence
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, packages_distributions, requires
from pathlib import Path

import pytest

from propmap.errors import EXTRAS
from tests.docs.pages import ROOT
from tools.import_graph import modules

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
RUN = """
import json, sys
sys.modules.update(dict.fromkeys({hidden}))
from propmap.cli import main
for arguments in json.loads(sys.argv[1]):
    print("exit", main(arguments), file=sys.stderr)
for code in json.loads(sys.argv[2]):
    try: exec(code)
    except ImportError as error: print(error)
"""
POINT = ["--rpm", "6000", "--speed", "10", "--beta", "60"]
ENVELOPE = ["--rpm", "6000:7000", "--speed", "0:2", "--beta", "0:20", "--tolerance", "10%"]
GRID = ["--rpm", "6000,7000", "--speed", "1", "--beta", "20"]
VEHICLE = str(ROOT / "examples" / "px4" / "vehicle.toml")
NEEDS = (
    ("cluster", ["sweep", "apc-8x6e", *GRID, "-o", "a.zarr"]),
    ("cluster", ["table", "apc-8x6e", *ENVELOPE, "--cluster", "local", "-o", "a.npz"]),
    ("explore", ["explore", "apc-8x6e"]),
    ("figures", ["plot", "planform", "apc-8x6e", "-o", "a.png"]),
    ("figures", ["trim", VEHICLE, "--speed", "0", "--picture", "a.png"]),
    ("figures", ["report", "a.npz", "-o", "page"]),
    ("logs", ["fit", "flight", "a.csv", "--vehicle", VEHICLE, "-o", "f.toml"]),
    ("logs", ["vehicle", "from-log", "a.ulg", "-o", "vehicle.toml"]),
    ("netcdf", ["table", "apc-8x6e", *ENVELOPE, "-o", "a.nc"]),
    ("netcdf", ["sweep", "apc-8x6e", *GRID, "-o", "a.nc"]),
    ("netcdf", ["trim", VEHICLE, "--speed", "0,1", "-o", "a.nc"]),
    ("parquet", ["fit", "flight", "a.parquet", "--vehicle", VEHICLE, "-o", "f.toml"]),
)
NEEDED_BY = (
    ("jax", "import propmap.jax"),
    ("jax", "from propmap.table import JaxTable"),
    ("jax", "import propmap.sim.mjx"),
    ("mujoco", "import propmap.sim.mujoco"),
)
"""Commands and imports that need an extra."""


def run(
    commands: Sequence[Sequence[str]], hidden: set[str], folder: Path, imports: Sequence[str] = ()
) -> tuple[list[str], list[str]]:
    """Run commands, then imports, where some packages are not installed: lines of both outputs."""
    code = RUN.format(hidden=sorted(hidden))
    done = subprocess.run(
        [sys.executable, "-c", code, json.dumps(commands), json.dumps(imports)],
        capture_output=True,
        text=True,
        cwd=folder,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines(), done.stderr.splitlines()


@pytest.mark.parametrize("extras", [{*EXTRAS} - {"parquet"}, {"parquet"}], ids=["most", "parquet"])
def test_a_missing_extra_is_named_in_one_line(extras: set[str], tmp_path: Path) -> None:
    """Parquet alone, because without logs it is logs that are missing for its command."""
    files = {"a.csv", "a.ulg", "a.parquet"}
    for name in files:
        (tmp_path / name).write_text("time\n")
    package = {extra: EXTRAS[extra].split()[-1] for extra in extras}
    needs = [(extra, command) for extra, command in NEEDS if extra in extras]
    imports = [(extra, code) for extra, code in NEEDED_BY if extra in extras]
    commands, codes = [command for _, command in needs], [code for _, code in imports]
    out, err = run(commands, {*package.values()}, tmp_path, codes)
    missing = "not installed; run: pip install 'propmap[{}]'"
    told = [line for line in err if not line.startswith("note: ")]
    for (extra, command), line, code in zip(needs, told[::2], told[1::2], strict=True):
        assert line.startswith("propmap: error: ") and code == "exit 2", command
        assert line.endswith(missing.format(extra)), command
    assert out == [f"{package[one]} is {missing.format(one)}" for one, _ in imports]
    assert {path.name for path in tmp_path.iterdir()} == files


def test_every_extra_is_tested() -> None:
    assert {extra for extra, _ in (*NEEDS, *NEEDED_BY)} == {*EXTRAS}


def installed_by(requirements: Sequence[str], extras: Sequence[str] = ()) -> Iterator[str]:
    """Names of distributions that the requirements ask for, and those of the extras named."""
    for requirement in requirements:
        name = re.split(r"[^\w.-]", requirement, maxsplit=1)[0]
        marker = re.search(r"extra *== *['\"]([\w-]+)", requirement)
        if marker is not None and marker[1] not in extras:
            continue
        inner = re.search(r"\[([\w,]+)\]", requirement)
        if name == "propmap" and inner is not None:
            for extra in inner[1].split(","):
                yield from installed_by(PROJECT["optional-dependencies"][extra])
        else:
            yield name.lower().replace("_", "-")


def with_theirs(names: set[str]) -> set[str]:
    """Distributions, and all that they bring where they are installed here."""
    found: set[str] = set()
    while rest := names - found:
        found |= rest
        for name in rest:
            with suppress(PackageNotFoundError):
                names = names | set(installed_by(requires(name) or []))
    return found


BASE = set(installed_by(PROJECT["dependencies"]))
OF_EXTRAS = set(installed_by(PROJECT["optional-dependencies"]["all"]))
THEIRS = packages_distributions()


def distributions(module: str) -> set[str]:
    """Distributions that bring a module; none for Python's own and the package itself."""
    own = module in sys.stdlib_module_names or module == "propmap" or module.startswith("_")
    missing = [] if own else [module]
    found = THEIRS.get(module, missing)
    return {name.lower().replace("_", "-") for name in found} - {"propmap"}


def imported() -> set[str]:
    """Packages of others that the source imports, but for the type checker alone."""

    def names(node: ast.AST) -> Iterator[str]:
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            return
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module or ""
        for child in ast.iter_child_nodes(node):
            yield from names(child)

    trees = (ast.parse(path.read_text(encoding="utf-8")) for path in modules().values())
    found = {name.partition(".")[0] for tree in trees for name in names(tree)}
    return found - {"propmap"} - sys.stdlib_module_names


def test_what_the_source_imports_is_stated_and_what_is_stated_is_imported() -> None:
    needed = [distributions(name) for name in imported()]
    stated = with_theirs(BASE | OF_EXTRAS)
    assert not [found for found in needed if not found & stated]
    assert set().union(*needed) >= BASE


@pytest.mark.parametrize("extra", EXTRAS)
def test_an_extra_installs_what_is_asked_of_it(extra: str) -> None:
    stated = set(installed_by(PROJECT["optional-dependencies"][extra]))
    for name in EXTRAS[extra].split():
        assert distributions(name) & stated, name


def test_all_is_all_that_users_have() -> None:
    others = {"all", "dev", "docs", "peers", "targets"}
    (whole,) = PROJECT["optional-dependencies"]["all"]
    assert {*whole[len("propmap[") : -1].split(",")} == {*PROJECT["optional-dependencies"]} - others
