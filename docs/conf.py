"""Sphinx: python -m sphinx -W docs docs/_build. No page needs a network."""

import sys
from pathlib import Path

import varcontact

sys.path.insert(0, str(Path(__file__).parent / "_extensions"))

project = "varcontact"
author = "The varcontact developers"
copyright = "2026, the varcontact developers"
version = release = varcontact.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "sphinx_design",
    "mathml",
    "gallery",
]
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_ivar = True
exclude_patterns = ["_build", "_extensions", "made"]
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
html_math_renderer = "mathml"
html_theme = "furo"
html_title = f"varcontact {version}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
