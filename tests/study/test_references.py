"""References: the bank, its error bars judged by closed forms, the file, and the command that makes
it.
"""

import json
import math
from importlib.resources import files
from itertools import islice

import numpy as np
import pytest

import varcontact as vc
from tests.benchmarks.references import main, make, series_of, solves
from tests.scenes import make_scene, refused
from varcontact.reference import carter, cattaneo_mindlin, line_contact
from varcontact.study.extrapolate import extrapolate_series
from varcontact.study.references import read

BANK = vc.continuum_values()
FRICTION = 0.3


def cattaneo_without_poisson(name, part):
    """For nu = 0 tangential and normal flexibility are the same, and Cattaneo's shift is exact in
    any ellipse.
    """
    full = FRICTION * BANK[name].scene.hertz.approach
    return full * (1 - (1 - part) ** (2 / 3))


def rolling_cylinders(name):
    scene = BANK[name].scene
    given = {"creepage": scene.motion.vx} if scene.motion.Fx is None else {"force": scene.motion.Fx}
    return carter(line_contact(scene.surface.R, scene.bodies, force=1.0), FRICTION, **given)


EXACT = [
    ("line, creepage 0.3", "Fx", lambda name: rolling_cylinders(name).force),
    ("line, creepage 0.9", "Fx", lambda name: rolling_cylinders(name).force),
    ("line, Fx = 0.5", "vx", lambda name: rolling_cylinders(name).creepage),
    ("line, creepage 0.3", "stick_area", lambda name: 2 * rolling_cylinders(name).stick_half_width),
    ("line, creepage 0.9", "stick_area", lambda name: 2 * rolling_cylinders(name).stick_half_width),
    ("line, Fx = 0.5", "stick_area", lambda name: 2 * rolling_cylinders(name).stick_half_width),
    ("shift, nu = 0, Fx = 0.5", "ux", lambda name: cattaneo_without_poisson(name, 0.5)),
    ("shift, nu = 0, a/b = 0.3, Fx = 0.7", "ux", lambda name: cattaneo_without_poisson(name, 0.7)),
    ("shift, nu = 0, a/b = 4, Fy = 0.4", "uy", lambda name: -cattaneo_without_poisson(name, 0.4)),
    ("shift, nu = 0, Fx = 0.5", "stick_area", lambda _: math.pi * 0.5 ** (2 / 3)),
    ("shift, nu = 0, a/b = 0.3, Fx = 0.7", "stick_area", lambda _: math.pi * 0.3 ** (2 / 3)),
    ("shift, nu = 0, a/b = 4, Fy = 0.4", "stick_area", lambda _: math.pi * 0.6 ** (2 / 3)),
    ("rotation, full slip", "Mz", lambda _: -3 * math.pi / 16 * FRICTION),
]


@pytest.mark.parametrize(("name", "value", "exact"), EXACT)
def test_closed_forms_lie_within_the_error_bars(name, value, exact):
    reference = BANK[name]
    assert "extrapolated" in reference.how
    assert abs(reference.values[value] - exact(name)) <= reference.bars[value]


@pytest.mark.parametrize(("value", "exact"), [
    ("approach", lambda hertz: hertz.approach),
    ("peak_pressure", lambda hertz: hertz.peak_pressure),
    ("contact_area", lambda hertz: math.pi * hertz.a * hertz.b),
])  # fmt: skip
def test_hertz_lies_within_the_error_bars_of_computed_pressures(value, exact):
    reference = BANK["normal, sampled paraboloid"]
    hertz = make_scene(vc.Paraboloids(Rx=0.6, Ry=1.2), bodies=reference.scene.bodies).hertz
    assert abs(reference.values[value] - exact(hertz)) <= reference.bars[value]


def test_cattaneos_shift_with_poissons_ratio_is_nearly_exact():
    """The lateral traction that it neglects changes the shift by less than half a per cent."""
    reference = BANK["from Cattaneo to Carter"]
    shift = cattaneo_mindlin(
        reference.scene.hertz, reference.scene.bodies, FRICTION, -0.6 * FRICTION
    ).shift
    assert reference.values["ux[0]"] == pytest.approx(shift, rel=5e-3)


def test_there_are_at_least_sixty_scenes_of_all_classes_without_a_grid():
    assert len(BANK) >= 60
    assert [*dict.fromkeys(reference.kind for reference in BANK.values())] == [
        "normal", "shift", "steady, circular", "steady, slender", "forces given", "non-Hertzian", "unlike bodies",
        "line contact", "transient",
    ]  # fmt: skip
    assert all(reference.scene.grid == "auto" for reference in BANK.values())
    ratios = [reference.scene.surface.a / reference.scene.surface.b for reference in BANK.values()
              if isinstance(reference.scene.surface, vc.Ellipse)]  # fmt: skip
    assert min(ratios) == pytest.approx(0.1) and max(ratios) == pytest.approx(10)


def test_error_bars_are_small():
    """Small enough to judge errors of 0.3 per cent, and most of them errors of 0.1 per cent."""
    bars = np.array([reference.bar for reference in BANK.values()])
    assert 0 < bars.min() and bars.max() < 6e-4
    assert np.mean(bars < 5e-4) > 0.98
    assert np.median(bars) < 1e-4


def test_the_error_of_an_answer():
    reference = BANK["circle, half, along"]
    assert reference.error(reference.values) == 0
    found = reference.values | {"Fx": reference.values["Fx"] + 0.03}
    assert reference.error(found) == pytest.approx(0.1)
    assert math.isnan(reference.error({"Fx": 0.0}))


@pytest.mark.long
def test_fresh_solves_agree_with_the_file():
    name = "circle, across and spin"
    coarse = list(islice(solves(BANK[name].scene), 6))
    cells = np.array([n for n, _, _ in coarse])
    for value in BANK[name].units:
        fresh, bar = extrapolate_series(
            1 / cells, np.array([found[value] for _, _, found in coarse])
        )
        assert abs(fresh - BANK[name].values[value]) < bar + BANK[name].bars[value] + 1e-9


@pytest.mark.long
def test_the_command_goes_on_from_its_runs(tmp_path, capsys):
    name, runs = "line, creepage 0.3", tmp_path / "runs.csv"
    one = {name: BANK[name].scene}
    first = make(runs, one)
    assert capsys.readouterr().out == f"{name}\n"
    assert make(runs, one) == first
    assert capsys.readouterr().out == ""  # nothing was solved again
    entry = first["references"][name]
    assert entry["values"]["Fx"] == pytest.approx(BANK[name].values["Fx"], abs=1e-8)
    assert (
        f"{len(series_of(one[name]).cells)} solves with 100 to 1600 elements across" in entry["how"]
    )


def test_another_folder_than_there_is_is_refused(tmp_path, capsys):
    store = tmp_path / "other.csv"
    store.write_text("a,b\n1,2\n")
    assert main([str(tmp_path / "out.json"), "--runs", str(store)]) == 2
    assert "is not a table of the solves of references" in capsys.readouterr().err


def content():
    return json.loads(files("varcontact.data").joinpath("references.json").read_text())


@pytest.mark.parametrize(("spoil", "message"), [
    (lambda c: c.update(version=99), "is of version 99, and version 1 is read; make it again: python -m"),
    (lambda c: c.pop("references"), "is no file of references; make it again"),
    (lambda c: c["references"].pop("circle, spin"), "for other scenes .*'circle, spin' for one"),
])  # fmt: skip
def test_files_of_another_version_are_refused(tmp_path, spoil, message):
    changed = content()
    spoil(changed)
    path = tmp_path / "references.json"
    path.write_text(json.dumps(changed))
    refused(lambda: vc.references(path), match=message)


def test_a_copy_of_the_file_is_read(tmp_path):
    path = tmp_path / "copy.json"
    path.write_text(json.dumps(content()))
    assert vc.references(path)["circle, spin"].values == BANK["circle, spin"].values
    refused(lambda: vc.references(tmp_path / "nowhere.json"), match="nowhere")
    refused(lambda: read("[]", "a list"), match="is no file of references")


def test_long_series_are_extrapolated_within_their_bars():
    rng = np.random.default_rng(5)
    inside = 0
    for _ in range(40):
        h = 1 / np.array([32, 40, 48, 64, 80, 96, 128, 160, 192, 256])
        first, second = rng.normal(size=2)
        values = (
            1
            + first * h
            + second * h ** rng.choice([1.5, 2.0])
            + 3e-2 * rng.normal(size=h.size) * h**1.5
        )
        value, bar = extrapolate_series(h, values)
        inside += abs(value - 1) < bar
        assert bar < 0.02
    assert inside >= 36


@pytest.mark.long
def test_a_scene_of_ones_own_has_values_with_bars():
    """Against the values of the package's own file; a trade-off takes the scene itself."""
    known = vc.continuum_values()["line, creepage 0.3"]
    (own,) = vc.continuum_values(known.scene).values()
    assert own.units == pytest.approx(known.units)
    for name in own.units:
        apart = abs(own.values[name] - known.values[name])
        assert apart <= own.bars[name] + known.bars[name], name
        assert own.bars[name] <= 2e-3 * own.units[name]
    study = vc.tradeoff(known.scene, ["auto"], cells=[8, 16])
    same = vc.tradeoff({"scene": known}, ["auto"], cells=[8, 16])
    assert study.runs["error"].tolist() == pytest.approx(same.runs["error"].tolist(), abs=2e-3)
