"""Frequency responses against closed forms, histories that swing, and limits; growth of
corrugation.
"""

import dataclasses
import functools

import numpy as np
import pytest
import xarray as xr

import varcontact as vc
from tests.scenes import LIKE, make_scene, refused
from varcontact.elasticity.operators import influence_operator
from varcontact.reference import harmonic_coefficients, harmonic_line

UNLIKE = vc.Bodies(G=(1.0, 3.0), nu=(0.1, 0.3))
STEADY = vc.Steady(vx=0.03, vy=0.02, spin=0.05)


@functools.cache
def line(cells=60, friction=0.3, depth=20.0, **motion):
    surface, bodies = vc.Cylinders(R=50.0, reference_depth=depth), vc.Bodies(G=1.0, nu=0.3)
    scene = make_scene(surface, 0.01, vc.Steady(**motion), vc.Grid(nx=cells), friction, bodies)
    return vc.solve(scene, tol=1e-11)


@functools.cache
def ball(cells=12, edge="centres", motion=STEADY, **changes):
    grid = vc.Grid(nx=cells, ny=cells, edge=edge)
    return vc.solve(make_scene(vc.Ellipse(a=1.0, b=1.0), 1.0, motion, grid, **changes), tol=1e-11)


def test_line_contact_without_slip():
    kappa = np.array([0.0, 0.5, 2.0, 4.0])
    coarse, fine = (line(cells, np.inf, vx=1e-4) for cells in (100, 200))
    a = coarse.scene.hertz.a
    found = [sol.frequency_response(kappa / a).of("Fx", "vx") for sol in (coarse, fine)]
    exact = [-a * harmonic_line(each, 0.3, 20.0 / a) for each in kappa]
    np.testing.assert_allclose(found[1], exact, rtol=1e-3)
    np.testing.assert_allclose(2 * found[1] - found[0], exact, rtol=3e-5)


@pytest.mark.long
def test_sphere_without_slip():
    """Elements extrapolated: all five coefficients, and C32 = -C23."""
    motion = vc.Steady(vx=1e-4, spin_offset=0.0)
    pair = [ball(cells, edge="softened", friction=np.inf, motion=motion) for cells in (12, 24)]
    coarse, fine = (sol.frequency_response([0.5, 2.0]).values[:, :3] for sol in pair)
    for found, kappa in zip(2 * fine - coarse, (0.5, 2.0), strict=True):
        expected = -harmonic_coefficients(1.0, 0.28, kappa)
        np.testing.assert_allclose(found, expected, atol=0.02 * np.abs(expected).max())


def without_slip(cells=12, motion=None, surface=None, friction=np.inf, **changes):
    surface = surface or vc.Ellipse(a=1.0, b=1.0)
    grid = vc.Grid(nx=cells) if isinstance(surface, vc.Cylinders) else vc.Grid(nx=cells, ny=cells)
    motion = motion or vc.Harmonic(wave_number=1.5, vx=2e-3, vy=1e-3, spin=-1e-3)
    return make_scene(surface, 1.0, motion, grid, friction, **changes)


def test_harmonic_creepages_are_one_dense_complex_solve():
    scene = without_slip()
    found, motion = vc.solve(scene), scene.motion
    grid, step = found.free_rolling.grid, found.free_rolling.grid.dx
    elements = np.flatnonzero(found.free_rolling.pressure.ravel() > 0)
    here, before = (
        influence_operator(grid, "xy", "xy", nu=0.28, offset=at).dense(elements)
        for at in (0.0, step)
    )
    turn = np.exp(-1j * 1.5 * step)
    iy, ix = np.divmod(elements, grid.nx)
    x, y = grid.x[ix] + step / 6, grid.y[iy]
    rigid = (
        np.concatenate([motion.vx - motion.spin * y, motion.vy + motion.spin * x])
        * (1 - turn)
        / 1.5j
    )
    traction = np.linalg.solve(here - turn * before, -rigid).reshape(2, -1)
    size = np.abs(traction).max()
    np.testing.assert_allclose(
        found.traction.reshape(2, -1)[:, elements], traction, atol=1e-9 * size
    )
    assert abs(found.Fx - traction[0].sum() * grid.area) < 1e-10 * abs(found.Fx)
    # and nothing beside them
    assert abs(found.traction).sum() == pytest.approx(abs(traction).sum(), rel=1e-9)


@pytest.mark.long
def test_harmonic_creepages_without_a_matrix_tend_to_the_continuum():
    exact = -2e-3 * harmonic_coefficients(1.0, 0.28, 1.5)[0, 0]
    motion = vc.Harmonic(wave_number=1.5, vx=2e-3)
    errors = [abs(vc.solve(without_slip(cells, motion)).Fx / exact - 1) for cells in (16, 64)]
    assert errors[1] < 0.02
    assert errors[1] < 0.4 * errors[0]


@pytest.mark.parametrize(
    "surface", [vc.Ellipse(a=1.0, b=1.5), vc.Cylinders(R=50.0, reference_depth=20.0)]
)
@pytest.mark.parametrize("wave_number", [0.0, 1.5])
def test_harmonic_creepages_of_unlike_bodies(surface, wave_number):
    """Forces in proportion to the derivatives about any steady solution; at rest those of steady
    rolling.
    """
    spin = 0.0 if isinstance(surface, vc.Cylinders) else 1e-3
    given = {"vx": 2e-3, "vy": 1e-3, "spin": spin}
    scene = without_slip(
        surface=surface, motion=vc.Harmonic(wave_number=wave_number, **given), bodies=UNLIKE
    )
    found = vc.solve(scene)
    steady = vc.solve(dataclasses.replace(scene, motion=vc.Steady(**given)), tol=1e-11)
    response = steady.frequency_response(wave_number)
    names = [each for each in given if each in response.inputs]
    expected = sum(given[name] * response.of("Fx", name)[0] for name in names)
    assert abs(found.Fx - expected) < 1e-8 * abs(expected)
    if wave_number == 0:
        assert found.Fx == pytest.approx(steady.Fx - found.free_rolling.Fx, rel=1e-7)
        change = steady.pressure - found.free_rolling.pressure
        np.testing.assert_allclose(found.pressure, change, atol=1e-6 * np.abs(change).max())


@pytest.mark.parametrize("bodies", [LIKE, UNLIKE])
@pytest.mark.parametrize("friction", [0.3, np.inf])
def test_slow_swings_are_the_sensitivity(bodies, friction):
    sol = ball(bodies=bodies, friction=friction)
    response = sol.frequency_response([0.0, 1e-7])
    slope = sol.sensitivity()
    for each in response.values[:, :2, :3]:
        np.testing.assert_allclose(each, slope, atol=1e-5 * np.abs(slope).max())
    assert ("normal_force" in response.inputs) == (friction != np.inf and bodies == LIKE)


@pytest.mark.long
def test_what_a_solution_is_by_default_responds_as_fine_elements_do():
    """Second-order differences and softened edges: at rest the sensitivity, and near the limit of
    fine elements.
    """
    known, coarse = ball(32), ball(16)
    kappa = [0.0, 0.5, 1.0]
    second = vc.solve(coarse.scene.second_order())
    assert second.grid.edge == "softened"
    at_rest, slopes = second.frequency_response(0.0).values[0, :2, :3].real, second.sensitivity()
    np.testing.assert_allclose(at_rest, slopes, atol=1e-9 * abs(slopes).max())
    fine = 2 * known.frequency_response(kappa).of("Fx", "vx") - coarse.frequency_response(kappa).of(
        "Fx", "vx"
    )
    found = second.frequency_response(kappa)
    assert found.inputs == ("vx", "vy", "spin")
    np.testing.assert_allclose(found.of("Fx", "vx"), fine, atol=0.02 * abs(fine[0]))


@pytest.mark.long
def test_fast_swings_are_mindlin():
    """Where the contact hardly rolls within a swing, the force follows the displacement v/(i k)."""
    motion = vc.Steady(vx=1e-4, dq=1e-4)
    sol = ball(24, friction=np.inf, motion=motion)
    still = dataclasses.replace(sol.scene, motion=vc.Shift(ux=1e-4))
    stiffness = vc.solve(still, tol=1e-11).sensitivity()[0, 0]
    k = np.array([10.0, 20.0, 30.0])
    found = 1j * k * sol.frequency_response(k).of("Fx", "vx") / stiffness
    assert np.all(np.diff(abs(found - 1)) < 0)
    assert abs(found[-1] - 1) < 2e-3


def swinging(sol, name, amplitude):
    """Wave number of a history whose creepage swings about a solution, and complex amplitude of its
    forces by it.
    """
    per = 16
    dq = sol.grid.sides[0]
    k = 2 * np.pi / (per * dq)
    q = dq * np.arange(1, 6 * per + 1)
    swing = amplitude * np.real((1 - np.exp(-1j * k * dq)) / (1j * k * dq) * np.exp(1j * k * q))
    creepages = {"vx": sol.vx, "vy": sol.vy, "spin": sol.spin}
    motion = vc.Transient(
        steps=q.size, dq=dq, **creepages | {name: creepages[name] + swing}, start=sol
    )
    history = vc.solve(dataclasses.replace(sol.scene, motion=motion, grid=sol.grid), tol=1e-11)
    last = slice(-2 * per, None)
    change = history.force[last] - sol.force
    return k, 2 * np.mean(change * np.exp(-1j * k * q[last])[:, None], axis=0) / amplitude


@pytest.mark.long
@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({}, "vx"),
        ({"friction": np.inf}, "vy"),
        ({"bodies": UNLIKE}, "vy"),
        ({"third_body": vc.ThirdBody(h=0.1, G=0.1)}, "vx"),
    ],
)
def test_histories_that_swing(changes, name):
    sol = ball(**changes)
    k, found = swinging(sol, name, 1e-6)
    response = sol.frequency_response(k)
    expected = np.array([response.of(force, name)[0] for force in ("Fx", "Fy")])
    np.testing.assert_allclose(found, expected, atol=1e-4 * np.abs(expected).max())


@pytest.mark.parametrize(("part", "expected"), [(0.5, -0.7071), (0.9, -1.5811)])
def test_creepage_by_load_at_constant_force(part, expected):
    """Carter: d ln vx/d ln N = 1/2 - T/(2 sqrt(1 - T) (1 - sqrt(1 - T))); the leading edge moves
    with the load.
    """
    errors = []
    for cells in (120, 240):
        sol = line(cells, Fx=-0.003 * part)
        response = sol.frequency_response(0.0)
        slope = (
            -(response.of("Fx", "normal_force") / response.of("Fx", "vx"))[0].real * 0.01 / sol.vx
        )
        errors.append(abs(slope / expected - 1))
    assert errors[1] < 0.007
    assert errors[1] < 0.7 * errors[0]


@pytest.mark.parametrize("order", ["first-order", "second-order"])
def test_a_slow_swing_of_the_load_moves_the_leading_edge(order):
    """Near the derivative on a grid that follows Hertz's ellipse, by both slip differences."""
    motion = dataclasses.replace(STEADY, slip_difference=order, spin_offset=0.0)
    ellipse = ball(24, motion=motion).scene
    sphere = vc.Paraboloids(ellipse.hertz.Rx, ellipse.hertz.Ry)
    sol = vc.solve(dataclasses.replace(ellipse, surface=sphere), tol=1e-11)
    found = sol.frequency_response(0.0).of("Fx", "normal_force")[0].real
    expected = float(sol.gradient("Fx", "normal_force", edge="following").normal_force)
    assert found == pytest.approx(expected, rel=0.12)


def test_rows_of_four_elements_bring_no_rounding_in():
    """Their inner pressures are equal but for rounding, whose ratio is no slope at the edge."""
    responses = []
    for cells in (10, 20):
        grid = vc.Grid(nx=cells, ny=cells, dx=2.8 / cells, dy=2.8 / cells, x0=-1.4, y0=-1.38)
        surface, motion = vc.Paraboloids(100.0, 90.0), vc.Steady(vx=5e-4, vy=1.5e-4, spin=3e-4)
        scene = make_scene(surface, 0.0141853, motion, grid, 0.3, LIKE)
        sol = vc.solve(scene, normal="norm")
        responses.append(np.abs(sol.frequency_response([0.5]).of("Fx", "normal_force")[0]))
        if cells == 10:
            assert 4 in (sol.pressure > 0).sum(axis=1)
    assert responses[0] < 5 * responses[1]


def test_unlike_bodies_have_no_response_to_the_load():
    """How tractions enter at a moving edge of unlike bodies is not known."""
    sol = ball(bodies=UNLIKE)
    assert sol.frequency_response(0.0).inputs == ("vx", "vy", "spin")
    with pytest.raises(vc.SceneError, match="bodies"):
        vc.corrugation_growth(sol, 1.0)


def test_full_slip_follows_the_load():
    response = ball(motion=vc.Steady(vx=2.0)).frequency_response([0.0, 2.0])
    # some slips to the side
    np.testing.assert_allclose(response.of("Fx", "normal_force"), -0.3, rtol=2e-5)
    np.testing.assert_allclose(response.of("Fz", "normal_force"), 1.0, rtol=1e-12)
    assert np.abs(response.of("Fx", "vx")).max() < 1e-5  # -4 where it sticks


@pytest.mark.long
def test_wave_numbers_share_a_space():
    """Many at once, in any order, as each of them alone."""
    some = np.random.default_rng(3).uniform(0, 9, 30)
    for sol in (
        line(60, Fx=-0.0015),
        ball(bodies=UNLIKE),
        ball(motion=vc.Steady(vx=0.03, dq=1e-5)),
    ):
        together = sol.frequency_response(some).values
        for i in (0, 17, 29):
            alone = sol.frequency_response(some[i]).values[0]
            np.testing.assert_allclose(together[i], alone, atol=1e-8 * np.abs(alone).max())


def test_flat_heights_move_the_bodies_apart():
    """A height that does not vary over the contact leaves the pressure; a short wave is
    filtered.
    """
    response = ball().frequency_response([0.0, 4.0])
    assert response.of("approach", "roughness")[0] == pytest.approx(-1.0, abs=1e-12)
    assert abs(response.of("approach", "roughness")[1]) < 0.3
    np.testing.assert_allclose(response.of("Fz", "roughness"), 0.0, atol=1e-12)


@pytest.mark.long
def test_state_space():
    response = ball().frequency_response(np.linspace(0, 6, 40))
    errors = []
    for order in (3, 8):
        system = response.state_space(
            order, outputs=("Fx", "Fy"), inputs=("vx", "vy", "spin"), speed=3.0
        )
        assert system.A.shape == (3 * order, 3 * order)
        assert np.linalg.eigvals(system.A).real.max() < 0
        s = 3j * response.wave_number[:, None, None] * np.eye(len(system.A))
        found = (
            system.C
            @ np.linalg.solve(s - system.A, np.broadcast_to(system.B, (40, *system.B.shape)))
            + system.D
        )
        expected = response.values[:, :2, :3]
        errors.append((np.abs(found - expected).max(axis=0) / np.abs(expected).max(axis=0)).max())
    assert errors[0] < 0.15
    assert errors[1] < 0.01


GROWTH = {0.25: 9.277 - 1.051j, 0.5: 3.611 - 1.169j, 1: 1.127 - 0.742j}
"""Wear by height, times a^2/(2 R), by wavelength/2a: half the friction limit, constant forces.

From an independent dense program with its own edges: 240 and 480 elements, extrapolated to 1 %."""
OF_HISTORIES = {2: 0.508 - 0.093j, 4: 0.147 - 0.0085j}
"""Of histories on 240 and 144 elements to the contact, under waves of 0.1/(R k^2)."""


@pytest.mark.long
def test_growth_by_wavelength():
    """Against another program, against histories within 2 %, and at long waves, where only the
    curvature counts.
    """
    lengths, found = np.array([*GROWTH, *OF_HISTORIES, 20]), []
    for cells in (120, 240):
        sol = line(cells, Fx=-0.0015)
        a = sol.scene.hertz.a
        growth = vc.corrugation_growth(sol, 2 * a * lengths)
        found.append((-growth.growth + 1j * growth.phase_shift).values * a**2 / (2 * 50.0))
        assert np.abs(growth.load_swing).max() < 1e-12
        assert float(growth.smooth.sum()) == pytest.approx(sol.power, rel=1e-6)
    known = np.array([*GROWTH.values(), *OF_HISTORIES.values(), (np.pi / 20) ** 2 / 4])
    np.testing.assert_allclose(found[1].real, known.real, rtol=0.015)
    np.testing.assert_allclose(found[1].real[3:], known.real[3:], rtol=0.003)
    off = np.abs(2 * found[1] - found[0] - known) / np.abs(known)
    assert off.max() < 0.015


LOAD_SWINGS = {0.5: {0.5: 0.123 - 0.304j, 1: -0.214 + 0.530j, 2: -0.577 + 0.104j, 100: -0.7071},
               0.9: {0.5: 0.117 - 0.122j, 1: -0.056 + 0.232j, 2: -1.050 - 0.010j, 100: -1.5811}}  # fmt: skip
"""Wear by the relative swing of the load at a constant force, by its part of the limit, and
wavelength/2a."""


@pytest.mark.long
@pytest.mark.parametrize("part", LOAD_SWINGS)
def test_growth_by_a_load_that_swings(part):
    """On a soft track less that of a constant load; of long waves as Carter's creepage follows the
    load.
    """
    known, found = LOAD_SWINGS[part], []
    for cells in (120, 240):
        sol = line(cells, Fx=-0.003 * part)
        lengths = 2 * sol.scene.hertz.a * np.array([*known])
        constant, swings = (
            vc.corrugation_growth(sol, lengths, track=track, speed=1.0)
            for track in (None, lambda w: 100.0)
        )
        more = constant.growth - swings.growth + 1j * (swings.phase_shift - constant.phase_shift)
        found.append((more / (swings.load_swing / 0.01)).values)
    known = np.array([*known.values()])
    assert (np.abs(2 * found[1] - found[0] - known) / np.abs(known)).max() < 0.03


def sampled(cells):
    """The same contact by samples: its pressure is computed, and the edge may be anywhere in an
    element.
    """
    sol = line(Fx=-0.0015)
    dx, nx = 2 * sol.scene.hertz.a / cells, 2 * int(0.8 * cells)
    grid = vc.Grid(nx=nx, dx=dx, x0=-nx * dx / 2)
    surface = vc.SampledDistance(grid.x**2 / 100.0, x=grid.x, reference_depth=20.0)
    return vc.solve(dataclasses.replace(sol.scene, surface=surface, grid=grid), tol=1e-11)


@pytest.mark.long
def test_growth_of_a_history():
    sol, contacts, cells = sampled(96), 2, 96
    dx, nx = sol.grid.dx, sol.grid.nx
    x, length = np.arange(contacts * cells) * dx, contacts * cells * dx
    k = 2 * np.pi / length
    wave, first = 0.05 / (50.0 * k**2), 3 * nx
    carried = vc.Carried(wave * np.cos(k * x), x, period=length)
    motion = vc.Transient(steps=first + x.size + nx, dq=dx, Fx=-0.0015, start=sol, carried=carried)
    work = vc.solve(dataclasses.replace(sol.scene, motion=motion)).work_along()[
        0, first : first + x.size
    ]
    swing = 2 * complex(
        np.mean((work - work.mean()) * np.exp(-1j * k * work.X)) / wave / work.mean()
    )
    growth = vc.corrugation_growth(line(240, Fx=-0.0015), length)
    assert -float(growth.growth[0]) == pytest.approx(swing.real, rel=0.02)
    assert float(growth.phase_shift[0]) == pytest.approx(swing.imag, abs=0.03 * abs(swing))


def test_growth_where_the_edge_hardly_touches_an_element():
    """Of 48.75 elements to the contact the one that particles enter slips, as it bears hardly
    anything.
    """
    thin, usual = sampled(48.75), sampled(48)
    assert np.flatnonzero(thin.state[0] == 2).max() == np.flatnonzero(thin.state[0]).max()
    found = [float(vc.corrugation_growth(sol, 2.7).growth[0]) for sol in (thin, usual)]
    assert found[0] == pytest.approx(found[1], rel=0.1)


@pytest.mark.long
def test_growth_with_receptances():
    """Rigid tracks and soft ones, a table and its function; a swing of the load that crosses over
    to growth.
    """
    sol = line(60, Fx=-0.0015)
    lengths = 2 * sol.scene.hertz.a * np.array([1.0, 2.0, 6.0])
    constant = vc.corrugation_growth(sol, lengths)
    soft = vc.corrugation_growth(sol, lengths, track=lambda w: 1e9, speed=1.0)
    np.testing.assert_allclose(soft.growth, constant.growth, rtol=1e-6)
    assert not [name for name in constant.variables if hasattr(xr.Dataset, name)], (
        "hidden by methods of xarray"
    )
    assert vc.corrugation_growth(sol, lengths, speed=[1.0, 2.0]).equals(constant)
    stiff = vc.corrugation_growth(sol, lengths, track=lambda w: 0.0, speed=1.0)
    response = sol.frequency_response(2 * np.pi / lengths)
    # with nothing that gives way the bodies stay where they are: approach = 0, at the creepages
    # that keep Fx
    ratio = np.array([response.of("approach", each) for each in ("normal_force", "roughness")])
    np.testing.assert_allclose(stiff.load_swing, -ratio[1] / ratio[0], rtol=1e-9)
    frequencies = np.linspace(0.1, 100.0, 40)
    mass = [-1 / (w**2 * 0.3) + 5j for w in frequencies]
    table = vc.corrugation_growth(sol, lengths, wheel=(frequencies, mass), speed=2.0)
    called = vc.corrugation_growth(
        sol, lengths, wheel=lambda w: np.interp(w, frequencies, mass), speed=2.0
    )
    np.testing.assert_allclose(table.growth, called.growth, rtol=1e-12)
    mapped = vc.corrugation_growth(sol, lengths, wheel=(frequencies, mass), speed=[1.0, 2.0])
    np.testing.assert_allclose(mapped.growth.sel(speed=2.0), table.growth, rtol=1e-12)
    image = vc.plot_growth(mapped).axes[0].collections[0]
    np.testing.assert_allclose(np.ravel(image.get_array()), np.ravel(mapped.growth.T))


@pytest.mark.parametrize(
    ("call", "field"),
    [
        (lambda sol: sol.frequency_response(1e3), "wave_number"),
        (lambda sol: sol.frequency_response(-1.0), "wave_number"),
        (lambda sol: sol.frequency_response([1.0, np.nan]), "wave_number[1]"),
        (lambda sol: sol.frequency_response([[1.0]]), "wave_number"),
        (lambda sol: sol.frequency_response([1.0]).of("Mx", "vx"), "output"),
        (lambda sol: sol.frequency_response([1.0]).state_space(2), "order"),
        (lambda sol: vc.corrugation_growth(sol, 1e-4), "wavelengths"),
        (lambda sol: vc.corrugation_growth(sol, []), "wavelengths"),
        (lambda sol: vc.corrugation_growth(sol, 1.0, wheel=lambda w: np.nan, speed=1.0), "wheel"),
        (
            lambda sol: vc.corrugation_growth(sol, 1.0, track=([0.0, 1.0], [1.0, 1.0]), speed=1.0),
            "track",
        ),
        (lambda sol: vc.corrugation_growth(sol, 1.0, track=lambda w: 1.0), "speed"),
        (lambda sol: vc.corrugation_growth(sol, 1.0, speed=-1.0), "speed"),
        (lambda sol: vc.corrugation_growth(sol, 1.0, track=lambda w: 1 / 0, speed=1.0), "track"),
        (lambda sol: vc.corrugation_growth(sol, 1.0, wheel=5, speed=1.0), "wheel"),
        (lambda sol: vc.corrugation_growth(sol.scene, 1.0), "sol"),
        (lambda sol: vc.corrugation_growth(ball(friction=np.inf), 1.0), "solution"),
        (lambda sol: ball(motion=vc.Shift(ux=0.01)).frequency_response(1.0), "motion"),
        (lambda sol: vc.corrugation_growth(ball(edge="softened"), 1.0), "grid.edge"),
        (lambda sol: line(depth=None, vx=1e-4).frequency_response(1.0), "surface.reference_depth"),
        (lambda sol: vc.Harmonic(wave_number=-1.0), "motion.wave_number"),
        (lambda sol: vc.Harmonic(wave_number=1.0, vy=np.nan), "motion.vy"),
        (lambda sol: vc.Harmonic(wave_number=1.0, dq=0.0), "motion.dq"),
        (lambda sol: without_slip(friction=0.3), "friction"),
        (
            lambda sol: without_slip(third_body=vc.ThirdBody(h=0.1, G=1.0, tau_c0=0.1)),
            "third_body.tau_c0",
        ),
        (lambda sol: without_slip(surface=vc.Cylinders(R=50.0)), "surface.reference_depth"),
        (
            lambda sol: vc.solve(without_slip(motion=vc.Harmonic(wave_number=1e3))),
            "motion.wave_number",
        ),
        (lambda sol: vc.plan(without_slip()), "motion"),
        (lambda sol: vc.sweep(without_slip(), over={"motion.vx": [0.0, 1.0]}), "scenes.motion"),
        (lambda sol: vc.compare(without_slip()), "scenes.motion"),
        (lambda sol: vc.converge(without_slip(), [8, 16]), "motion"),
    ],
)
def test_refused(call, field):
    refused(lambda: call(ball()), field)
