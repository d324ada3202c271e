"""JSON Schema of input files: valid files pass, unknown keys and wrong kinds do not."""

import json
import re
import sys
import tomllib
from pathlib import Path

import jsonschema
import pytest

from tests.command import run
from tests.test_every_kind import KINDS
from varcontact.cli.json_schema import SCHEMAS
from varcontact.io.scene_toml import scene_to

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "docs" / "_extensions"))
CHECKERS = {name: jsonschema.Draft202012Validator(schema()) for name, schema in SCHEMAS.items()}
BALL = """
normal_force = 1000.0
[bodies]
E = 210e9
nu = 0.28
[surface]
kind = "paraboloids"
Rx = 0.1
Ry = 0.1
"""


def faults(kind, table):
    return [error.message for error in CHECKERS[kind].iter_errors(json.loads(json.dumps(table)))]


def kind_of(table):
    if "track" in table:
        return "wheel"
    return "sweep" if "over" in table else "scene"


@pytest.mark.long
@pytest.mark.parametrize("kind", SCHEMAS)
def test_schemas_are_schemas(kind):
    jsonschema.Draft202012Validator.check_schema(SCHEMAS[kind]())


@pytest.mark.parametrize("name", KINDS)
def test_every_kind_of_scene_passes(name):
    assert faults("scene", scene_to(KINDS[name])) == []


def test_files_on_pages_pass():
    import pages

    checked = 0
    for page in (ROOT / "docs").rglob("*.md"):
        for block in pages.blocks(page):
            if block.language != "toml":
                continue
            table = tomllib.loads(block.code)
            if {"bodies", "surface"} <= table.keys() or "track" in table:
                assert faults(kind_of(table), table) == [], f"{page.name}:{block.line}"
                checked += 1
    assert checked >= 3


@pytest.mark.parametrize(
    "change",
    [
        "norml_force = 3.0\n",
        'friction = "much"\n',
        'friction = { kind = "static-kinetic", static = 0.3, kinetik = 0.2 }\n',
        '[motion]\nkind = "steady"\nvx = "fast"\n',
        '[motion]\nkind = "rolling"\n',
        "[solve]\naccuracyy = 0.1\n",
        "[grid]\nnx = 10.5\nny = 10\n",
    ],
)
def test_mistakes_do_not_pass(change):
    top = change if change[0] != "[" else ""
    below = "" if top else change
    assert faults("scene", tomllib.loads(BALL)) == []
    assert faults("scene", tomllib.loads(top + BALL + below)) != []


def test_wheels_have_their_own_entries():
    wheel = """
    vertical_force = [80e3, 90e3]
    side = "both"
    track = { rail = { file = "rail.csv", smoothing = 5.0 }, cant = 0.025 }
    wheelset = { wheel = "s1002" }
    position = { y = { from = 0.0, to = 4.0, count = 2 } }
    friction = { kind = "by_angle", angles = [-0.5, 0.0], coefficients = [0.1, 0.3] }
    """
    assert faults("wheel", tomllib.loads(wheel)) == []
    for right, wrong in (("cant", "kant"), ("both", "all"), ("count", "number"), ("file", "fill")):
        assert faults("wheel", tomllib.loads(wheel.replace(right, wrong))) != [], wrong


WHEEL = """
vertical_force = 80e3
track = { rail = "60e1" }
wheelset = { wheel = "s1002" }
"""


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("left = { y = 1.0 }", "left = { y = 'far' }"),
        ("right = { roll = 0.01 }", "right = 0.01"),
        ("right_rail = ['wing.slcs', 'nose.slcs']", "right_rail = []"),
        ("left_rail = { profiles = '60e1', positions = [0, 1] }", "left_rail = { profiles = 3 }"),
    ],
)
def test_tables_of_the_track(right, wrong):
    for entry, valid in ((right, True), (wrong, False)):
        text = WHEEL.replace('"60e1"', f'"60e1", {entry}')
        assert (faults("wheel", tomllib.loads(text)) == []) is valid, entry


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("third_body = { G = 8e3, h = 0.02 }", "third_body = { G = 8e3 }"),
        ("bodies = { kind = 'viscoelastic', G = 1, nu = 0.3, relaxations = [[1, 1]] }", "bodies = { rail = { G = 1, nu = 0.3 } }"),
        ("friction = [0.3, { kind = 'pressure', static = 0.4, kinetic = 0.1 }]", "friction = [0.3]"),
        ("friction = { kind = 'shear-strength', coefficient = 0.3, strength = 1 }", "friction = { kind = 'carried' }"),
        ("thermal = { conductivity = 1, density = 1, heat_capacity = 1 }", "thermal = { rail = 1, wheel = 1 }"),
        ("wear = { kind = 'archard-map' }", "wear = { kind = 'archard' }"),
        ("wear = { k = 1e-4, hardness = 3e3 }", "wear = { k = 'small', hardness = 3e3 }"),
    ],
)  # fmt: skip
def test_tables_of_a_wheel(right, wrong):
    assert faults("wheel", tomllib.loads(f"{right}\n{WHEEL}")) == []
    assert faults("wheel", tomllib.loads(f"{wrong}\n{WHEEL}")) != []


def test_every_entry_of_a_wheel_has_a_type():
    """And every reference a table."""
    schema = SCHEMAS["wheel"]()
    entries = schema["properties"]
    for name in ("track", "wheelset", "third_body"):
        entries |= {f"{name}.{key}": each for key, each in entries[name]["properties"].items()}
    assert [name for name, each in entries.items() if each.keys() <= {"description"}] == []
    for reference in re.findall(r'"#/\$defs/([^"]*)"', json.dumps(schema)):
        assert reference in schema["$defs"]


def test_descriptions_come_from_the_docstrings():
    grid = SCHEMAS["scene"]()["$defs"]["grid"]["properties"]
    assert grid["nx"]["description"]


def test_the_command_prints_and_writes(tmp_path):
    printed = run("schema", "wheel", folder=tmp_path)
    assert json.loads(printed.stdout) == SCHEMAS["wheel"]()
    file = tmp_path / "scene.schema.json"
    for _ in range(2):  # its own may be replaced
        assert run("schema", "scene", "--out", file, folder=tmp_path).returncode == 0
    assert json.loads(file.read_text())["$id"] == "varcontact-scene.schema.json"
    refused = run("schema", "scenes", folder=tmp_path)
    assert refused.returncode == 2 and "did you mean scene" in refused.stderr
