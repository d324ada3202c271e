"""The docstrings of public names, those docs/api lists, name each parameter; none names one that is
gone.
"""

import ast
import importlib
import inspect
import re
from pathlib import Path

import pytest

import varcontact

ROOT = Path(varcontact.__file__).parent
PAGES = Path(__file__).parents[1] / "docs" / "api"


def public():
    """Dotted names of what docs/api lists."""
    for page in sorted(PAGES.glob("*.md")):
        module = ""
        for directive, name, members in re.findall(
            r"^\.\. (\w+):: ([\w.]+)\n(?:   :members:(.*))?", page.read_text(), re.M
        ):
            if directive in ("currentmodule", "module"):
                module = name
            elif directive == "automodule":
                listed_in = getattr(importlib.import_module(name), "__all__", ())
                names = members.split(",") if members.strip() else listed_in
                yield from (f"{name}.{each.strip()}" for each in names)
            elif directive in (
                "autofunction",
                "autoclass",
                "autoexception",
                "automethod",
                "autodata",
            ):
                yield name if name.startswith("varcontact.") else f"{module}.{name}"


def found(name):
    """The object of a dotted name."""
    parts = name.split(".")
    for k in range(len(parts) - 1, 0, -1):
        try:
            value = importlib.import_module(".".join(parts[:k]))
        except ModuleNotFoundError:
            continue
        for part in parts[k:]:
            value = getattr(value, part)
        return value
    raise AssertionError(name)


def listed(doc, sections=("Parameters", "Attributes")):
    """Names in the sections of a docstring on parameters, or between backticks."""
    heads = []
    for section in sections:
        text = re.search(rf"^{section}\n-+\n(.*?)(?:\n\n[A-Z][a-z ]+\n---|\Z)", doc, re.M | re.S)
        heads += re.findall(r"^\S.*$", text[1], re.M) if text else []
    return {name.strip(" *") for head in heads for name in head.split(" : ")[0].split(",")}


def parameters(call):
    return set(inspect.signature(call).parameters) - {"self", "cls"}


@pytest.mark.parametrize("name", sorted(set(public())))
def test_public_names_tell_what_they_take(name):
    value = found(name)
    doc = inspect.getdoc(value) or ""
    assert len(doc) > 20
    if inspect.isfunction(value):
        assert parameters(value) <= listed(doc) | set(re.findall(r"`(\w+)`", doc))
    for own, method in vars(value).items() if inspect.isclass(value) else ():
        if inspect.isfunction(method) and own[0] != "_":
            doc = inspect.getdoc(method) or ""
            assert doc, f"{name}.{own}"
            assert parameters(method) <= listed(doc) | set(re.findall(r"`(\w+)`", doc)), (
                f"{name}.{own}"
            )


def test_no_docstring_lists_a_parameter_that_is_gone():
    for path in sorted(ROOT.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef):
                told = listed(ast.get_docstring(node) or "", ("Parameters",))
                own = {each.arg for each in ast.walk(node.args) if isinstance(each, ast.arg)}
                assert told <= own, f"{path}:{node.lineno} {node.name}: {told - own}"
