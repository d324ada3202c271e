"""What pressures and tractions there are on a grid: the state that passes from one solver to the next."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from varcontact.discrete.contact_grid import no_element_in_contact
from varcontact.discrete.discretisation import Discretisation
from varcontact.reference.line_contact import line_contact
from varcontact.scene.bodies import Bodies
from varcontact.scene.grid import Grid


@dataclass(frozen=True, eq=False)
class ContactState:
    """Pressure (ny, nx) and tractions (2, ny, nx) on the whole grid, dimensionless, and how solvers came to them."""

    pressure: np.ndarray
    approach: float
    traction: np.ndarray
    rigid: np.ndarray  # (2,) Uniform rigid shift where a force is prescribed, else 0
    iterations: dict[str, int] = field(default_factory=dict)
    status: dict[str, str] = field(default_factory=dict)
    solved: dict[str, bool] = field(default_factory=dict)
    solved_by: dict[str, str] = field(default_factory=dict)
    reasons: dict[str, str] = field(default_factory=dict)
    # of each pass of a coupling loop: its change, and the residual of the whole after it
    passes: tuple[tuple[float, float], ...] = ()
    bound_pressure: np.ndarray | None = None
    slips: np.ndarray | None = None  # (ny, nx) The slip area where a theory tells it; otherwise the natural map does
    # (ny, nx) Under a law of friction: the coefficient of the next pass, and where the search began
    friction: np.ndarray | None = None
    branch: str = ""


def unloaded(grid: Grid) -> ContactState:
    """Bodies without pressure or traction."""
    return ContactState(np.zeros(grid.shape), 0.0, np.zeros((2, *grid.shape)), np.zeros(2))


def hertz_pressure(disc: Discretisation, state: ContactState) -> ContactState:
    """The state with Hertz's pressure: his values on the elements, scaled to carry exactly his force."""
    assert disc.hertz is not None
    pressure = disc.hertz.on_elements(disc.grid)
    if not pressure.any():
        raise no_element_in_contact(disc.surface, disc.loading.approach, disc.grid)
    pressure *= disc.hertz.force / (pressure.sum() * disc.grid.area)
    approach = disc.hertz.approach
    if disc.line:  # from the depth that its influence numbers have
        assert isinstance(disc.bodies, Bodies)
        cylinders = line_contact(disc.hertz.Rx, disc.bodies, a=disc.hertz.a)
        approach = cylinders.approach(disc.operators.medium.depth * disc.scales.length)
    approach = (approach - disc.base) / disc.scales.displacement
    return replace(state, pressure=pressure / disc.scales.pressure, approach=approach)
