"""Cases of bad files: scenes in TOML, the files they name, and saved solutions and histories, damaged at random."""

import functools
import json
import math
import tempfile
import tomllib
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path

import numpy as np
import xarray as xr

import varcontact as vc
from tests.fuzz.junk import PLAIN, Deep
from tests.fuzz.outcome import Case, says_what

Random = np.random.Generator
SMALL, SHORT = 600, 10
"""Elements and steps up to which a scene from a damaged file is solved as well."""


def files(rng: Random) -> Case:
    """Damage a file and read it; a scene that can still be read is planned, and solved where it is small."""
    folder = tempfile.TemporaryDirectory()
    damage = _weighted(rng, {entry: 4, text: 2, named_file: 1, container: 3, record: 3})
    words, read = damage(rng, Path(folder.name))

    def within() -> list[str]:
        with folder:
            read()
        return []

    return Case(words, within, says_what, bad_input=True)


Damage = tuple[str, Callable[[], None]]

# ----------------------------------------------------------------------------- scenes in TOML

SCENES = (Path(__file__).parents[1] / "data" / "scenes_to_damage.txt").read_text().split("# ----\n")
"""Whole scenes of all kinds, to be damaged."""


def entry(rng: Random, folder: Path) -> Damage:
    """One to three entries of a scene replaced, left out, renamed or added."""
    table = tomllib.loads(str(rng.choice(SCENES)))
    changed = [_change(rng, table, PLAIN) for _ in range(int(rng.choice([1, 1, 2, 3])))]
    return "; ".join(changed), lambda: _used(_written(folder, table))


def text(rng: Random, folder: Path) -> Damage:
    """A scene's text cut, with other bytes, or with what is no text at all."""
    whole = str(rng.choice(SCENES)).encode()
    cut = whole[: rng.integers(len(whole))]
    flipped = bytearray(whole)
    for place in rng.integers(len(whole), size=int(rng.integers(1, 5))):
        flipped[place] = rng.integers(256)
    doubled = whole + whole
    deep = b"x = " + b"[" * 100_000
    kinds = {
        "cut": cut,
        "other bytes": bytes(flipped),
        "BOM": b"\xef\xbb\xbf" + whole,
        "UTF-16": whole.decode().encode("utf-16"),
        "NUL": whole.replace(b"=", b"\0=", 1),
        "doubled": doubled,
        "deep": deep,
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


def named_file(rng: Random, folder: Path) -> Damage:
    """A file of samples that a scene names: ragged, of words, empty, of another kind, or not there."""
    ending = str(rng.choice([".csv", ".txt", ".npy", ""]))
    name = f"h{ending}"
    samples = "1.0, 1.0, 1.0\n1.0, 0.0, 1.0\n1.0, 1.0, 1.0\n"
    contents = [
        *(samples, samples[:9], samples.replace("0.0", "nothing"), samples.replace("\n1.0", "\n"), "", "\0", "nan"),
        *("1e999, 1\n", "1;2;3\n", "é", "# 1\n", "1.0 1.0, 1.0\n", "inf, 1.0, 1.0\n" * 3, "1.0\n" * 3),
    ]
    raw = str(rng.choice(contents)).encode()
    if ending == ".npy":
        arrays = [np.zeros((3, 3)), np.array([["a"]]), np.zeros(3), np.zeros((3, 3), complex), np.array(1.0)]
        np.save(folder / name, arrays[rng.integers(len(arrays))])
        raw = (folder / name).read_bytes()
        raw = raw[: rng.integers(len(raw))] if rng.random() < 0.5 else raw
    (folder / name).write_bytes(raw)
    named = str(rng.choice([name, name, name, name, "missing.csv", "..", ".", "", "h\\0.csv", str(folder)]))
    table = tomllib.loads(SCENES[1])
    field = str(rng.choice(["h", "friction"]))
    if field == "h":
        table["surface"]["h"] = {"file": named}
    else:
        table["friction"] = {"file": named}
    return f"{field} from {named!r}: {raw[:60]!r}", lambda: _used(_written(folder, table))


def _written(folder: Path, table: dict) -> Path:
    """A scene file."""
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


# ----------------------------------------------------------------------------- saved solutions and histories


@functools.cache
def saved(kind: str) -> bytes:
    """The file of a solution or a history."""
    base: dict = {"bodies": vc.Bodies(G=1.0, nu=0.28), "friction": 0.3, "grid": vc.Grid(nx=5, ny=5)}
    motion = {"solution": vc.Steady(vx=0.04, spin=0.05), "history": vc.Transient(steps=3, dq=0.1, vx=4e-3)}[kind]
    answer = vc.solve(vc.Scene(**base, surface=vc.Paraboloids(10.0, 8.0), normal_force=0.02, motion=motion))
    with tempfile.TemporaryDirectory() as name:
        answer.save(Path(name) / "saved.nc")
        return (Path(name) / "saved.nc").read_bytes()


def container(rng: Random, folder: Path) -> Damage:
    """The bytes of a saved file: some flipped, the end cut off, or more behind it."""
    kind = str(rng.choice(["solution", "history"]))
    whole = bytearray(saved(kind))
    how = str(rng.choice(["flipped", "cut", "longer", "zeros", "swapped"]))
    places = rng.integers(len(whole), size=int(rng.integers(1, 30)))
    if how == "flipped":
        for place in places:
            whole[place] ^= 1 << int(rng.integers(8))
    elif how == "cut":
        whole = whole[: places[0]]
    elif how == "longer":
        whole += rng.bytes(100)
    elif how == "zeros":
        whole[places[0] : places[0] + 200] = bytes(len(whole[places[0] : places[0] + 200]))
    else:
        whole[: places[0]], whole[places[0] :] = whole[places[0] :], whole[: places[0]]
    path = folder / "saved.nc"
    path.write_bytes(bytes(whole))
    return f"{kind}, {how} at {sorted(places)[:3]}", lambda: _loaded(path)


def record(rng: Random, folder: Path) -> Damage:
    """The JSON record, or an array, of a saved solution replaced."""
    path = folder / "saved.nc"
    path.write_bytes(saved("solution"))
    with xr.open_dataset(path, engine="h5netcdf") as opened:
        data = opened.load()
    if rng.random() < 0.7:
        entries = json.loads(str(data["record"].values))
        words = _change(rng, entries, [*PLAIN, None])
        dumped = _json(entries)
        data["record"] = ((), dumped[: rng.integers(len(dumped))] if rng.random() < 0.1 else dumped)
    else:
        name = str(rng.choice([str(each) for each in data.data_vars]))
        values = [np.full((2, 5), np.nan), np.zeros((0, 3)), np.array("words"), np.array(1e308), np.zeros((7, 7, 2))]
        value = values[rng.integers(len(values))]
        data = data.drop_vars(name)
        if rng.random() < 0.8:
            data[name] = (tuple(f"d{name}{i}" for i in range(value.ndim)), value)
        words = f"{name} of shape {value.shape}"
    path.unlink()
    data.to_netcdf(path, engine="h5netcdf")
    return words, lambda: _loaded(path)


def _loaded(path: Path) -> None:
    """Load a file and say what is in it."""
    answer = vc.load(path)
    for each in [answer] if isinstance(answer, vc.Solution) else answer:
        each.report()
        each.summary()


# ----------------------------------------------------------------------------- changes of tables


def _change(rng: Random, table: dict, junk: list) -> str:
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
    value = deepcopy(junk[rng.integers(len(junk))])
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
    """A value in TOML."""
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


def _json(value) -> str:
    """A value in JSON."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)}: {_json(each)}" for key, each in value.items()) + "}"
    if isinstance(value, list):
        return f"[{', '.join(map(_json, value))}]"
    return str(value) if isinstance(value, Deep) else json.dumps(value)


def _weighted(rng: Random, choices: dict):
    weights = np.array(list(choices.values()))
    return list(choices)[rng.choice(len(weights), p=weights / weights.sum())]
