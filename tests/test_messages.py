"""Refusals that no other test meets: the field, and what is wrong or to do instead."""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene, refused
from varcontact import checks, reference
from varcontact.reference import bufler, cattaneo_mindlin, hertz, line_contact, spence_ratio

BODIES = vc.Bodies(G=1.0, nu=0.3)
BALL = vc.Paraboloids(1.0, 1.0)
SCENE = make_scene(BALL, 1.0, vc.Steady(vx=0.01), vc.Grid(nx=6, ny=6), bodies=BODIES)
UNLIKE = vc.Bodies(G=(1.0, 3.0), nu=(0.3, 0.2))
SQUARE = vc.Grid(nx=3, ny=3, dx=1.0, dy=1.0, x0=-1.5, y0=-1.5)
BOWL = vc.SampledDistance(np.array([[0.5, 0.2, 0.5], [0.2, 0.0, 0.2], [0.5, 0.2, 0.5]]))
AXIS = np.array([-1.0, 0.0, 1.0])
COUPLED = reference.line_contact(1.0, UNLIKE, a=0.1)


def scene(**changes):
    return replace(SCENE, **changes)


def certified(traction, **changes):
    return vc.certify(scene(**changes), np.zeros(traction))


MESSAGES = [
    (lambda: vc.Grid(nx=3, ny=3).x, "grid", "only such a grid has positions"),
    (lambda: scene(motion=vc.Transient(steps=1, surface=[vc.Cylinders(1.0)])), "motion.surface", "or none"),
    (lambda: vc.SampledDistance(np.eye(3), AXIS / 2, AXIS / 2).distance(SQUARE), "grid", "within the samples"),
    (lambda: scene(surface=BOWL, grid=SQUARE, normal_force=None, approach=-0.5), "approach", "must exceed"),
    (lambda: vc.plan(scene(surface=BOWL, grid=SQUARE), normal="hertz"), "", "for paraboloids, ellipses and cylinders"),
    (lambda: vc.plan(scene(surface=BOWL, grid=replace(SQUARE, edge="touched"))), "", "samples without coordinates"),
    (lambda: vc.solve(scene(), store="history.nc"), "store", "only a history"),
    (lambda: certified((2, 3, 4), motion=vc.Steady(Fx=0.1)), "motion", "no prescribed force"),
    (lambda: certified((2, 8, 8), surface=BOWL, grid=vc.Grid(nx=8, ny=8)), "grid", "as surface.h is given on it"),
    (lambda: certified((2, 6, 6), surface=replace(BOWL, x=AXIS, y=AXIS)), "grid", "explicit, with dx, dy, x0 and y0"),
    (lambda: certified((2, 4, 3), grid=SQUARE), "traction", "must be of shape (2, 3, 3)"),
    (lambda: vc.converge(scene(motion=vc.Transient(steps=1, dq=0.1)), [8, 16]), "motion", "studied on one problem"),
    (lambda: vc.stress(vc.solve(scene()), [0.0, 1.0]), "points", "(3, ...)"),
    (lambda: vc.stress_below(vc.solve(scene()), []), "depths", "a number or several"),
    (lambda: vc.solve(scene()).plot_passes(), "solution", "no passes to plot"),
    (lambda: reference.carter(reference.line_contact(1.0, BODIES, a=0.1), 0.3), "", "neither creepage nor force"),
    (lambda: reference.carter(COUPLED, 0.3, creepage=0.01), "bodies.K", "like bodies"),
    (lambda: reference.bufler(1.0, BODIES, force=1.0, a=1.0), "", "force and a are both given"),
    (lambda: reference.line_contact(1.0, BODIES), "", "neither force nor a nor approach is given"),
    (lambda: reference.line_contact(1.0, BODIES, approach=0.1), "depth", "measured from a depth"),
]  # fmt: skip


@pytest.mark.parametrize(("act", "field", "words"), MESSAGES)
def test_message(act, field, words):
    refused(act, field or None, words)


def test_refusals_keep_their_parts():
    with pytest.raises(vc.SceneError) as refused:
        vc.plan(scene(), formulation="potential")
    assert (refused.value.field, refused.value.value) == ("formulation", "potential")
    assert refused.value.allowed == '"gap" or "marching"'


ONES = np.ones((2, 3))


@pytest.mark.parametrize(
    "value",
    [
        ONES.astype(bool),
        ONES.astype(complex),
        ONES.astype(object),
        ONES.astype("M8[s]"),
        [["1", "2"], ["3", "4"]],
        [[1.0, 2.0], [3.0]],
        [[10**400, 1], [1, 1]],
        np.ma.masked_array(ONES, mask=[[0, 1, 0], [0, 0, 0]]),
    ],
    ids=["bool", "complex", "object", "date", "text", "ragged", "overflow", "masked"],
)
def test_arrays_of_anything_else_are_refused(value):
    refused(
        lambda: checks.array("surface.h", value, 2),
        "surface.h",
        "2-dimensional array of finite numbers",
    )


def test_masked_array_without_masked_values_is_an_array():
    np.testing.assert_array_equal(
        checks.array("surface.h", np.ma.masked_array(2 * ONES), 2), 2 * ONES
    )


@pytest.mark.parametrize("value", ["no", "false", 0, 1, None, 1.0])
def test_flags_are_true_or_false_and_nothing_like_it(value):
    refused(lambda: checks.flag("polish", value), match="true or false")
    assert checks.flag("polish", np.bool_(False)) is False


def test_error_of_a_value_nested_too_deep_for_repr():
    value: list = []
    for _ in range(100_000):
        value = [value]
    assert "nested deep" in str(vc.SceneError("a", value, "less"))


FIELD = np.zeros((2, 14, 14))
HERTZIAN = vc.Scene(bodies=BODIES, surface=BALL, normal_force=1e-3)
HISTORY = make_scene(BALL, 1e-3, vc.Transient(steps=2, vx=0.01), bodies=BODIES)
DIGITS = 10**5000


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: vc.certify(5, FIELD), "scene = 5 is not allowed: must be a Scene"),
        (lambda: vc.load(3), "path = 3 is not allowed: must be the name of a file"),
        (lambda: vc.load(b"a.nc"), "path = b'a.nc' is not allowed"),
        (lambda: vc.read_scene(None), "path is|path = None"),
        (
            lambda: vc.solve(HISTORY, store=3),
            "store = 3 is not allowed: must be the name of a file",
        ),
        (
            lambda: vc.converge(HERTZIAN, [4, 6], method=3),
            "method = 3 is not allowed: must be a name, or a list of",
        ),
        (lambda: vc.plot_comparison(3), "table = 3 is not allowed"),
        (lambda: hertz(1, 1, 5, force=1.0), "bodies = 5 is not allowed: must be half-spaces"),
        (lambda: line_contact(1, 5, force=1.0), "bodies = 5"),
        (lambda: bufler(1, 5, force=1.0), "bodies = 5"),
        (lambda: spence_ratio(5, 0.3), "bodies = 5"),
        (lambda: cattaneo_mindlin(hertz(1, 1, BODIES, force=1e-3), 5, 0.3, 1e-5), "bodies = 5"),
        (
            lambda: hertz(1e100, 1e-100, BODIES, force=1.0),
            r"Rx, Ry = \(1e\+100, 1e-100\) .* at most 1e\+150 times",
        ),
        (
            lambda: vc.Steady(vx=np.complex128(0.1 + 2j)),
            r"motion\.vx = \(0\.1\+2j\) is not allowed",
        ),
        (lambda: vc.Grid(nx=np.array(True)), r"grid\.nx = True is not allowed"),
        (lambda: vc.Steady(vx=bytearray(b"1.5")), r"motion\.vx = bytearray"),
        (
            lambda: vc.Steady(vx=DIGITS),
            r"motion\.vx = a number of thousands of digits is not allowed",
        ),
        (lambda: vc.Bodies(G=DIGITS, nu=0.3), r"bodies\.G = a number of thousands of digits"),
        (lambda: vc.SampledDistance([[DIGITS, 1], [2, 3]]), r"surface\.h = a list is not allowed"),
        (
            lambda: vc.SampledDistance([[1.0, 2.0], [3.0, -1e308]]),
            r"surface\.h\[1, 1\] = -1e\+308 .* at most 1e\+100",
        ),
        (
            lambda: vc.Grid(nx=2, ny=2, dx=np.float64(0.0), dy=1, x0=0, y0=0),
            r"grid\.dx = 0\.0 is not allowed",
        ),
        (
            lambda: vc.Units(length="m\0", force="N"),
            r"units\.length = 'm\\x00' is not allowed: must be printable",
        ),
        (
            lambda: vc.Units(length="m", force="N" * 41),
            r"units\.force = .* in 40 characters at most",
        ),
        (lambda: vc.Units(length="\ud800", force="N"), r"units\.length = .* must be printable"),
    ],
)
def test_refused_by_name(call, words):
    refused(call, match=words)
