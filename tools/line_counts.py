"""Write into CHANGELOG.md the lines of source by folder, at a commit and as committed last.

Usage: python -m tools.line_counts COMMIT
"""

from __future__ import annotations

import subprocess
import sys
from collections import Counter
from pathlib import Path, PurePosixPath

ROOT = Path(__file__).resolve().parent.parent
SOURCE = "src/propmap"


def lines(commit: str) -> Counter[str]:
    """Of every folder of the package, of the modules of its root, and of all templates."""
    count: Counter[str] = Counter()
    for name in _git("ls-tree", "-r", "--name-only", commit, SOURCE).splitlines():
        path = PurePosixPath(name)
        inside = path.relative_to(SOURCE).parts
        if path.suffix in (".j2", ".in"):
            folder = "templates"
        elif path.suffix == ".py":
            folder = f"{inside[0]}/" if len(inside) > 1 else "root"
        else:
            continue
        count[folder] += len(_git("show", f"{commit}:{name}").splitlines())
    return count


def table(before: Counter[str], after: Counter[str]) -> str:
    """A row for each folder, those of both sides first, and the sum."""
    rows = ["| folder | lines before | lines after |", "|---|---|---|"]
    names = sorted(before | after, key=lambda name: (name not in before, name not in after, name))
    for name in names:
        rows.append(f"| `{name}` | {before[name] or 0} | {after[name] or 0} |")
    return "\n".join([*rows, f"| sum | {before.total()} | {after.total()} |"])


def _git(*arguments: str) -> str:
    command = ["git", "-C", str(ROOT), *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def with_table(text: str, found: str) -> str:
    """The ``text`` with the table ``found`` between its marks."""
    before, mark, rest = text.partition("<!-- line counts -->\n")
    _, end, after = rest.partition("<!-- /line counts -->")
    assert mark and end, "the marks are missing"
    return f"{before}{mark}{found}\n{end}{after}"


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    changes = ROOT / "CHANGELOG.md"
    text = with_table(changes.read_text(encoding="utf-8"), table(lines(sys.argv[1]), lines("HEAD")))
    changes.write_text(text, encoding="utf-8")
