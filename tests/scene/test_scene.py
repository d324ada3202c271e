"""Every class checks itself when made, and names what is wrong."""

import dataclasses

import numpy as np
import pandas as pd
import pytest

import varcontact as vc
from tests.scenes import refusals, refused

STEEL = vc.Bodies(G=82e9, nu=0.28)
GOOD = {"bodies": STEEL, "surface": vc.Paraboloids(Rx=0.46, Ry=0.3), "normal_force": 1e5}
LATTICE = {"nx": 4, "ny": 3, "dx": 1e-3, "dy": 1e-3, "x0": -2e-3, "y0": -1.5e-3}
NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize(("make", "field"), [
    (lambda: vc.Bodies(G=0.0, nu=0.3), "bodies.G"),
    (lambda: vc.Bodies(G=-1.0, nu=0.3), "bodies.G"),
    (lambda: vc.Bodies(G=NAN, nu=0.3), "bodies.G"),
    (lambda: vc.Bodies(G=(1.0, -INF), nu=0.3), "bodies.G[1]"),
    (lambda: vc.Bodies(G=(INF, INF), nu=0.3), "bodies.G"),
    (lambda: vc.Bodies(G=INF, nu=0.3), "bodies.G"),
    (lambda: vc.Bodies(G=(1.0, 2.0, 3.0), nu=0.3), "bodies.G"),
    (lambda: vc.Bodies(G="soft", nu=0.3), "bodies.G"),
    (lambda: vc.Bodies(G=True, nu=0.3), "bodies.G"),
    (lambda: vc.Bodies(G=1.0, nu=0.51), "bodies.nu"),
    (lambda: vc.Bodies(G=1.0, nu=-1.0), "bodies.nu"),
    (lambda: vc.Bodies(G=1.0, nu=(0.3, NAN)), "bodies.nu[1]"),
    (lambda: vc.Bodies.from_young(E=-1.0, nu=0.3), "bodies.E"),
    (lambda: vc.Bodies.from_young(E=(1.0, (2.0, 3.0)), nu=0.3), "bodies.E[1]"),
    (lambda: vc.Bodies.from_young(E=1.0, nu=(0.3, [0.2])), "bodies.nu[1]"),
    (lambda: vc.Paraboloids(Rx=-1.0, Ry=1.0), "surface.Rx"),
    (lambda: vc.Paraboloids(Rx=1.0, Ry=0.0), "surface.Ry"),
    (lambda: vc.Paraboloids(Rx=INF, Ry=1.0), "surface.Rx"),
    (lambda: vc.Paraboloids(Rx=NAN, Ry=1.0), "surface.Rx"),
    (lambda: vc.Paraboloids(Rx=None, Ry=1.0), "surface.Rx"),
    (lambda: vc.Paraboloids.from_bodies(Rx=(1.0, -0.5), Ry=(1.0, 1.0)), "surface.Rx"),
    (lambda: vc.Paraboloids.from_bodies(Rx=(1.0, 0.0), Ry=(1.0, 1.0)), "surface.Rx"),
    (lambda: vc.Ellipse(a=1.0, b=-1.0), "surface.b"),
    (lambda: vc.SampledDistance(h=[[0.0, NAN]]), "surface.h[0, 1]"),
    (lambda: vc.SampledDistance(h=0.0), "surface.h"),
    (lambda: vc.SampledDistance(h=[[[0.0, 1.0]]]), "surface.h"),
    (lambda: vc.SampledDistance(h=[["a"]]), "surface.h"),
    (lambda: vc.SampledDistance(h=np.zeros((3, 4)), x=[0.0, 1.0, 2.0], y=[0.0, 1.0, 2.0]), "surface.x"),
    (lambda: vc.SampledDistance(h=np.zeros((3, 3)), x=[0.0, 1.0, 1.0], y=[0.0, 1.0, 2.0]), "surface.x"),
    (lambda: vc.SampledDistance(h=np.zeros((3, 3)), x=[0.0, 1.0, 2.0]), "surface.x, surface.y"),
    (lambda: vc.Grid(nx=0, ny=3), "grid.nx"),
    (lambda: vc.Grid(nx=3.5, ny=3), "grid.nx"),
    (lambda: vc.Grid(nx=3, ny=3, dx=1.0), "grid.dy"),
    (lambda: vc.Grid(**{**LATTICE, "dx": -1.0}), "grid.dx"),
    (lambda: vc.Grid(**{**LATTICE, "dy": INF}), "grid.dy"),
    (lambda: vc.Grid(**{**LATTICE, "x0": NAN}), "grid.x0"),
    (lambda: vc.Grid(nx=3, ny=3, margin=-1), "grid.margin"),
    (lambda: vc.Steady(vx=NAN), "motion.vx"),
    (lambda: vc.Steady(spin=INF), "motion.spin"),
    (lambda: vc.Steady(dq=0.0), "motion.dq"),
    (lambda: vc.Steady(spin_offset=1.5), "motion.spin_offset"),
    (lambda: vc.Steady(vx=0.1, Fx=3.0), "motion.Fx, motion.vx"),
    (lambda: vc.Steady(Fy=INF), "motion.Fy"),
    (lambda: vc.Shift(uy=0.1, Fy=3.0), "motion.Fy, motion.uy"),
    (lambda: vc.Shift(rotation="left"), "motion.rotation"),
    (lambda: vc.Units(length=3, force="N"), "units.length"),
    (lambda: vc.Units(length="m", force=None), "units.force"),
])  # fmt: skip
def test_parts_refuse(make, field):
    for name in field.split(", "):
        refused(make, field, name, match="must be|is missing|give both|prescribe one")


@pytest.mark.parametrize(("changes", "field"), [
    ({"normal_force": None}, "normal_force, approach"),
    ({"approach": 1e-4}, "normal_force, approach"),
    ({"normal_force": 0.0}, "normal_force"),
    ({"normal_force": -1.0}, "normal_force"),
    ({"normal_force": NAN}, "normal_force"),
    ({"normal_force": None, "approach": INF}, "approach"),
    ({"friction": -0.1}, "friction"),
    ({"friction": NAN}, "friction"),
    ({"friction": "much"}, "friction"),
    ({"motion": vc.Steady(vx=0.1)}, "friction"),
    ({"friction": np.ones((3, 4))}, "grid"),
    ({"friction": np.ones((4, 3)), "grid": vc.Grid(**LATTICE)}, "friction"),
    ({"friction": np.full((3, 4), NAN), "grid": vc.Grid(**LATTICE)}, "friction[0, 0]"),
    ({"friction": np.full((3, 4), -1.0), "grid": vc.Grid(**LATTICE)}, "friction"),
    ({"grid": "fine"}, "grid"),
    ({"grid": (3, 4)}, "grid"),
    ({"grid": np.zeros(3)}, "grid"),
    ({"grid": np.array(["auto"])}, "grid"),
    ({"friction": [[0.3], [0.3, 0.2]]}, "friction"),
    ({"motion": {"vx": 1e-3}, "friction": 0.3}, "motion"),
    ({"surface": 0.3}, "surface"),
    ({"bodies": 82e9}, "bodies"),
    ({"units": "mm"}, "units"),
    ({"surface": vc.SampledDistance(np.zeros((3, 4)))}, "grid"),
    ({"surface": vc.SampledDistance(np.zeros((4, 4))), "grid": vc.Grid(**LATTICE)}, "surface.h"),
])  # fmt: skip
def test_scene_refuses(changes, field):
    for name in field.split(", "):
        refused(lambda: vc.Scene(**GOOD | changes), field, name)


@pytest.mark.parametrize("approach", [0.0, -1e-6])
def test_bodies_that_do_not_touch(approach):
    with pytest.raises(vc.NoContact, match="approach"):
        vc.Scene(bodies=STEEL, surface=vc.Paraboloids(1.0, 1.0), approach=approach)
    with pytest.raises(vc.NoContact, match="no contact"):
        vc.Scene(
            bodies=STEEL,
            surface=vc.SampledDistance(np.full((3, 4), 1e-5)),
            approach=1e-5,
            grid=vc.Grid(**LATTICE),
        )


def test_combined_constants():
    """(58)-(60) by hand, with a rigid body, and both orders."""
    bodies = vc.Bodies(G=(2.0, 6.0), nu=(0.1, 0.4))
    assert bodies.combined_G == pytest.approx(3.0)
    assert bodies.combined_nu == pytest.approx(3.0 * (0.1 / 2 + 0.4 / 6) / 2)
    assert bodies.K == pytest.approx(0.75 * (0.8 / 2 - 0.2 / 6))
    assert vc.Bodies(G=(6.0, 2.0), nu=(0.4, 0.1)).K == pytest.approx(-bodies.K)
    rigid = vc.Bodies(G=(1.0, INF), nu=(0.286, 0.0))
    assert (rigid.combined_G, rigid.combined_nu, rigid.K) == pytest.approx((2.0, 0.286, 0.214))
    assert vc.Bodies(G=(1.0, INF), nu=(0.5, 0.1)).K == 0, "rubber on steel is quasi-identical"


def test_young():
    assert vc.Bodies.from_young(E=(210.0, INF), nu=0.25).pairs[0] == (84.0, INF)
    assert vc.Bodies.from_young(E=np.array([210.0, 105.0]), nu=0.25).pairs[0] == (84.0, 42.0)


def test_scenes_cannot_be_changed():
    scene = vc.Scene(**GOOD)
    with pytest.raises(dataclasses.FrozenInstanceError):
        scene.friction = 0.5
    h = np.zeros((3, 4))
    surface = vc.SampledDistance(h)
    h[:] = 7.0
    assert np.all(surface.h == 0), "a scene keeps its own copy"
    with pytest.raises(ValueError, match="read-only"):
        surface.h[0, 0] = 1.0


def test_errors_are_one_family():
    for error in (
        vc.SceneError,
        vc.NoContact,
        vc.Saturated,
        vc.NotConverged,
        vc.SolverUnavailable,
        vc.TooLarge,
    ):
        assert issubclass(error, vc.VarcontactError)


# ------------------------------------------------------------------- Bodies that are no half-spaces


COAT = vc.Layered([vc.Layer(h=0.1, G=4.0, nu=0.3)], base=(1.0, 0.25))
HALF_SPACE = vc.Bodies(G=2.0, nu=0.3)
ENTRIES = {
    "surface": vc.Paraboloids(1.0, 1.0),
    "normal_force": 0.1,
    "friction": 0.3,
    "motion": vc.Steady(vx=1e-3),
}


def test_one_body_stands_for_two():
    bodies = vc.Scene(bodies=COAT, **ENTRIES).bodies
    assert (bodies.upper, bodies.lower, bodies.coupled) == (COAT, COAT, False)
    assert (bodies.combined_G, bodies.combined_nu) == (4.0, 0.3)


def test_a_pair_has_the_constants_of_its_surfaces():
    pair = vc.Scene(bodies=(COAT, HALF_SPACE), **ENTRIES).bodies
    surfaces = vc.Bodies(G=(4.0, 2.0), nu=0.3)
    assert pair.coupled and pair.combined_G == surfaces.combined_G
    assert pair.softest.pairs[0] == (1.0, 2.0)


def test_two_half_spaces_are_plain_bodies():
    assert vc.Scene(bodies=(HALF_SPACE, vc.Bodies(1.0, 0.2)), **ENTRIES).bodies == vc.Bodies(
        G=(2.0, 1.0), nu=(0.3, 0.2)
    )


def test_no_hertz():
    scene = vc.Scene(bodies=COAT, **ENTRIES)
    assert scene.hertz is None
    for options in ({"normal": "hertz"}, {"tangential": "fastsim"}):
        refused(
            lambda options=options: vc.plan(scene, **options),
            next(iter(options)),
            match="half-spaces",
        )
    with pytest.raises(vc.SceneError, match="Paraboloids"):
        vc.Scene(bodies=COAT, **ENTRIES | {"surface": vc.Ellipse(1.0, 1.0)})


test_bad_bodies_are_named = refusals(
    (lambda: vc.Layer(h=0.0, G=1.0, nu=0.3), "layer.h"),
    (lambda: vc.Layer(h=1.0, G=float("inf"), nu=0.3), "layer.G"),
    (lambda: vc.Layer(h=1.0, G=1.0, nu=0.6), "layer.nu"),
    (lambda: vc.Layered([], base="rigid"), "bodies.layers"),
    (lambda: vc.Layered([vc.Layer(1.0, 1.0, 0.3)], base="soft"), "bodies.base"),
    (lambda: vc.Layered([vc.Layer(1.0, 1.0, 0.3)], base=(0.0, 0.3)), "bodies.base[0]"),
    (lambda: vc.Scene(bodies=(COAT, vc.Bodies(G=(1.0, 2.0), nu=0.3)), **ENTRIES), "bodies.lower"),
    (lambda: vc.Scene(bodies=(COAT, 3.0), **ENTRIES), "bodies.lower"),
    by="field",
)


def test_tables_of_pandas_are_arrays():
    creepages = pd.Series([1e-3, 2e-3], index=[7, 9])
    assert vc.Transient(steps=2, vx=creepages).vx == (1e-3, 2e-3)
    with pytest.raises(vc.SceneError, match="vx"):
        vc.Transient(steps=2, vx=pd.DataFrame(np.ones((2, 2))))
    friction = np.linspace(0.1, 0.4, 12).reshape(3, 4)
    scene = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.3),
        surface=vc.Paraboloids(1.0, 2.0),
        normal_force=0.1,
        friction=pd.DataFrame(friction),
        grid=vc.Grid(nx=4, ny=3, dx=0.3, dy=0.4, x0=-0.6, y0=-0.6),
        motion=vc.Steady(vx=1e-3),
    )
    np.testing.assert_array_equal(scene.friction, friction)
