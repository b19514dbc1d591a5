"""Mutation trial: plant one small fault at a time in the code and record which tests fail.

    python -m tools.mutation_trial plan        # choose the mutants, build the core with all of them
    python -m tools.mutation_trial baseline    # durations; which test files execute which mutant
    python -m tools.mutation_trial first       # per mutant: the short tests that execute it
    python -m tools.mutation_trial second      # per survivor: the other tests, until one fails
    python -m tools.mutation_trial report DIR  # mutants.csv and kills_by_test.csv

A stopped command continues where it stopped; `plan` starts over.  All files are in build/mutants.

The core is compiled once with all its mutants.  The environment variable PROPMAP_MUTANT selects the
active mutant by its number; 0 selects none.  Mutants of Python modules are changes of the syntax
tree at import.  Each mutant runs in a forked process, which imports propmap and the tests anew but
inherits the loaded libraries.  Processes started by tests run the same mutant, by `sitecustomize`.
"""

from __future__ import annotations

import argparse
import ast
import atexit
import builtins
import contextlib
import copy
import csv
import ctypes
import faulthandler
import importlib
import importlib.machinery
import importlib.util
import json
import multiprocessing
import os
import random
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time
import traceback
import warnings
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
HOME = ROOT / "build/mutants"
HEADERS = "core/include/propmap"
CORE, ROOMS = "core", ("fit", "table", "vehicle", "model")
SIZES = {CORE: 190} | dict.fromkeys(ROOMS, 50)  # a tenth of the core's mutants do not compile
FIRST = 900_000  # numbers of mutants start here: compiler messages contain no other such numbers
SHORT = 0.2  # s, the longest test of the first pass
# Tests of the core in the first pass.  Most others use the core too, but test something else.
CORE_TESTS = r"(core/test_[ct]|rotor|oracle|model|table|vehicle|sim|test_ref)"
ENOUGH = 8  # failing test functions after which the first pass skips the other tests
LONG = 5.0  # s, the longest test of the second pass
# Loaded before the processes fork.
LIBRARIES = (
    "ambiance casadi dask h5netcdf hypothesis.extra.numpy jax jinja2 matplotlib.pyplot msgspec "
    "mujoco numpy pandas pymavlink.mavutil pytest pyulog rich.table rosbags.rosbag2 "
    "scipy.interpolate scipy.optimize scipy.stats tomli_w typer.testing xarray zarr"
)
PYTEST = (
    "-m 'not slow' -p no:cacheprovider -p no:xdist -p no:faulthandler --tb=no "
    "--continue-on-collection-errors -W ignore::pytest.PytestAssertRewriteWarning"
)

Mutant = dict[str, Any]  # id, room, file, line, code, change; `text` or `path` says how to plant it
Place = list[tuple[str, int | None]]  # of a node in a syntax tree: fields and indices from the root

# --- The core ------------------------------------------------------------------------------------

NUMBER = re.compile(r"(?<![\w.\[])(\d+\.\d*(?:e[-+]?\d+)?|\d+(?:e-\d+)?)(?![\w.])")
TEXT = re.compile(
    r'//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\])\'|^ *#(?:[^\n]*\\\n)*[^\n]*', re.M
)
NOT_MUTATED = re.compile(
    r"\b(?:for|while|decltype|sizeof|static_assert|asm) ?\("
    r"|\btemplate <|\bconcept\b[^;]*;|\brequires "
)
# With up to three levels of brackets.
CONDITION = re.compile(r"\bif \(((?:[^()]|\((?:[^()]|\((?:[^()]|\([^()]*\))*\))*\))*)\)")
EXTREME = re.compile(r"(?<![\w:.] )(?<![\w.])(?:std::)?(min|max)(imum)?\(")
CHANGE = re.compile(r"^ +(?=[\w.\[\]>-]+(?:\([^()]*\))?(?:[.\w\[\]]*) (?:[-+*/&|]=) )", re.M)
SIGN = re.compile(r"(?:(?<=[(\[{,=?:] )|(?<=[(\[{])|(?<=return ))-(?=[A-Za-z(])")


def masked(text: str) -> str:
    """Blank out comments, strings, directives, loop headers and template parameters."""

    def blank(some: str) -> str:
        return re.sub(r"\S", " ", some)

    text = TEXT.sub(lambda match: blank(match[0]), text)
    for match in NOT_MUTATED.finditer(text):
        start, end = match.span()
        if text[start] != " " and text[end - 1] in "(<":
            depth, opening, closing = 1, text[end - 1], {"(": ")", "<": ">"}[text[end - 1]]
            while depth:
                depth += (text[end] == opening) - (text[end] == closing)
                end += 1
        text = text[:start] + blank(text[start:end]) + text[end:]
    return text


def changed_number(text: str) -> str:
    """Change a C++ number: whole ones by 1, zero by 0.1, tolerances by 1000, others by 1.1."""
    if "." not in text and "e" not in text:
        return str(int(text) + 1)
    number = float(text)
    return repr(0.1 if number == 0.0 else number * (1000.0 if number < 1e-5 else 1.1))


def core_sites(text: str) -> Iterator[tuple[int, int, str, str]]:
    """Yield start, end, replacement, with K for the mutant's number, and description of mutants."""
    code = masked(text)
    header = ROOT.joinpath("tools/mutant.hpp").read_text()
    infix = defaultdict(list)
    for name, operator, mutated in re.findall(
        r"^MUTANT_INFIX\((\w+), (\S+), (.*)\)$", header, re.M
    ):
        infix[operator].append((name, mutated.replace(" - R{}", "")))
    for match in re.finditer(r"(?<=[\w)\]}])\s([-+*/<>]|[<>=!]=)(?=\s)", code):
        for name, mutated in infix[match[1]]:
            new = f"{match[0]} mutant::{name}<K>{{}} {match[1]}"
            yield *match.span(), new, f"a {match[1]} b: {mutated}"
    for match in NUMBER.finditer(code):
        new = changed_number(match[0])
        yield *match.span(), f"mutant::value<K>({match[0]}, {new})", f"{match[0]}: {new}"
    for match in re.finditer(r"(?<=[\w)\]]) (\?|&&|\|\|)(?=\s)", code):
        new = f" == mutant::Flip<K>{{}} {match[1]}"
        yield *match.span(), new, f"condition before {match[1]} negated"
    for match in CONDITION.finditer(code):
        end = match.end()
        yield end - 1, end, " == mutant::Flip<K>{})", "last condition of if negated"
    for match in EXTREME.finditer(code.replace("return ", "return(")):
        other = {"min": "max", "max": "min"}[match[1]]
        both = (match[0], match[0].replace(match[1], other))
        new = "mutant::pick<K>(" + ", ".join(f"[](auto... a) {{ return {f}a...); }}" for f in both)
        yield *match.span(), f"{new})(", f"{match[0]}): min and max swapped"
    for match in CHANGE.finditer(code):
        yield match.end(), match.end(), "if (mutant::on<K>()) {} else ", "statement deleted"
    for match in SIGN.finditer(code):
        yield *match.span(), "mutant::Sign<K>{} * ", "sign dropped"


def plan_core(dice: random.Random) -> list[Mutant]:
    """Choose mutants on random lines of the headers, one per line."""
    by_line: dict[tuple[Path, int], list[tuple[int, int, str, str]]] = defaultdict(list)
    for file in sorted((ROOT / HEADERS).glob("*.hpp")):
        text = file.read_text()
        for site in core_sites(text) if file.name != "instructions.hpp" else ():  # CPU detection
            by_line[file, text.count("\n", 0, site[0] + 1) + 1].append(site)
    mutants = []
    chosen = sorted(dice.sample(sorted(by_line), SIZES[CORE]))
    for number, (file, line) in enumerate(chosen, FIRST + 1):
        kinds = defaultdict(list)
        for site in by_line[file, line]:
            kinds[site[3].split(":")[0].strip("0123456789.e-")].append(site)
        start, end, new, change = dice.choice(kinds[dice.choice(sorted(kinds))])
        code = file.read_text().splitlines()[line - 1].strip()
        mutant = {"id": number, "room": CORE, "file": str(file.relative_to(ROOT)), "line": line}
        where = [start, end, new.replace("<K>", f"<{number}>")]
        mutants.append(mutant | {"code": code, "change": change, "text": where})
    return mutants


def write_core(mutants: Sequence[Mutant]) -> None:
    """Write a copy of the core's sources with these mutants."""
    for file in sorted((ROOT / HEADERS).glob("*.hpp")):
        text = file.read_text()
        here = [m["text"] for m in mutants if m["file"] == str(file.relative_to(ROOT))]
        for start, end, new in sorted(here, reverse=True):
            text = text[:start] + new + text[end:]
            line = text.rfind("\n", 0, start) + 1
            if text.startswith("inline constexpr double ", line):  # set when the module is loaded
                text = text[:line] + text[line:].replace("constexpr", "const    ", 1)
        text = text.replace("once\n\n", 'once\n#include "mutant.hpp"\n', 1)
        (HOME / "source" / HEADERS / file.name).write_text(text)


def build_core(mutants: list[Mutant]) -> list[Mutant]:
    """Build the core with all mutants that compile and return these mutants."""
    source, build = HOME / "source", HOME / "core"
    shutil.copytree(ROOT / "core", source / "core")
    shutil.copy(ROOT / "tools/mutant.hpp", source / HEADERS)
    shutil.copy(ROOT / "CMakeLists.txt", source)
    write_core(mutants)
    cmake = Path(sys.executable).with_name("cmake")
    defined = {
        "CMAKE_BUILD_TYPE": "Release",
        "CMAKE_EXPORT_COMPILE_COMMANDS": "ON",
        "CMAKE_MAKE_PROGRAM": cmake.with_name("ninja"),
        "Python_EXECUTABLE": sys.executable,
    }
    options = [f"-D{name}={value}" for name, value in defined.items()]
    subprocess.run([cmake, "-G", "Ninja", "-S", source, "-B", build, *options], check=True)
    commands = json.loads((build / "compile_commands.json").read_text())
    checks = [
        shlex.split(f"{c['command']} -fsyntax-only -Werror=vla -w -fmax-errors=0")
        for c in commands
        if "/source/core/" in c["file"]
    ]
    while errors := "".join(
        subprocess.run(check, cwd=build, capture_output=True, text=True).stderr for check in checks
    ):
        named = {int(n) for n in re.findall(r"\b900\d{3}\b", errors)}
        lines = set(re.findall(r"(\w+\.hpp):(\d+):\d+: error", errors))
        bad = [
            m
            for m in mutants
            if m["id"] in named or (Path(m["file"]).name, str(m["line"])) in lines
        ]
        if not bad:
            raise SystemExit(errors[:5000])
        print(f"{len(bad)} mutants do not compile")
        mutants = [m for m in mutants if m not in bad]
        write_core(mutants)
    subprocess.run([cmake, "--build", build], check=True)
    (build / "include").symlink_to(ROOT / "core/include")
    return mutants


# --- Python modules ------------------------------------------------------------------------------

SWAPPED = {
    getattr(ast, old): getattr(ast, new)
    for old, new in re.findall(
        r"(\w+) to (\w+)",
        "Add to Sub, Sub to Add, Mult to Div, Div to Mult, Pow to Mult, FloorDiv to Div, "
        "And to Or, Or to And, Lt to LtE, LtE to Lt, Gt to GtE, GtE to Gt, Eq to NotEq, "
        "NotEq to Eq, Is to IsNot, IsNot to Is, In to NotIn, NotIn to In",
    )
}
EXTREMES = {"min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum"}
NO_NUMBER = (ast.JoinedStr, ast.List, ast.Tuple, ast.ListComp)


def python_changes(node: Any) -> Iterator[tuple[str, ast.AST]]:
    """Yield mutants of a node of a syntax tree: description and new node."""
    match node:
        case ast.BinOp(left, op, right) if type(op) in SWAPPED:
            for one in (left, right):
                is_text = isinstance(one, ast.Constant) and isinstance(one.value, str)
                if is_text or isinstance(one, NO_NUMBER):
                    return
            yield "operator swapped", ast.BinOp(left, SWAPPED[type(op)](), right)
            yield "right operand dropped", left
        case ast.Compare(left, [op], right) if type(op) in SWAPPED:
            yield "comparison swapped", ast.Compare(left, [SWAPPED[type(op)]()], right)
        case ast.Constant(float() | int() as number) if not isinstance(number, bool):
            new = number + 1 if isinstance(number, int) else number * 1.1 or 0.1
            yield f"{number}: {new}", ast.Constant(new)
        case ast.BoolOp(op, values):
            yield "and/or swapped", ast.BoolOp(SWAPPED[type(op)](), values)
        case ast.If() | ast.IfExp():
            opposite = copy.copy(node)
            opposite.test = ast.UnaryOp(ast.Not(), node.test)
            yield "condition negated", opposite
        case ast.UnaryOp(ast.Not() | ast.USub(), operand) if not isinstance(operand, ast.Constant):
            yield "not or sign dropped", operand
        case ast.Call(ast.Name(name), args, keywords) if name in EXTREMES:
            swapped: ast.expr = ast.Name(EXTREMES[name], ast.Load())
            yield "min and max swapped", ast.Call(swapped, args, keywords)
        case ast.Call(ast.Attribute(value, name, ctx), args, keywords) if name in EXTREMES:
            swapped = ast.Attribute(value, EXTREMES[name], ctx)
            yield "min and max swapped", ast.Call(swapped, args, keywords)
        case ast.AugAssign():
            yield "statement deleted", ast.Pass()


def python_sites(node: ast.AST, place: Place) -> Iterator[tuple[Place, ast.AST]]:
    """Yield place and node of all code, without annotations, decorators, messages, patterns."""
    match node:
        case ast.JoinedStr() | ast.Raise() | ast.Assert() | ast.Import() | ast.ImportFrom():
            return
        case ast.FunctionDef("__repr__" | "__str__") | ast.If(ast.Name("TYPE_CHECKING")):
            return
    yield place, node
    for name, child in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "pattern", "op", "ops"):
            continue
        for index, one in enumerate(child) if isinstance(child, list) else ((None, child),):
            if isinstance(one, ast.AST):
                yield from python_sites(one, [*place, (name, index)])


def plan_python(room: str, dice: random.Random, first: int) -> list[Mutant]:
    """Choose mutants on random lines of the room's modules, one per line."""
    by_line = defaultdict(list)
    for file in sorted((ROOT / "src/propmap" / room).glob("*.py")):
        for place, node in python_sites(ast.parse(file.read_text()), []):
            for choice, (change, _) in enumerate(python_changes(node)):
                by_line[file, getattr(node, "lineno", 0)].append((place, choice, change, node))
    mutants = []
    chosen = sorted(dice.sample(sorted(by_line), SIZES[room]))
    for number, (file, line) in enumerate(chosen, first):
        place, choice, change, node = dice.choice(by_line[file, line])
        code = " ".join((ast.get_source_segment(file.read_text(), node) or "").split())[:100]
        mutant = {"id": number, "room": room, "file": str(file.relative_to(ROOT)), "line": line}
        mutants.append(mutant | {"code": code, "change": change, "path": [place, choice]})
    return mutants


def replace(tree: ast.AST, place: Place, change: Callable[[Any], ast.AST]) -> None:
    """Replace the node at this place of the tree."""
    node: Any = tree
    for name, index in place[:-1]:
        node = getattr(node, name) if index is None else getattr(node, name)[index]
    name, index = place[-1]
    siblings, key = (vars(node), name) if index is None else (getattr(node, name), index)
    siblings[key] = ast.copy_location(change(siblings[key]), siblings[key])


class MutatedLoader(importlib.machinery.SourceFileLoader):
    """Load a module with its active mutant, or, without one, note which mutants are executed."""

    def __init__(self, name: str, path: str, mutants: list[Mutant], active: int) -> None:
        super().__init__(name, path)
        self.mutants, self.active = mutants, active

    def get_code(self, fullname: str) -> Any:  # noqa: ARG002 - as Python calls it
        """Compile the changed syntax tree."""
        tree = ast.parse(Path(self.path).read_text())
        for mutant in sorted(self.mutants, key=lambda m: -len(m["path"][0])):
            place, choice = mutant["path"]

            def change(node: Any, number: int = mutant["id"], choice: int = choice) -> ast.AST:
                if self.active:
                    return list(python_changes(node))[choice][1]
                is_value = isinstance(node, ast.expr)
                values: list[ast.expr] = [
                    ast.Constant(number),
                    node if is_value else ast.Constant(1),
                ]
                call = ast.Call(ast.Name("__reached__", ast.Load()), values, [])
                return call if is_value else ast.If(call, [node], [])

            replace(tree, place, change)
        return compile(ast.fix_missing_locations(tree), self.path, "exec", dont_inherit=True)


class Finder:
    """Find the core with mutants, and the Python modules with mutants."""

    def __init__(self, active: int) -> None:
        self.active, self.by_module = active, defaultdict(list)
        for mutant in json.loads((HOME / "mutants.json").read_text()):
            if "path" in mutant and active in (0, mutant["id"]):
                name = mutant["file"].removeprefix("src/").removesuffix(".py").replace("/", ".")
                self.by_module[name.removesuffix(".__init__")].append(mutant)

    def find_spec(self, name: str, path: Any, target: Any = None) -> Any:  # noqa: ARG002
        """Return the spec of a module with mutants."""
        if name == "propmap._core":
            library = next((HOME / "core").glob("_core*.so"))
            return importlib.util.spec_from_file_location(name, library)
        if name not in self.by_module:
            return None
        file = str(ROOT / self.by_module[name][0]["file"])
        loader = MutatedLoader(name, file, self.by_module[name], self.active)
        return importlib.util.spec_from_file_location(name, file, loader=loader)


def install() -> Callable[[], None]:
    """Import propmap with the mutant PROPMAP_MUTANT from now on.

    The function returned writes which mutants were executed to the file PROPMAP_REACHED.
    """
    finder: Any = Finder(int(os.environ["PROPMAP_MUTANT"]))
    sys.meta_path.insert(0, finder)
    reached: set[int] = set()

    def note(number: int, value: Any) -> Any:
        reached.add(number)
        return value

    def write() -> None:
        if not os.environ.get("PROPMAP_REACHED"):
            return
        if core := sys.modules.get("propmap._core"):
            library = ctypes.CDLL(str(core.__file__))
            library.mutants_reached.restype = ctypes.POINTER(ctypes.c_int)
            reached.update(FIRST + k for k in range(1000) if library.mutants_reached()[k])
        file = Path(f"{os.environ['PROPMAP_REACHED']}-{os.getpid()}")
        file.write_text(json.dumps(sorted(reached)))

    vars(builtins)["__reached__"] = note
    atexit.register(write)
    return write


# --- Tests ---------------------------------------------------------------------------------------


def function_of(test: str) -> str:
    """Return the name of a test without its parameters."""
    return test.split("[")[0]


class Observer:
    """A pytest plugin that runs the wanted tests, and logs their ends and failures."""

    def __init__(self, log: Path, wanted: dict[str, float] | None, enough: int, ends: float):
        self.log, self.wanted, self.enough, self.ends = log.open("a"), wanted, enough, ends
        self.failed: set[str] = set()
        self.seconds: dict[str, float] = defaultdict(float)

    def tell(self, what: str, test: str) -> None:
        """Write one line."""
        self.log.write(f"{what} {self.seconds[test]:.3f} {test}\n")
        self.log.flush()

    def pytest_collection_modifyitems(self, items: list[Any]) -> None:
        """Keep the wanted tests."""
        items[:] = [i for i in items if self.wanted is None or i.nodeid in self.wanted]

    def pytest_collectreport(self, report: Any) -> None:
        """Count a module that fails to import as a failed test."""
        if report.failed:
            self.tell("failed", f"{report.nodeid}::import")

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        """End the process if the test hangs."""
        self.tell("start", nodeid)
        usual = (self.wanted or {}).get(nodeid, 30.0)
        faulthandler.dump_traceback_later(20.0 + 4.0 * usual, exit=True)

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Log a failure in any phase."""
        self.seconds[report.nodeid] += report.duration
        if report.failed:
            self.failed.add(function_of(report.nodeid))
            self.tell("failed", report.nodeid)

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        """Log the end of a test; end the process if enough tests failed."""
        faulthandler.cancel_dump_traceback_later()
        self.tell("end", nodeid)
        if len(self.failed) >= self.enough or time.monotonic() > self.ends:
            os._exit(0)


def run_forked(log: Path, mutant: int, files: list[str], observer: Observer) -> None:
    """Run test files in this process, which was forked for them."""
    os.setpgid(0, 0)
    os.chdir(ROOT)
    output = os.open(log.with_suffix(".out"), os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(output, 1)
    os.dup2(output, 2)
    reached = "" if mutant else str(log.with_suffix(".reached"))
    hook = {"PYTHONPATH": str(HOME / "hook"), "PROPMAP_REACHED": reached}
    os.environ |= hook | {"PROPMAP_MUTANT": str(mutant)}
    import hypothesis
    import pytest

    phases = (hypothesis.Phase.explicit, hypothesis.Phase.generate)  # no time to shrink examples
    settings = hypothesis.settings(derandomize=True, database=None, deadline=None, phases=phases)
    hypothesis.settings.register_profile("trial", settings)
    hypothesis.settings.load_profile("trial")
    write_reached = install()
    options = [*shlex.split(PYTEST), f"--basetemp={log.with_suffix('.tmp')}"]
    pytest.main([*files, *options], plugins=[observer])
    write_reached()


def run_tests(
    mutant: int, wanted: dict[str, float] | None, files: list[str], enough: int, seconds: float
) -> Mutant:
    """Run tests with a mutant; a test in which the process dies or hangs counts as failed."""
    log = HOME / "logs" / ((str(mutant) if mutant else files[0].replace("/", ".")) + ".log")
    for old in log.parent.glob(f"{log.stem}.*"):
        shutil.rmtree(old) if old.is_dir() else old.unlink()
    begin = time.monotonic()
    failed: dict[str, None] = {}
    ended: dict[str, float] = {}
    for _ in range(3):
        observer = Observer(log, wanted, enough, begin + seconds)
        pid = os.fork()
        if pid == 0:
            try:
                run_forked(log, mutant, files, observer)
            except BaseException:
                traceback.print_exc()
            os._exit(0)
        os.waitpid(pid, 0)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(pid, signal.SIGKILL)
        running = ""
        for line in log.read_text().splitlines():
            what, took, test = line.split(" ", 2)
            running = test if what == "start" else "" if what == "end" else running
            if what == "failed":
                failed[test] = None
            elif what == "end":
                ended[test] = float(took)
        if not (running or ended or failed) and mutant:
            failed["tests::import"] = None  # an import of tests/conftest.py failed
        if not running:
            break
        failed[running] = None
        observer.tell("end", running)
        if wanted is None or len({function_of(t) for t in failed}) >= enough:
            break
        wanted = {t: s for t, s in wanted.items() if t not in ended and t != running}
    shutil.rmtree(log.with_suffix(".tmp"), ignore_errors=True)
    return {"failed": list(failed), "ended": ended, "seconds": round(time.monotonic() - begin, 1)}


def baseline(file: str) -> Mutant:
    """Run a test file without a mutant: durations, and the mutants that it executes."""
    result = run_tests(0, None, [file], 10**9, 1e9)
    reached: set[int] = set()
    for part in (HOME / "logs").glob(f"{file.replace('/', '.')}.reached-*"):
        reached.update(json.loads(part.read_text()))
    return {"file": file, **result, "reached": sorted(reached)}


def trial(job: tuple[int, dict[str, float], int, float]) -> Mutant:
    """Run the wanted tests with a mutant: those of its room first, otherwise in random order."""
    mutant, wanted, enough, seconds = job
    files = sorted({t.split("::")[0] for t in wanted})
    random.Random(mutant).shuffle(files)
    near = [CORE_TESTS, *ROOMS][(mutant - FIRST) // 10_000]
    files.sort(key=lambda file: not re.match(near, file.removeprefix("tests/")))
    result = run_tests(mutant, wanted, files, enough, seconds) if wanted else {"failed": []}
    return {"id": mutant, "seconds": 0.0, **result, "ended": len(result.get("ended", ()))}


def read_lines(name: str) -> list[Any]:
    """Return the objects in a result file, which contains one per line."""
    file = HOME / name
    return [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []


def jobs(second: bool, seconds: float) -> Iterator[tuple[int, dict[str, float], int, float]]:
    """Yield mutants with tests: in the second pass, survivors with longer and other tests."""
    first = {r["id"]: r for r in read_lines("first.jsonl")}
    done = {r["id"] for r in read_lines("second.jsonl")} if second else first.keys()
    files = read_lines("baseline.jsonl")
    for mutant in json.loads((HOME / "mutants.json").read_text()):
        number, wanted = mutant["id"], {}
        for file in files:
            near = mutant["room"] != CORE or bool(
                re.match(CORE_TESTS, file["file"].removeprefix("tests/"))
            )
            for test, took in file["ended"].items() if number in file["reached"] else ():
                if test not in file["failed"] and took < LONG:
                    wanted[test] = took, near and took < SHORT
        short = sum(is_short for _, is_short in wanted.values())
        enough, again = ENOUGH, False
        if second and number in first:
            enough = not first[number]["failed"]
            again = first[number]["ended"] < short  # the first pass ran out of time
        if number not in done and enough and (not second or number in first):
            chosen = {t: s for t, (s, is_short) in wanted.items() if again or is_short != second}
            yield number, chosen, int(enough), seconds


def write_report(out: Path) -> None:
    """Write the mutants with the tests that kill them, and the tests with their kills."""
    found: dict[int, list[Mutant]] = defaultdict(list)
    for result in read_lines("first.jsonl") + read_lines("second.jsonl"):
        found[result["id"]].append(result)
    seconds: dict[str, float] = defaultdict(float)
    for file in read_lines("baseline.jsonl"):
        for test, took in file["ended"].items():
            seconds[function_of(test)] += took
    kills: dict[str, list[int]] = defaultdict(list)
    names = ["id", "room", "file", "line", "code", "change"]
    with (out / "mutants.csv").open("w", newline="") as stream:
        table = csv.writer(stream)
        table.writerow([*names, "killers", "tests_run", "passes", "killed_by"])
        for mutant in json.loads((HOME / "mutants.json").read_text()):
            runs = found[mutant["id"]]
            killers = sorted({function_of(t) for run in runs for t in run["failed"]})
            for test in killers:
                kills[test].append(len(killers))
            row = [len(killers), sum(run["ended"] for run in runs), len(runs), " ".join(killers)]
            table.writerow([mutant[name] for name in names] + row)
    with (out / "kills_by_test.csv").open("w", newline="") as stream:
        table = csv.writer(stream)
        table.writerow(["test", "kills", "alone", "by_two_at_most", "seconds"])
        for test in sorted(seconds.keys() | kills.keys(), key=lambda t: (-len(kills[t]), t)):
            few = sum(n <= 2 for n in kills[test])
            row = [len(kills[test]), kills[test].count(1), few, round(seconds[test], 2)]
            table.writerow([test, *row])


def plan(seed: int) -> None:
    """Choose all mutants and build the core."""
    shutil.rmtree(HOME, ignore_errors=True)
    for name in ("hook", "logs", "source"):
        (HOME / name).mkdir(parents=True)
    lines = ["import sys", f"sys.path.append({str(ROOT)!r})", "from tools import mutation_trial"]
    lines += ["sys.path.pop()", "mutation_trial.install()", ""]
    (HOME / "hook/sitecustomize.py").write_text("\n".join(lines))
    dice = random.Random(seed)
    mutants = build_core(plan_core(dice))
    for k, room in enumerate(ROOMS, 1):
        mutants += plan_python(room, dice, FIRST + 10_000 * k + 1)
    (HOME / "mutants.json").write_text(json.dumps(mutants, indent=1))
    print(Counter(m["room"] for m in mutants))


def main() -> None:
    """Run a command of the trial."""
    formatter = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=formatter)
    commands = ("plan", "baseline", "first", "second", "report")
    parser.add_argument("command", choices=commands)
    parser.add_argument("folder", nargs="?", type=Path, default=HOME, help="folder of the report")
    parser.add_argument("--workers", type=int, default=2, help="processes (default: 2)")
    parser.add_argument("--seconds", type=float, default=60.0, help="per mutant (default: 60)")
    parser.add_argument("--seed", type=int, default=1, help="of the choice (default: 1)")
    options = parser.parse_args()
    if options.command == "plan":
        return plan(options.seed)
    if options.command == "report":
        return write_report(options.folder)
    sys.dont_write_bytecode = False
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    warnings.simplefilter("ignore")
    for library in shlex.split(LIBRARIES):
        with contextlib.suppress(ImportError):
            importlib.import_module(library)
    work: Callable[[Any], Mutant] = trial
    todo: list[Any] = list(jobs(options.command == "second", options.seconds))
    random.Random(options.seed).shuffle(todo)  # a stopped pass is a random sample
    if options.command == "baseline":
        known = {r["file"] for r in read_lines("baseline.jsonl")}
        files = [str(f.relative_to(ROOT)) for f in sorted((ROOT / "tests").rglob("test_*.py"))]
        work, todo = baseline, [f for f in files if f not in known]
    with ProcessPoolExecutor(options.workers, multiprocessing.get_context("fork")) as pool:
        running = [pool.submit(work, one) for one in todo]
        for count, future in enumerate(as_completed(running), 1):
            result = future.result()
            with (HOME / f"{options.command}.jsonl").open("a") as stream:
                stream.write(json.dumps(result) + "\n")
            name, failed = result.get("file") or result["id"], len(result["failed"])
            print(f"{count}/{len(todo)} {name}: {failed} failed, {result['seconds']} s", flush=True)
    return None


if __name__ == "__main__":
    main()
