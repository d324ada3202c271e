"""What has no leading underscore tells what it takes: its docstring names each parameter, and none that is gone."""

import ast
import re
from collections import defaultdict
from pathlib import Path

import varcontact

ROOT = Path(varcontact.__file__).parent
TREES = {path.relative_to(ROOT): ast.parse(path.read_text()) for path in sorted(ROOT.rglob("*.py"))}
PUBLIC = [
    (path, owner, node)
    for path, tree in TREES.items()
    for owner in (tree, *(each for each in tree.body if isinstance(each, ast.ClassDef) and each.name[0] != "_"))
    for node in owner.body
    if isinstance(node, ast.FunctionDef) and node.name[0] != "_"
    if "overload" not in map(ast.unparse, node.decorator_list)
]


def parameters(node):
    return {each.arg for each in ast.walk(node.args) if isinstance(each, ast.arg)} - {"self", "cls"}


def listed(node):
    """Names in the section on parameters."""
    doc = ast.get_docstring(node) or ""
    section = re.search(r"^Parameters\n-+\n(.*?)(?:\n\n[A-Z][a-z ]+\n---|\Z)", doc, re.M | re.S)
    heads = re.findall(r"^\S.*$", section[1], re.M) if section else []
    return {name.strip(" *") for head in heads for name in head.split(" : ")[0].split(",")}


def is_command(node):
    """Whether a function is a command of the command line."""
    return any("app" in ast.unparse(decorator) for decorator in node.decorator_list)


def test_public_functions_and_methods_name_each_parameter():
    """In the section on parameters, or in the text between backticks; of methods one tells for those of its protocol.

    These are the methods of its name in the same room. The options of commands have help texts instead.
    """
    told = defaultdict(set)
    for path, owner, node in PUBLIC:
        key = path.parts[0] if isinstance(owner, ast.ClassDef) else path
        told[key, node.name] |= listed(node) | set(re.findall(r"`(\w+)`", ast.get_docstring(node) or ""))
    for path, owner, node in PUBLIC:
        silent = parameters(node) - told[path.parts[0] if isinstance(owner, ast.ClassDef) else path, node.name]
        assert not silent or is_command(node), f"{path}:{node.lineno} {node.name}: {silent}"


def test_no_docstring_lists_a_parameter_that_is_gone():
    for path, _, node in PUBLIC:
        assert listed(node) <= parameters(node), f"{path}:{node.lineno} {node.name}: {listed(node) - parameters(node)}"
