"""Zones of slip and stick too thin for the elements: which rows have them, and what they do to estimates."""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from varcontact.solving.on_demand.zones import unresolved

ROLLING = vc.Scene(
    bodies=vc.Bodies(G=1.0, nu=0.28),
    surface=vc.Ellipse(a=1.0, b=1.0),
    normal_force=1.0,
    friction=0.3,
    motion=vc.Steady(vx=0.05),
)
UNLIKE = vc.Bodies(G=(1.0, 2.0), nu=(0.1, 0.4))


def coupled(part):
    """Unlike bodies with K/f that is given."""
    friction = abs(UNLIKE.K) / part
    return vc.Scene(
        bodies=UNLIKE,
        surface=vc.Paraboloids(Rx=1.0, Ry=1.0),
        normal_force=1e-4,
        friction=friction,
        motion=vc.Steady(vx=1e-4 * friction),
        grid=vc.Grid(nx=36, ny=24),
    )


def of_rows(*rows, traction=None):
    """A solution with these areas, from the trailing to the leading edge: 1 sticks at half the bound, 2 slips.

    Where it slips, tractions are on the bound; or all are what is given, by the bound.
    """
    state = np.array([[int(letter) for letter in row] for row in rows], dtype=np.int8)
    parts = np.select([state == 2, state == 1], [1.0, 0.5], 0.0) if traction is None else np.array(traction)
    solved = vc.solve(replace(ROLLING, grid=vc.Grid(nx=state.shape[1], ny=len(rows), margin=0)))
    return replace(solved, state=state, pressure=(state > 0) * 1.0, traction=np.array([0.3 * parts, 0.0 * parts]))


@pytest.mark.parametrize(
    ("row", "finer", "share"),
    [
        ("0222111111112220", 1.0, 1.0),  # slip at the leading edge, three elements
        ("0222111111122220", 1.0, 0.0),  # four of them
        ("0222111111112220", 1.2, 0.0),
        ("0222111111122220", 0.8, 1.0),
        ("0211111111111110", 1.0, 0.0),  # what happens at the trailing edge is left behind
        ("0222222222222110", 1.0, 0.0),
        ("0222111222222220", 1.0, 1.0),  # stick between slip
        ("0211112211111110", 1.0, 1.0),  # slip between stick
        ("0222222222222220", 1.0, 0.0),
        ("0111111111111110", 1.0, 0.0),
        ("0000000000000000", 1.0, 0.0),
    ],
)
def test_thin_zones(row, finer, share):
    assert unresolved(of_rows(row, row), finer) == share


def test_rows_count_by_their_elements():
    assert unresolved(of_rows("0111111111111222", "0111111100000000", "0111122000000000")) == pytest.approx(21 / 28)
    assert unresolved(of_rows("0000222222222222", "0111111100000000")) == 0.0


def test_zones_thinner_than_an_element():
    """Slip that reverses from one element to the next, and sticking elements at the leading edge that nearly slip."""
    row = "02222220"
    assert unresolved(of_rows(row, traction=[[0, 1, 1, 1, -1, -1, -1, 0]])) == 1.0
    assert unresolved(of_rows(row, traction=[[0, 1, 1, 1, 1, 1, 1, 0]])) == 0.0
    row = "02211110"
    assert unresolved(of_rows(row, traction=[[0, 1, 1, 0.5, 0.5, 0.5, 0.8, 0]])) == 1.0
    assert unresolved(of_rows(row, traction=[[0, 1, 1, 0.5, 0.9, 0.5, 0.6, 0]])) == 0.0


def test_mirrored_scenes_have_the_same():
    rolling = replace(ROLLING, motion=vc.Steady(vx=0.02, vy=0.03, spin=0.1), grid=vc.Grid(nx=36, ny=24))
    mirrored = replace(rolling, motion=vc.Steady(vx=0.02, vy=-0.03, spin=-0.1))
    found = [unresolved(vc.solve(scene)) for scene in (rolling, mirrored)]
    assert 0.0 < found[0] < 1.0 and found[0] == found[1]


def test_unlike_bodies_slip_in_a_thin_zone_where_friction_and_coupling_are_about_equal():
    """Little creepage: by K/f the zone at the leading edge is thinner than an element, thin, or wide."""
    none, thin, wide = (unresolved(vc.solve(coupled(part))) for part in (0.05, 0.7, 4.0))
    assert none == 0.0 and thin > 0.9 and wide < 0.4


def test_an_accuracy_counts_them():
    wide, thin = (vc.solve(replace(coupled(part), grid="auto"), accuracy=0.01) for part in (0.05, 0.7))
    assert thin.grid.nx > 1.5 * wide.grid.nx


@pytest.mark.parametrize("accuracy", [0.1, 0.03, 0.01])
def test_a_thin_zone_at_the_leading_edge_keeps_its_accuracy(accuracy):
    """K/f = 0.8: on 24 to 48 elements across, errors fall more slowly than elsewhere; Fx is that of up to 192."""
    scene = vc.Scene(
        bodies=vc.Bodies(G=(1.0, 4.514893126034589), nu=(0.11135882560004867, 0.05391654645106203)),
        surface=vc.Paraboloids(Rx=0.29764103625617017, Ry=1.0),
        normal_force=1e-4,
        friction=0.3,
        motion=vc.Steady(vx=-0.004944866017265924),
    )
    sol = vc.solve(scene, accuracy=accuracy)
    assert sol.force[0] / (0.3 * 1e-4) == pytest.approx(-0.1829, abs=accuracy)
    assert sol.error_estimate.largest <= accuracy
