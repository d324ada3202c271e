"""What many tests share."""

import csv
import dataclasses
from pathlib import Path

import hypothesis
import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

import varcontact as vc
from varcontact.elasticity.operators import influence_operator
from varcontact.problem import operators

mpl.use("Agg")
DATA = Path(__file__).parent / "data"

hypothesis.settings.register_profile("default", deadline=None, derandomize=True, print_blob=True)
hypothesis.settings.load_profile("default")


@pytest.fixture(scope="session")
def rolling():
    """A function: a small steady rolling scene, with whatever is to be different."""
    base = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Ellipse(a=1.2, b=0.9),
        normal_force=1.0,
        friction=0.3,
        motion=vc.Steady(vx=0.04, vy=-0.02, spin=0.05),
        grid=vc.Grid(nx=12, ny=12),
    )
    return lambda **changes: dataclasses.replace(base, **changes)


@pytest.fixture
def pictures(monkeypatch):
    """The figures that are written to files during a test, in their order."""
    written, write = [], Figure.savefig

    def savefig(figure, *arguments, **options):
        write(figure, *arguments, **options)
        written.append(figure)

    monkeypatch.setattr(Figure, "savefig", savefig)
    return written


@pytest.fixture(scope="session")
def paper_table():
    """A function: a table of the paper as a list of dictionaries of floats."""

    def read(name: str) -> list[dict[str, float]]:
        with open(DATA / name) as lines:
            return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(lines)]

    return read


@pytest.fixture
def built(monkeypatch):
    """The tables of influence numbers that are built from now on: (name, operator), named as in a plan."""
    tables, make = [], operators.influence_operator

    def counted(grid, rows, columns, **constants):
        operator = make(grid, rows, columns, **constants)
        name = operators.table_name(rows, columns, constants.get("lag"), constants.get("offset", 0.0))
        tables.append((name, operator))
        return operator

    monkeypatch.setattr(operators, "influence_operator", counted)
    return tables


@pytest.fixture(scope="session")
def touched_coefficients():
    """A function: Kalker's creepage coefficients of a discrete ellipse, see `no_slip_on_touched`."""
    return no_slip_on_touched


def no_slip_on_touched(ratio: float, nu: float, cells: int, offset: float) -> np.ndarray:
    """C11, C22, C23, C33 on all elements that the ellipse touches, with ab = 1 and G = 1.

    Elements taken by their centres make the error jump with the grid (staircase); taking every element touched
    makes it larger but regular, so that its order can be fitted and the limit extrapolated.
    """
    a, b = np.sqrt(ratio), 1 / np.sqrt(ratio)
    grid = vc.Grid(nx=cells, ny=cells, margin=0).spread((-a, a, -b, b))
    dx, dy = grid.sides
    near_x, near_y = np.maximum(np.abs(grid.x) - dx / 2, 0) / a, np.maximum(np.abs(grid.y) - dy / 2, 0) / b
    touched = np.flatnonzero((near_x[None, :] ** 2 + near_y[:, None] ** 2 < 1 - 1e-12).ravel())
    x, y = (c.ravel()[touched] for c in np.meshgrid(grid.x, grid.y))
    matrix = influence_operator(grid, "xy", "xy", nu=nu, lag=dx).dense(touched)
    one, zero = np.ones(x.size), np.zeros(x.size)
    shifts = dx * np.array([[one, zero], [zero, one], [-y, x + offset * dx]]).reshape(3, -1)
    tractions = -np.linalg.solve(matrix, shifts.T).T.reshape(3, 2, -1) * grid.area
    forces = tractions.sum(axis=2)
    moment = np.sum(x * tractions[2, 1] - y * tractions[2, 0])
    return -np.array([forces[0, 0], forces[1, 1], forces[2, 1], moment])


@pytest.fixture(scope="session")
def check_kkt():
    """A function: the optimality conditions of a solution, element by element, see `kkt`."""
    return kkt


def kkt(sol: vc.Solution, tol: float, *, closed_form: bool = False, previous: vc.Solution | None = None) -> None:
    """Assert Kalker's conditions (15)-(17), (45)-(49) of a solution, from nothing but its fields.

    Dense matrices made here, pair by pair, from the influence functions as THEORY prints them: neither the FFT nor
    the tables of offsets of the package. Displacements are judged in terms of the tractions that would cause them
    in their own element (divided by rho, the diagonal), tractions by the largest one possible: `tol` then means the
    same everywhere, and is what a natural-map residual of `tol` implies.

    Parameters
    ----------
    tol : float
        Relative, of the tractions.
    closed_form : bool
        Whether the pressure is Hertz's, which meets the equations of a grid to the grid's error only.
    previous : Solution, optional
        Of a step of a history: the step before.
    """
    scene, grid, motion = sol.scene, sol.grid, sol.scene.motion
    x, y = (values.ravel() for values in np.meshgrid(grid.x, grid.y))
    pressure, traction = sol.pressure.ravel(), sol.traction.reshape(2, -1)
    fields = np.concatenate([traction.ravel(), pressure])
    n, contact = pressure.size, pressure > 0
    instant = influence(x, y, grid.sides, scene.bodies)
    displacement = (instant @ fields).reshape(3, n)

    # normal: (15)-(17)
    rho, peak = instant[2 * n, 2 * n], pressure.max()
    distance = undeformed(scene, x, y) + displacement[2] - sol.approach
    assert pressure.min() >= 0
    np.testing.assert_allclose(sol.distance.ravel(), distance, atol=1e-11 * np.abs(displacement[2]).max())
    if not closed_form:
        assert distance.min() >= -tol * rho * peak, "bodies overlap"
        assert np.minimum(pressure, distance / rho).max() <= tol * peak, "pressure at a distance"
    if scene.normal_force is not None:
        assert sol.normal_force == pytest.approx(scene.normal_force, rel=tol)
    else:
        assert sol.approach == pytest.approx(scene.approach, rel=1e-12)
    if motion is None:
        assert not traction.any()
        return

    # tangential: (45)-(49)
    first, second, third = sol.creepage
    if isinstance(motion, vc.Steady):
        step = motion.dq if motion.dq is not None else grid.sides[0]
        before = (influence(x + step, y, grid.sides, scene.bodies, at=(x, y)) @ fields).reshape(3, n)
        ahead = x + motion.spin_offset * step
    elif isinstance(motion, vc.TimeStep):
        step, moved, before = motion.dq or 1.0, motion.direction * motion.dq, 0.0
        ahead = x + motion.spin_offset * moved
        if previous is not None:
            carried = np.concatenate([previous.traction.ravel(), previous.pressure.ravel()])
            before = (influence(x + moved, y, grid.sides, scene.bodies, at=(x, y)) @ carried).reshape(3, n)
    else:
        step, before, ahead = 1.0, 0.0, x
    rigid = np.array([first - third * y, second + third * ahead]) * step
    shift = rigid + (displacement - before)[:2]
    np.testing.assert_allclose(
        sol.slip.reshape(2, -1)[:, contact] * step,
        shift[:, contact],
        atol=1e-11 * (np.abs(displacement).max() + np.abs(rigid).max()),
    )
    size, slip, bound = np.hypot(*traction), np.hypot(*shift), sol.traction_bound.ravel()
    assert not traction[:, ~contact].any()
    if np.isinf(bound[contact]).all():
        assert slip[contact].max() <= tol * instant[0, 0] * size.max(), "slip in spite of infinite friction"
    else:
        rho, largest = (instant[0, 0] + instant[n, n]) / 2, bound.max()
        assert np.all(size <= bound + tol * largest), "traction beyond its bound"
        loose = bound - size > tol * largest
        assert np.max(slip[loose], initial=0.0) <= tol * rho * largest, "slip below the traction bound"
        opposed = np.hypot(*(traction * slip + bound * shift))[contact]
        allowed = tol * largest * (slip + rho * bound)[contact]
        assert np.all(opposed <= 2 * allowed), "slip not against the traction"
        state = sol.state.ravel()
        assert np.all((state != 0) == contact)
        assert np.max(slip[state == 1], initial=0.0) <= 2 * tol * rho * largest, "slip in the stick area"
        assert np.all((bound - size)[state == 2] <= 2 * tol * largest), "less than the bound in the slip area"
    for force, asked in zip(sol.force, (motion.Fx, motion.Fy), strict=True):
        if asked is not None:
            assert abs(force - asked) <= tol * max(np.sum(bound) * grid.area, abs(asked))
    for found, given, asked in zip(sol.creepage, motion.rigid, (motion.Fx, motion.Fy, None), strict=True):
        assert asked is not None or found == given


def undeformed(scene: vc.Scene, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Undeformed distance at points."""
    if isinstance(scene.surface, vc.SampledDistance):
        return scene.surface.h.ravel()
    return x**2 / (2 * scene.hertz.Rx) + y**2 / (2 * scene.hertz.Ry)


def influence(x, y, sides, bodies, at=None) -> np.ndarray:
    """Displacements (x, y, z, one after the other) at points by unit tractions on rectangles about the points `at`."""
    x0, y0 = at if at is not None else (x, y)
    nu, K, G = bodies.combined_nu, bodies.K, bodies.combined_G
    xx, xy, xz, yy, yz, zz = (np.zeros((x.size, x0.size)) for _ in range(6))
    for sx, sy in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
        X, Y = x[:, None] - x0 + sx * sides[0] / 2, y[:, None] - y0 + sy * sides[1] / 2
        r, sign = np.hypot(X, Y), sx * sy
        with np.errstate(divide="ignore", invalid="ignore"):
            by_y = np.where(X != 0, X * (np.arcsinh(Y / np.abs(X)) + np.log(np.abs(X))), 0.0)  # x ln(y + r)
            by_x = np.where(Y != 0, Y * (np.arcsinh(X / np.abs(Y)) + np.log(np.abs(Y))), 0.0)  # y ln(x + r)
            xz -= sign * K * (Y * np.log(r) + np.where(X != 0, X * np.arctan(Y / X), 0.0))
            yz -= sign * K * (X * np.log(r) + np.where(Y != 0, Y * np.arctan(X / Y), 0.0))
        xx += sign * (by_x + (1 - nu) * by_y)
        yy += sign * (by_y + (1 - nu) * by_x)
        xy -= sign * nu * r
        zz += sign * (1 - nu) * (by_y + by_x)
    return np.block([[xx, xy, xz], [xy, yy, yz], [-xz, -yz, zz]]) / (np.pi * G)
