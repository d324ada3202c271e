"""The memory that solvers need."""

from __future__ import annotations

ONE_BLOCK, TWO_BLOCKS = "complementary", "gap"

PEAK_MATRICES: dict[tuple[str, str], float] = {
    ("clarabel", ONE_BLOCK): 9.8,
    ("clarabel", TWO_BLOCKS): 27.0,
    ("scs", ONE_BLOCK): 13.0,
    ("scs", TWO_BLOCKS): 40.0,
    ("osqp", ONE_BLOCK): 6.2,
    ("norm", ""): 1.7,
    ("norm-single", ""): 1.7,
    ("tang", ""): 4.2,
    ("tang-exact", ""): 4.2,
    ("tang-safeguarded", ""): 4.2,
    ("no-slip", ""): 4.2,
}
"""Peak memory of methods, in dense matrices of their unknowns (8 n^2 bytes), as measured: docs/measurements.md.

Programs by complementary energy have one dense block; those by the gap or by potential energy more.
"""

KEPT_FACTORS = 2.0
"""Dense factors of the contact that NORM leaves for the next pass."""

NORMAL_BYTES, TANGENTIAL_BYTES = {"newton": 290.0}, {"newton": 550.0}
"""Peak memory of methods without a matrix, in bytes by unknown, as measured."""

FIELD_BYTES, THEORY_BYTES = 170.0, 200.0
"""Bytes by element of the grid that fields take, with those of a solution; and what an approximate theory adds."""

OTHERS = {ONE_BLOCK: 25.0, TWO_BLOCKS: 60.0}
"""The same of solvers behind qpsolvers and CVXPY."""

CVXPY_TWO_BLOCKS = 5e-3
"""Bytes by n^4 that CVXPY takes to compile the gap program: more than any solver does."""

CERTIFICATE_MATRICES = 3.6
"""The same of the certificate, which factors the symmetric part."""


def peak(method: str, formulation: str, unknowns: int, without_matrix: dict[str, float] = TANGENTIAL_BYTES) -> float:
    """Bytes that a method takes at its peak, with all its matrices; influence numbers by offset are not among them.

    Parameters
    ----------
    method : str
        Of the normal or of the tangential problem.
    formulation : str
        Of the program, where it states one.
    unknowns : int
        Pressures or traction components: the order of the dense matrix.
    without_matrix : dict
        What methods without a matrix take by unknown: `NORMAL_BYTES` or `TANGENTIAL_BYTES`.

    Examples
    --------
    >>> print(f"{peak('clarabel', 'gap', 2 * 812) / 2**20:.0f} MiB")
    543 MiB
    """
    if method in without_matrix:
        return without_matrix[method] * unknowns
    blocks = TWO_BLOCKS if formulation in ("gap", "potential") else ONE_BLOCK
    known = PEAK_MATRICES.get((method, ""), PEAK_MATRICES.get((method, blocks), OTHERS[blocks]))
    compiled = CVXPY_TWO_BLOCKS * float(unknowns) ** 4 if method.startswith("cvxpy:") and blocks == TWO_BLOCKS else 0.0
    return max(known * 8.0 * unknowns**2, compiled)
