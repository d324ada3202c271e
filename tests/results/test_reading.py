"""Results as numbers, without dimension, as reports in notebooks and in few words; and what looks
like a slip.
"""

import dataclasses
import html
import math
import re

import numpy as np
import pytest

import varcontact as vc
from tests.command import run
from tests.scenes import make_scene, wheel_on_rail
from varcontact.results.report import with_bar

RAIL = wheel_on_rail(vc.Steady(vx=1e-3, vy=-5e-4, spin=0.2), vc.Grid(nx=12, ny=12), units=vc.SI)
LINE = dataclasses.replace(
    RAIL,
    surface=vc.Cylinders(R=0.46),
    normal_force=8e6,
    motion=vc.Steady(vx=1e-3),
    grid=vc.Grid(nx=40),
)


def rail(**changes):
    return dataclasses.replace(RAIL, **changes)


@pytest.fixture(scope="module")
def sol():
    return vc.solve(RAIL)


def test_work_in_the_report(sol):
    (row,) = (line for line in sol.report().splitlines() if line.startswith("  work "))
    assert row.split("work")[1].strip() == (
        f"{sol.power:.5g} N supplied, {sol.friction_work:.5g} N dissipated by friction per unit of distance rolled"
    )
    negative = -sol.power_density[sol.power_density < 0].sum() / sol.power_density.sum()
    assert (
        sol.negative_work == pytest.approx(-negative)
        and sol.summary()["negative_work"] == sol.negative_work
    )
    assert (
        negative > 1e-5 and f"\n{20 * ' '}{100 * negative:.2g} % of it is negative" in sol.report()
    )
    positive = vc.solve(rail(motion=vc.Steady(vx=8e-3)))
    assert positive.negative_work == 0.0 and "negative" not in positive.report()
    assert "supplied" not in vc.solve(rail(friction=0.0)).report()


@pytest.mark.parametrize("scale", [1e-3, 7.0])
@pytest.mark.parametrize(
    "scene", [RAIL, LINE, rail(motion=vc.Shift(uy=2e-6, rotation=1e-4))], ids=range(3)
)
def test_what_has_no_dimension_is_the_same_at_any_size(scene, scale):
    """All lengths times a number, forces by its square (by length: by itself), spin by its
    inverse.
    """
    surface, motion = scene.surface, scene.motion
    names = [field.name for field in dataclasses.fields(surface) if field.name.startswith("R")]
    change = (
        {"spin": motion.spin / scale}
        if isinstance(motion, vc.Steady)
        else {"uy": scale * motion.uy}
    )
    other = dataclasses.replace(
        scene,
        surface=type(surface)(**{name: scale * getattr(surface, name) for name in names}),
        normal_force=scene.normal_force * scale ** (1 if scene.line else 2),
        motion=dataclasses.replace(motion, **change),
        units=None,
    )
    one, two = (dataclasses.astuple(vc.solve(each).normalised) for each in (scene, other))
    assert two == pytest.approx(one, rel=1e-7, abs=1e-10)


def test_largest_by_mean_pressure():
    ellipse = vc.solve(rail(motion=None, grid=vc.Grid(nx=41, ny=41)))
    line = vc.solve(dataclasses.replace(LINE, motion=None, grid=vc.Grid(nx=81)))
    assert ellipse.normalised.max_pressure == pytest.approx(3 / 2, rel=5e-3)
    assert line.normalised.max_pressure == pytest.approx(4 / np.pi, rel=5e-3)
    lifted = vc.solve(rail(motion=vc.Transient(steps=2, vx=1e-3, normal_force=[2.0, 0.0])))[1]
    assert np.isnan(lifted.normalised.Fx)


def test_unit_presets(sol):
    assert (vc.SI.of("pressure"), vc.MM_N.of("pressure")) == ("N/m^2", "N/mm^2")
    assert "106700 N" in sol.report()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"surface": vc.Paraboloids(Rx=460.0, Ry=300.0), "units": None},
            "looks like pascals, a radius of 300 like",
        ),
        (
            {"surface": vc.Paraboloids(Rx=460.0, Ry=300.0), "units": vc.MM_N},
            "is 8.2e+16 Pa, stiffer than solids are",
        ),
        (
            {"bodies": vc.Bodies(G=82e3, nu=0.28), "normal_force": 0.1},
            "is 8.2e+04 Pa, softer than solids are",
        ),
        ({"motion": vc.Steady(vx=0.2)}, "vx = 0.2: creepages are mostly below 0.1"),
        ({"motion": vc.Transient(steps=2, vy=[0.0, -1.5])}, "vy = -1.5"),
        ({"surface": vc.Paraboloids(Rx=1e-3, Ry=1e-3)}, "of the radius 0.001; half-spaces"),
        ({"normal_force": None, "approach": 2.0}, "approach = 2: the contact's semi-axis"),
    ],
)
def test_what_looks_like_a_slip_of_the_pen(changes, words):
    """It is said by the scene, its plan and its report; a usual scene has no such word."""
    assert RAIL.doubts == LINE.doubts == ()
    scene = rail(**changes)
    (doubt,) = scene.doubts
    assert words in doubt
    plan = vc.plan(scene)
    assert str(plan).startswith(f"Plan\n\n  WARNING             {doubt}\n") and plan.summary()[
        "doubts"
    ] == [doubt]
    if isinstance(scene.motion, vc.Steady):
        with pytest.warns(vc.PlausibilityWarning):
            solved = vc.solve(scene)
        assert (
            solved.report().startswith(f"WARNING: {doubt}\n") and solved.report().count(doubt) == 1
        )
        assert solved.summary()["doubts"] == [doubt]


@pytest.mark.parametrize(
    ("value", "bar", "text"),
    [
        (-13.0987, 0.0461, "-13.099 +- 0.046"),
        (1.84, 0.2, "1.84 +- 0.20"),
        (79176.3, 14.6, "79176 +- 15"),
        (-11707.76, 166.7, "-11710 +- 170"),
        (1.2345678e9, 2.4e6, "1.2346e+09 +- 2.4e+06"),
        (1.2346e-9, 2.4e-11, "1.235e-09 +- 2.4e-11"),
        (0.0, 0.012, "0.000 +- 0.012"),
        (-3.0, 0.0, "-3"),
        (2.5, math.nan, "2.5"),
        (2.5, math.inf, "2.5"),
    ],
)
def test_values_have_the_digits_of_their_bars(value, bar, text):
    assert with_bar(value, bar) == text


@pytest.mark.long
def test_page_stands_alone_and_repeats_the_answer(tmp_path):
    scene = wheel_on_rail(vc.Steady(vx=1e-3, spin=0.2), units=vc.Units(length="m", force="N"))
    sol = vc.solve(scene, accuracy=0.05)
    sol.to_html(tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    assert "data:image/png;base64" in page
    assert not re.findall(r'(?:src|href)="(?!data:)', page), "it asks for another file"
    row = next(line for line in sol.report().splitlines() if "tangential force" in line)
    assert row.split("force", 1)[1].strip() in html.unescape(page)

    report, toml, command = (
        html.unescape(text) for text in re.findall("<pre>(.*?)</pre>", page, re.DOTALL)
    )
    assert report == sol.report()
    (tmp_path / "scene.toml").write_text(toml)
    name, *words = command.split()
    assert name == "varcontact" and row in run(*words, folder=tmp_path).stdout


@pytest.mark.parametrize("name", ["history", "estimate", "certificate", "profile", "scene"])
def test_notebooks_show_values(name):
    from varcontact.wheel_rail import Profile

    motion = vc.Transient(steps=2, dq=0.2, vx=0.2)
    scene = make_scene(
        vc.Ellipse(1.0, 1.0), 1.0, motion, friction=3.0, bodies=vc.Bodies(200.0, 0.3)
    )
    history = vc.solve(scene, accuracy=0.1)
    last = history[-1]
    shown, value = {
        "history": (history, f"{history.rolled[-1]:.5g}"),
        "estimate": (last.error_estimate, f"{last.error_estimate.errors['Fx']:.1e}"),
        "certificate": (last.certificate, f"{last.certificate.residual:.2e}"),
        "profile": (Profile.s1002(), f"{Profile.s1002().y.size} points"),
        "scene": (scene, f"WARNING             {scene.doubts[0]}"),
    }[name]
    assert html.escape(value) in shown._repr_html_()


def test_notebooks_show_reports(sol):
    scene = make_scene(
        vc.Ellipse(1.0, 1.0),
        1.0,
        vc.Transient(steps=2, dq=0.2, vx=0.01),
        bodies=vc.Bodies(1.0, 0.3),
    )
    history = vc.solve(dataclasses.replace(scene, grid=vc.Grid(6, 6)))
    for shown in (sol, vc.plan(RAIL), history):
        assert (
            shown._repr_html_() == f"<pre>{html.escape(shown.report())}</pre>"
            and str(shown) == shown.report()
        )
