"""Types of results, names of methods, names of arguments."""

import importlib

import pytest

import varcontact as vc
from tests import typed
from tests.scenes import make_scene, refused
from varcontact.solving.methods import METHODS
from varcontact.solving.selection import PRESETS


def test_results_are_of_the_types_that_are_promised():
    assert all(isinstance(sol, vc.Solution) for sol in typed.solutions())
    assert isinstance(typed.history(), vc.History)


def test_names_for_type_checkers_are_those_of_the_methods():
    assert METHODS == tuple(PRESETS)


def test_only_public_names_are_listed():
    assert set(dir(vc)) == {*vc.__all__, "theories"}


def test_every_public_name_is_found_and_no_other():
    """Most are imported when they are first used."""
    for name in [*vc.__all__, "theories"]:
        assert getattr(importlib.import_module("varcontact"), name) is not None
    assert vc.solve is importlib.import_module("varcontact.solving.solve").solve
    assert vc.theories is importlib.import_module("varcontact.theories")
    misspelt = "slove"
    refused(lambda: getattr(vc, misspelt), match="slove", error=AttributeError)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: vc.Steady(cksi=1e-3), "Steady has no cksi: write vx, the longitudinal creepage"),
        (lambda: vc.Steady(spinn=1.0), "Steady has no spinn (did you mean spin?)"),
        (lambda: vc.Shift(vx=1e-3), "Shift has no vx: write ux, or Steady for a creepage"),
        (lambda: vc.Bodies(E=2.1e11, nu=0.3), "Bodies has no E: write Bodies.from_young(E, nu)"),
        (lambda: vc.Grid(mx=24, my=24), "Grid has no mx: write nx"),
        (
            lambda: vc.Scene(bodies=typed.BODIES, surface=typed.SURFACE, FN=1.0),
            "Scene has no FN: write normal_force",
        ),
        (lambda: vc.Grid(6, 6, zzz=1), "Grid has no zzz; it has nx, ny, dx"),
    ],
)
def test_a_wrong_name_is_told_the_right_one(make, words):
    refused(make, words=words)


def test_a_flat_list_of_creepages_is_told_what_rows_are():
    scene = make_scene(typed.SURFACE, 1e-3, vc.Steady(), vc.Grid(6, 6), bodies=typed.BODIES)
    with pytest.raises(vc.SceneError, match=r"a row of vx, vy, spin for each solution"):
        vc.scan(scene, [1e-3, 2e-3])
