"""Claims of the paper that do not depend on the machine."""

from tests.benchmarks.claims import book_entries, norm_failures, two_coefficients
from tests.benchmarks.interop import theory_errors


def test_two_coefficients_of_friction_change_little():
    """The more, the larger the static one; by FASTSIM more than by the exact theory."""
    found = two_coefficients(cells=6, points=2)
    for low, high in found.values():
        assert 0 <= low < high < 0.08
    assert max(found["exact theory"]) < max(found["FASTSIM"])


def test_whole_sets_of_elements_never_fail():
    failures, most = norm_failures(40)
    assert failures == 0
    assert most <= 12


def test_the_bound_of_hertz_is_no_worse_in_fastsim():
    """The paper has it that it gives bad results; the largest error is half of the parabolic
    one's.
    """
    found = theory_errors()
    assert 0.1 < found["fastsim"][:, 0].max() < 0.15
    assert found["fastsim-elliptic"][:, 0].max() < 0.07


def test_the_book_has_fewer_entries_than_the_papers():
    assert book_entries() == 27_405 < 115_000
