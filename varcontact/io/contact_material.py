"""Bodies, layers, temperatures and friction of CONTACT's input files, modules 1 and 3."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from varcontact.elasticity.halfspace import influence_numbers
from varcontact.elasticity.own import Elasticity
from varcontact.io.contact_cases import CaseInput
from varcontact.io.contact_words import Group, located
from varcontact.io.influence_numbers import read_influence_numbers
from varcontact.scene.bodies import Bodies, Viscoelastic, as_bodies
from varcontact.scene.friction import ExponentialFalling, Law, LinearFalling, RationalFalling
from varcontact.scene.friction_laws import FrictionLaw, TemperatureFalling
from varcontact.scene.grid import Grid
from varcontact.scene.interface import Thermal, ThirdBody

FALLING: dict[int, type[Any]] = {
    2: LinearFalling,
    3: RationalFalling,
    4: ExponentialFalling,
}
"""Laws by slip velocity, by the digit L."""
NUMBERS = 9
"""Value of the digit C for influence numbers from a file."""
SHEET = 1
"""Value of the digit B for a thin sheet between the bodies."""
ROOM = 4
"""Elements by which influence numbers exceed the contact: for a step of rolling, and for a ring of
elements where the contact reaches the end."""
VISCOELASTIC = 1
LAYERED = 4
"""Values of the digit M."""
WATT = 1000.0
"""One watt [N mm/s]."""
INFINITE_STRENGTH = 1e-10
"""Yield stress of a third body up to which CONTACT treats it as elastic."""


def own_elasticity(case: CaseInput, grid: Grid) -> Elasticity | None:
    """Bodies by influence numbers: those of a file (C = 9), or of half-spaces with a thin sheet
    between them (B = 1); None of other bodies.
    """
    nu1, nu2, G1, G2 = case.entries["material"].numbers()
    bodies = Bodies(G=(G1, G2), nu=(nu1, nu2))
    if kept(case, "INFLCF", 1) == NUMBERS:
        group: Group = case.entries["influence"]
        file = Path(group.path).parent / group.text(0)
        with located(group):
            return read_influence_numbers(file, G=bodies.combined_G)
    if case.controls["BOUND"] != SHEET:
        return None
    group = case.needs("sheet", "BOUND", "a thin sheet", "C = 2")
    flexibility = group.number(0)
    if flexibility < 0:
        group.refuse("FLX_Z", flexibility, "is negative")
    return _with_sheet(bodies, grid, flexibility)


def _with_sheet(bodies: Bodies, grid: Grid, flexibility: float) -> Elasticity:
    """Half-spaces with a thin sheet between them: each element has an extra compliance under its
    own pressure.
    """
    dx, dy = grid.sides
    columns = grid.nx + ROOM
    rows = grid.rows + ROOM
    x = dx * np.arange(1 - columns, columns)
    y = dy * np.arange(1 - rows, rows)[:, None]
    constants = {"nu": bodies.combined_nu, "K": bodies.K, "G": bodies.combined_G}
    pairs = [first + second for first in "xyz" for second in "xyz"]
    numbers = influence_numbers(x, y, dx, dy, components=pairs, **constants)
    kernel = np.array([numbers[pair] for pair in pairs]).reshape(3, 3, y.size, x.size)
    kernel[2, 2, rows - 1, columns - 1] += flexibility
    return Elasticity(kernel=kernel, sides=(dx, dy))


def kept(case: CaseInput, digit: str, keeping: int) -> int:
    """Value of a digit, or of the earlier case from which it is kept; 0 if there is none."""
    found: CaseInput | None = case
    while found is not None and found.controls[digit] <= keeping:
        found = found.before
    if found is None:
        return 0
    return found.controls[digit]


def bodies_of(case: CaseInput) -> Any:
    """Half-spaces, elastic or viscoelastic."""
    group: Group = case.needs("material", "INFLCF", "a material", "C = 2")
    nu1, nu2, G1, G2 = group.numbers()
    with located(group):
        bodies = Bodies(G=(G1, G2), nu=(nu1, nu2))
    if case.controls["MATER"] != VISCOELASTIC:
        return bodies
    group = case.needs("viscoelastic", "MATER", "viscoelastic constants", "C = 2")
    part1, part2, time1, time2 = group.numbers()
    with located(group):
        return as_bodies((_solid(G1, nu1, part1, time1), _solid(G2, nu2, part2, time2)))


def _solid(G: float, nu: float, part: float, time: float) -> Bodies | Viscoelastic:
    """A standard linear solid; one that relaxes at once, or does not, is elastic."""
    if part == 0:
        return Bodies(G=G, nu=nu)
    if time == 0:
        return Bodies(G=G / (1 + part), nu=nu)
    return Viscoelastic(G=G, nu=nu, relaxations=((part, time),))


def flexibility_of(case: CaseInput) -> tuple[float | None, tuple[float, float, float]]:
    """The flexibility of simplified theory, which M = 2 gives alone, and its slopes."""
    if case.controls["MATER"] != 2:
        start, rest, decay = case.needs("slope", "MATER", "slopes", "C = 2").numbers()
        return None, (start, rest, decay)
    group: Group = case.needs("flexibility", "MATER", "a flexibility", "C = 2")
    flexibility, start, rest, decay = group.numbers()
    return flexibility, (start, rest, decay)


def layer_of(case: CaseInput) -> ThirdBody | None:
    """The third body of M = 4."""
    if case.controls["MATER"] != LAYERED:
        return None
    group: Group = case.needs("layer", "MATER", "a third body", "C = 2")
    modulus, thickness, strength, hardening = group.numbers()
    if strength <= INFINITE_STRENGTH:
        strength = math.inf
        hardening = 0.0
    with located(group):
        return ThirdBody(h=thickness, G=modulus, tau_c0=strength, k_tau=hardening)


def thermal_of(case: CaseInput) -> tuple[Thermal, Thermal] | None:
    """Thermal data of both bodies, in N, mm, s and degrees."""
    if case.controls["HEAT"] == 0:
        return None
    groups = [case.needs(f"heat {k}", "HEAT", "thermal data", "H = 3") for k in (1, 2)]
    bodies = []
    for group in groups:
        temperature, capacity, conductivity, density = group.numbers()
        with located(group):
            bodies.append(
                Thermal(
                    conductivity=WATT * conductivity,
                    density=density,
                    heat_capacity=WATT * capacity,
                    temperature=temperature,
                )
            )
    return bodies[0], bodies[1]


def friction_of(case: CaseInput, velocity: float, grid: Grid) -> Any:
    """A coefficient or law of a basic contact, also by row of its elements."""
    groups = laws_of(case)
    law = kept_law(case)
    if case.controls["VARFRC"] == 0:
        return friction_law(law, groups[0], groups, velocity)
    rows = groups[: len(groups) - (law != 0)]
    if len(rows) != grid.rows:
        case.controls.complain("VARFRC", "keeps friction of another number of rows: use L = 0")
    laws = [friction_law(law, group, groups, velocity) for group in rows]
    if law == 0:
        return np.tile(np.array(laws)[:, None], (1, grid.nx))
    if any(isinstance(each, TemperatureFalling) for each in laws):
        case.controls.complain("VARFRC", "with L = 6 is not supported")
    return _by_row(laws, velocity)


def laws_of(case: CaseInput) -> tuple[Group, ...]:
    """The groups of the friction law, given or kept."""
    groups: tuple[Group, ...] = case.needs("friction", "FRCLAW", "a friction law", "L = 0")
    return groups


def kept_law(case: CaseInput) -> int:
    """The digit L, or that of the case from which friction is kept."""
    found: CaseInput | None = case
    while found is not None and found.controls["FRCLAW"] == 1:
        found = found.before
    if found is None:
        return 0
    if found.controls["VARFRC"] != case.controls["VARFRC"]:
        case.controls.complain("VARFRC", "needs a new friction law, and L is 1")
    return found.controls["FRCLAW"]


def friction_law(law: int, group: Group, groups: tuple[Group, ...], velocity: float) -> float | Law:
    """One coefficient or law; its memory is in the last of the groups."""
    # after the place, where friction varies
    first_entry = int(group.names[0] in ("ALPHA", "SVF"))
    values = [group.number(k) for k in range(first_entry, len(group.values))]
    if law == 0:
        static, kinetic = values
        if not 0.999 * kinetic <= static <= 1.001 * kinetic:
            why = f"is not FSTAT = {static}; CONTACT supports one coefficient (its guide, 4.2)"
            group.refuse("FKIN", kinetic, why)
        return static
    distance, least = groups[-1].numbers()
    memory: dict[str, Any] = {}
    if distance > 0:
        memory = {"memory_distance": distance, "memory_velocity": least, "memory_step": "implicit"}
    with located(group):
        if law == 6:
            return _by_temperature(group, values, memory)
        return _falling(FALLING[law], values, velocity, memory)


def _falling(
    kind: Any, values: list[float], velocity: float, memory: dict[str, Any]
) -> float | Law:
    """A law of one or two terms that fall with the slip velocity."""
    kinetic, first, half, second, other_half = values
    if first == second == 0 and not memory:
        return kinetic
    if second == 0:
        one: Law = kind(kinetic + first, kinetic, half, velocity, **memory)
        return one
    part = kind(1.0, 0.0, 1.0)
    # the second rational term falls with the square
    power = 2 if kind is RationalFalling else 1

    def falling(slip_velocity: np.ndarray) -> np.ndarray:
        slip = np.asarray(slip_velocity)
        found = kinetic + second * part((slip / other_half) ** power)
        if first > 0:
            found = found + first * part(slip / half)
        return np.asarray(found)

    return FrictionLaw(kinetic + first + second, kinetic, [falling], velocity=velocity, **memory)


def _by_temperature(group: Group, values: list[float], memory: dict[str, Any]) -> Law:
    reference, start, change, over = values
    if change > 0:
        group.refuse("DFHEAT", change, "is not supported: friction here falls with temperature")
    return TemperatureFalling(reference, reference + change, start, over, **memory)


def _by_row(laws: list[Any], velocity: float) -> FrictionLaw:
    """Laws of rows as one."""

    def falling(slip_velocity: np.ndarray) -> np.ndarray:
        if slip_velocity.shape[0] != len(laws):  # evaluated once, on an example
            return np.asarray(laws[0](slip_velocity / velocity))
        rows = [law(row / velocity) for law, row in zip(laws, slip_velocity, strict=True)]
        return np.stack(rows)

    static = max(law.static for law in laws)
    kinetic = min(law.kinetic for law in laws)
    return FrictionLaw(static, kinetic, [falling], velocity=velocity)
