"""The memory that solvers need."""

from __future__ import annotations

ONE_BLOCK, TWO_BLOCKS = "complementary", "gap"

PEAK_MATRICES: dict[tuple[str, str], float] = {
    ("clarabel", ONE_BLOCK): 11.0,
    ("clarabel", TWO_BLOCKS): 34.0,
    ("scs", ONE_BLOCK): 14.0,
    ("scs", TWO_BLOCKS): 42.0,
    ("osqp", ONE_BLOCK): 8.0,
    ("norm", ""): 4.0,
    ("norm-single", ""): 4.0,
    ("tang", ""): 6.0,
    ("tang-exact", ""): 6.0,
    ("tang-safeguarded", ""): 6.0,
    ("no-slip", ""): 6.0,
}
"""Peak memory of methods, in dense matrices of their unknowns (8 n^2 bytes), as measured: docs/methods.md.

Programs by complementary energy have one dense block; those by the gap or by potential energy more.
"""

PEAK_BYTES: dict[str, float] = {"newton": 1000.0}
"""Peak memory of methods without a matrix, in bytes by unknown, as measured."""

OTHERS = {ONE_BLOCK: 25.0, TWO_BLOCKS: 60.0}
"""The same of solvers behind qpsolvers and CVXPY."""

CVXPY_TWO_BLOCKS = 5e-3
"""Bytes by n^4 that CVXPY takes to compile the gap program: more than any solver does."""

CERTIFICATE_MATRICES = 4.0
"""The same of the certificate, which factors the symmetric part."""


def peak(method: str, formulation: str, unknowns: int) -> float:
    """Bytes that a method takes at its peak, with all its matrices; influence numbers by offset are not among them.

    Parameters
    ----------
    method : str
        Of the normal or of the tangential problem.
    formulation : str
        Of the program, where it states one.
    unknowns : int
        Pressures or traction components: the order of the dense matrix.

    Examples
    --------
    >>> print(f"{peak('clarabel', 'gap', 2 * 812) / 2**20:.0f} MiB")
    684 MiB
    """
    if method in PEAK_BYTES:
        return PEAK_BYTES[method] * unknowns
    blocks = TWO_BLOCKS if formulation in ("gap", "potential") else ONE_BLOCK
    known = PEAK_MATRICES.get((method, ""), PEAK_MATRICES.get((method, blocks), OTHERS[blocks]))
    compiled = CVXPY_TWO_BLOCKS * float(unknowns) ** 4 if method.startswith("cvxpy:") and blocks == TWO_BLOCKS else 0.0
    return max(known * 8.0 * unknowns**2, compiled)
