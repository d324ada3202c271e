"""Whole scenes against closed forms, symmetries, and invariances."""

import dataclasses
from functools import partial

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene, refused
from varcontact.reference import cattaneo_mindlin

# ----------------------------------------------------------------------------- normal contact


def test_hertz_pressure_carries_the_force(rolling):
    sol = vc.solve(rolling(motion=None, friction=None, grid=vc.Grid(nx=40, ny=40)))
    hertz = sol.scene.hertz
    assert sol.plan.normal == "hertz"
    assert sol.normal_force == pytest.approx(1.0, rel=1e-13)
    assert sol.approach == pytest.approx(hertz.approach)
    exact = hertz.pressure(sol.grid.x[None, :], sol.grid.y[:, None])
    np.testing.assert_allclose(sol.pressure, exact, atol=5e-3 * hertz.peak_pressure)
    assert not sol.force.any()
    assert sol.elements["slip"] == 0


@pytest.mark.parametrize("part", [0.3, 0.657, 0.9])
def test_cattaneo(part):
    """nu = 0, where Cattaneo is exact: shift, traction, and the area of the stick disk, to the
    grid's error.
    """
    bodies = vc.Bodies(G=1.0, nu=0.0)
    motion, grid = vc.Shift(Fx=-part * 0.4), vc.Grid(nx=32, ny=32)
    scene = make_scene(vc.Ellipse(1.0, 1.0), 1.0, motion, grid, 0.4, bodies)
    sol = vc.solve(scene)
    exact = cattaneo_mindlin(scene.hertz, bodies, 0.4, -part * 0.4)
    assert sol.force == pytest.approx([-part * 0.4, 0.0], abs=1e-14)
    assert sol.creepage[0] == pytest.approx(exact.shift, rel=0.02)
    assert sol.areas["stick"] == pytest.approx(np.pi * exact.stick_radius**2, rel=0.06)
    inside = exact.traction(sol.grid.x[None, :], sol.grid.y[:, None])
    difference = np.sqrt(np.sum((sol.traction[0] - inside) ** 2) / np.sum(inside**2))
    assert difference < 0.05
    assert np.abs(sol.traction[1]).max() < 1e-13, "for nu = 0 there is no lateral traction"


def test_shift_problem_turns_with_the_axes(rolling):
    """Rotated by 90 degrees: ellipse, shift and all."""
    motion = vc.Shift(ux=0.1, uy=0.03, rotation=0.05)
    turned_motion = vc.Shift(ux=-0.03, uy=0.1, rotation=0.05)
    sol = vc.solve(rolling(motion=motion, grid=vc.Grid(nx=12, ny=10)))
    turned = vc.solve(
        rolling(motion=turned_motion, surface=vc.Ellipse(a=0.9, b=1.2), grid=vc.Grid(nx=10, ny=12))
    )
    # (x, y) -> (-y, x): rows become columns
    px, py = np.rot90(sol.traction[0], -1), np.rot90(sol.traction[1], -1)
    np.testing.assert_allclose(turned.traction, [-py, px], atol=1e-12)
    assert turned.force == pytest.approx([-sol.force[1], sol.force[0]], rel=1e-11)
    assert turned.moment == pytest.approx(sol.moment, rel=1e-11)


def test_full_slip(rolling):
    """Creepage far beyond the elastic: f Fz against the rigid slip, exactly in direction."""
    sol = vc.solve(rolling(motion=vc.Steady(vx=3e3, vy=-4e3)))
    assert sol.elements["stick"] == 0
    assert sol.force == pytest.approx([-0.3 * 0.6, 0.3 * 0.8], rel=1e-4)
    assert np.hypot(*sol.force) == pytest.approx(0.3, rel=1e-7)
    spinning = vc.solve(rolling(motion=vc.Steady(spin=1e4, spin_offset=0.0)))
    assert spinning.force == pytest.approx([0.0, 0.0], abs=2e-3)
    x, y = spinning.grid.x[None, :], spinning.grid.y[:, None]
    assert spinning.moment == pytest.approx(
        -np.sum(spinning.traction_bound * np.hypot(x, y)) * spinning.grid.area, rel=1e-3
    )


def test_swapping_unlike_bodies(rolling):
    """Seen from the other body, (x, y) -> (x, -y): K and the spin's sense change, tractions keep
    their mirror.
    """
    bodies, swapped = (
        vc.Bodies(G=(1.0, np.inf), nu=(0.2, 0.3)),
        vc.Bodies(G=(np.inf, 1.0), nu=(0.3, 0.2)),
    )
    one = vc.solve(rolling(bodies=bodies, motion=vc.Steady(vx=0.01, vy=0.02, spin=0.03)))
    # Upside down about the x-axis: body 2 becomes body 1; slip and traction change sign, y and z,
    # too.
    other = vc.solve(rolling(bodies=swapped, motion=vc.Steady(vx=-0.01, vy=0.02, spin=0.03)))
    assert one.scene.bodies.K == pytest.approx(-other.scene.bodies.K)
    flipped = one.traction[:, ::-1] * np.array([-1.0, 1.0])[:, None, None]
    np.testing.assert_allclose(other.traction, flipped, atol=1e-9)
    np.testing.assert_allclose(other.pressure, one.pressure[::-1], atol=1e-9)


@pytest.mark.parametrize(
    "motion", [vc.Steady(Fx=0.31), vc.Steady(Fx=0.22, Fy=-0.22), vc.Shift(Fx=0.3)]
)
def test_saturated(rolling, motion):
    with pytest.raises(vc.Saturated) as failure:
        vc.solve(rolling(motion=motion))
    assert failure.value.limit == pytest.approx(0.3)
    approach = rolling().hertz.approach
    with pytest.raises(vc.Saturated):
        vc.solve(rolling(motion=motion, normal_force=None, approach=approach))


def test_spin_offset_and_reciprocity(rolling):
    """theta = 0: the discrete C23 = -C32 exactly (no slip); other offsets shift only the spin's
    share.
    """
    base = {"friction": np.inf}
    lateral = vc.solve(rolling(motion=vc.Steady(vy=1.0), **base))
    spin0 = vc.solve(rolling(motion=vc.Steady(spin=1.0, spin_offset=0.0), **base))
    assert spin0.force[1] == pytest.approx(-lateral.moment, rel=1e-12)
    spin = vc.solve(rolling(motion=vc.Steady(spin=1.0, spin_offset=0.5), **base))
    np.testing.assert_allclose(
        spin.force, spin0.force + 0.5 * 0.2 * lateral.force, rtol=1e-10, atol=1e-12
    )


def test_friction_per_element(rolling):
    """An array of one number is that number; elements without friction carry nothing and slip."""
    grid = vc.Grid(nx=12, ny=12, dx=0.2, dy=0.15, x0=-1.2, y0=-0.9)
    same = vc.solve(rolling(grid=grid, friction=np.full((12, 12), 0.3)))
    np.testing.assert_allclose(same.traction, vc.solve(rolling(grid=grid)).traction, atol=1e-14)
    half = np.full((12, 12), 0.3)
    half[:, :6] = 0.0
    sol = vc.solve(rolling(grid=grid, friction=half))
    assert not sol.traction[:, :, :6].any()
    assert np.all(sol.state[:, :6][sol.pressure[:, :6] > 0] == 2)
    decades = np.geomspace(1e-6, 1e3, 144).reshape(12, 12)
    assert vc.solve(rolling(grid=grid, friction=decades)).certificate.residual < 1e-8


def test_frictionless_rolling_slips_as_rigid_bodies_do(rolling):
    sol = vc.solve(rolling(friction=0.0))
    contact = sol.pressure > 0
    assert not sol.traction.any()
    assert sol.plan.tangential == "none"
    assert np.all(sol.state[contact] == 2)
    x, y = (c[contact] for c in np.meshgrid(sol.grid.x, sol.grid.y))
    offset = sol.grid.sides[0] / 6
    np.testing.assert_allclose(
        sol.slip[:, contact], [0.04 - 0.05 * y, -0.02 + 0.05 * (x + offset)], atol=1e-14
    )


@pytest.mark.parametrize(
    ("arguments", "field", "words"),
    [
        ({"coupling": "tight"}, "coupling", "panagiotopoulos"),
        ({"tol": 0.0}, "tol", "positive"),
        ({"polish": "no"}, "polish", "true or false"),
        ({"polish": 1}, "polish", "true or false"),
    ],
)
def test_unknown_methods(rolling, arguments, field, words):
    refused(lambda: vc.solve(rolling(), **arguments), field, match=words)


@pytest.mark.parametrize("options", [{}, {"accuracy": 0.01}, {"tangential": "fastsim"}])
def test_an_argument_of_an_earlier_version_is_refused_with_what_takes_its_place(
    rolling, monkeypatch, options
):
    monkeypatch.setattr("varcontact.solving.on_grid.solve_contact", None)
    grid = "auto" if "accuracy" in options else vc.Grid(nx=8, ny=8)
    call = partial(vc.solve, rolling(grid=grid), refine="continuum", **options)
    refused(call, "refine", "refine = 'continuum' must be left out: this version has accuracy")


def test_progress_is_a_function():
    """Of a history, too, and before any work."""
    scene = make_scene(vc.Cylinders(R=1.0), 1e-3, None, vc.Grid(nx=10))
    for motion in (vc.Transient(steps=2, dq=0.01), vc.Steady()):
        with pytest.raises(vc.SceneError) as refused:
            vc.solve(dataclasses.replace(scene, motion=motion), progress=3)
        assert (
            str(refused.value)
            == "progress = 3 is not allowed: must be true, false, or a function of one string"
        )
        for other in (object, lambda: None):
            with pytest.raises(
                vc.SceneError,
                match=r"progress = .* must be true, false, or a function of one string",
            ):
                vc.solve(dataclasses.replace(scene, motion=motion), progress=other)


@pytest.mark.parametrize("scene", [None, "scene.toml", {"normal_force": 1.0}])
def test_what_is_no_scene_is_refused(scene):
    refused(lambda: vc.solve(scene), match="must be a Scene")


def test_hertz_is_refused_where_it_is_wrong(rolling):
    grid = vc.Grid(nx=4, ny=4, dx=1.0, dy=1.0, x0=-2.0, y0=-2.0)
    samples = rolling(surface=vc.SampledDistance(np.zeros((4, 4))), grid=grid)
    for scene, reason in (
        (samples, "paraboloids"),
        (rolling(bodies=vc.Bodies(G=(1, 2), nu=0.3)), "K"),
    ):
        with pytest.raises(vc.SceneError, match=reason):
            vc.solve(scene, normal="hertz")


@pytest.mark.long
def test_not_converged_keeps_the_best_iterate(rolling):
    with pytest.raises(vc.NotConverged) as failure:
        vc.solve(rolling(), tol=1e-30)
    assert failure.value.residual < 1e-12
    assert failure.value.solution.force[0] < 0
    assert not failure.value.solution.converged


def test_what_would_overflow_is_refused(rolling):
    """By its own name, where a number is too large for any scene, and where it is too large for
    this one.
    """
    with pytest.raises(
        vc.SceneError, match=r"motion\.vx = 1e\+308 is not allowed: must be at most 1e\+100 in size"
    ):
        vc.Steady(vx=1e308)
    for friction in (1e300, 1e-300):
        with pytest.raises(
            vc.SceneError, match=r"friction = .*: must be 0, between 1e-20 and 1e\+20, or inf"
        ):
            rolling(friction=friction)
    # the displacements are small, and the shifts many times as large
    stiff = vc.Bodies(G=1e20, nu=0.3)
    with pytest.raises(
        vc.SceneError,
        match=r"motion\.vx = 1e\+90 is not allowed: must be smaller: the shift in a step",
    ):
        vc.solve(rolling(motion=vc.Steady(vx=1e90), bodies=stiff))
    with pytest.raises(
        vc.SceneError, match=r"motion\.dq = 1e\+50 .* at most 1e\+09 times the element's dx"
    ):
        vc.solve(rolling(motion=vc.Steady(vx=0.1, dq=1e50)))
    scene, field = rolling(), np.full((2, *vc.solve(rolling()).grid.shape), 1e99)
    with pytest.raises(
        vc.SceneError, match=r"traction = 1e\+99 .* at most 1e\+50 times the contact's pressures"
    ):
        vc.certify(scene, field)


def test_too_large_is_refused_before_the_work(rolling, monkeypatch):
    monkeypatch.setattr("varcontact.system.process.LITTLE", 0.0)
    monkeypatch.setattr("varcontact.system.process.available", lambda: 1e6)
    refused(lambda: vc.solve(rolling()), match="tangential", error=vc.TooLarge)


def test_progress_names_the_stages(rolling):
    stages = []
    sol = vc.solve(rolling(), progress=stages.append)
    assert stages == ["grid", "normal", "grid", "tangential", "certificate"]
    assert set(sol.timing) == {"grid", "normal", "tangential", "certificate", "total"}
    seconds = [second for stage, second in sol.timing.items() if stage != "total"]
    assert min(seconds) >= 0
    assert sum(seconds) <= sol.timing["total"], "the time within a stage counts once"


def long_elements(rolling, ratio, part, cells, **motion):
    """Rolling on elements with dx/dy = ratio, in steps of `part` elements."""
    a, b = np.sqrt(ratio), 1 / np.sqrt(ratio)
    step = vc.Steady(dq=part * 2 * a / cells, **motion)
    return rolling(surface=vc.Ellipse(a=a, b=b), motion=step, grid=vc.Grid(nx=cells, ny=cells))


@pytest.mark.parametrize(
    ("ratio", "part", "motion"),
    [
        (3, 0.3, {"vx": 0.016, "spin": 0.001}),
        (5, 0.4, {"vx": 0.04, "vy": -0.02, "spin": 0.05}),
        (10, 0.1, {"Fx": -0.25}),
    ],
)
def test_solved_without_a_guarantee(rolling, ratio, part, motion):
    """S not positive definite: a solution to rounding, no bound, and the report says why there is
    none.
    """
    sol = vc.solve(long_elements(rolling, ratio, part, 8, **motion))
    assert sol.certificate.residual < 1e-12
    assert np.all(np.isposinf(sol.certificate.force_bound))
    assert sol.summary()["certificate"]["force_bound"] == [None, None, None]
    assert (
        "no guaranteed bound: the symmetric part of the problem is not found to be positive"
        in sol.report()
    )
    assert f"motion.dq = {sol.scene.motion.dq:.3g} is short for elements" in sol.report()
    assert "so nothing is proved but the residual" in sol.report()
    assert not sol.certificate.proved
    assert "nothing is proved" in sol.certificate._repr_html_()


@pytest.mark.parametrize("normal", ["clarabel", "scs", "osqp"])
def test_no_contact_where_bodies_are_apart(rolling, normal):
    """Interior points leave small pressures everywhere; elements that are apart are exterior all
    the same.
    """
    scene = rolling(grid=vc.Grid(nx=16, ny=16, dx=0.25, dy=0.25, x0=-2.0, y0=-2.0))
    rough = vc.solve(scene, normal=normal, tangential="tang-safeguarded", polish=False, tol=1e-6)
    exact = vc.solve(scene, normal="norm")
    np.testing.assert_array_equal(rough.pressure > 0, exact.pressure > 0)
    assert np.sum(rough.pressure > 0) < 100


@pytest.mark.parametrize("normal", ["auto", "norm", "clarabel"])
@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"normal_force": 1e-300}, "normal_force"),
        ({"bodies": ((5e-324, 1.0), 0.3)}, "bodies.G[0]"),
        ({"surface": (1e308, 1e308)}, "surface.Rx"),
        ({"normal_force": None, "approach": 1e-300}, "approach"),
        (
            {
                "normal_force": None,
                "approach": 1e-99,
                "bodies": (1e-99, 0.3),
                "surface": (1e-90, 1e-90),
            },
            "scene",
        ),
    ],
)
def test_sizes_beyond_floating_point_are_refused(rolling, change, field, normal):
    """Their products are 0 or inf: by name, before a division by zero or an answer of noughts."""
    made = {"bodies": lambda pair: vc.Bodies(*pair), "surface": lambda pair: vc.Paraboloids(*pair)}

    def described():
        changes = {
            name: made.get(name, lambda value: value)(value) for name, value in change.items()
        }
        return rolling(motion=None, friction=None, **changes)

    refused(lambda: vc.solve(described(), normal=normal), field)


@pytest.mark.parametrize("load", [{"approach": 1 + 1e-15}, {"normal_force": 1e-20}])
def test_distances_whose_rounding_is_as_large_as_the_approach_are_refused(rolling, load):
    """Samples that count from far away are a staircase there; counted from the contact they are
    none.
    """
    x = np.linspace(-1.0, 1.0, 81)
    near = x**2 / 2 + x[:, None] ** 2 / 2
    changes = {"normal_force": None, "motion": None, "friction": None, "grid": vc.Grid(nx=8, ny=8)}
    refused(
        lambda: vc.solve(
            rolling(surface=vc.SampledDistance(1 + near, x, x), **{**changes, **load})
        ),
        "surface.h",
        match="counted from a level near the contact",
    )
    sphere = rolling(surface=vc.Paraboloids(1.0, 1.0), **{**changes, "approach": 1e-9})
    sol = vc.solve(rolling(surface=vc.SampledDistance(near, x, x), **{**changes, "approach": 1e-9}))
    assert sol.normal_force == pytest.approx(sphere.hertz.force, rel=0.05)


def test_splitting_where_active_sets_fail(check_kkt):
    """Nearly saturated, in steps of a small part of an element: splitting shows TANG the way."""
    motion, bodies = vc.Steady(Fx=-0.29, Fy=0.05, dq=1e-5), vc.Bodies(G=1.0, nu=0.5)
    scene = make_scene(vc.Ellipse(a=0.25, b=4.0), 1.0, motion, vc.Grid(nx=12, ny=4), bodies=bodies)
    sol = vc.solve(scene)
    assert sol.plan.tangential == "tang-safeguarded"
    assert sol.calls["tangential"]["splitting"].count == 1
    assert sol.certificate.residual < 1e-10
    check_kkt(sol, 1e-8)
    np.testing.assert_allclose(
        sol.traction, vc.solve(scene, tangential="clarabel").traction, rtol=0, atol=1e-9
    )


def test_progress_of_newton_tells_grids_steps_and_residuals(rolling):
    told = []
    sol = vc.solve(rolling(grid=vc.Grid(nx=32, ny=32)), tangential="newton", progress=told.append)
    lines = [line for line in told if line.startswith("tangential: ")]
    coarse, fine = (
        f"tangential: {size[1]} x {size[0]} elements, step " for size in ((16, 16), (32, 32))
    )
    assert lines[0].startswith(coarse + "0, residual 1.0e+00")
    assert lines[-1].startswith(fine) and float(lines[-1].split()[-1]) < 1e-8
    assert sum(line.startswith(fine) for line in lines) <= sol.iterations["tangential"] + 2


@pytest.mark.long
def test_failure_tells_of_a_mesh_that_is_not_monotone_whatever_its_size(rolling, monkeypatch):
    """Beyond the size up to which bounds are computed, too: then the reason is looked for."""
    monkeypatch.setattr("varcontact.discrete.certificate.FULL_LIMIT", 0)
    scene = rolling(
        bodies=vc.Bodies(G=1.0, nu=0.5),
        surface=vc.Ellipse(1.0, 1.0),
        motion=vc.Steady(vx=0.02, vy=0.01, spin=0.02, dq=0.2146 * 2 / 42),
        grid=vc.Grid(nx=42, ny=42),
    )
    assert vc.solve(scene).certificate.level == "gap"
    with pytest.raises(
        vc.NotConverged, match=r"positive definite, .* motion\.dq = 0\.0102 is short"
    ):
        vc.solve(scene, tangential="newton", tol=1e-16)
