"""Random scenes of all kinds, one function for each kind of part; a scene follows from a seed and
its number.

Sizes are drawn dimensionless about a contact with semi-axes a, b and ab = 1 under a largest
pressure p0, and put into units at the end. `natural` creepages are those at which about half of the
contact slips.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import varcontact as vc
from tests.elasticity_again import Constants, Ellipse, hertz_by_axes, hertz_line

Random = np.random.Generator


@dataclass(frozen=True)
class Base:
    """What the parts of a scene have to fit together: the contact's sizes, in the scene's units."""

    bodies: vc.Bodies
    contact: Ellipse  # of half-spaces under the load; infinite b is line contact
    friction: float  # of the order of the scene's
    units: vc.Units | None

    @property
    def line(self) -> bool:
        """Whether it is a line contact."""
        return bool(np.isinf(self.contact.b))

    @property
    def size(self) -> float:
        """Mean radius of the contact."""
        return self.contact.a if self.line else float(np.sqrt(self.contact.a * self.contact.b))

    @property
    def natural(self) -> float:
        """Creepage at which about half of the contact slips."""
        return self.friction * self.contact.peak / Constants.of(self.bodies).G


def scene(rng: Random) -> vc.Scene:
    """A scene of any kind."""
    base = _base(rng)
    kind = _one_of(rng, {no_motion: 1, shift: 3, steady: 5, transient: 2})
    grid = _grid(rng, base)
    surface, grid = (_line_surface if base.line else _surface)(rng, base, grid)
    motion = kind(rng, base, grid)
    if isinstance(motion, vc.Transient) and isinstance(surface, vc.Ellipse):
        surface = vc.Paraboloids(base.contact.Rx, base.contact.Ry)
    friction = None if motion is None and rng.random() < 0.5 else _friction(rng, base, grid)
    explicit = isinstance(friction, np.ndarray) or (
        isinstance(surface, vc.SampledDistance) and surface.x is None
    )
    laid_out = "auto" if not explicit and rng.random() < 0.02 and base.bodies.K == 0 else grid
    given = {"bodies": base.bodies, "surface": surface, **_load(rng, base, surface)}
    return vc.Scene(**given, friction=friction, motion=motion, grid=laid_out, units=base.units)


# ----------------------------------------------------------------------------- bodies and sizes


def _base(rng: Random) -> Base:
    """Bodies, and a contact from 0.05 to 20 times as long as wide, or a line; in any units."""
    length, modulus, units = _one_of(
        rng,
        {
            (1.0, 1.0, None): 3,
            (5e-3, 8e10, vc.Units(length="m", force="N")): 3,
            (5.0, 8e4, vc.Units(length="mm", force="N")): 2,
            (float(10 ** rng.uniform(-9, 9)), float(10 ** rng.uniform(-9, 9)), None): 1,
        },
    )
    bodies = _bodies(rng, modulus)
    constants, peak = Constants.of(bodies), modulus * 10 ** rng.uniform(-5, -1.5)
    friction = float(
        _one_of(
            rng, {rng.uniform(0.05, 0.8): 6, 10 ** rng.uniform(-6, -2): 1, rng.uniform(1, 10): 1}
        )
    )
    if rng.random() < 0.2:
        force = np.pi * length * peak / 2
        R = length * constants.G / (2 * (1 - constants.nu) * peak)
        return Base(bodies, hertz_line(R, constants, depth=None, force=force), friction, units)
    ratio = float(np.sqrt(_one_of(rng, {1.0: 1, 10 ** rng.uniform(-1.3, 1.3): 4})))
    a, b = length * ratio, length / ratio
    return Base(
        bodies, hertz_by_axes(a, b, constants, force=2 * np.pi / 3 * a * b * peak), friction, units
    )


def _bodies(rng: Random, modulus: float) -> vc.Bodies:
    """Like bodies, unlike ones, one that is rigid, nearly like ones."""
    nu = float(_one_of(rng, {0.28: 2, 0.5: 1, 0.0: 1, rng.uniform(-0.9, 0.5): 2}))
    other, ratio = float(rng.uniform(-0.5, 0.5)), float(10 ** rng.uniform(-2, 2))
    return _one_of(
        rng,
        {
            vc.Bodies(modulus, nu): 6,
            vc.Bodies((modulus, modulus * ratio), (nu, other)): 2,
            vc.Bodies((np.inf, modulus), (other, nu)): 1,
            vc.Bodies(
                (modulus, modulus), (nu, nu + 10 ** rng.uniform(-8, -3) * (-1 if nu > 0.4 else 1))
            ): 1,
        },
    )


# ----------------------------------------------------------------------------- surface and grid


def _grid(rng: Random, base: Base) -> vc.Grid:
    """Elements across the contact, or a lattice of its own, small or large for the contact, or of
    one row.
    """
    nx, ny = int(rng.integers(1, 15)), int(rng.integers(1, 15))
    if base.line:
        nx = int(rng.integers(2, 40))
    if rng.random() < 0.5:
        rows = None if base.line else ny
        return (
            vc.Grid(nx=nx, ny=rows, edge="touched")
            if rng.random() < 0.15
            else vc.Grid(nx=nx, ny=rows)
        )
    return _lattice(rng, base, max(nx, 2), max(ny, int(_one_of(rng, {1: 1, 2: 3}))))


def _lattice(rng: Random, base: Base, nx: int, ny: int, wide: float = 1.0) -> vc.Grid:
    """An explicit grid around the contact, not quite in its middle."""
    width = 2 * base.contact.a * wide * rng.uniform(1.3, 1.8)
    x0 = -width * rng.uniform(0.42, 0.58)
    if base.line:
        return vc.Grid(nx=nx, dx=width / nx, x0=x0)
    height = 2 * base.contact.b * wide * rng.uniform(1.3, 1.8)
    if ny == 1:
        height = base.contact.b * rng.uniform(1.2, 1.9)  # one row within the contact
    return vc.Grid(
        nx=nx, ny=ny, dx=width / nx, dy=height / ny, x0=x0, y0=-height * rng.uniform(0.42, 0.58)
    )


def _surface(rng: Random, base: Base, grid: vc.Grid) -> tuple[object, vc.Grid]:
    """Analytic, sampled on the grid (rough, with elements that are missing), or sampled
    anywhere.
    """
    contact = base.contact
    kind = _one_of(rng, {"paraboloids": 3, "ellipse": 3, "rough": 3, "placed": 1})
    if kind == "paraboloids":
        return vc.Paraboloids(contact.Rx, contact.Ry), grid
    if kind == "ellipse":
        return vc.Ellipse(contact.a, contact.b), grid
    if kind == "rough":
        grid = _lattice(rng, base, max(grid.nx, 2), max(grid.rows, 2), wide=rng.uniform(1, 2))
        return vc.SampledDistance(
            _rough(rng, base, vc.Paraboloids(contact.Rx, contact.Ry).distance(grid))
        ), grid
    x = contact.a * 2.2 * np.linspace(-1, 1, int(rng.integers(5, 30)))
    y = contact.b * 2.2 * np.linspace(-1, 1, int(rng.integers(5, 30)))
    h = x**2 / (2 * contact.Rx) + y[:, None] ** 2 / (2 * contact.Ry)
    tilt = rng.uniform(-0.3, 0.3, 2) * contact.approach
    h = h + tilt[0] * x / contact.a + tilt[1] * y[:, None] / contact.b
    return vc.SampledDistance(h, x, y), vc.Grid(nx=max(grid.nx, 2), ny=max(grid.rows, 2))


def _line_surface(rng: Random, base: Base, grid: vc.Grid) -> tuple[object, vc.Grid]:
    """Cylinders, or samples on the grid; with a reference depth or without."""
    depth = float(base.contact.a * 10 ** rng.uniform(1, 3)) if rng.random() < 0.85 else None
    cylinders = vc.Cylinders(base.contact.Rx, depth)
    if rng.random() < 0.7:
        return cylinders, grid
    grid = grid if grid.explicit else _lattice(rng, base, grid.nx, 1)
    return vc.SampledDistance(
        _rough(rng, base, cylinders.distance(grid))[0], reference_depth=depth
    ), grid


def _rough(rng: Random, base: Base, h: np.ndarray) -> np.ndarray:
    """Distances with waves, with noise, and with elements that are missing: cut out, or a whole
    corner.
    """
    depth = base.contact.a**2 / (2 * base.contact.Rx)
    h = h + depth * _one_of(rng, {0.0: 1, 10 ** rng.uniform(-4, 0): 2}) * rng.normal(size=h.shape)
    missing = rng.random(h.shape) < _one_of(rng, {0.0: 2, 0.1: 1, 0.4: 1})
    if rng.random() < 0.6:  # the bodies end within the grid
        missing[:, [0, -1]] = True
        if len(h) > 2:
            missing[[0, -1]] = True
    if rng.random() < 0.3:
        missing[: h.shape[0] // 2, : h.shape[1] // 3] = True
    if missing.all():
        missing.flat[0] = False
    return np.where(missing, h + 10 ** rng.uniform(1, 4) * depth, h)


def _load(rng: Random, base: Base, surface) -> dict:
    """The normal force, or the approach where that means something."""
    contact, rough = base.contact, isinstance(surface, vc.SampledDistance)
    if rng.random() < 0.7 or (base.line and (surface.reference_depth is None or rough)):
        return {"normal_force": contact.force}
    if base.line:
        constants = Constants.of(base.bodies)
        contact = hertz_line(
            contact.Rx, constants, depth=surface.reference_depth, force=contact.force
        )
    if rough:
        return {"approach": float(surface.h.min()) + contact.approach * rng.uniform(0.1, 1)}
    return {"approach": contact.approach}


# ----------------------------------------------------------------------------- friction


def _friction(rng: Random, base: Base, grid):
    """A number, infinity, nothing, one for each element, or a law."""
    f = base.friction
    kind = _one_of(rng, {"number": 8, "inf": 1, "zero": 0.3, "array": 1.5, "law": 1.5})
    if kind == "array" and isinstance(grid, vc.Grid) and grid.explicit:
        field = f * 10 ** rng.uniform(-1, 0, grid.shape)
        return np.where(rng.random(grid.shape) < 0.2, 0.0, field)
    if kind == "law":
        return law(rng, base)
    return {"inf": np.inf, "zero": 0.0}.get(kind, f)


def law(rng: Random, base: Base):
    """A law of friction of any kind, of slip velocities at which it falls."""
    kinetic = base.friction * rng.uniform(0.3, 1)
    velocity = float(10 ** rng.uniform(-1, 2))
    half = velocity * base.natural * 10 ** rng.uniform(-1, 2)
    falling = _one_of(rng, {vc.LinearFalling: 1, vc.RationalFalling: 1, vc.ExponentialFalling: 1})
    return _one_of(
        rng,
        {
            vc.StaticKinetic(base.friction, kinetic): 1,
            falling(base.friction, kinetic, half, velocity): 2,
        },
    )


# ----------------------------------------------------------------------------- motion


def no_motion(rng: Random, base: Base, grid) -> None:
    """The normal problem alone."""


def shift(rng: Random, base: Base, grid) -> vc.Shift:
    """A shift in place."""
    ux, Fx = _moved(rng, base, base.size)
    uy, Fy = _moved(rng, base, base.size)
    turn = 0.0 if base.line else _amount(rng, base)
    return vc.Shift(ux=ux, uy=uy, rotation=turn, Fx=Fx, Fy=Fy)


def steady(rng: Random, base: Base, grid) -> vc.Steady:
    """Steady rolling, in steps of about an element, short ones or long ones."""
    vx, Fx = _moved(rng, base, 1.0)
    vy, Fy = _moved(rng, base, 1.0)
    spin = 0.0 if base.line else _amount(rng, base) / base.size
    dx = 2 * base.contact.a / grid.nx
    dq = _one_of(rng, {None: 4, dx * rng.uniform(0.5, 2): 2, dx * 10 ** rng.uniform(-4, 0.7): 1})
    offset = _one_of(rng, {1 / 6: 2, float(rng.uniform(0, 1)): 1})
    return vc.Steady(vx=vx, vy=vy, spin=spin, Fx=Fx, Fy=Fy, dq=dq, spin_offset=offset)


def transient(rng: Random, base: Base, grid) -> vc.Transient:
    """A few steps of rolling in time, which may change direction, length, load, friction, creepage
    and force.
    """
    steps = int(rng.integers(1, 5))
    dx = 2 * base.contact.a / grid.nx

    def each(draw: Callable, varies: float = 0.5):
        return [draw() for _ in range(steps)] if rng.random() < varies else draw()

    dq = each(lambda: _one_of(rng, {dx: 2, 0.0: 1, dx * rng.uniform(0.2, 3): 1}))
    along, across = (each(lambda: _moved(rng, base, 1.0, most=0.25), 1.0) for _ in "xy")
    entries: dict = {
        "vx": [v for v, _ in along],
        "vy": [v for v, _ in across],
        "Fx": [F for _, F in along],
        "Fy": [F for _, F in across],
    }
    if not base.line:
        entries["spin"] = each(lambda: _amount(rng, base) / base.size)
        entries["rotation"] = each(lambda: _one_of(rng, {0.0: 3, _amount(rng, base): 1}))
    if rng.random() < 0.3:
        entries["ux"] = [
            0.0 if F is not None else _amount(rng, base) * base.size for F in entries["Fx"]
        ]
    if rng.random() < 0.3:
        least = 1 if any(entries["Fx"] + entries["Fy"]) else 0
        load = each(lambda: _one_of(rng, {rng.uniform(0.4, 1): 4, least: 1}))
        entries["normal_force"] = (np.array(load) * base.contact.force).tolist()
    if rng.random() < 0.3:
        entries["friction"] = each(
            lambda: _one_of(rng, {None: 2, float(base.friction * rng.uniform(0.5, 1)): 2})
        )
    direction = each(lambda: _one_of(rng, {1: 2, -1: 1}), 0.2)
    return vc.Transient(steps=steps, dq=dq, direction=direction, **entries)


def _moved(rng: Random, base: Base, length: float, most: float = 1.0) -> tuple[float, float | None]:
    """A creepage (times a length: a shift), or a force in its place, up to a part of what friction
    carries or so.
    """
    kind = _one_of(rng, {"creepage": 5, "none": 2, "force": 3})
    if kind == "force":
        part = _one_of(
            rng,
            {
                rng.uniform(-0.7, 0.7): 6,
                0.0: 1,
                10 ** rng.uniform(-8, -2): 1,
                rng.uniform(0.9, 1.1): 1,
            },
        )
        return 0.0, float(part * most * base.friction * base.contact.force)
    return (_amount(rng, base) * length if kind == "creepage" else 0.0), None


def _amount(rng: Random, base: Base) -> float:
    """A creepage of either sign, from next to nothing to full sliding."""
    size = _one_of(rng, {10 ** rng.uniform(-1, 0.5): 4, 10 ** rng.uniform(-6, 2): 1, 0.0: 0.5})
    return float(base.natural * size * rng.choice([-1, 1]))


def _one_of(rng: Random, choices: dict):
    """One of the keys, with these weights."""
    weights = np.array(list(choices.values()), float)
    return list(choices)[rng.choice(len(weights), p=weights / weights.sum())]
