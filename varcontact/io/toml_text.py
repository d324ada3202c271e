"""Tables of plain numbers, words and lists as TOML."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np


def toml_text(table: Mapping[str, Any], none: str) -> str:
    """A table as TOML: its own entries, then a section for each table in it.

    Parameters
    ----------
    table : mapping
        Of numbers, words, truth values, lists, and mappings of these.
    none : str
        The word for None, which TOML does not have.

    Examples
    --------
    >>> print(toml_text({"normal_force": 1e5, "bodies": {"G": 82e9, "nu": [0.28, None]}}, "none"), end="")
    normal_force = 100000.0
    <BLANKLINE>
    [bodies]
    G = 82000000000.0
    nu = [0.28, "none"]
    """
    own = [_entry(key, value, none) for key, value in table.items() if not isinstance(value, Mapping)]
    sections = [
        "\n".join([f"[{key}]", *(_entry(inner, each, none) for inner, each in value.items())])
        for key, value in table.items()
        if isinstance(value, Mapping)
    ]
    return "\n\n".join(part for part in ("\n".join(own), *sections) if part) + "\n"


def _entry(key: str, value: Any, none: str) -> str:
    return f"{key} = {_value(value, none)}"


def _value(value: Any, none: str) -> str:
    if value is None:
        return json.dumps(none)
    if isinstance(value, str):
        return json.dumps(value).replace("\x7f", "\\u007f")
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, int | np.integer):
        return str(int(value))
    if isinstance(value, float | np.floating):
        return repr(float(value)) if math.isfinite(value) else str(float(value))
    if isinstance(value, Mapping):
        return "{ " + ", ".join(_entry(key, each, none) for key, each in value.items()) + " }"
    return "[" + ", ".join(_value(each, none) for each in value) + "]"
