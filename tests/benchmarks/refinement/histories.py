"""Histories, corrected step by step: errors from infinitely many elements with the same steps.

Not part of the package, see docs/refinement.md. The field on the parts of the elements carries its displacements to the
next step; what it lacks of the step's slip there is averaged over the elements, as in steady rolling.
"""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

import varcontact as vc
from tests.benchmarks.refinement import FRICTION
from varcontact.problem.discretisation import Carried, Discretisation
from varcontact.problem.operators import Operators
from varcontact.problem.slip import unit_slip
from varcontact.problem.state import ContactState, unloaded
from varcontact.solving.refine.field import Shape, means, reconstructed
from varcontact.solving.refine.pressed import divided
from varcontact.solving.refine.sublattice import loads
from varcontact.solving.subproblems import Steps, contact
from varcontact.solving.timing import Clock
from varcontact.solving.transient import largest_contacts, marching_on

FULL = FRICTION / 3.7
"""About the creepage of saturation of a circle."""
PARTS, PASSES = 2, 2


def corrected(scene: vc.Scene) -> np.ndarray:
    """Fx, Fy, Mz of the field and vx of all steps, physical, (steps, 4); the grid is explicit."""
    steps = Steps(vc.plan(scene), 1e-7, True, Clock(), certify="none")
    march = marching_on(scene, largest_contacts(scene)[0], scene.grid, steps)
    cells = (1 if scene.line else PARTS, PARTS)
    operators = march.disc.operators.on(divided(march.disc.lattice, cells))
    state, field, found = unloaded(scene.grid), None, []
    for k in range(scene.motion.steps):
        disc = march.problem(k, None)[1]
        carried = Carried(np.zeros_like(state.traction), np.zeros(2))
        if field is not None:
            came = disc.operators.carrying(disc.motion.rolls * (disc.step or 0.0)).apply(state.traction)
            carried = Carried(came, loads(state.traction, disc.lattice)[:2])
        state = replace(steps.pressure(disc, state), rigid=np.zeros(2))
        state, field = _step(replace(disc, carried=carried), state, field, operators, steps, cells)
        vx = disc.motion.rigid[0] + state.rigid[0] / unit_slip(disc)
        found.append([*loads(field * disc.pressure, divided(disc.grid, cells)), vx])
    return np.array(found)


def _step(
    disc: Discretisation,
    state: ContactState,
    before: np.ndarray | None,
    operators: Operators,
    steps: Steps,
    cells: tuple[int, int],
) -> tuple[ContactState, np.ndarray]:
    """A step: the state on the elements, and the field on their parts."""
    hertz, grid = disc.hertz, divided(disc.grid, cells)
    pressure = hertz.mean_pressure(*grid.lines) / disc.pressure
    coarse = Shape(disc.coefficient * state.pressure, state.pressure)
    fine = Shape(disc.coefficient * pressure, pressure)
    slip, weight = _slip(disc, before, operators), means(fine.bound, cells)
    prescribed = {name: getattr(disc.motion, name) for name in ("Fx", "Fy")}
    posed = disc
    for k in range(PASSES + 1):
        state = contact(posed, steps, state)
        field = reconstructed(state.traction, coarse, fine, cells)
        if k == PASSES:
            break
        own = disc.known_shift + state.rigid[:, None, None] + disc.tangential_operator.apply(state.traction)
        exact = means(slip(field, state.rigid) * fine.bound, cells) / np.where(weight > 0, weight, 1.0)
        carried = Carried(disc.carried.displacement - (exact - own) * (coarse.bound > 0), disc.carried.force)
        more = loads(state.traction * disc.pressure, disc.grid) - loads(field * disc.pressure, grid)
        forces = {name: None if F is None else float(F + more[i]) for i, (name, F) in enumerate(prescribed.items())}
        posed = replace(disc, motion=replace(disc.motion, **forces), carried=carried)
    return state, field


def _slip(
    disc: Discretisation, before: np.ndarray | None, operators: Operators
) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """The local shift at the centres of the parts by a traction on them, dimensionless."""
    x, y = np.meshgrid(operators.lattice.x, operators.lattice.y)
    known = disc.motion.step().shift(x, y, disc.length) / disc.displacement
    if before is not None:
        known = known - operators.carrying(disc.motion.rolls * (disc.step or 0.0)).apply(before)
    return lambda traction, rigid: known + rigid[:, None, None] + operators.tangential().apply(traction)


def history(ratio: float, **motion: object) -> vc.Scene:
    """An ellipse of area pi under a unit load."""
    return vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Ellipse(a=ratio**0.5, b=ratio**-0.5),
        normal_force=1.0,
        friction=FRICTION,
        motion=vc.Transient(**motion),
    )


def scenes(part: int) -> dict[str, vc.Scene]:
    """Histories with steps of a by `part`: two contact lengths from rest, and changes on the way."""
    n, dq, slender = min(2 * part + 2, 14), 1.0 / part, 3.0**0.5 / part
    waves = np.sin(2 * math.pi * np.arange(n) / n)
    shifted = {"dq": [0.0, *[dq] * (n - 1)], "ux": [0.5 * FULL, *[0.0] * (n - 1)]}
    swinging = [float(1 - 0.3 * abs(wave)) for wave in waves]
    return {
        "from rest": history(1.0, steps=n, dq=dq, vx=0.6 * FULL),
        "creepage swings": history(1.0, steps=n, dq=dq, vx=[float(0.7 * FULL * wave) for wave in waves]),
        "Cattaneo to Carter": history(1.0, steps=n, vx=[0.0, *[0.4 * FULL] * (n - 1)], **shifted),
        "spin": history(1.0, steps=n, dq=dq, spin=1.2 * FULL),
        "all three, a/b = 3": history(3.0, steps=n, dq=slender, vx=0.4 * FULL, vy=0.3 * FULL, spin=0.3 * FULL),
        "load swings": history(0.6, steps=n, dq=0.6**0.5 / part, vx=0.5 * FULL, normal_force=swinging),
        "force given": history(1.5, steps=n, dq=1.5**0.5 / part, Fx=[-0.2 * (k + 1) / n for k in range(n)]),
    }


def strips(part: int) -> dict[str, vc.Scene]:
    """The same in line contact."""
    n, bodies, surface, load = (
        min(2 * part + 2, 14),
        vc.Bodies(G=1.0, nu=0.28),
        vc.Cylinders(1.0, reference_depth=5.0),
        0.01,
    )
    a = vc.Scene(bodies=bodies, surface=surface, normal_force=load).hertz.a
    full, dq = 4 * 0.72 * FRICTION * load / (math.pi * a), a / part
    waves = np.sin(2 * math.pi * np.arange(n) / n)
    shifted = {"dq": [0.0, *[dq] * (n - 1)], "ux": [0.5 * full * a, *[0.0] * (n - 1)]}
    motions = {
        "strips, from rest": vc.Transient(steps=n, dq=dq, vx=0.6 * full),
        "strips, creepage swings": vc.Transient(steps=n, dq=dq, vx=[float(0.7 * full * wave) for wave in waves]),
        "strips, Cattaneo to Carter": vc.Transient(steps=n, vx=[0.0, *[0.4 * full] * (n - 1)], **shifted),
    }
    posed = {"bodies": bodies, "surface": surface, "normal_force": load, "friction": FRICTION}
    return {name: vc.Scene(motion=motion, **posed) for name, motion in motions.items()}


def on(scene: vc.Scene, cells: int) -> vc.Scene:
    """On an explicit grid across the contact."""
    hertz = scene.hertz
    if scene.line:
        return replace(scene, grid=vc.Grid(nx=cells, dx=2 * hertz.a / cells, x0=-hertz.a))
    return replace(scene, grid=vc.Grid(nx=cells, ny=cells).spread((-hertz.a, hertz.a, -hertz.b, hertz.b)))


def plain(scene: vc.Scene) -> np.ndarray:
    """Fx, Fy, Mz and vx of all steps, on the scene's grid."""
    steps = vc.solve(scene, certify=None)
    return np.array([[*step.force, step.moment, step.creepage[0]] for step in steps])


def limit(scene: vc.Scene) -> np.ndarray:
    """What plain grids tend to: of touched elements 48 and 96, of strips 256 and 512."""
    if scene.line:
        return 2 * plain(on(scene, 512)) - plain(on(scene, 256))
    grids = [vc.Grid(nx=cells, ny=cells, edge="touched") for cells in (96, 48)]
    fine, coarse = (plain(replace(scene, grid=grid)) for grid in grids)
    return 2 * fine - coarse


def table() -> None:
    """Plain and corrected on 16 and 32 cells, largest error of all steps, from corrected histories on 64."""
    errors = []
    for part in (4, 8, 16):
        for name, posed in (scenes(part) | strips(part)).items():
            size = FRICTION * posed.normal_force
            given = posed.motion.Fx is not None
            units = np.array([size, size, size, FULL if given else math.inf])

            def off(found: np.ndarray, truth: np.ndarray, units: np.ndarray = units) -> float:
                return float(np.nanmax(np.abs(found - truth) / units))

            best = limit(posed)
            truth = best if posed.line else corrected(on(posed, 64))
            row = [off(best, truth)]
            for cells in (16, 32):
                row += [off(plain(on(posed, cells)), truth), off(corrected(on(posed, cells)), truth)]
            if not posed.line:
                errors.append(row)
            print(f"a/{part:<3d} {name:28s} " + " ".join(f"{value:.1e}" for value in row), flush=True)
    print("median of ellipses " + " ".join(f"{value:.1e}" for value in np.median(errors, axis=0)))
