"""Contact that curves along the rolling direction: Persson's pin in a hole, half-spaces where the
curvature is slight, and what must not matter.
"""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from varcontact import energy
from varcontact.reference import pin_in_hole

STEEL = vc.Bodies(G=80e9, nu=0.3)
R = 0.01
FORCE = 2e5


def pin(clearance, bodies=STEEL, grid="auto", **changes):
    surface = vc.PinInHole(R=R, clearance=clearance)
    return vc.Scene(bodies=bodies, surface=surface, normal_force=FORCE, grid=grid, **changes)


def clearance_of(degrees):
    """The clearance at which Persson's contact goes so far either way."""
    square = np.tan(np.radians(degrees) / 2) ** 2
    ratio = 2 * (1 - square) - np.log(square + 1) / (square + 1)
    return ratio / (np.pi * square) * FORCE * (1 - STEEL.nu) / (2 * STEEL.G)


@pytest.mark.parametrize("degrees", [5, 30, 60, 75, 84])
def test_pressures_are_perssons(degrees):
    clearance = clearance_of(degrees)
    persson = pin_in_hole(R, clearance, STEEL, force=FORCE)
    assert np.degrees(persson.half_angle) == pytest.approx(degrees, rel=1e-10)
    sol = vc.solve(pin(clearance), accuracy=1e-3)
    assert sol.max_pressure == pytest.approx(persson.peak_pressure, rel=5e-4)
    half = np.count_nonzero(sol.pressure) * sol.grid.dx / 2
    assert half == pytest.approx(persson.half_angle * R, abs=1.01 * sol.grid.dx)
    inside = np.abs(sol.grid.x) < 0.9 * persson.half_angle * R
    expected = persson.pressure(sol.grid.x / R)
    np.testing.assert_allclose(sol.pressure[0, inside], expected[inside], rtol=2e-3)
    assert sol.normal_force == pytest.approx(FORCE, rel=1e-8)


@pytest.mark.long
def test_the_pin_rolls_and_slips():
    """Forces are in balance with the tractions, friction loses what drives it, and the other way
    round all is mirrored.
    """
    grid = vc.Grid(nx=100, dx=2.0 * R / 100, x0=-R)
    sols = {}
    for motion in (vc.Steady(vx=1e-3), vc.Steady(vx=-1e-3), vc.Shift(ux=1e-5)):
        sol = vc.solve(pin(clearance_of(40), grid=grid, friction=0.2, motion=motion))
        sin, cos = np.sin(grid.x / R), np.cos(grid.x / R)
        vertical = (sin * sol.traction[0] + cos * sol.pressure).sum() * grid.area
        along = (cos * sol.traction[0] - sin * sol.pressure).sum() * grid.area
        assert [sol.normal_force, sol.Fx] == pytest.approx([vertical, along], rel=1e-12)
        assert sol.normal_force == pytest.approx(FORCE, rel=1e-8)
        assert sol.certificate.residual < 1e-8
        sols[motion] = sol
    forward, backward, shift = sols.values()
    assert forward.power == pytest.approx(forward.friction_work, rel=1e-9)
    assert 0 < shift.friction_work < shift.power
    # a shift has no direction that particles come from
    other = vc.solve(replace(shift.scene, motion=vc.Shift(ux=-1e-5)))
    np.testing.assert_allclose(other.pressure[:, ::-1], shift.pressure, rtol=1e-5, atol=1.0)
    # no creepage, but pressures stretch both surfaces unevenly: not quite mirrored
    assert forward.Fx < 0 < backward.Fx
    assert backward.Fx == pytest.approx(-forward.Fx, rel=0.5)


def test_a_rigid_body_leaves_half_of_the_compliance():
    """Of a small contact half the width by the root of a half, Hertz's; of a large one less, and
    other for the pin than for the plate.
    """
    rigid = float("inf")
    halves = {}
    for degrees in (8, 40):
        for G in (80e9, (80e9, rigid), (rigid, 80e9)):
            sol = vc.solve(pin(clearance_of(degrees), vc.Bodies(G=G, nu=0.5)), accuracy=3e-3)
            halves[degrees, G] = sol.normal_force / sol.max_pressure
    small, large = (
        [halves[degrees, each] / halves[degrees, 80e9] for each in ((80e9, rigid), (rigid, 80e9))]
        for degrees in (8, 40)
    )
    np.testing.assert_allclose(small, np.sqrt(0.5), rtol=0.02)
    assert abs(large[0] - large[1]) > 0.01


def test_energies_of_a_pin_are_equal_at_the_solution():
    """Potential and complementary energy of its pressures, at the approach that its force makes."""
    posed = energy.posed(vc.solve(pin(clearance_of(60)), accuracy=1e-2))
    energies = [
        each(posed.normal, posed.pressure)
        for each in (energy.potential_energy, energy.complementary_energy)
    ]
    assert energies[0] == pytest.approx(energies[1], rel=1e-9)


def test_extrapolated_approaches_are_not_those_of_the_fields(tmp_path):
    sol = vc.solve(pin(clearance_of(60)), accuracy=1e-2)
    sol.save(tmp_path / "pin.nc")
    loaded = vc.load(tmp_path / "pin.nc")
    assert loaded.approach == sol.approach
    assert loaded.certificate.residual == pytest.approx(sol.certificate.residual, abs=1e-12)


def test_stresses_below_a_pin_are_refused():
    sol = vc.solve(pin(clearance_of(60)))
    with pytest.raises(vc.SceneError, match="surface"):
        vc.stress_below(sol, depths=[1e-3])


@pytest.mark.long
def test_files_keep_pins_and_inclinations(tmp_path):
    x = np.linspace(-2.0, 2.0, 41)
    turned = vc.SampledDistance(x**2 / 100, x, reference_depth=40.0, inclination_x=x / 8)
    line = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.3),
        surface=turned,
        normal_force=0.02,
        friction=0.3,
        motion=vc.Steady(vx=1e-3),
        grid=vc.Grid(nx=50, dx=0.05, x0=-1.25),
    )
    grid = vc.Grid(nx=80, dx=2.0 * R / 80, x0=-R)
    round_pin = pin(clearance_of(40), grid=grid, friction=0.2, motion=vc.Steady(vx=1e-3))
    for scene in (line, round_pin):
        sol = vc.solve(scene)
        scene.save(tmp_path / "scene.toml")
        again = vc.solve(vc.read_scene(tmp_path / "scene.toml")[0])
        np.testing.assert_array_equal(again.traction, sol.traction)
        sol.save(tmp_path / "solution.nc")
        loaded = vc.load(tmp_path / "solution.nc")
        np.testing.assert_array_equal(loaded.pressure, sol.pressure)
        assert loaded.certificate.residual < 1e-8


# ----------------------------------------------------------------------------- turned half-spaces


def turned_line(radius, friction=0.3, vx=1e-3):
    """Line contact 2 wide on a reference arc."""
    x = np.linspace(-2.0, 2.0, 401)
    inclination = None if np.isinf(radius) else x / radius
    surface = vc.SampledDistance(x**2 / 100, x, reference_depth=10.0, inclination_x=inclination)
    return vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.3),
        surface=surface,
        normal_force=0.02,
        friction=friction,
        motion=vc.Steady(vx=vx),
        grid=vc.Grid(nx=100, dx=0.025, x0=-1.25),
    )


def test_slight_curvature_is_half_spaces_and_a_creepage():
    """Pressures change with the square of the curvature.

    Tractions do with the curvature itself: displacements along normals that turn are slip, and on
    an arc of radius R it is the creepage ``2 (1 - nu) Fn/(pi G R)``.
    """
    plane = vc.solve(turned_line(np.inf))
    off, forces = [], []
    for radius in (3e4, 1e4):
        sol = vc.solve(turned_line(radius, friction=3e-2, vx=1e-4))
        creepage = 2 * 0.7 * 0.02 / (np.pi * radius)
        flat = [
            vc.solve(turned_line(np.inf, friction=3e-2, vx=1e-4 + more)).Fx
            for more in (0.0, creepage)
        ]
        forces.append((sol.Fx - flat[0]) / (flat[1] - flat[0]))
        off.append(sol.max_pressure / plane.max_pressure - 1)
    np.testing.assert_allclose(forces, 1.0, atol=0.05)
    assert np.abs(off).max() < 1e-5
    frictionless = [
        vc.solve(replace(turned_line(radius), motion=None, friction=None)).max_pressure
        for radius in (np.inf, 40.0, 20.0)
    ]
    first, second = np.diff(frictionless)
    assert first + second == pytest.approx(4 * first, rel=0.02)


@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_a_pin_that_hardly_goes_round_is_two_cylinders_and_a_creepage(nu):
    """``(1 - 3 nu/2) Fn/(pi G R)``: displacements along normals, and longer circumferences."""
    bodies = vc.Bodies(G=1.0, nu=nu)
    force, friction, radius = 1e-5, 0.01, 20.0  # of a pin of radius 1 with a clearance of 0.05
    half = vc.reference.line_contact(radius, bodies, force=force).a
    grid = vc.Grid(nx=120, dx=2.4 * half / 120, x0=-1.2 * half)
    vx = 0.3 * friction * half / radius
    creepage = (1 - 1.5 * nu) * force / np.pi

    def traction(surface, vx):
        scene = vc.Scene(
            bodies=bodies, surface=surface, normal_force=force, friction=friction,
            motion=vc.Steady(vx=vx), grid=grid,
        )  # fmt: skip
        return vc.solve(scene).traction[0].sum()

    cylinders = [traction(vc.Cylinders(radius), vx + more) for more in (0.0, creepage)]
    change = traction(vc.PinInHole(R=1.0, clearance=0.05), vx) - cylinders[0]
    assert change == pytest.approx(cylinders[1] - cylinders[0], rel=0.05)


GRID = vc.Grid(nx=20, ny=14, dx=1.0, dy=1.0, x0=-10.0, y0=-7.0)


def groove(across=None, along=None, motion=None, exchanged=False, waves=0.0):
    """A body in a hollow, curved across or along x, or the same with x and y exchanged."""
    x, y = GRID.x, GRID.y
    h = x**2 / 1301 + y[:, None] ** 2 / 702
    by_row = None if across is None else y / across + waves * np.sin(y / 3)
    by_column = None if along is None else x / along + waves * np.sin(x / 3)
    grid = GRID
    if exchanged:
        grid = vc.Grid(nx=14, ny=20, dx=1.0, dy=1.0, x0=-7.0, y0=-10.0)
        h = h.T
        by_row, by_column = by_column, by_row
    return vc.Scene(
        bodies=vc.Bodies(G=82000.0, nu=0.28),
        surface=vc.SampledDistance(h, inclination=by_row, inclination_x=by_column),
        approach=0.06,
        friction=0.3,
        motion=motion,
        grid=grid,
    )


@pytest.mark.parametrize("waves", [0.0, 0.1])
def test_a_shift_along_a_groove_is_that_across_with_axes_exchanged(waves):
    across = vc.solve(groove(10.1, motion=vc.Shift(ux=2e-3, uy=5e-3), waves=waves))
    motion = vc.Shift(ux=5e-3, uy=2e-3)
    along = vc.solve(groove(10.1, motion=motion, exchanged=True, waves=waves))
    assert 0 < across.elements["slip"] < across.elements["contact"]
    largest = across.max_pressure
    np.testing.assert_allclose(along.pressure.T, across.pressure, atol=1e-7 * largest)
    np.testing.assert_allclose(
        along.traction[::-1].swapaxes(1, 2), across.traction, atol=1e-6 * largest
    )
    assert [along.Fy, along.Fx] == pytest.approx([across.Fx, across.Fy], rel=1e-6)


@pytest.mark.parametrize(("across", "along"), [(None, 12.0), (10.1, 12.0)])
def test_rolling_along_a_curved_surface_loses_what_drives_it(across, along):
    """Curved along x, and along both axes, where numbers are by element; slightly, it is the
    plane.
    """
    motion = vc.Steady(vx=2e-3, spin=1e-4)
    sol = vc.solve(groove(across, along, motion, waves=0.1))
    assert sol.power == pytest.approx(sol.friction_work, rel=1e-9)
    assert sol.certificate.residual < 1e-7
    flat = vc.solve(groove(motion=motion))
    near = [vc.solve(groove(across and 100 * s, 100 * s, motion)) for s in (10.0, 100.0)]
    off = [abs(each.Fx - flat.Fx) for each in near]
    assert off[1] < 0.15 * off[0] < 0.05 * abs(flat.Fx)


BAD = {
    "surface.inclination_x": [
        lambda: vc.solve(turned_line(0.6)),
        lambda: vc.SampledDistance(np.zeros(3), reference_depth=1.0, inclination_x=[0.0, 0.5, 1.0]),
        lambda: vc.SampledDistance(np.zeros((2, 3)), inclination_x=[0.0, 0.1]),
        lambda: replace(turned_line(1.5), grid=vc.Grid(nx=4, dx=0.6, x0=-1.2)),
        lambda: vc.SampledDistance(np.zeros((2, 3)), inclination_x=[0.0, 0.1, np.nan]),
    ],
    "surface.inclination": [lambda: vc.SampledDistance(np.zeros(3), inclination=[0.0])],
    "motion.Fx": [
        lambda: replace(turned_line(10.0), motion=vc.Steady(Fx=1e-3)),
        lambda: pin(1e-5, friction=0.2, motion=vc.Steady(Fx=1e3)),
    ],
    "motion": [
        lambda: replace(turned_line(10.0), motion=vc.Transient(steps=3, vx=1e-3)),
        lambda: pin(1e-5, friction=0.2, motion=vc.Transient(steps=3, vx=1e-3)),
    ],
    "surface.clearance": [
        lambda: vc.PinInHole(R=R, clearance=-1e-6),
        lambda: pin(0.11 * R),
    ],
    "surface.reference_depth": [
        lambda: vc.SampledDistance(np.zeros(3), inclination_x=[0.0, 0.1, 0.2]),
        lambda: vc.PinInHole(R=R, clearance=1e-5, reference_depth=2 * R),
    ],
    "approach": [lambda: replace(pin(1e-5), normal_force=None, approach=1e-6)],
    "bodies": [lambda: pin(1e-5, bodies=vc.Layered([vc.Layer(h=0.1, G=3.0, nu=0.3)], base=(1.0, 0.3)))],
    "grid": [lambda: pin(1e-5, grid=vc.Grid(nx=100, dx=0.07 * R, x0=-3.5 * R))],
    "grid.tractions": [lambda: pin(1e-5, grid=vc.Grid(nx=100, tractions="linear"))],
    "loads": [lambda: pin(1e-5, loads=vc.SurfaceLoad(x=(0.5 * R, 0.6 * R), pressure=1e6))],
    "surface": [
        lambda: vc.friction_problem(
            pin(1e-5, friction=0.2, motion=vc.Shift(ux=1e-5), grid=vc.Grid(nx=50, dx=R / 25, x0=-R))
        )
    ],
    "normal": [lambda: vc.solve(pin(1e-5), normal="hertz")],
    "tangential": [
        lambda: vc.solve(pin(1e-5, friction=0.2, motion=vc.Steady(vx=1e-3)), tangential="fastsim")
    ],
}  # fmt: skip


@pytest.mark.parametrize(
    ("field", "call"), [(name, call) for name, calls in BAD.items() for call in calls]
)
def test_bad_input_is_refused(field, call):
    with pytest.raises(vc.SceneError) as error:
        call()
    assert error.value.field.split("[")[0] == field
