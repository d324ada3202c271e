"""Whatever another module calls says what it takes: a docstring names each parameter, and no parameter that is gone."""

import ast
import re
from collections import defaultdict
from pathlib import Path

import pytest

import varcontact

ROOT = Path(varcontact.__file__).parent
TREES = {path.relative_to(ROOT): ast.parse(path.read_text()) for path in sorted(ROOT.rglob("*.py"))}
FUNCTIONS = [(path, node) for path, tree in TREES.items() for node in tree.body if isinstance(node, ast.FunctionDef)]
CLASSES = [(path, node) for path, tree in TREES.items() for node in tree.body if isinstance(node, ast.ClassDef)]
METHODS = [(path, node) for path, cls in CLASSES for node in cls.body if isinstance(node, ast.FunctionDef)]


def used_elsewhere():
    """Names that a module imports, or takes as an attribute, with the modules that do so."""
    users = defaultdict(set)
    for path, tree in TREES.items():
        for node in ast.walk(tree):
            names = [alias.name for alias in node.names] if isinstance(node, ast.ImportFrom) else []
            for name in [*names, *([node.attr] if isinstance(node, ast.Attribute) else [])]:
                users[name].add(path)
    return users


def parameters(function):
    """Names of the parameters, but for self and cls."""
    every = function.args
    given = [*every.posonlyargs, *every.args, every.vararg, *every.kwonlyargs, every.kwarg]
    return {each.arg for each in given if each is not None} - {"self", "cls"}


def listed(doc):
    """Names in the section on parameters."""
    section = re.search(r"^Parameters\n-+\n(.*?)(?:\n\n[A-Z][a-z ]+\n---|\Z)", doc, re.M | re.S)
    heads = re.findall(r"^(\S.*)$", section[1], re.M) if section else []
    return {name.strip().lstrip("*") for head in heads for name in head.split(" : ")[0].split(",")}


def named(node):
    """Names in the section on parameters, and in the text between backticks."""
    doc = ast.get_docstring(node) or ""
    return listed(doc) | set(re.findall(r"(?<!`)`(\w+)`(?!`)", doc))


def lacking():
    """Parameters that nothing is said about; of methods of one name it suffices that one says it: their protocol."""
    users, by_name = used_elsewhere(), defaultdict(set)
    for _, node in METHODS:
        by_name[node.name] |= named(node)
    for path, node in FUNCTIONS + METHODS:
        command = any("app." in ast.unparse(each) for each in node.decorator_list)  # its options have help texts
        if users[node.name] - {path} and not node.name.startswith("_") and not command:
            missing = parameters(node) - (by_name[node.name] if (path, node) in METHODS else named(node))
            yield from (f"{path}:{node.lineno} {node.name}({name})" for name in sorted(missing))


def test_every_function_that_another_module_calls_documents_its_parameters():
    assert not list(lacking())


@pytest.mark.parametrize("room", sorted({path.parts[0] for path in TREES}))
def test_no_docstring_describes_a_parameter_that_does_not_exist(room):
    for path, node in FUNCTIONS + METHODS:
        if path.parts[0] == room:
            stale = listed(ast.get_docstring(node) or "") - parameters(node)
            assert not stale, f"{path}:{node.lineno} {node.name}"
