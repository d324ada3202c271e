"""Cases of bad files: scenes in TOML, damaged at random."""

import json
import math
import tempfile
import tomllib
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path

import numpy as np

import varcontact as vc
from tests.fuzz.junk import PLAIN
from tests.fuzz.outcome import Case, says_what

Random = np.random.Generator
SMALL, SHORT = 600, 10
"""Elements and steps up to which a scene from a damaged file is solved as well."""


def files(rng: Random) -> Case:
    """Damage a file and read it; a scene that can still be read is planned, and solved where it is small."""
    folder = tempfile.TemporaryDirectory()
    words, read = (entry if rng.random() < 0.7 else text)(rng, Path(folder.name))

    def within() -> list[str]:
        with folder:
            read()
        return []

    return Case(words, within, says_what, bad_input=True)


Damage = tuple[str, Callable[[], None]]

SCENES = (Path(__file__).parents[1] / "data" / "scenes_to_damage.txt").read_text().split("# ----\n")
"""Whole scenes of all kinds, to be damaged."""


def entry(rng: Random, folder: Path) -> Damage:
    """One to three entries of a scene replaced, left out, renamed or added."""
    table = tomllib.loads(str(rng.choice(SCENES)))
    changed = [_change(rng, table) for _ in range(int(rng.choice([1, 1, 2, 3])))]
    return "; ".join(changed), lambda: _used(_written(folder, table))


def text(rng: Random, folder: Path) -> Damage:
    """A scene's text cut, with other bytes, or with what is no text at all."""
    whole = str(rng.choice(SCENES)).encode()
    cut = whole[: rng.integers(len(whole))]
    flipped = bytearray(whole)
    for place in rng.integers(len(whole), size=int(rng.integers(1, 5))):
        flipped[place] = rng.integers(256)
    kinds = {
        "cut": cut,
        "other bytes": bytes(flipped),
        "BOM": b"\xef\xbb\xbf" + whole,
        "UTF-16": whole.decode().encode("utf-16"),
        "NUL": whole.replace(b"=", b"\0=", 1),
        "doubled": whole + whole,
        "deep": b"x = " + b"[" * 100_000,
        "empty": b"",
        "Latin": whole + "\n# é".encode("latin-1"),
        "long number": whole.replace(b"1.0", b"1" * 6000, 1),
        "CRLF": whole.replace(b"\n", b"\r\n"),
        "random": rng.bytes(300),
    }
    kind = str(rng.choice(list(kinds)))
    path = folder / "scene.toml"
    path.write_bytes(kinds[kind])
    return kind, lambda: _used(path)


def _written(folder: Path, table: dict) -> Path:
    path = folder / "scene.toml"
    lines = [f"{json.dumps(key)} = {_toml(value)}\n" for key, value in table.items()]
    path.write_text("".join(lines), "utf-8", "replace")
    return path


def _used(path: Path) -> None:
    """Read a scene, plan it, and solve it where it is small."""
    scene, options = vc.read_scene(path)
    named = ("method", "normal", "tangential", "coupling", "formulation")
    methods = {name: options[name] for name in named if name in options}
    sizes = vc.plan(scene, **methods).sizes
    assert sizes is not None
    steps = scene.motion.steps if isinstance(scene.motion, vc.Transient) else 1
    if math.prod(sizes.grid) <= SMALL and steps <= SHORT:
        vc.solve(scene, **options)


def _change(rng: Random, table: dict) -> str:
    """Change one entry somewhere in nested dictionaries, and say what was done."""
    where, within = "", table
    while True:
        keys = list(within)
        if not keys:
            break
        key = str(rng.choice(keys))
        if isinstance(within[key], dict) and rng.random() < 0.85:
            where, within = f"{where}{key}.", within[key]
            continue
        break
    if not within:
        within["extra"] = 1
        return f"{where}extra added"
    how = str(rng.choice(["replaced", "replaced", "replaced", "left out", "renamed", "added", "element"]))
    value = deepcopy(PLAIN[rng.integers(len(PLAIN))])
    if how == "element" and isinstance(within[key], list) and within[key]:
        within[key] = list(within[key])
        within[key][rng.integers(len(within[key]))] = value
    elif how == "left out":
        within.pop(key)
    elif how == "renamed":
        within[key + str(rng.choice(["x", "_", " ", "é", "\u200b"]))] = within.pop(key)
    elif how == "added":
        within[str(rng.choice(["vx", "Fx", "dy", "start", "kind", "nz", "", "a.b", "é"]))] = value
    else:
        how, within[key] = "replaced", value
    return f"{where}{key} {how}: {repr(value)[:100]}"


def _toml(value) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return "nan" if math.isnan(value) else repr(value)
    if isinstance(value, str):
        return json.dumps(value).replace("\x7f", "\\u007F")
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {_toml(each)}" for key, each in value.items()) + "}"
    return '"none"' if value is None else str(value)
