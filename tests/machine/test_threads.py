"""BLAS has one thread while a scene is solved, and afterwards as many as before."""

from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import varcontact as vc
from varcontact.machine.threads import VARIABLES, one_blas_thread


def counts():
    """Threads of the BLAS libraries, NumPy's and SciPy's; those of solvers may have one only."""
    libraries = [library for library in threadpool_info() if library["user_api"] == "blas"]
    return {
        each["num_threads"] for each in libraries if {"numpy.libs", "scipy.libs"} & set(Path(each["filepath"]).parts)
    }


@pytest.fixture
def two_threads(monkeypatch):
    """As on a machine of two cores, of which no environment variable tells otherwise."""
    for name in VARIABLES:
        monkeypatch.delenv(name, raising=False)
    vc.solve(vc.Scene(bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Ellipse(1.0, 1.0), normal_force=1.0))  # imports
    with threadpool_limits(2, user_api="blas"):
        yield
        assert counts() == {2}


def test_one_thread_while_a_scene_is_solved(rolling, two_threads):
    seen = []
    vc.solve(rolling(), progress=lambda stage: seen.append(counts()))
    assert len(seen) > 2 and seen == [{1}] * len(seen)
    assert counts() == {2}


def test_threads_are_restored_after_an_error_and_between_the_scenes_of_a_scan(rolling, two_threads):
    with pytest.raises(vc.Saturated):
        vc.solve(rolling(motion=vc.Steady(Fx=1.0)))
    assert counts() == {2}
    seen = []
    vc.scan(rolling(), np.array([[0.01, 0.0, 0.0], [0.02, 0.0, 0.0]]), progress=lambda stage: seen.append(counts()))
    assert {1} in seen and counts() == {2}


def test_two_solves_at_once(two_threads):
    """The first to come ends before the second: one thread until both have ended, then as many as before."""
    first, second = one_blas_thread(), one_blas_thread()
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    assert counts() == {1}
    second.__exit__(None, None, None)
    assert counts() == {2}


@pytest.mark.parametrize("name", VARIABLES)
def test_an_environment_variable_has_its_way(two_threads, monkeypatch, name):
    monkeypatch.setenv(name, "2")
    with one_blas_thread():
        assert counts() == {2}
