"""Parts of the solver of many problems at once; its answers are those of single ones, see
tests/study/test_many.py.
"""

import numpy as np

from varcontact.solvers.batched.pool import inverse_of
from varcontact.solvers.batched.transforms import transforms

NY, NX = 5, 7


def test_the_inverse_of_a_symbol():
    """Of the matrices xx, -i xy; -i xy, yy with a shift of the diagonal."""
    symbol = np.random.default_rng(1).uniform(1.0, 2.0, (3, 4, 6))
    real, imaginary = inverse_of(symbol, np.full((4, 6), 0.5))
    np.testing.assert_array_equal(imaginary[:, :, 0], -imaginary[:, :, 1])
    xx, xy, yy = symbol + np.array([0.5, 0.0, 0.5])[:, None, None]
    matrix = np.array([[xx, -1j * xy], [-1j * xy, yy]])
    off = real[2, :, 0] + 1j * imaginary[2, :, 1]
    inverse = np.array([[real[0, :, 0], off], [off, real[1, :, 0]]])
    product = np.einsum("ijsx,jksx->iksx", matrix, inverse)
    expected = np.eye(2)[:, :, None, None] * np.ones((4, 6))
    np.testing.assert_allclose(product, expected, atol=1e-6)
