"""Contacts of layered bodies: solutions by other methods, limits, unlike stacks by two solvers,
files, refusals.
"""

import csv
import math
from pathlib import Path

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import refused

with (Path(__file__).parents[1] / "data" / "layered_contacts.csv").open() as file:
    ROWS = list(csv.DictReader(file))

COAT = vc.Layered(
    [vc.Layer(h=0.3, G=4.0, nu=0.3), vc.Layer(h=0.2, G=2.0, nu=0.4)], base=(1.0, 0.25)
)
PAD = vc.Layered([vc.Layer(h=0.2, G=0.5, nu=0.45)], base="rigid")
STRIP = vc.Layered([vc.Layer(h=0.3, G=1.0, nu=0.3)], base="smooth")
ROLLING = {"normal_force": 0.1, "friction": 0.3, "motion": vc.Steady(Fx=-0.01, vy=5e-3, spin=0.02)}
SPHERES = {"surface": vc.Paraboloids(1.0, 1.0), "grid": vc.Grid(nx=12, ny=12)}
LINE = {"surface": vc.Cylinders(1.0), "grid": vc.Grid(nx=160)}


def rows(case):
    return [
        {name: float(value) for name, value in row.items() if name != "case" and value}
        for row in ROWS
        if row["case"] == case
    ]


def half_space_force(nu, G=1.0):
    """Of a rigid cylinder of radius 1 on a half-space, with half a width of 1."""
    return math.pi * G / (2 * (1 - nu))


@pytest.mark.parametrize("row", rows("cylinder on bonded layer"))
def test_cylinder_on_a_bonded_layer(row):
    nu, h = row["nu"], 1 / row["size"]
    bodies = ("rigid", vc.Layered([vc.Layer(h, 1.0, nu)], base="rigid"))
    sol = vc.solve(
        vc.Scene(bodies=bodies, normal_force=row["force"] * half_space_force(nu), **LINE)
    )
    assert sol.pressure.max() == pytest.approx(row["peak"], rel=1e-3)
    assert (sol.pressure > 0).sum() * sol.grid.sides[0] / 2 == pytest.approx(
        1, abs=sol.grid.sides[0]
    )
    assert sol.certificate.normal_relative_gap < 1e-11
    if "approach" in row:
        assert sol.approach == pytest.approx(row["approach"] / 2, rel=1e-3)
        again = vc.solve(vc.Scene(bodies=bodies, approach=row["approach"] / 2, **LINE))
        assert again.normal_force == pytest.approx(sol.normal_force, rel=3e-3)


def test_approach_on_a_thick_layer():
    """Hertz's pressure, nearly, over the compliance of the layer: its transform is 2 J1(k)/k by the
    force.
    """
    from scipy.integrate import quad
    from scipy.special import j1

    nu, h = 0.3, 20.0
    s, c = (lambda k: -math.expm1(-4 * k)), (lambda k: 1 + math.exp(-4 * k))

    def compliance(k):
        """Closed form, times exp(-2 k h) above and below."""
        rest = math.exp(-2 * k)
        above = (3 - 4 * nu) * s(k) / 2 - 2 * k * rest
        return (
            (1 - nu)
            * above
            / ((3 - 4 * nu) * c(k) / 2 + (2 * k**2 + 5 - 12 * nu + 8 * nu**2) * rest)
        )

    parts = [
        quad(lambda k: compliance(k * h) / k * 2 * j1(k) / k, a, a + 2, epsrel=1e-12)[0]
        for a in np.arange(1e-9, 400, 2)
    ]
    force = half_space_force(nu)
    bodies = ("rigid", vc.Layered([vc.Layer(h, 1.0, nu)], base="rigid"))
    sol = vc.solve(vc.Scene(bodies=bodies, normal_force=force, **LINE))
    assert sol.approach == pytest.approx(force * sum(parts) / math.pi, rel=1e-3)


def punch(nu, h, cells):
    side, edge = 2.2 / cells, -1.1
    x = edge + (np.arange(cells) + 0.5) * side
    distance = np.where(np.hypot(x, x[:, None]) < 1, 0.0, 100.0)
    grid = vc.Grid(nx=cells, ny=cells, dx=side, dy=side, x0=edge, y0=edge)
    bodies = ("rigid", vc.Layered([vc.Layer(h, 1.0, nu)], base="rigid"))
    return vc.solve(
        vc.Scene(bodies=bodies, surface=vc.SampledDistance(distance), approach=1.0, grid=grid)
    )


@pytest.mark.parametrize("row", rows("punch on bonded layer"))
def test_flat_punch_on_a_bonded_layer(row):
    """Forces on 64 x 64 squares: pressures at the edge, which are singular, lack about 1 % of
    them.
    """
    sol = punch(row["nu"], 1 / row["size"], 64)
    assert sol.normal_force * (1 - row["nu"]) / 4 == pytest.approx(row["force"], rel=1.5e-2)
    assert sol.certificate.normal_relative_gap < 1e-7


@pytest.mark.parametrize("row", rows("strip between rollers"))
def test_strip_between_rollers(row):
    roller = vc.Bodies(1.0, row["nu"])
    hertz = vc.reference.line_contact(1.0, roller, a=1.0)
    strip = vc.Layered([vc.Layer(row["size"], 1.0, row["nu"])], base="smooth")
    sol = vc.solve(
        vc.Scene(bodies=(roller, strip), normal_force=row["force"] * hertz.force, **LINE)
    )
    assert sol.pressure.max() / hertz.peak_pressure == pytest.approx(row["peak"], rel=3e-4)


@pytest.mark.parametrize("row", rows("free rolling of the strip"))
def test_strip_that_rolls_freely(row):
    """The strip leads: vx of the roller over it is negative, though the materials are the same."""
    roller = vc.Bodies(1.0, row["nu"])
    force = vc.reference.line_contact(1.0, roller, a=1.0).force
    strip = vc.Layered([vc.Layer(row["size"], 1.0, row["nu"])], base="smooth")
    free = {
        "normal_force": force,
        "friction": 0.1,
        "motion": vc.Steady(Fx=0.0),
        "surface": vc.Cylinders(1.0),
    }
    sol = vc.solve(vc.Scene(bodies=(roller, strip), grid=vc.Grid(nx=80), **free))
    assert sol.creepage[0] == pytest.approx(row["vx"], abs=3e-4)
    assert sol.certificate.relative_gap < 1e-9 and abs(sol.force[0]) < 1e-12


@pytest.mark.parametrize("shape", [SPHERES, LINE])
def test_homogeneous_bodies_cut_into_layers(shape):
    """Unlike half-spaces, one of them cut into layers: tractions, forces and creepage are
    theirs.
    """
    cut = vc.Layered([vc.Layer(0.05, 1.0, 0.2), vc.Layer(0.4, 1.0, 0.2)], base=(1.0, 0.2))
    motion = ROLLING["motion"] if shape is SPHERES else vc.Steady(Fx=-0.01)
    line = vc.Cylinders(1.0, reference_depth=50.0)
    entries = ROLLING | {
        "motion": motion,
        "surface": shape["surface"] if shape is SPHERES else line,
    }
    grid = vc.Grid(nx=16, ny=16) if shape is SPHERES else vc.Grid(nx=40)
    half = vc.solve(vc.Scene(bodies=vc.Bodies((1.0, 3.0), (0.2, 0.4)), grid=grid, **entries))
    layered = vc.solve(vc.Scene(bodies=(cut, vc.Bodies(3.0, 0.4)), grid=half.grid, **entries))
    np.testing.assert_allclose(layered.pressure, half.pressure, atol=1e-8 * half.pressure.max())
    np.testing.assert_allclose(layered.traction, half.traction, atol=1e-7 * half.pressure.max())
    np.testing.assert_allclose(layered.creepage, half.creepage, atol=1e-8)
    assert layered.approach == pytest.approx(half.approach, rel=1e-8)


@pytest.mark.parametrize("shape", [SPHERES, LINE])
@pytest.mark.parametrize("bodies", [(COAT, PAD), ("rigid", PAD), (vc.Bodies(2.0, 0.3), COAT)])
def test_unlike_stacks_by_two_solvers(bodies, shape):
    """Panagiotopoulos's loop of NORM and TANG, and Newton's method for all tractions; both with a
    gap of zero.
    """
    motion = ROLLING["motion"] if shape is SPHERES else vc.Steady(Fx=-0.01)
    scene = vc.Scene(bodies=bodies, **ROLLING | {"motion": motion}, **shape)
    loop = vc.solve(scene, coupling="panagiotopoulos", normal="norm", tangential="tang")
    newton = vc.solve(scene, coupling="newton")
    np.testing.assert_allclose(newton.pressure, loop.pressure, atol=1e-7 * loop.pressure.max())
    np.testing.assert_allclose(newton.traction, loop.traction, atol=1e-6 * loop.pressure.max())
    for sol in (loop, newton):
        assert sol.certificate.normal_relative_gap < 1e-8
        assert sol.certificate.relative_gap < 1e-8


def test_soft_pad_on_a_nearly_rigid_half_space():
    """It bulges beside the load, and only differences of displacements are known."""
    pad = vc.Layered([vc.Layer(h=0.3, G=1.0, nu=0.5)], base=(1e4, 0.3))
    bonded = vc.Layered(pad.layers, base="rigid")
    loads = [
        vc.solve(vc.Scene(bodies=("rigid", body), normal_force=0.5, **LINE))
        for body in (pad, bonded)
    ]
    assert loads[0].pressure.max() == pytest.approx(loads[1].pressure.max(), rel=1e-3)
    assert math.isnan(loads[0].approach) and loads[1].approach > 0


def test_scene_file_by_hand(tmp_path):
    path = tmp_path / "coat.toml"
    start = 'normal_force = 1.0\n[surface]\nkind = "paraboloids"\nRx = 1.0\nRy = 1.0\n'
    coat = 'kind = "layered"\n' + "layers = [{ h = 0.1, G = 4.0, nu = 0.3 }]\nbase = [1.0, 0.25]\n"
    layered = vc.Layered([vc.Layer(0.1, 4.0, 0.3)], base=(1.0, 0.25))
    for text, bodies in (
        (f"[bodies]\n{coat}", (layered, layered)),
        (f'[bodies]\nupper = "rigid"\n[bodies.lower]\n{coat}', ("rigid", layered)),
        (
            f"[bodies.upper]\nE = 2.6\nnu = 0.3\n[bodies.lower]\n{coat}",
            (vc.Bodies(1.0, 0.3), layered),
        ),
    ):
        path.write_text(start + text)
        found = vc.read_scene(path)[0].bodies
        assert (found.upper, found.lower) == bodies
    for text, field in (
        (
            "[bodies]\nkind = 'layered'\nlayers = [{ h = 0.1, nu = 0.3 }]\nbase = 'rigid'\n",
            "bodies.layers[0].G",
        ),
        ("[bodies]\nkind = 'layered'\nlayers = 3\nbase = 'rigid'\n", "bodies.layers"),
        ("[bodies]\nkind = 'layered'\nlayers = [{ h = 0.1, G = 1.0, nu = 0.3 }]\n", "bodies.base"),
        ("[bodies]\nupper = 'rigid'\n", "bodies.lower"),
        ("[bodies]\nupper = 'rigid'\nlower = 'rigid'\n", "bodies"),
        (
            "[bodies.upper]\nG = 1.0\nnu = 0.3\nh = 1\n[bodies.lower]\nG = 1.0\nnu = 0.3\n",
            "bodies.upper.h",
        ),
    ):
        path.write_text(start + text)
        refused(lambda: vc.read_scene(path), field)


@pytest.mark.long
def test_what_displacements_count_from():
    line = {
        "surface": vc.Cylinders(1.0),
        "normal_force": 0.1,
        "friction": 0.3,
        "motion": vc.Shift(ux=0.01),
    }
    assert vc.solve(vc.Scene(bodies=PAD, **line)).force[0] < 0
    refused(lambda: vc.Scene(bodies=COAT, **line), match=r"surface\.reference_depth")
    with pytest.raises(vc.SceneError, match="bases that do not move"):
        vc.Scene(bodies=PAD, **line | {"surface": vc.Cylinders(1.0, reference_depth=9.0)})
    for surface in (vc.Cylinders(1.0), vc.Paraboloids(1.0, 1.0)):
        refused(
            lambda s=surface: vc.Scene(bodies=STRIP, **line | {"surface": s}),
            "bodies.base",
            match="smooth base",
        )
        forced = vc.solve(
            vc.Scene(bodies=STRIP, **line | {"surface": surface, "motion": vc.Shift(Fx=0.01)})
        )
        assert math.isnan(forced.creepage[0])


def test_net_shear_of_a_strip_is_doubted():
    line = {"surface": vc.Cylinders(1.0), "normal_force": 0.1, "friction": 0.3}
    assert "smooth base" in vc.Scene(bodies=STRIP, motion=vc.Steady(vx=0.01), **line).doubts[0]
    assert not vc.Scene(bodies=STRIP, motion=vc.Steady(Fx=0.0), **line).doubts


def test_closed_forms_refuse_layers():
    bodies = vc.Scene(bodies=COAT, **ROLLING, **SPHERES).bodies
    for closed_form in (
        lambda: vc.reference.hertz(1.0, 1.0, bodies, force=1.0),
        lambda: vc.reference.bufler(1.0, bodies, force=1.0),
    ):
        with pytest.raises(vc.SceneError, match="half-spaces"):
            closed_form()
