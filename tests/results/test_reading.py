"""Results as numbers, without dimension, as tables for notebooks and in few words; and what looks like a slip."""

import dataclasses
from html.parser import HTMLParser

import numpy as np
import pytest

import varcontact as vc

RAIL = vc.Scene(
    bodies=vc.Bodies(G=82e9, nu=0.28),
    surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
    normal_force=106.7e3,
    friction=0.33,
    motion=vc.Steady(vx=1e-3, vy=-5e-4, spin=0.2),
    grid=vc.Grid(nx=12, ny=12),
    units=vc.SI,
)
LINE = dataclasses.replace(
    RAIL, surface=vc.Cylinders(R=0.46), normal_force=8e6, motion=vc.Steady(vx=1e-3), grid=vc.Grid(nx=40)
)


def rail(**changes):
    return dataclasses.replace(RAIL, **changes)


@pytest.fixture(scope="module")
def sol():
    return vc.solve(RAIL)


class Cells(HTMLParser):
    """The texts of a table's cells; tags that are not closed in their order are an error."""

    def __init__(self, text):
        super().__init__()
        self.open, self.cells = [], []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if data.strip():
            self.cells.append(" ".join(data.split()))


def test_power_is_that_of_the_forces(sol):
    """F.v + Mz spin, with the sign turned; and in the report beside the integral over the contact."""
    assert sol.power == pytest.approx(-(sol.Fx * sol.vx + sol.Fy * sol.vy + sol.Mz * sol.spin))
    assert sol.friction_work == pytest.approx(sol.power, rel=1e-12)
    (row,) = (line for line in sol.report().splitlines() if line.startswith("  work "))
    assert row.split("work")[1].strip() == (
        f"{sol.power:.5g} N supplied, {sol.friction_work:.5g} N dissipated by friction per unit of distance rolled"
    )
    negative = -sol.power_density[sol.power_density < 0].sum() / sol.power_density.sum()
    assert sol.negative_work == pytest.approx(-negative) and sol.summary()["negative_work"] == sol.negative_work
    assert negative > 1e-5 and f"\n{20 * ' '}{100 * negative:.2g} % of it is negative" in sol.report()
    positive = vc.solve(rail(motion=vc.Steady(vx=8e-3)))
    assert positive.negative_work == 0.0 and "negative" not in positive.report()
    assert "supplied" not in vc.solve(rail(friction=0.0)).report()


@pytest.mark.parametrize("scale", [1e-3, 7.0])
@pytest.mark.parametrize("scene", [RAIL, LINE, rail(motion=vc.Shift(uy=2e-6, rotation=1e-4))], ids=range(3))
def test_what_has_no_dimension_is_the_same_at_any_size(scene, scale):
    """All lengths times a number, forces by its square (by length: by itself), spin by its inverse."""
    surface, motion = scene.surface, scene.motion
    names = [field.name for field in dataclasses.fields(surface) if field.name.startswith("R")]
    change = {"spin": motion.spin / scale} if isinstance(motion, vc.Steady) else {"uy": scale * motion.uy}
    other = dataclasses.replace(
        scene,
        surface=type(surface)(**{name: scale * getattr(surface, name) for name in names}),
        normal_force=scene.normal_force * scale ** (1 if scene.line else 2),
        motion=dataclasses.replace(motion, **change),
        units=None,
    )
    one, two = (dataclasses.astuple(vc.solve(each).normalised) for each in (scene, other))
    assert two == pytest.approx(one, rel=1e-7, abs=1e-10)


def test_small_creepages_have_kalkers_coefficients():
    """Fx = -C11 vx, Fy = -C22 vy and Fy = -C23 spin without dimension, to the error of the grid."""
    hertz, grid = RAIL.hertz, vc.Grid(nx=24, ny=24)
    C = vc.reference.creepage_coefficients(hertz.a, hertz.b, 0.28)
    part = vc.solve(rail(motion=vc.Steady(vx=1e-7, vy=1e-7), grid=grid)).normalised
    assert -part.Fx / part.vx == pytest.approx(C.C11, rel=0.03)
    assert -part.Fy / part.vy == pytest.approx(C.C22, rel=0.03)
    spun = vc.solve(rail(motion=vc.Steady(spin=1e-4), grid=grid)).normalised
    assert -spun.Fy / spun.spin == pytest.approx(C.C23, rel=0.05)


def test_largest_by_mean_pressure():
    """3/2 of Hertz's ellipse, 4/pi of his line; without contact there is none."""
    ellipse = vc.solve(rail(motion=None, grid=vc.Grid(nx=41, ny=41)))
    line = vc.solve(dataclasses.replace(LINE, motion=None, grid=vc.Grid(nx=81)))
    assert ellipse.normalised.max_pressure == pytest.approx(3 / 2, rel=5e-3)
    assert line.normalised.max_pressure == pytest.approx(4 / np.pi, rel=5e-3)
    lifted = vc.solve(rail(motion=vc.Transient(steps=2, vx=1e-3, normal_force=[2.0, 0.0])))[1]
    assert np.isnan(lifted.normalised.Fx)


def test_tables_for_notebooks(sol):
    """What is printed, cell by cell; what a user calls a unit is text and no tag."""
    odd = vc.solve(rail(units=vc.Units(length="<b>", force="N & lbf")))
    for each in (sol, odd):
        cells = Cells(each._repr_html_()).cells
        printed = " ".join(each.report().split())
        assert cells[0] == each.report().splitlines()[0] and "normal force" in cells
        assert all(cell in printed for cell in cells)
    plan = vc.plan(RAIL)
    cells = Cells(plan._repr_html_()).cells
    printed = " ".join(str(plan).split())
    assert cells[0] == "Plan" and all(cell in printed for cell in cells)
    cells = Cells(RAIL._repr_html_()).cells
    assert cells[0] == "Scene" and repr(RAIL.bodies) in cells and "motion" in cells


def test_unit_presets(sol):
    assert (vc.SI.of("pressure"), vc.MM_N.of("pressure")) == ("N/m^2", "N/mm^2")
    assert "106700 N" in sol.report()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"surface": vc.Paraboloids(Rx=460.0, Ry=300.0), "units": None}, "looks like pascals, a radius of 300 like"),
        ({"surface": vc.Paraboloids(Rx=460.0, Ry=300.0), "units": vc.MM_N}, "is 8.2e+16 Pa, stiffer than solids are"),
        ({"bodies": vc.Bodies(G=82e3, nu=0.28), "normal_force": 0.1}, "is 8.2e+04 Pa, softer than solids are"),
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
    assert str(plan).startswith(f"Plan\n\n  WARNING             {doubt}\n") and plan.summary()["doubts"] == [doubt]
    assert doubt in Cells(scene._repr_html_()).cells
    if isinstance(scene.motion, vc.Steady):
        solved = vc.solve(scene)
        assert solved.report().startswith(f"WARNING: {doubt}\n") and solved.report().count(doubt) == 1
        assert Cells(solved._repr_html_()).cells[1:3] == ["WARNING", doubt]
        assert solved.summary()["doubts"] == [doubt]
