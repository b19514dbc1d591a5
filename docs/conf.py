"""Settings of Sphinx; every build regenerates the results on the pages."""

from __future__ import annotations

import os
import re
import shutil
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "docs" / "extensions")]

import propmap  # noqa: E402
from tools import docs_figures, docs_pages  # noqa: E402
from tools.propeller_pages import pages as propeller_pages  # noqa: E402

GENERATED = ROOT / "docs" / "generated"
GENERATED.mkdir(exist_ok=True)
docs_figures.write(GENERATED)
docs_pages.write(GENERATED)
propeller_pages.write(ROOT / "docs")

# Code cells run the `propmap` command of this environment, with tables as wide as a page.
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
os.environ["COLUMNS"] = "96"
os.environ["IPYTHONDIR"] = str(GENERATED / "ipython")
shutil.copytree(
    ROOT / "docs" / "kernel", GENERATED / "ipython" / "profile_default", dirs_exist_ok=True
)
os.environ["PROPMAP_EXAMPLES"] = str(ROOT / "examples")

project = "propmap"
author = "The propmap developers"
version = release = propmap.__version__
project_copyright = author

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx_design",
    "cell_magics",
    "mathml",
    "reproduce_page",
]
root_doc = "index"
exclude_patterns = ["_build", "generated", "figures", "kernel"]
nitpicky = False

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_timeout = 600  # Seconds per cell; only a hanging cell takes longer.
nb_execution_raise_on_error = True
nb_merge_streams = True

autodoc_member_order = "bysource"
autodoc_typehints = "none"
autoclass_content = "class"
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

html_math_renderer = "mathml"
html_theme = "pydata_sphinx_theme"
html_title = f"propmap {version}"
html_static_path = ["_static"]
html_extra_path = ["generated/site"]
html_css_files = ["propmap.css"]
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "navigation_with_keys": False,
    "show_prev_next": True,
    "show_toc_level": 2,
    "navbar_end": ["theme-switcher"],
    "navbar_persistent": ["search-button"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
    "header_links_before_dropdown": 8,
}
# These pages belong to no section, so the sidebar has no section list for them.
html_sidebars = {
    page: []
    for page in (
        "index",
        "getting-started",
        "stability",
        "tutorial",
        "choosing",
        "theory",
        "root-search",
        "equations",
        "validation",
        "architecture",
        "propellers",
        "propellers/*",
        "simulators",
    )
}


def setup(app: Any) -> None:
    """Escape bars and stars in docstring formulas, which reStructuredText would read as markup."""

    def escape(*arguments: Any) -> None:
        lines = arguments[-1]
        text = re.split(r"(``[^`]*``)", "\n".join(lines))
        text[::2] = [re.sub(r"([|*])", r"\\\1", words) for words in text[::2]]
        lines[:] = "".join(text).split("\n")

    app.connect("autodoc-process-docstring", escape, priority=100)
