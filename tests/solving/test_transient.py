"""Rolling in time against closed forms, steady solutions, and the equations of each step."""

import dataclasses
import itertools

import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest

import varcontact as vc

LIKE, UNLIKE = vc.Bodies(G=1.0, nu=0.28), vc.Bodies(G=(1.0, 3.0), nu=(0.1, 0.35))
LINE = vc.Cylinders(R=100.0)


def ball(**changes):
    """A ball on a plane, with a moving scene's rest."""
    base = {
        "bodies": LIKE,
        "surface": vc.Paraboloids(10.0, 10.0),
        "normal_force": 0.02,
        "friction": 0.3,
    }
    return vc.Scene(**{**base, "grid": vc.Grid(nx=10, ny=10), **changes})


def cylinder(**changes):
    base = {
        "bodies": LIKE,
        "surface": LINE,
        "normal_force": 1.0,
        "friction": 0.3,
        "grid": vc.Grid(nx=40),
    }
    return vc.Scene(**{**base, **changes})


def furthest(one, other):
    """Largest difference of tractions by the largest."""
    return np.abs(one.traction - other.traction).max() / np.abs(other.traction).max()


CREEPAGES = {"vx": 1.0e-3, "vy": -5e-4, "spin": 2e-3}
WILD = vc.Transient(
    steps=7,
    dq=[0, 0.1, 0.05, 0.2, 0, 0.1, 0.1],
    direction=[1, 1, 1, -1, -1, -1, 1],
    vx=[0, 0, 4e-3, -6e-3, 0, 0, 4e-3],
    vy=[0, 1e-3, 0, 2e-3, 0, 0, 0],
    ux=[1e-3, 0, 0, 0, 0, 0, 0],
    rotation=[0, 0, 0, 0, 4e-4, 0, 0],
    spin=[0, 5e-3, 0, 5e-3, 0, 0, 5e-3],
    Fx=[None, -3e-3, None, None, 2e-3, 1e-3, None],
    Fy=[None, None, 1e-3, None, None, -1e-3, None],
    normal_force=[0.02, 0.02, 0.03, None, None, 0.025, 0.01],
    approach=[None, None, None, 0.028, 0.02, None, None],
    friction=[0.3, 0.3, 0.2, 0.2, 0.4, 0.3, 0.3],
)


def turns(step):
    """How often the tangential traction begins to rise or to fall along x."""
    ways = np.sign(np.diff(step.traction[0, 0]))
    ways = ways[ways != 0]
    return int(np.sum(ways[1:] != ways[:-1]))


@pytest.mark.parametrize("elements", [0.5, 1.0, 1.2])
def test_steps_up_to_an_element_have_smooth_tractions(elements):
    half = vc.reference.line_contact(100.0, LIKE, force=1.0).a
    dq = elements * 2 * half / 40
    steps = round(3 * half / dq)
    motion = vc.Transient(steps=1 + steps, dq=[0.0] + steps * [dq], Fx=-0.75 * 0.3)
    history = vc.solve(cylinder(motion=motion))
    assert turns(history[-1]) == 1
    assert not any(step.warnings for step in history)


def test_longer_steps_are_warned_of_with_the_dq_to_take():
    half = vc.reference.line_contact(100.0, LIKE, force=1.0).a
    dq = 2.05 * 2 * half / 40
    motion = vc.Transient(steps=31, dq=[0.0] + 30 * [dq], Fx=-0.75 * 0.3)
    history = vc.solve(cylinder(motion=motion))
    assert history[0].warnings == () and turns(history[-1]) > 9
    (warning,) = history[-1].warnings
    assert (
        f"steps of dq = {dq:.4g} are longer than an element" in warning
        and warning in history.report()
    )
    advised = float(warning.rpartition("take dq = ")[2].split()[0])
    assert 0.99 * history.grid.sides[0] <= advised <= history.grid.sides[0]


@pytest.mark.long
@pytest.mark.parametrize("bodies", [LIKE, UNLIKE])
def test_each_step_meets_its_own_equations(check_kkt, bodies):
    """All that may change does: direction, creepage and force, load and approach, friction, the
    distance rolled.
    """
    history = vc.solve(ball(bodies=bodies, motion=WILD), normal="clarabel")
    assert len(history) == WILD.steps
    for before, sol in zip([None, *history], history, strict=False):
        check_kkt(sol, 1e-8, previous=before)
        assert sol.certificate.residual < 1e-8


STEADY = {
    "creepages and spin": ball(motion=vc.Steady(**CREEPAGES)),
    "another offset and step": ball(motion=vc.Steady(**CREEPAGES, spin_offset=0.5, dq=0.05)),
    "force": ball(motion=vc.Steady(Fx=-4e-3, vy=2e-4)),
    "unlike": ball(bodies=UNLIKE, motion=vc.Steady(**CREEPAGES)),
    "line": cylinder(motion=vc.Steady(Fx=-0.2)),
    "line, unlike": cylinder(bodies=UNLIKE, motion=vc.Steady(Fx=-0.2, Fy=0.1)),
    "line, creepage": cylinder(
        surface=vc.Cylinders(R=100.0, reference_depth=100.0), motion=vc.Steady(vx=0.01)
    ),
}


@pytest.mark.long
@pytest.mark.parametrize("name", ["creepages and spin", "unlike", "line"])
def test_a_long_history_tends_to_the_steady_state(name):
    """From nothing: after three lengths of the contact a thousandth is left, after ten next to
    nothing.
    """
    scene, dx = STEADY[name], vc.solve(STEADY[name]).grid.sides[0]
    given = {
        key: value
        for key, value in vars(scene.motion).items()
        if value is not None and key != "slip_difference"
    }
    steps, dq = 110, (4.0 if name == "line" else 1.0) * dx
    history = vc.solve(dataclasses.replace(scene, motion=vc.Transient(**given, steps=steps, dq=dq)))
    rolling = dataclasses.replace(scene.motion, dq=dq)
    steady = vc.solve(dataclasses.replace(scene, motion=rolling, grid=history[-1].grid))
    distances = [furthest(sol, steady) for sol in history]
    assert distances[-1] < 1e-6
    assert distances[33] < 0.02 * distances[0]


@pytest.mark.long
def test_from_cattaneo_to_carter():
    """A cylinder shifted by 0.75 f Fz, then rolled under it (paper, 6.2.1): the two closed forms at
    either end.
    """
    contact = vc.reference.line_contact(100.0, LIKE, force=1.0)
    errors = []
    for cells in (40, 80):
        dq = 2 * contact.a / cells
        motion = vc.Transient(steps=1 + 2 * cells, dq=[0] + [dq] * (2 * cells), Fx=-0.225)
        history = vc.solve(cylinder(motion=motion, grid=vc.Grid(nx=cells)))
        x = history.grid.x
        cattaneo = vc.reference.cattaneo_line(contact, 0.3, -0.225).traction(x)
        carter = vc.reference.carter(contact, 0.3, force=-0.225)
        ends = (
            (history[0].traction[0, 0], cattaneo),
            (history[-1].traction[0, 0], carter.traction(x)),
        )
        creepage = abs(history.creepage[-1, 0] / carter.creepage - 1) * 0.3 * contact.peak_pressure
        errors.append([*(np.abs(found - exact).mean() for found, exact in ends), creepage])
    rates = np.log2(np.array(errors[0]) / errors[1])
    assert np.all(rates > 0.7)
    assert np.all(np.array(errors[1]) < 0.03 * 0.3 * contact.peak_pressure)


def test_a_shift_is_one_step_in_place():
    force = -0.5 * 0.3 * 0.02
    scene = ball(bodies=vc.Bodies(G=1.0, nu=0.0), grid=vc.Grid(nx=24, ny=24))
    (step,) = vc.solve(dataclasses.replace(scene, motion=vc.Transient(steps=1, dq=0, Fx=force)))
    shift = vc.solve(dataclasses.replace(scene, motion=vc.Shift(Fx=force)))
    assert furthest(step, shift) < 1e-9
    assert step.creepage == pytest.approx(shift.creepage, rel=1e-9)
    exact = vc.reference.cattaneo_mindlin(scene.hertz, scene.bodies, 0.3, force)
    assert step.creepage[0] == pytest.approx(exact.shift, rel=0.02)


def test_unloading_follows_mindlin():
    """With the pressure constant the way back is the way there, twice as large: slip the other way
    creeps inwards.
    """
    force, back, scene = (
        -4e-3,
        1e-3,
        ball(bodies=vc.Bodies(G=1.0, nu=0.0), grid=vc.Grid(nx=20, ny=20)),
    )
    history = vc.solve(
        dataclasses.replace(scene, motion=vc.Transient(steps=2, dq=0, Fx=[force, back]))
    )
    shifts = history.creepage[:, 0].cumsum()
    half = vc.solve(dataclasses.replace(scene, motion=vc.Shift(Fx=(force - back) / 2)))
    assert shifts[1] == pytest.approx(shifts[0] - 2 * half.creepage[0], rel=1e-7)
    traction = history[0].traction - 2 * half.traction
    assert history[1].traction == pytest.approx(traction, abs=1e-7 * np.abs(traction).max())

    def exact(F):
        return vc.reference.cattaneo_mindlin(scene.hertz, scene.bodies, 0.3, F).shift

    assert shifts[0] == pytest.approx(exact(force), rel=0.03)
    assert shifts[1] == pytest.approx(exact(force) - 2 * exact((force - back) / 2), rel=0.05)


@pytest.mark.long
def test_the_order_in_time_is_one():
    """The same way in ever shorter steps, parts of an element, on one grid: what a halving changes
    is about halved.
    """
    grid = vc.solve(ball(motion=None)).grid
    length = 3 * grid.sides[0]
    counts = np.array([6, 12, 24, 48])
    motions = [vc.Transient(steps=n, dq=length / n, vx=3e-3, vy=1e-3) for n in counts]
    tractions = [vc.solve(ball(grid=grid, motion=motion))[-1].traction for motion in motions]
    changes = [np.abs(one - two).sum() for one, two in itertools.pairwise(tractions)]
    order = -np.polyfit(np.log(counts[:-1]), np.log(changes), 1)[0]
    assert 0.8 < order < 1.2


def mirrored(sol):
    """Tractions seen from the other side: x turned round."""
    return np.array([-sol.traction[0, :, ::-1], sol.traction[1, :, ::-1]])


@pytest.mark.long
def test_compression_tends_to_spence_with_order_one():
    """Unlike cylinders pressed together, as many steps as elements: half-widths of stick by those
    of the contact.
    """
    bodies, counts = vc.Bodies(G=(1.0, np.inf), nu=(0.2, 0.3)), np.array([25, 50, 100])
    errors, half_an_element = np.zeros((2, counts.size)), np.zeros(counts.size)
    for (i, friction), (j, n) in itertools.product(enumerate((0.25, 0.3)), enumerate(counts)):
        a = vc.reference.line_contact(LINE.R, bodies, force=1.0).a
        widths = a * np.arange(1, n + 1) / n
        motion = vc.Transient(steps=int(n), dq=0.0, normal_force=(widths / a) ** 2, Fx=0.0)
        grid = vc.Grid(nx=int(n), dx=2.1 * a / n, x0=-1.05 * a)
        history = vc.solve(
            cylinder(bodies=bodies, friction=friction, motion=motion, grid=grid), coupling="johnson"
        )
        ratios = [
            sol.areas["stick"] / 2 / width for sol, width in zip(history, widths, strict=True)
        ]
        errors[i, j] = np.mean(ratios[n // 2 :]) - vc.reference.spence_ratio(
            bodies, friction, "line"
        )
        half_an_element[j] = np.mean(grid.dx / 2 / widths[n // 2 :])
    assert np.all(np.abs(errors) < half_an_element)
    sizes = np.sqrt(np.mean(errors**2, axis=0))
    assert -np.polyfit(np.log(counts), np.log(sizes), 1)[0] == pytest.approx(1.0, abs=0.15)
    assert sizes[-1] < 0.005


@pytest.mark.parametrize("bodies", [LIKE, UNLIKE])
def test_rolling_backwards_is_the_mirror_image(bodies):
    motion = vc.Transient(
        steps=4, dq=[0, 0.05, 0.1, 0.1], vx=3e-3, vy=1e-3, spin=4e-3, ux=[1e-4, 0, 0, 0]
    )
    other = dataclasses.replace(motion, direction=-1, vx=-3e-3, spin=-4e-3, ux=[-1e-4, 0, 0, 0])
    forward, backward = (vc.solve(ball(bodies=bodies, motion=each)) for each in (motion, other))
    for one, two in zip(forward, backward, strict=True):
        assert mirrored(one) == pytest.approx(two.traction, abs=1e-9 * np.abs(two.traction).max())
    assert forward.position[-1] == -backward.position[-1] == pytest.approx(0.25)
    assert backward.rolled[-1] == pytest.approx(0.25)


NUMBERS = st.floats(-1, 1, allow_nan=False)
STEPS = st.lists(
    st.tuples(NUMBERS, NUMBERS, NUMBERS, st.floats(0, 1), st.sampled_from([-1, 1])),
    min_size=1,
    max_size=4,
)


@pytest.mark.long
@hypothesis.given(STEPS, st.sampled_from([LIKE, UNLIKE]))
@hypothesis.settings(max_examples=15)
def test_friction_never_gives_work(given, bodies):
    vx, vy, spin, load, direction = zip(*given, strict=True)
    motion = vc.Transient(
        steps=len(given),
        dq=[0.1 * round(abs(v), 1) for v in vy],
        direction=direction,
        vx=[6e-3 * v for v in vx],
        vy=[4e-3 * v for v in vy],
        ux=[4e-4 * v for v in vx],
        spin=[0.02 * v for v in spin],
        normal_force=[0.0 if F < 0.1 else 0.02 * F for F in load],
    )
    hypothesis.assume(any(motion.normal_force))
    history = vc.solve(
        ball(bodies=bodies, grid=vc.Grid(nx=6, ny=6), motion=motion), normal="clarabel"
    )
    for sol in history:
        assert np.all(
            np.sum(sol.traction * sol.slip, axis=0) * sol.grid.area <= 1e-12 * 0.3 * 0.02 * 1e-3
        )


def test_a_contact_that_vanishes_and_returns():
    loads = [0.02, 0.02, 0.0, 0.01, 0.01]
    motion = vc.Transient(steps=5, vx=3e-3, vy=1e-3, normal_force=loads)
    history = vc.solve(ball(motion=motion), tangential="tang")
    after = vc.Transient(steps=2, vx=3e-3, vy=1e-3, normal_force=0.01)
    again = vc.solve(ball(grid=history.grid, motion=after), tangential="tang")
    assert not history[2].pressure.any()
    assert not history[2].traction.any()
    assert history[2].elements == {"contact": 0, "stick": 0, "slip": 0}
    assert history[2].distance.min() == 0.0
    for one, two in zip(history[3:], again, strict=True):
        np.testing.assert_array_equal(one.traction, two.traction)
    lifted = vc.solve(
        ball(motion=vc.Transient(steps=3, vx=3e-3, approach=[0.02, -0.01, 0.01], normal_force=None))
    )
    assert lifted.normal_force[1] == 0
    assert lifted[1].distance.min() == pytest.approx(0.01, rel=0.05)
    assert lifted.approach == pytest.approx([0.02, -0.01, 0.01])


def test_a_contact_that_moves_over_the_grid():
    """A hill that goes an element further in each step, frictionless and in place: the pressure
    goes with it.
    """
    grid = vc.Grid(nx=30, ny=12, dx=0.1, dy=0.1, x0=-1.5, y0=-0.6)

    def hill(steps):
        return vc.SampledDistance((grid.x - 0.1 * steps) ** 2 / 20 + grid.y[:, None] ** 2 / 20)

    hills = [hill(k) for k in range(4)]
    scene = ball(
        surface=hills[0], grid=grid, friction=0.0, motion=vc.Transient(steps=4, dq=0, surface=hills)
    )
    history = vc.solve(scene)
    for k, sol in enumerate(history):
        assert sol.pressure == pytest.approx(
            np.roll(history[0].pressure, k, axis=1), abs=1e-9 * sol.pressure.max()
        )


def test_the_slopes_of_a_step_are_those_of_differences():
    def last_force(vx, spin):
        return vc.solve(
            ball(motion=vc.Transient(steps=3, vx=[3e-3, 3e-3, vx], vy=1e-3, spin=[0, 0, spin]))
        )[-1]

    sol, h = last_force(3e-3, 0.01), 1e-8
    by_vx = (last_force(3e-3 + h, 0.01).force - last_force(3e-3 - h, 0.01).force) / (2 * h)
    by_spin = (last_force(3e-3, 0.01 + h).force - last_force(3e-3, 0.01 - h).force) / (2 * h)
    slopes = sol.sensitivity()
    assert slopes[:, 0] == pytest.approx(by_vx, rel=1e-4, abs=1e-5)
    assert slopes[:, 2] == pytest.approx(by_spin, rel=1e-4, abs=1e-5)


@pytest.mark.parametrize("stored", [False, True])
@pytest.mark.parametrize(
    ("friction", "steps"),
    [
        (0.0, None),
        (np.zeros((8, 8)), None),
        (None, 0.0),
        (None, [0.3, 0.0, 0.3]),
        (0.3, [None, 0.0, None]),
    ],
    ids=["number", "array", "history", "one step", "one step of the scene's"],
)
def test_a_force_without_friction_is_refused_before_any_work(friction, steps, stored, tmp_path):
    """As of steady rolling: not a force of nothing with creepages that are no numbers."""
    store = tmp_path / "history.nc" if stored else None
    grid = vc.Grid(nx=8, ny=8, dx=0.1, dy=0.1, x0=-0.4, y0=-0.4)
    told = []
    for force in ({"Fx": [0.0, 1e-4, 0.0]}, {"Fy": [None, -1e-4, None]}):
        motion = vc.Transient(steps=3, friction=steps, **force)
        slippery = ball(friction=friction, grid=grid, motion=motion)
        with pytest.raises(
            vc.Saturated, match=r"step 1 of the history: .* 0.0001 cannot be carried"
        ) as failure:
            vc.solve(slippery, store=store, progress=told.append)
        assert (failure.value.step, failure.value.limit, failure.value.history) == (1, 0.0, None)
    assert told == []
    assert not stored or not store.exists()


def test_a_step_of_a_line_whose_areas_stay_takes_one_newton_step():
    """Equations are linear on given areas: what is left after one step is rounding."""
    elements = 128
    side = 2.0 / elements
    surface = vc.Cylinders(R=LIKE.combined_G / (2 * (1 - LIKE.combined_nu)))  # half-width 1
    force = np.pi / 2
    motion = vc.Transient(steps=24, dq=[0.0] + [side] * 23, Fx=-0.75 * force)
    grid = vc.Grid(nx=154, dx=side, x0=-1.2)
    scene = cylinder(surface=surface, normal_force=force, friction=1.0, motion=motion, grid=grid)
    settled = vc.solve(scene)[12:]
    assert sum(step.iterations["tangential"] for step in settled) <= 1.25 * len(settled)
    assert max(step.certificate.residual for step in settled) < 1e-12


def test_the_scene_of_a_step_is_one_that_its_own_checks_accept():
    """Steps take over the checked scene of the history, number by number."""
    grid = vc.Grid(nx=40, dx=0.1, x0=-2.0)
    motion = vc.Transient(steps=3, dq=0.1, Fx=[0.0, 0.1, 0.0], normal_force=[1.0, 2.0, 0.0])
    history = cylinder(motion=motion, friction=np.full(40, 0.3), grid=grid)
    for k in range(3):
        step = history.step(k, grid)
        checked = dataclasses.replace(step)
        assert repr(step) == repr(checked)
        assert np.array_equal(step.friction, checked.friction)
