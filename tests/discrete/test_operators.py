"""One owner of influence numbers: each table is built once, whatever is derived from the
discretisation.
"""

import dataclasses
import weakref
from functools import partial

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import LIKE, make_scene
from varcontact.discrete import penetration
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.operators import Operators
from varcontact.discrete.state import ContactState
from varcontact.elasticity.halfspace import HalfSpaces
from varcontact.transports import HERE, SteadyRolling

UNLIKE = vc.Bodies(G=(1.0, 3.0), nu=(0.25, 0.3))
EXPLICIT = vc.Grid(nx=12, ny=12, dx=0.25, dy=0.25, x0=-1.5, y0=-1.5)
TIGHT = vc.Grid(nx=10, ny=8, dx=0.25, dy=0.25, x0=-1.25, y0=-1.0)


def names(built):
    return sorted(name for name, _ in built)


SPHERES = {"surface": vc.Paraboloids(2.0, 2.0), "grid": EXPLICIT}
MARCH = vc.Transient(steps=6, dq=[0.0, 0.1, 0.1, 0.2, 0.1, 0.2], vx=0.02)
COUPLED = ["A_tt - C_tt", "A_tz - C_tz", "A_zt", "A_zz"]
SCAN = partial(vc.scan, creepages=np.array([[0.01, 0.0, 0.0], [0.02, 0.0, 0.0], [0.02, 0.01, 0.1]]))
ONCE = {
    "law": (
        {"friction": vc.LinearFalling(0.4, 0.3, half_velocity=0.05)},
        vc.solve,
        ["A_tt - C_tt", "A_zz"],
    ),
    "loop": (SPHERES | {"bodies": UNLIKE}, partial(vc.solve, coupling="panagiotopoulos"), COUPLED),
    "joint": (SPHERES | {"bodies": UNLIKE}, partial(vc.solve, coupling="joint"), COUPLED),
    "history": (SPHERES | {"motion": MARCH}, vc.solve, ["A_tt", "A_zz", "C_tt", "C_tt"]),
    "scan": (SPHERES | {"bodies": UNLIKE}, SCAN, COUPLED),
    "beyond": (
        SPHERES | {"bodies": UNLIKE, "grid": TIGHT},
        SCAN,
        sorted([*COUPLED, "A_zt", "A_zz"]),
    ),
}
"""Scenes, what solves them, and the tables: of a history C for each distance that is rolled with
tractions, of a contact at the edge those of a look beyond it, on one more element."""


@pytest.mark.parametrize("name", ONCE)
def test_each_table_is_built_once(rolling, built, name):
    changes, work, tables = ONCE[name]
    sol = work(rolling(**changes))
    assert not isinstance(sol, vc.Solution) or len(sol.passes) > 3
    assert names(built) == tables


def test_what_is_derived_shares_what_any_builds(rolling):
    """Also what a child builds, its parent and its siblings have."""
    scene = rolling(grid=EXPLICIT)
    disc = discretise(scene, EXPLICIT)
    child = disc.with_loading(friction=np.full(EXPLICIT.shape, 0.2))
    sibling = disc.with_loading(motion=vc.Steady(vx=0.1))
    assert child.tangential_operator is sibling.tangential_operator is disc.tangential_operator
    assert discretise(scene, EXPLICIT, disc.operators).operators is disc.operators


@pytest.mark.parametrize(
    "changes",
    [{"grid": vc.Grid(nx=10, ny=8, dx=0.3, dy=0.25, x0=-1.5, y0=-1.0)}, {"bodies": UNLIKE}],
)
def test_another_lattice_or_other_bodies_have_their_own(rolling, changes):
    scene = rolling(grid=EXPLICIT)
    disc = discretise(scene, EXPLICIT)
    other = dataclasses.replace(scene, **changes)
    assert discretise(other, other.grid, disc.operators).operators is not disc.operators


def test_steps_of_many_lengths_leave_a_few_tables(rolling):
    """Steady rolling has tables for each length of its step; those of the last few are kept, and
    the others are not.
    """
    operators = discretise(
        rolling(bodies=UNLIKE, surface=vc.Paraboloids(2.0, 2.0)), TIGHT
    ).operators
    normal = weakref.ref(operators.normal)
    steps = [SteadyRolling(distance, 0.1).stencil for distance in np.linspace(0.05, 0.5, 20)]
    made = [weakref.ref(operators.tangential(stencil)) for stencil in steps]
    kept = [each() is not None for each in made]
    assert sum(kept) == 4 and all(kept[-4:])
    assert normal() is not None and operators.tangential(steps[-1]) is made[-1]()


def test_a_medium_whose_operator_does_not_fit_is_refused():
    class Wide(HalfSpaces):
        def operator(self, lattice, rows, columns, stencil=HERE):
            return super().operator(lattice.extended(), rows, columns, stencil)

    with pytest.raises(
        vc.SceneError, match=r"operator of Wide from z to z has a table of shape \(1, 1, 19, 23\)"
    ):
        _ = Operators(TIGHT.scaled(1.0), Wide(0.3)).normal


# ------------------------------------------------------------ Samples outside the potential contact


def pressed(cells, line, bodies):
    """A discretisation of a contact that samples go on around, and its state with tractions."""
    x = np.linspace(-2.0, 2.0, 81)
    h = x**2 / 2 if line else x**2 / 2 + x[:, None] ** 2
    surface = vc.SampledDistance(h, x, reference_depth=5.0) if line else vc.SampledDistance(h, x, x)
    grid = vc.Grid(nx=cells, ny=None if line else cells)
    scene = make_scene(surface, 0.5, vc.Shift(ux=0.05), grid, bodies=bodies)
    sol = vc.solve(scene, certify=None)
    disc = discretise(scene, sol.grid)
    pressure, traction = (field / disc.scales.pressure for field in (sol.pressure, sol.traction))
    return disc, ContactState(
        pressure, sol.approach / disc.scales.displacement, traction, np.zeros(2)
    )


@pytest.mark.long
@pytest.mark.parametrize("line", [False, True], ids=["plane", "line"])
@pytest.mark.parametrize(
    "bodies", [LIKE, vc.Bodies(G=(1.0, 4.0), nu=(0.1, 0.4))], ids=["like", "unlike"]
)
@pytest.mark.parametrize("cells", [8, 24, 40])
def test_displacements_between_centres_are_as_good_as_they_are_taken_for(cells, bodies, line):
    """Linear between the elements' centres, against the exact displacements of all elements, away
    from the contact.
    """
    disc, state = pressed(cells, line, bodies)
    dx, dy = disc.lattice.sides
    (left, right, bottom, top) = penetration.contact_box(disc.lattice, state.pressure, around=1)
    x, y = np.meshgrid(
        np.linspace(left - 1, right + 1, 30),
        [0.0] if line else np.linspace(bottom - 1, top + 1, 30),
    )
    away = (
        (x < left - dx / 4)
        | (x > right + dx / 4)
        | ((y < bottom - dy / 4) | (y > top + dy / 4) & (not line))
    )
    x, y = x[away], y[away]
    elements = np.flatnonzero(state.pressure)
    loads = np.concatenate([state.traction, state.pressure[None]]).reshape(3, -1)[:, elements]
    centres = disc.points.reshape(2, -1)[:, elements, None]
    numbers = disc.operators.medium.influence(
        disc.lattice, x - centres[0], y - centres[1], ["zx", "zy", "zz"]
    )
    exact = sum(load @ numbers[name] for load, name in zip(loads, ("zx", "zy", "zz"), strict=True))
    about = penetration._between_centres(disc, state, x, y)
    off = np.abs(about - exact).max() * max(disc.grid.shape) / state.approach
    assert off < penetration.INTERPOLATION_ERROR
