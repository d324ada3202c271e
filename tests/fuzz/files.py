"""Cases of bad files: scenes in TOML, damaged at random, and files of results with one bit
flipped.
"""

import json
import math
import tempfile
import tomllib
from collections.abc import Callable
from copy import deepcopy
from functools import cache
from pathlib import Path

import numpy as np

import varcontact as vc
from tests.fuzz.junk import PLAIN
from tests.fuzz.outcome import Case, says_what
from tests.scenes import make_scene

Random = np.random.Generator
SMALL, SHORT = 600, 10
"""Elements and steps up to which a scene from a damaged file is solved as well."""


def files(rng: Random) -> Case:
    """Damage a file and read it; a scene that can still be read is planned, and solved where it is
    small.
    """
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
    how = str(
        rng.choice(["replaced", "replaced", "replaced", "left out", "renamed", "added", "element"])
    )
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
        return (
            "{"
            + ", ".join(f"{json.dumps(key)} = {_toml(each)}" for key, each in value.items())
            + "}"
        )
    return '"none"' if value is None else str(value)


# ----------------------------------------------------------------------------- flipped bits


def flips(rng: Random) -> Case:
    """One bit of a solution, a history or a sweep flipped: refused, or every figure in it is as
    before.
    """
    name = str(rng.choice(["solution.nc", "history.nc", "sweep.nc"]))
    content, before = results_to_damage()[name]
    place, bit = int(rng.integers(len(content))), int(rng.integers(8))
    damaged = bytearray(content)
    damaged[place] ^= 1 << bit

    def within() -> list[str]:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / name
            path.write_bytes(damaged)
            return different(figures_of(path), before)

    return Case(f"bit {bit} of byte {place} of {name}", within, says_what, bad_input=True)


Figures = list[dict[str, bytes]]
"""Of each step of a solution or a history, or each scene of a sweep."""


@cache
def results_to_damage() -> dict[str, tuple[bytes, Figures]]:
    """Files of results, with the figures in them."""
    grid = vc.Grid(nx=6, ny=6)
    rolling = make_scene(vc.Ellipse(a=1.2, b=0.9), motion=vc.Steady(vx=0.04), grid=grid)
    steps = make_scene(
        vc.Paraboloids(10.0, 10.0), 0.3, vc.Transient(steps=4, dq=0.2, vx=0.01), grid
    )
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder) / name for name in ("solution.nc", "history.nc", "sweep.nc")]
        vc.solve(rolling).save(paths[0])
        vc.solve(steps).save(paths[1])
        vc.sweep(rolling, {"motion.vx": [0.01, 0.02, 0.05]}, store=paths[2])
        for path in paths:
            found[path.name] = path.read_bytes(), figures_of(path)
    return found


def figures_of(path: Path) -> Figures:
    """All figures in a file of results, as bytes."""
    if path.name == "sweep.nc":
        swept = vc.read_sweep(path)
        names = [*swept.data_vars, *swept.coords]
        scenes = [swept.isel({"motion.vx": k}) for k in range(swept.sizes["motion.vx"])]
        return [{name: scene[name].values.tobytes() for name in names} for scene in scenes]
    found = vc.load(path, certify=False)
    names = (
        "pressure",
        "traction",
        "slip",
        "distance",
        "state",
        "approach",
        "creepage",
        "power_density",
    )
    steps = [found] if isinstance(found, vc.Solution) else list(found)
    figures = [{name: np.asarray(getattr(sol, name)).tobytes() for name in names} for sol in steps]
    for sol, each in zip(steps, figures, strict=True):
        each["report"] = repr(
            (sol.certificate.plain(), sol.iterations, sol.timing, sol.scene)
        ).encode()
    if isinstance(found, vc.History):
        series = {
            "normal_force": found.normal_force,
            "forces": found.force,
            "approach": found.approach,
        }
        for name, values in series.items():
            for each, value in zip(figures, values, strict=True):
                each[f"{name} of the history"] = np.asarray(value).tobytes()
    return figures


def different(found: Figures, before: Figures) -> list[str]:
    """Figures that are others than before; a scene may be called unfinished, and the last step may
    be missing.
    """
    faults = (
        [] if len(found) in (len(before), len(before) - 1) else [f"{len(found)} of {len(before)}"]
    )
    for k, (now, then) in enumerate(zip(found, before, strict=False)):
        unfinished = "outcome" in now and not any(now["outcome"])
        faults += [] if unfinished else [f"{k}: {name}" for name in then if now[name] != then[name]]
    return faults
