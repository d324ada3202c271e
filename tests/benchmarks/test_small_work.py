"""What is kept between solves never answers for another scene."""

import pytest

from tests.benchmarks.small_work import answers_that_differ


@pytest.mark.long
def test_scenes_among_others_have_the_answers_of_a_fresh_process():
    """Two here; the benchmark has two hundred."""
    assert answers_that_differ(2) == []
