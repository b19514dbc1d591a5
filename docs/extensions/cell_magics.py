"""Sphinx extension that hides the IPython magics of executed cells.

``%%bash -e`` becomes a shell block, ``%%writefile NAME`` a block with the file name above it.
The cells run unchanged; only their display on the page changes.
"""

from __future__ import annotations

from pathlib import PurePath
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx

LANGUAGES = {".csv": "text", ".toml": "toml", ".py": "python", ".c": "c", ".sdf": "xml"}


def show_plainly(_: Sphinx, doctree: nodes.document) -> None:
    """Remove the magics from the literal blocks of a page."""
    for block in list(doctree.findall(nodes.literal_block)):
        first, _, rest = block.astext().partition("\n")
        words = first.split()
        if words[:1] == ["%%bash"]:
            _replace(block, rest, "bash")
        elif words[:1] == ["%%writefile"]:
            name = words[1]
            _replace(block, rest, LANGUAGES[PurePath(name).suffix])
            _add_caption(doctree, block, name)


def _replace(block: nodes.literal_block, text: str, language: str) -> None:
    block.rawsource = text
    block.children = [nodes.Text(text)]
    block["language"] = language


def _add_caption(doctree: nodes.document, block: nodes.literal_block, name: str) -> None:
    wrapper = nodes.container("", literal_block=True, classes=["literal-block-wrapper"])
    block.replace_self(wrapper)
    wrapper += [nodes.caption("", name), block]
    # Sphinx numbers blocks with a caption, which requires an id.
    doctree.note_implicit_target(wrapper)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the extension with Sphinx."""
    app.connect("doctree-read", show_plainly)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
