"""Contact problems from files, with NumPy and SciPy alone; as QPs and as CVXPY problems.

A file `data/NAME.npz` has

    kernel      (c, c, 2 ny - 1, 2 nx - 1) influence of a traction, by the distance of elements
    elements    (n, 2) row and column of each element on the grid of ny by nx
    shift       (c, n) W: rigid shifts of a tangential, undeformed distances of a normal problem
    bound       (n,) g: traction bounds of a tangential problem
    force       (c,) prescribed sums of the tractions; NaN: the rigid shift is prescribed
    symmetric   whether M is
    p, rigid    (c, n) and (c,) the solution, and the rigid shift where a force is prescribed
    residual    of this solution

for: find p, and r where a force is prescribed, with ``E = M p + W + r``,

    normal       p >= 0,  E >= 0,  p E = 0
    tangential   |p_i| <= g_i,  p_i = -g_i E_i/|E_i| where E_i is not 0

M is dense; the mean of its diagonal, the own influence of an element, is 1.
"""

from pathlib import Path

import numpy as np

DATA = Path(__file__).parent / "data"


def names(kind=None):
    """Names of the problems: "normal", "tangential", or all."""
    paths = sorted(DATA.glob("*.npz"))
    if kind is not None:
        tangential = kind == "tangential"
        paths = [path for path in paths if ("bound" in load(path.stem)) == tangential]
    return [path.stem for path in paths]


def load(name):
    """The arrays of a problem, by name."""
    with np.load(DATA / f"{name}.npz") as file:
        return {key: file[key] for key in file.files}


def matrix(problem):
    """M (c n, c n), all components along x first."""
    kernel = problem["kernel"]
    components, _, height, width = kernel.shape
    row, column = problem["elements"].T
    down = row[:, None] - row[None, :] + height // 2
    right = column[:, None] - column[None, :] + width // 2
    size = components * len(row)
    blocks = kernel[:, :, down, right]
    return blocks.transpose(0, 2, 1, 3).reshape(size, size)


def residual(problem, p, rigid):
    """Largest ``|p - Proj(p - E)|``, relative to the largest traction; and errors of forces."""
    shift = problem["shift"] + np.reshape(rigid, (-1, 1))
    shift = shift + (matrix(problem) @ p.ravel()).reshape(p.shape)
    trial = p - shift
    if "bound" in problem:
        size = np.linalg.norm(trial, axis=0)
        image = trial * (problem["bound"] / np.maximum(size, problem["bound"]))
    else:
        image = np.maximum(trial, 0.0)
    largest = np.linalg.norm(p, axis=0).max()
    error = np.linalg.norm(p - image, axis=0).max() / largest
    missing = np.abs(p.sum(axis=1) - problem["force"]) / (largest * np.sqrt(p.shape[1]))
    return float(max(error, np.nanmax(missing, initial=0.0)))


def quadratic_program(problem):
    """(P, q, G, h, A, b, lb, ub) of a symmetric normal problem, as qpsolvers has them."""
    q = problem["shift"][0]
    lower = np.zeros_like(q)
    if np.isnan(problem["force"][0]):
        return matrix(problem), q, None, None, None, None, lower, None
    total = np.ones((1, q.size))
    return matrix(problem), q, None, None, total, problem["force"], lower, None


def conic_program(problem):
    """A ``cvxpy.Problem`` with the variable "p": energy where M is symmetric, else the gap."""
    import cvxpy as cp

    M = matrix(problem)
    W = problem["shift"]
    components, n = W.shape
    p = cp.Variable((components, n), name="p")
    field = cp.reshape(p, (components * n,), order="C")
    quadratic = cp.quad_form(field, cp.psd_wrap((M + M.T) / 2))
    sums = [i for i in range(components) if not np.isnan(problem["force"][i])]
    constraints = [cp.sum(p[i]) == problem["force"][i] for i in sums]
    if "bound" in problem:
        constraints.append(cp.norm(p, axis=0) <= problem["bound"])
    else:
        constraints.append(p >= 0)
    if problem["symmetric"]:
        return cp.Problem(cp.Minimize(quadratic / 2 + cp.sum(cp.multiply(W, p))), constraints)
    # without an energy: the gap p'E + g |E| is zero at the solution, and positive elsewhere
    rigid = cp.Variable(components, name="rigid")
    constraints += [rigid[i] == 0 for i in range(components) if i not in sums]
    columns = [rigid[i] * np.ones(n) for i in range(components)]
    shift = cp.reshape(M @ field, (components, n), order="C") + W + cp.vstack(columns)
    gap = quadratic + cp.sum(cp.multiply(W, p))
    gap += sum(rigid[i] * problem["force"][i] for i in sums)
    if "bound" in problem:
        gap += problem["bound"] @ cp.norm(shift, axis=0)
    else:
        constraints.append(shift >= 0)
    return cp.Problem(cp.Minimize(gap), constraints)
