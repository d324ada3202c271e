"""What another module calls tells what it takes: its docstring names each parameter, and none that is gone."""

import ast
import re
from collections import defaultdict
from pathlib import Path

import varcontact

ROOT = Path(varcontact.__file__).parents[1]
TREES = {path: ast.parse(path.read_text()) for path in sorted(ROOT.glob("varcontact/**/*.py"))}
PUBLIC = [
    (path, owner, node)
    for path, tree in TREES.items()
    for owner in (tree, *(each for each in tree.body if isinstance(each, ast.ClassDef) and each.name[0] != "_"))
    for node in owner.body
    if isinstance(node, ast.FunctionDef) and node.name[0] != "_"
]


def parameters(node):
    return {each.arg for each in ast.walk(node.args) if isinstance(each, ast.arg)} - {"self", "cls"}


def listed(node):
    """Names in the section on parameters."""
    doc = ast.get_docstring(node) or ""
    section = re.search(r"^Parameters\n-+\n(.*?)(?:\n\n[A-Z][a-z ]+\n---|\Z)", doc, re.M | re.S)
    heads = re.findall(r"^\S.*$", section[1], re.M) if section else []
    return {name.strip(" *") for head in heads for name in head.split(" : ")[0].split(",")}


def called(path, owner, node):
    """As what another module reaches for it: ".method" of an object, or "varcontact.room.module.function"."""
    module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
    return f".{node.name}" if isinstance(owner, ast.ClassDef) else f"{module}.{node.name}"


def test_what_another_module_calls_names_each_parameter():
    """In the section on parameters or between backticks; of methods of one name one suffices, their protocol's."""
    users, named = defaultdict(set), defaultdict(set)
    for path, tree in TREES.items():
        for node in ast.walk(tree):
            for alias in node.names if isinstance(node, ast.ImportFrom) else ():
                users[f"{node.module}.{alias.name}"].add(path)
            if isinstance(node, ast.Attribute):
                users[f".{node.attr}"].add(path)
    for each in PUBLIC:
        named[called(*each)] |= listed(each[2]) | set(re.findall(r"`(\w+)`", ast.get_docstring(each[2]) or ""))
    for path, owner, node in PUBLIC:
        name = called(path, owner, node)
        module = name.rpartition(".")[0]
        if (users[name] | (users[f".{node.name}"] if users[module] else set())) - {path}:  # or from the module itself
            assert parameters(node) <= named[name], f"{path}:{node.lineno} {name}: {parameters(node) - named[name]}"


def test_no_docstring_lists_a_parameter_that_is_gone():
    for path, _, node in PUBLIC:
        assert listed(node) <= parameters(node), f"{path}:{node.lineno}: no {listed(node) - parameters(node)}"
