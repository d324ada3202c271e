"""Ways: the grids they make, what they serve, and extrapolation, against closed forms."""

from dataclasses import replace

import pytest

import varcontact as vc
from tests.scenes import make_scene, refused
from varcontact.solving.discretisation_variants import Way, answer, extrapolated

SCENE = make_scene(vc.Ellipse(a=1.0, b=1.0), 1.0, vc.Steady(vx=0.05, spin=0.05))
UNLIKE = replace(SCENE, bodies=vc.Bodies(G=(1.0, 4.0), nu=(0.2, 0.3)))


def test_a_plain_way_is_solve_on_its_grid():
    sol = vc.solve(replace(SCENE, grid=vc.Grid(nx=10, ny=10)))
    found = answer(SCENE, Way(cells=10))
    assert found.values == {"Fx": sol.force[0], "Fy": sol.force[1], "Mz": sol.moment}
    assert found.solutions[0].grid == sol.grid


def test_entries_of_the_motion_and_options_of_solve():
    way = Way(cells=8, motion=(("spin_offset", 0.0),), options=(("tangential", "fastsim"),))
    sol = answer(SCENE, way, certify=None).solutions[0]
    assert sol.motion.spin_offset == 0.0
    assert sol.plan.tangential == "fastsim"
    assert sol.certificate.level == "none"


def test_extrapolation_takes_a_power_of_the_size_off():
    """Values 2 + 3/n and 2 + 3/n^2 are extrapolated to 2."""
    for order in (1.0, 2.0):
        way = Way(cells=12, coarser=8, order=order)
        found = extrapolated(way, [{"Fx": 2 + 3 / n**order} for n in (8, 12)])
        assert found["Fx"] == pytest.approx(2.0, abs=1e-12)


def test_a_history_by_the_steps_that_count():
    scene = replace(SCENE, motion=vc.Transient(steps=3, dq=0.25, vx=0.05))
    found = answer(scene, Way(cells=8, coarser=4, edge="touched"), steps=(2,))
    assert list(found.values) == ["Fx[2]", "Fy[2]", "Mz[2]"]
    for steps, message in (
        ((3,), r"steps\[0\] = 3 .* from 0 to 2"),
        (("x",), r"steps\[0\] = 'x'"),
        (2, "steps = 2"),
    ):
        with pytest.raises(vc.SceneError, match=message):
            answer(scene, Way(cells=8), steps=steps)


@pytest.mark.parametrize(("scene", "way", "reason"), [
    (UNLIKE, Way(cells=8, edge="touched"), "the edge 'touched' is for a pressure that tractions do"),
    (replace(SCENE, motion=None), Way(cells=8, edge="touched"), "nothing rubs"),
    (replace(SCENE, motion=vc.Shift(ux=0.1)), Way(cells=8, motion=(("spin_offset", 0.5),)), "is for steady rolling"),
])  # fmt: skip
def test_ways_that_do_not_serve_say_so(scene, way, reason):
    assert reason in way.why_not(scene)
    refused(lambda: answer(scene, way), match=f"way {way}: .*{reason}")


def test_an_accuracy_is_that_of_solve():
    way = Way(accuracy=0.03)
    found, sol = answer(SCENE, way), vc.solve(SCENE, accuracy=0.03)
    assert found.values["Fx"] == sol.force[0] and found.solutions[-1].grid == sol.grid
    assert found.solutions[-1].error_estimate is not None
    refused(lambda: answer(replace(SCENE, grid=vc.Grid(nx=4, ny=4)), way), match="accuracy")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "cells = 0 is not allowed: must be a whole number, 1 or more"),
        ({"cells": "8"}, "cells = '8'"),
        (
            {"cells": 8, "accuracy": 0.01},
            "accuracy = 0.01 is not allowed: must be the only choice of a grid",
        ),
        ({"edge": "touched", "accuracy": 0.01}, "leave out what else describes one"),
        ({"order": 2.0, "accuracy": 0.01}, "leave out what else describes one"),
        ({"accuracy": "x"}, "accuracy = 'x'"),
        ({"cells": 8, "along": 0.0}, "along = 0.0"),
        ({"cells": 8, "coarser": 4, "order": 0}, "order = 0"),
        ({"cells": 8, "options": (("accuracy", 0.1),)}, "give it as the accuracy of the way"),
        (
            {"cells": 8, "options": {"tangential": "fastsim"}},
            "options = .* must be pairs of a name and a value",
        ),
        (
            {"cells": 8, "options": ("tangential", "fastsim")},
            "options = .* must be pairs of a name and a value",
        ),
        (
            {"cells": 8, "motion": (("spin_offset", 0.0, 1.0),)},
            "motion = .* must be pairs of a name and a value",
        ),
        (
            {"cells": 8, "motion": ((0.0, "spin_offset"),)},
            "motion = .* must be pairs of a name and a value",
        ),
    ],
)
def test_a_way_has_cells_or_an_accuracy(given, message):
    refused(lambda: Way(**given), match=message)


def test_names():
    assert str(Way(cells=24)) == "centres 24"
    assert str(Way(cells=16, coarser=8, edge="touched")) == "touched 8 + 16"
    assert str(Way(cells=10, options=(("tangential", "fastsim"),))) == "fastsim 10"
    assert str(Way(accuracy=0.01)) == "accuracy 0.01"
    assert str(Way(cells=16, coarser=8, order=2.0)) == "centres 8 + 16 by order 2"
    assert str(Way(cells=8, motion=(("dq", 0.5),))) != str(
        Way(cells=8, motion=(("spin_offset", 0.5),))
    )
    assert Way(cells=16, coarser=8, edge="touched", along=1.5).family == (
        "touched, extrapolated, 1.5 times as many along x"
    )
