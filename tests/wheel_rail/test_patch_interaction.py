"""Parts of a patch: with weight 1 they are one half-space, with weight 0 two, and between the
forces are steady.
"""

import warnings
from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.wheel_rail.conditions import wheel
from varcontact.elasticity.operators import influence_operator
from varcontact.wheel_rail import patch_interaction
from varcontact.wheel_rail.patch_interaction import with_interaction

GRID = vc.Grid(nx=16, ny=40, dx=0.5, dy=0.5, x0=-4.0, y0=-10.0)
BUMPS = np.minimum(
    (GRID.y[:, None] + 4.0) ** 2 / 100 + GRID.x**2 / 400,
    (GRID.y[:, None] - 4.5) ** 2 / 60 + GRID.x**2 / 400 + 0.01,
)


def scene(distance=BUMPS):
    return vc.Scene(
        bodies=vc.Bodies(G=82e3, nu=0.28),
        surface=vc.SampledDistance(distance),
        approach=0.04,
        grid=GRID,
    )


def pressure(scene):
    return vc.solve(scene, certify=None).pressure


def solved(weight):
    return pressure(with_interaction(scene(), ((0.0, weight),)))


def test_full_weight_is_one_half_space():
    assert solved(1.0) == pytest.approx(pressure(scene()), abs=1e-6 * pressure(scene()).max())


def test_no_weight_is_two_half_spaces():
    alone = [
        pressure(scene(np.where(part[:, None], BUMPS, 1.0))) for part in (GRID.y < 0, GRID.y > 0)
    ]
    found = solved(0.0)
    assert found == pytest.approx(sum(alone), abs=1e-4 * found.max())
    assert found.sum() > 1.1 * pressure(scene()).sum()


@pytest.mark.parametrize("few", [patch_interaction.NORM_ELEMENTS_MAX, 0])
def test_the_weight_multiplies_the_influence_between_the_parts(few, monkeypatch):
    """The conditions of contact with the weighted matrix itself, whichever method the rounds
    take.
    """
    monkeypatch.setattr(patch_interaction, "NORM_ELEMENTS_MAX", few)
    found = solved(0.3).ravel()
    part = np.repeat(GRID.y > 0, GRID.nx)
    felt = np.where(part[:, None] == part, 1.0, 0.3)
    matrix = influence_operator(GRID, "z", "z", nu=0.28).dense(np.arange(GRID.size)) / 82e3
    distance = BUMPS.ravel() + (felt * matrix) @ found - 0.04
    assert found.min() >= 0
    assert distance[found > 0] == pytest.approx(0.0, abs=1e-6 * 0.04)
    assert distance[found == 0].min() > -1e-6 * 0.04


def test_three_parts_feel_each_other_through_the_seams_between():
    bumps = np.min(
        [(GRID.y[:, None] - at) ** 2 / 40 + GRID.x**2 / 400 for at in (-7.0, 0.0, 7.0)], axis=0
    )
    found = pressure(with_interaction(scene(bumps), ((-3.5, 0.0), (3.5, 1.0))))
    first = pressure(scene(np.where(GRID.y[:, None] < -3.5, bumps, 1.0)))
    others = pressure(scene(np.where(GRID.y[:, None] > -3.5, bumps, 1.0)))
    assert found == pytest.approx(first + others, abs=1e-4 * found.max())


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:with dy")
def test_forces_do_not_jump_when_parts_become_patches():
    """Tread and flange root touch 5 mm apart: as the distance of separation passes that, nothing
    jumps.
    """
    case = wheel(
        5.0, -3e-4, 0.012, vertical_force=None, z=0.0, join=1.0, separate=20.0, dx=0.4, dy=0.1
    )
    z = case.touching + 0.03
    (patch,) = case.patches(z)
    ((_, weight),) = patch.interactions
    apart = 20.0 - weight ** (1 / 0.8) * 19.0
    found = [
        replace(case, z=z, separate=separate).solve()
        for separate in (apart * 0.999, apart * 1.001, 40.0, 4000.0)
    ]
    forces = [sum(each.normal_force for each in one.patches) for one in found]
    assert [len(one.patches) for one in found] == [2, 1, 1, 1]
    assert forces[1] == pytest.approx(forces[0], rel=0.003)
    assert found[1].force[1:] == pytest.approx(found[0].force[1:], abs=0.003 * forces[0])
    assert found[1].force[0] == pytest.approx(found[0].force[0], rel=0.08), (
        "two creepages become one"
    )
    assert forces[0] > forces[2] > forces[3]


def test_angles_turn_towards_each_other_as_patches_come_nearer():
    """A flange at 70 degrees and the tread at 22 become one patch: a load between is found, and
    nothing jumps.
    """
    case = wheel(6.25, yaw=0.03, vertical_force=22e3, dx=0.5, dy=0.25)
    angles = np.array(
        [
            [each.angle for each in case.patches(case.touching + z)]
            for z in (0.045, 0.05, 0.053, 0.058)
        ]
    )
    assert (np.diff(angles[:, 0]) > 0).all() and (np.diff(angles[:, 1] - angles[:, 0]) < 0).all()
    (one,) = case.patches(case.touching + 0.06)
    assert angles[-1] == pytest.approx(one.angle, abs=0.02)
    alone = [each.angle for each in replace(case, turn=8.0).patches(case.touching + 0.058)]
    assert alone == pytest.approx([-1.22, -0.386], abs=0.01)
    assert replace(case, turn=8.0).patches(case.touching + 0.06)[0].angle == one.angle
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        assert case.solve().rounds < 15
