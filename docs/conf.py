"""Sphinx configuration: python -m sphinx -W docs docs/_build."""

import varcontact

project = "varcontact"
author = "The varcontact developers"
copyright = "2026, the varcontact developers"
version = release = varcontact.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax", "sphinx.ext.viewcode"]
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_ivar = True
exclude_patterns = ["_build"]
html_theme = "furo"
html_title = f"varcontact {version}"
