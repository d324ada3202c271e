"""Tractions that are linear between the centres of strips: Bentall and Johnson's elements."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

import varcontact as vc
from tests.scenes import carters_cylinders, make_scene
from varcontact.elasticity.halfspace import HalfSpaces
from varcontact.reference import cattaneo_line, line_contact

LIKE = vc.Bodies(G=1.0, nu=0.3)
UNLIKE = vc.Bodies(G=(1.0, 3.0), nu=(0.2, 0.4))
GRID = vc.Grid(nx=32, tractions="linear")


def cylinders(motion=None, bodies=LIKE, grid=GRID, **more):
    surface = vc.Cylinders(R=1.0, reference_depth=1.0)
    return make_scene(surface, 1e-3, motion, grid, bodies=bodies, **more)


@pytest.mark.parametrize("x", [0.0, 0.3, -1.0, 7.9, -8.1, 400.0])
def test_influence_numbers_are_means_of_strips(x):
    """A triangle is a strip, spread over its own width."""
    medium = HalfSpaces(0.3, K=0.1, depth=4.0)
    strip = vc.Grid(nx=1, dx=1.0, x0=-0.5)
    names = ("xx", "yy", "zz", "xz", "zx", "xy", "yz")

    def at(place, name):
        return medium.influence(strip, np.array([place]), np.zeros(1), [name])[name][0]

    numbers = medium.influence(
        replace(strip, tractions="linear"), np.array([x]), np.zeros(1), names
    )
    for name in names:
        mean = quad(lambda s, name=name: at(x + s, name), -0.5, 0.5, epsabs=1e-13, limit=200)[0]
        assert numbers[name][0] == pytest.approx(mean, abs=1e-12)


def test_pressures_meet_the_contact_equation():
    """By quadrature of the pressure as it is drawn between the centres."""
    sol = vc.solve(cylinders(), normal="norm")
    x = sol.grid.x
    pressure = sol.pressure[0]

    def deformed(at):
        def kernel(s):
            return -np.log(abs(s - at)) * np.interp(s, x, pressure)

        elastic = quad(kernel, x[0], x[-1], points=[at, *x[1:-1]], limit=2000, epsabs=1e-12)[0]
        return at**2 / 2 + 2 * (1 - LIKE.nu) / np.pi * elastic - sol.approach

    middle = int(np.argmax(pressure))
    for k in (middle - 9, middle, middle + 7):
        assert deformed(x[k]) == pytest.approx(0, abs=1e-7 * sol.approach)
    drawn = np.trapezoid(pressure, x)
    assert drawn == pytest.approx(sol.normal_force, rel=1e-12)


def test_order_on_hertz_is_two():
    study = vc.converge(cylinders(), [16, 24, 32, 48], method="norm", offsets=1)
    rows = study.limit("approach")
    exact = cylinders().hertz.approach
    assert rows["order"] == pytest.approx(2, abs=0.1)
    assert rows["value"] == pytest.approx(exact, rel=1e-5)


@pytest.mark.parametrize("tractions", ["constant", "linear"])
def test_order_on_carter_is_one(tractions):
    """Linear tractions are no better: the slip is a difference of first order over an element."""
    exact, scene = carters_cylinders()
    scene = replace(scene, grid=vc.Grid(nx=16, tractions=tractions))
    limit = vc.converge(scene, [16, 32, 64, 128], offsets=1).limit("Fx")
    assert limit["order"] == pytest.approx(1, abs=0.05)
    assert limit["value"] == pytest.approx(exact.force, rel=2e-3)
    error = abs(limit["finest"] / exact.force - 1)
    assert error == pytest.approx({"constant": 2.8e-3, "linear": 3.3e-3}[tractions], rel=0.05)


@pytest.mark.parametrize("tractions", ["constant", "linear"])
def test_order_on_cattaneo_is_one(tractions):
    """The distance of tractions from the closed form, at the centres."""
    contact = line_contact(1.0, LIKE, force=1e-3)
    exact = cattaneo_line(contact, 0.3, -0.6 * 0.3e-3)
    errors = []
    for nx in (16, 32, 64):
        grid = vc.Grid(nx=nx, tractions=tractions)
        sol = vc.solve(cylinders(vc.Shift(Fx=-0.6 * 0.3e-3), grid=grid), normal="norm")
        difference = sol.traction[0, 0] - exact.traction(sol.grid.x)
        errors.append(np.sqrt(np.mean(difference**2)) / (0.3 * contact.peak_pressure))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx(1.05, abs=0.1)
    assert errors[0] < 0.017


@pytest.mark.long
@pytest.mark.parametrize("tractions", ["constant", "linear"])
def test_order_on_cattaneos_shift_is_one_and_a_half(tractions):
    """At 3/4 of what friction carries half of the contact sticks: its edges fall between elements
    on all grids, as those of the contact do, and leave no noise.
    """
    contact = line_contact(1.0, LIKE, force=1e-3)
    motion = vc.Shift(Fx=-0.75 * 0.3e-3)
    scene = cylinders(motion, grid=vc.Grid(nx=16, tractions=tractions))
    study = vc.converge(scene, [16, 32, 48, 64], offsets=1)
    limit = study.limit("vx")
    assert limit["order"] == pytest.approx(1.5, abs=0.05)
    assert 1.3 < limit["order_low"] < limit["order_high"] < 1.7
    # k f N ((ln(2 d/a) + 1/2) - (c/a)^2 (ln(2 d/c) + 1/2)) below a depth d = 1, k = 2 (1 - nu)/(pi G)
    a = contact.a
    exact = (np.log(2 / a) + 0.5) - 0.25 * (np.log(4 / a) + 0.5)
    exact *= 2 * (1 - LIKE.combined_nu) / (np.pi * LIKE.combined_G) * 0.3e-3
    assert limit["value"] == pytest.approx(exact, rel=2e-5)
    # where they fall anywhere, the stick area's own staircase is larger than the errors
    anywhere = vc.converge(scene, [16, 32, 48, 64], offsets=3).limit("vx")
    assert anywhere["reason"] == "the noise hides the order"
    assert anywhere["value"] == pytest.approx(exact, abs=anywhere["error"])


@pytest.mark.parametrize("motion", [vc.Shift(ux=1e-4, uy=5e-5), vc.Steady(vx=5e-4), None])
@pytest.mark.parametrize("bodies", [LIKE, UNLIKE])
def test_both_courses_have_one_limit(motion, bodies):
    fine = vc.Grid(nx=128)
    scene = cylinders(motion, bodies, fine)
    normal = "auto" if motion else "norm"
    constant = vc.solve(scene, normal=normal)
    linear = vc.solve(replace(scene, grid=replace(fine, tractions="linear")), normal=normal)
    assert linear.certificate.residual < 1e-8
    assert linear.force == pytest.approx(constant.force, abs=2e-3 * 0.3e-3)
    size = constant.pressure.max()
    inside = np.abs(constant.grid.x) < 0.8 * constant.grid.x.max()
    distance = np.abs(linear.pressure - constant.pressure)[:, inside]
    assert distance.max() < 5e-3 * size


def test_a_history_ends_in_steady_rolling():
    scene = cylinders(vc.Steady(vx=5e-4), UNLIKE)
    steady = vc.solve(scene)
    history = vc.solve(replace(scene, motion=vc.Transient(steps=2, vx=5e-4, start=steady)))
    size = steady.pressure.max()
    assert history[-1].traction == pytest.approx(steady.traction, abs=1e-7 * size)


def test_stresses_below_are_those_of_linear_tractions():
    """By quadrature of line loads (Flamant)."""
    sol = vc.solve(cylinders(vc.Steady(vx=5e-4)))
    x = sol.grid.x
    at = np.array([x[12] + 0.3 * sol.grid.sides[0], 0.0, 0.5 * sol.grid.sides[0]])

    def flamant(s):
        along = at[0] - s
        pressed = at[2] * np.interp(s, x, sol.pressure[0])
        pulled = along * np.interp(s, x, sol.traction[0, 0])
        return -2 / np.pi * along**2 * (pressed + pulled) / (along**2 + at[2] ** 2) ** 2

    exact = quad(flamant, x[0], x[-1], points=[at[0], *x[1:-1]], limit=2000)[0]
    stress = vc.stress(sol, at[:, None], "upper").stress[0, 0, 0]
    assert stress == pytest.approx(exact, abs=2e-4 * sol.pressure.max())
    below = vc.stress_below(sol, [at[2]], "upper")
    again = vc.stress(sol, below.points, "upper")
    assert below.stress == pytest.approx(again.stress, abs=1e-14)


def test_files(tmp_path):
    scene = cylinders(vc.Steady(vx=5e-4))
    scene.save(tmp_path / "scene.toml")
    assert vc.read_scene(tmp_path / "scene.toml")[0].grid == scene.grid
    sol = vc.solve(scene)
    sol.save(tmp_path / "sol.nc")
    assert vc.load(tmp_path / "sol.nc").grid == sol.grid
    assert sol.grid.linear


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"bodies": vc.Layered([vc.Layer(0.1, 2.0, 0.3)], base=(1.0, 0.3))}, "grid.tractions"),
        ({"third_body": vc.ThirdBody(h=0.1, G=1.0)}, "grid.tractions"),
        (
            {
                "surface": vc.SampledDistance(
                    [0.1, 0.0, 0.1], [-1, 0, 1], None, 9.0, None, [-0.1, 0, 0.1]
                )
            },
            "grid.tractions",
        ),
    ],
)
def test_refused_scenes(change, named):
    with pytest.raises(vc.SceneError) as refused:
        replace(cylinders(vc.Steady(vx=1e-3)), **change)
    assert refused.value.field == named


@pytest.mark.parametrize(
    ("entries", "named"),
    [
        ({"ny": 8}, "grid.tractions"),
        ({"edge": "touched"}, "grid.edge"),
        ({"tractions": "quadratic"}, "grid.tractions"),
    ],
)
def test_refused_grids(entries, named):
    with pytest.raises(vc.SceneError) as refused:
        vc.Grid(**{"nx": 8, "tractions": "linear", **entries})
    assert refused.value.field == named
