"""Random scenes by random methods, judged; and tractions, certified."""

import dataclasses

import numpy as np

import varcontact as vc
from tests.conditions import Held
from tests.elasticity_again import influence
from tests.fuzz.arguments import arguments
from tests.fuzz.files import files, flips
from tests.fuzz.judge import faults, projected, untruths
from tests.fuzz.outcome import Case
from tests.fuzz.scenes import scene
from varcontact.solvers.registry import normal_methods, states_program, tangential_methods
from varcontact.theories.on_grid import THEORIES

__all__ = ["arguments", "certificates", "files", "flips", "scenes"]
Random = np.random.Generator
SLOW = ("cvxpy:",)
"""Rarely taken: a solve is more than ten times as long."""
EXACT = 1e-11
"""Largest residual of a solution that counts as exact."""


def steps_of(answer: vc.Solution | vc.History) -> list[vc.Solution]:
    return [answer] if isinstance(answer, vc.Solution) else list(answer)


# ------------------------------------------------------------------------- scenes by random methods


def scenes(rng: Random) -> Case:
    """A scene by any methods, judged; one whose answer is owed may not be refused."""
    chosen = scene(rng)
    keywords = options(rng, chosen)
    unjust = not keywords and owed(chosen)
    return Case(
        f"{chosen} by {keywords}",
        lambda: solved(chosen, keywords),
        lambda e: str(e) if unjust else "",
    )


def solved(chosen: vc.Scene, keywords: dict) -> list[str]:
    """Solve a scene and judge the answer, or the last iterate of a solver that did not converge."""
    try:
        answer = vc.solve(chosen, **keywords)
    except vc.NotConverged as error:
        if found := of_iterate(error):
            return found
        raise
    steps = steps_of(answer)
    for number, (before, sol) in enumerate(zip([None, *steps], steps, strict=False)):
        found = faults(sol, keywords.get("tol", 1e-8), before)
        if not sol.converged:
            found.append("not converged, and no error")
        if found:
            return [f"step {number}", *found]
    return []


def of_iterate(error: vc.NotConverged) -> list[str]:
    """What the certificate of a last iterate states otherwise than it is."""
    sol = error.solution
    if sol is None or sol.scene.under_law or not sol.pressure.any():
        return []
    before = None if error.history is None or len(error.history) == 0 else error.history[-1]
    return (["called converged"] if sol.converged else []) + untruths(Held(sol, before))


def owed(chosen: vc.Scene) -> bool:
    """Whether an answer is owed by default: like bodies, analytic surfaces on a grid laid around
    them, no forces.
    """
    grid, motion = chosen.grid, chosen.motion
    explicit = isinstance(grid, vc.Grid) and (grid.explicit or grid.edge == "touched")
    forces = any(getattr(motion, name, None) is not None for name in ("Fx", "Fy"))
    needs_depth = chosen.line and chosen.reference_depth is None and isinstance(motion, vc.Shift)
    apart = explicit or forces or isinstance(motion, vc.Transient) or needs_depth
    return not (apart or isinstance(chosen.surface, vc.SampledDistance) or chosen.bodies.coupled)


def options(rng: Random, chosen: vc.Scene) -> dict:
    """Keywords of `solve`: in two cases of five those it has by itself, otherwise drawn until the
    plan takes them.
    """
    keywords: dict = {}
    for _ in range(10 if rng.random() < 0.6 else 0):
        drawn = _methods(rng, chosen)
        try:
            vc.plan(chosen, **drawn)
        except (vc.SceneError, vc.SolverUnavailable):
            continue
        keywords = drawn
        break
    own = [
        kind for kind in ("normal", "tangential") if states_program(kind, keywords.get(kind, ""))
    ]
    if own and keywords.get("method") not in ("convex", "conic") and rng.random() < 0.4:
        keywords |= {"polish": False, "tol": 1e-5}
    if chosen.under_law and not isinstance(chosen.motion, vc.Transient) and rng.random() < 0.5:
        keywords["start"] = str(rng.choice(["stick", "slip"]))
    return keywords


def _methods(rng: Random, chosen: vc.Scene) -> dict:
    if rng.random() < 0.4:
        return {"method": str(rng.choice(["convex", "conic", "active-set", "kalker"]))}
    drawn = {}
    if chosen.bodies.coupled and rng.random() < 0.5:
        drawn["coupling"] = str(rng.choice(["johnson", "panagiotopoulos", "joint"]))
    if rng.random() < 0.6:
        drawn["normal"] = _name(rng, normal_methods())
    if rng.random() < 0.8:
        drawn["tangential"] = _name(
            rng, list(THEORIES) if rng.random() < 0.25 else tangential_methods()
        )
    if rng.random() < 0.3:
        drawn["formulation"] = str(rng.choice(["complementary", "potential", "gap", "marching"]))
    return drawn


def _name(rng: Random, names: list[str]) -> str:
    name = str(rng.choice(names))
    return str(rng.choice(names)) if name.startswith(SLOW) else name


# ----------------------------------------------------------------------------- certificates


def certificates(rng: Random) -> Case:
    """Tractions beside a solution exact to rounding, or of a rough solver: no bound falls below
    their true distance.
    """
    rough = rng.random() < 0.3
    chosen = _certifiable(rng, forces=rough)

    def judged() -> list[str]:
        exact = vc.solve(
            chosen, tangential="auto" if chosen.friction is np.inf else "tang-safeguarded"
        )
        if exact.certificate.residual > EXACT and exact.certificate.tangential_residual > EXACT:
            raise vc.NotConverged("not exact", exact.certificate.residual)
        return (_by_a_rough_solver if rough else _beside)(rng, exact)

    return Case(str(chosen), judged)


def _certifiable(rng: Random, forces: bool) -> vc.Scene:
    """A scene whose tractions can be certified; with prescribed forces only where they are
    wanted.
    """
    while True:
        try:
            chosen = scene(rng)
        except vc.SceneError:
            continue
        motion = chosen.motion
        if not isinstance(motion, vc.Steady | vc.Shift) or chosen.frictionless or chosen.under_law:
            continue
        hertzian = not chosen.bodies.coupled and not isinstance(chosen.surface, vc.SampledDistance)
        floating = isinstance(motion, vc.Shift) and chosen.line and chosen.reference_depth is None
        if (forces and not hertzian) or floating:
            continue
        placed = hertzian or (isinstance(chosen.grid, vc.Grid) and chosen.grid.explicit)
        if placed and (forces or (motion.Fx is None and motion.Fy is None)):
            return chosen


def _beside(rng: Random, exact: vc.Solution) -> list[str]:
    """Tractions, and at times pressures, next to the solution or far from it, certified and
    compared with it.
    """
    traction, pressure, spread = disturbed(rng, exact), None, 0.0
    if not exact.plan.closed_form:
        pressure = exact.pressure
        if rng.random() < 0.4:
            spread = 10 ** rng.uniform(-12, 0)
            pressure = pressure * (1 + spread * rng.uniform(-1, 1, pressure.shape))
            elsewhere = rng.random(pressure.shape) < rng.choice([0.0, 0.1])
            pressure = np.where(
                elsewhere, spread * pressure.max() * rng.random(pressure.shape), pressure
            )
    certificate = vc.certify(dataclasses.replace(exact.scene, grid=exact.grid), traction, pressure)
    found = bounded(certificate, exact, outputs(exact.grid, traction))
    moved = dataclasses.replace(exact, traction=traction, certificate=certificate, converged=False)
    if pressure is not None:
        moved = dataclasses.replace(moved, pressure=pressure, approach=np.nan)
    if exact.scene.no_slip:
        return found
    found += untruths(Held(moved, None))
    return found + (
        within_gap(Held(exact, None), Held(moved, None), certificate) if spread == 0 else []
    )


def disturbed(rng: Random, exact: vc.Solution) -> np.ndarray:
    """Tractions beside a solution, by anything from rounding to all of them."""
    size = float(10 ** rng.uniform(-13, 0.3))
    bound = np.where(np.isfinite(exact.traction_bound), exact.traction_bound, exact.pressure)
    shape, traction = exact.traction.shape, exact.traction
    noise = rng.normal(size=shape)
    kind = str(rng.choice(["all", "scaled", "turned", "one", "sparse", "other", "none", "outside"]))
    one = np.zeros(shape[1:])
    one.flat[rng.integers(one.size)] = 1
    change = {
        "all": traction + size * bound * noise,
        "scaled": traction * (1 + size * rng.choice([-1, 1])),
        "turned": traction + size * np.array([-1, 1])[:, None, None] * traction[::-1],
        "one": traction + size * bound * noise * one,
        "sparse": traction + size * bound * noise * (rng.random(shape[1:]) < 0.2),
        "other": bound * noise * rng.uniform(0, 1, shape[1:]),
        "none": np.zeros(shape),
        "outside": traction + size * bound.max() * noise,
    }[kind]
    if kind != "outside" and rng.random() < 0.6:  # tractions that friction can carry
        change = projected(change.reshape(2, -1), bound.ravel()).reshape(shape)
    return change


def outputs(grid: vc.Grid, traction: np.ndarray) -> np.ndarray:
    """Fx, Fy, Mz."""
    x, y = grid.x[None, :], grid.y[:, None]
    return (
        np.array([*traction.sum(axis=(1, 2)), np.sum(x * traction[1] - y * traction[0])])
        * grid.area
    )


def bounded(certificate: vc.Certificate, exact: vc.Solution, found: np.ndarray) -> list[str]:
    """The certified bounds hold, to what is known of the solution."""
    known = exact.certificate.force_bound
    if exact.scene.bodies.coupled:
        return (
            []
            if np.isinf(certificate.force_bound).any()
            else ["a bound where none is known: unlike bodies"]
        )
    away = np.abs(found - outputs(exact.grid, exact.traction))
    beyond = away > certificate.force_bound * (1 + 1e-9) + np.where(np.isfinite(known), known, 0.0)
    return [
        f"{name} is {error:.3e} away, certified {bound:.3e}"
        for name, error, bound, bad in zip(
            ("Fx", "Fy", "Mz"), away, certificate.force_bound, beyond, strict=True
        )
        if bad
    ]


def within_gap(exact: Held, moved: Held, certificate: vc.Certificate) -> list[str]:
    """The squared distance ``(p - p*)'S(p - p*)`` of admissible tractions is not above the gap."""
    away = projected(moved.traction, exact.bound) - exact.traction
    sol = exact.sol
    less = exact.step if isinstance(sol.motion, vc.Steady) else None
    matrix = influence(sol.grid, exact.constants, less=less, depth=sol.scene.reference_depth)
    n = exact.pressure.size
    squared = float(away.ravel() @ matrix[: 2 * n, : 2 * n] @ away.ravel()) * sol.grid.area
    noise = (
        sol.grid.area * float(exact.bound @ np.full(n, 4 * exact.shift_noise))
        + 1e-12 * certificate.gap
    )
    if squared <= certificate.gap + noise:
        return []
    return [
        f"the squared distance is {squared:.3e}, above the gap of {certificate.gap:.3e} (rounding {noise:.0e})"
    ]


def _by_a_rough_solver(rng: Random, exact: vc.Solution) -> list[str]:
    """A solver's own answer to a loose tolerance, also under prescribed forces: its certificate
    bounds its errors.
    """
    name, tol = str(rng.choice(["scs", "clarabel", "newton"])), float(10 ** rng.uniform(-6, -0.5))
    sol = vc.solve(
        dataclasses.replace(exact.scene, grid=exact.grid), tangential=name, polish=False, tol=tol
    )
    found = bounded(sol.certificate, exact, outputs(sol.grid, sol.traction))
    return found + untruths(Held(sol, None))
