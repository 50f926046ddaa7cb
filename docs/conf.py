"""The site: Sphinx with furo, made by `make docs` and read from a folder, without a network."""

import sys
import tomllib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "extensions"))

project = "orbsoc"
author = "the authors of orbsoc"
copyright = "the authors of orbsoc, Apache-2.0"
release = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))[
    "project"
]["version"]

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "command_line",
    "sphinx_copybutton",
    "sphinx_design",
    "scenario_keys",
    "gallery",
    "examples",
    "page_solver",
]
exclude_patterns = ["README.md", "extensions"]
source_suffix = {".md": "markdown"}
default_role = "literal"
nitpicky = False

myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 4

autodoc_member_order = "bysource"
autodoc_typehints = "signature"

html_theme = "furo"
html_title = "orbsoc"
html_static_path = ["static"]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"navigation_with_keys": True}
