"""The tables of README.md are those that the committed results give."""

from __future__ import annotations

from tools import readme_tables


def test_readme_is_what_the_results_give() -> None:
    """Nobody edits a figure by hand, and nobody forgets to write the tables anew."""
    text = readme_tables.README.read_text(encoding="utf-8")
    assert readme_tables.with_tables(text) == text, (
        "README.md's tables differ from benchmarks/results/: run tools/readme_tables.py"
    )
