"""Tradeoff: errors against closed forms, fronts by their definition, the store, the command
line.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import varcontact as vc
from tests.command import run
from tests.plotting.test_pictures import check_readable
from varcontact.solving.discretisation_variants import Way
from varcontact.study.tradeoff import TARGETS, Tradeoff, default_ways

BANK = vc.continuum_values()
MEASURED = Path(__file__).parents[2] / "docs" / "tradeoff.csv"
CARTER = {"line, creepage 0.3": BANK["line, creepage 0.3"]}
WAYS = [Way(cells=n) for n in (4, 8)] + [Way(cells=8, coarser=4, edge="touched")]


@pytest.fixture(scope="module")
def measured():
    return vc.tradeoff(CARTER, WAYS)


def test_errors_are_those_against_the_continuum(measured):
    reference = CARTER["line, creepage 0.3"]
    sol = vc.solve(replace(reference.scene, grid=vc.Grid(nx=16)))
    exact = -0.3 * (1 - 0.7**2)  # Carter
    assert measured.runs["error"][0] == pytest.approx(abs(sol.force[0] - exact) / 0.3, abs=2e-6)
    assert measured.runs["error"].is_monotonic_decreasing
    assert measured.runs["error"][2] < 2e-3
    assert (measured.runs["residual"] < 1e-8).all()


def rows(*points):
    """Made-up measurements: (way, error, seconds) of one scene."""
    known = {
        "scene": "one",
        "kind": "shift",
        "family": "f",
        "cells": 8,
        "outcome": "answered",
        "reason": "",
    }
    return [
        {**known, "way": str(way), "error": error, "processor_seconds": seconds}
        for way, error, seconds in points
    ]


def test_the_front_is_what_nothing_else_beats():
    ways = [Way(cells=n) for n in (2, 4, 6, 8, 10)]
    errors, seconds = [0.2, 0.05, 0.06, 0.004, 0.004], [1e-3, 2e-3, 3e-3, 5e-3, 9e-3]
    found = Tradeoff.of(rows(*zip(ways, errors, seconds, strict=True)), ["one"], ways)
    assert found.front("shift")["way"].tolist() == ["centres 2", "centres 4", "centres 8"]
    advice = found.advice().set_index("target")["way"]
    assert [advice[target] for target in TARGETS[:3]] == ["centres 4", "centres 8", "centres 8"]
    assert pd.isna(advice[0.003])
    assert found.advice(0.03)["way"].tolist() == [advice[0.03]]
    for targets, message in (("a", "targets = 'a'"), ([0.1, -1.0], "targets.*-1.0")):
        with pytest.raises(vc.SceneError, match=message):
            found.advice(targets)


@pytest.mark.long
def test_labels_of_the_picture_do_not_lie_over_each_other():
    check_readable(Tradeoff(pd.DataFrame(), pd.read_csv(MEASURED)).plot())


def test_an_accuracy_is_advised_for_what_it_was_asked_for():
    ways = [Way(accuracy=0.1), Way(cells=8), Way(accuracy=0.03)]
    found = Tradeoff.of(
        rows(*zip(ways, (0.02, 0.025, 0.009), (1e-3, 2e-3, 3e-3), strict=True)), ["one"], ways
    )
    assert found.front("shift")["way"].tolist() == ["accuracy 0.1", "accuracy 0.03"]
    advice = found.advice().set_index("target")["way"]
    assert [advice[target] for target in TARGETS[:2]] == ["accuracy 0.1", "centres 8"]
    assert pd.isna(advice[0.01])


def test_a_way_that_leaves_many_scenes_unanswered_is_not_on_the_front():
    ways = [Way(cells=2), Way(cells=4)]
    made = rows((ways[0], 0.001, 1e-3), (ways[1], 0.01, 2e-3))
    made += [
        {**made[0], "scene": "two", "outcome": "refused", "error": np.nan},
        {**made[1], "scene": "two"},
    ]
    found = Tradeoff.of(made, ["one", "two"], ways)
    assert found.front("shift")["way"].tolist() == ["centres 4"]
    answered = found.classes.set_index("way")
    assert answered.loc["centres 2", "answers"] == 1 and answered.loc["centres 2", "scenes"] == 2


def test_what_a_way_does_not_serve_is_recorded():
    found = vc.tradeoff({"shift along": BANK["shift along"]}, ["fastsim-weighted"], cells=[8])
    assert found.runs["outcome"].tolist() == ["refused"]
    assert "steady rolling" in found.runs["reason"][0]
    assert len(found.advice()) == len(found.front("shift")) == 0
    # the report says why, in place of an empty table
    assert found.report().startswith("shift\n  fastsim-weighted 8: refused: ")
    assert "steady rolling" in found.report()


def test_the_store_goes_on(tmp_path):
    store, told = tmp_path / "front.csv", []
    first = vc.tradeoff(CARTER, WAYS[:2], store=store)
    again = vc.tradeoff(CARTER, WAYS, store=store, progress=told.append)
    assert len(pd.read_csv(store)) == 3
    for name in ("error", "seconds"):
        assert again.runs[name][:2].tolist() == pytest.approx(first.runs[name].tolist(), rel=1e-12)
    other = tmp_path / "other.csv"
    other.write_text("a,b\n1,2\n")
    with pytest.raises(vc.SceneError, match="is not a table of an earlier tradeoff"):
        vc.tradeoff(CARTER, WAYS, store=other)


@pytest.mark.parametrize(("scenes", "methods", "message"), [
    ({"one": CARTER["line, creepage 0.3"].scene}, None, r"scenes\['one'\].*must be one of those"),
    (CARTER, ["fastsimm"], "methods"),
    (CARTER, "fastsim", "a list of names or ways"),
    (CARTER, [], "at least one name"),
    (CARTER, 3, "methods = 3 .* a list of names or ways"),
    (["a"], None, "a dict of names and references"),
    (CARTER, [Way(cells=8, options=(("certify", None),)), Way(cells=8)], "'centres 8' .* one way of this name"),
])  # fmt: skip
def test_bad_arguments_are_refused(scenes, methods, message):
    with pytest.raises(vc.SceneError, match=message):
        vc.tradeoff(scenes, methods)


def test_the_default_ways_have_names_of_their_own():
    ways = default_ways()
    assert len({str(way) for way in ways}) == len(ways)
    families = {"centres", "touched, extrapolated", "softened, second-order", "fastsim", "accuracy"}
    assert families <= {way.family for way in ways}


@pytest.mark.long
def test_accuracies_stand_beside_grids():
    found = vc.tradeoff(CARTER, ["auto", "accuracy"], cells=[4])
    assert found.runs["way"].tolist() == [
        "centres 4",
        *(f"accuracy {target:g}" for target in TARGETS),
    ]
    on_demand = found.runs[found.runs["family"] == "accuracy"]
    assert (on_demand["error"].to_numpy() < TARGETS).all() and (on_demand["memory"] > 1000).all()


@pytest.mark.long
def test_the_command(tmp_path):
    arguments = (
        "tradeoff",
        "--class",
        "shift",
        "--methods",
        "auto",
        "--cells",
        "4",
        "--json",
        "--plot",
        "front.png",
    )
    done = run(*arguments, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    printed = json.loads(done.stdout)
    assert printed["classes"][0]["way"] == "centres 4" and printed["classes"][0]["scenes"] == 9
    assert (tmp_path / "front.png").stat().st_size > 1000
    for bad, word in (
        (("--class", "shfit"), "class"),
        (("--cells", "a"), "cells[0] = 'a' is not allowed: must be a whole number"),
    ):
        refused = run("tradeoff", *bad, folder=tmp_path)
        assert refused.returncode == 2 and word in refused.stderr


def test_a_theory_without_a_moment_has_no_error():
    name = next(
        name
        for name, each in BANK.items()
        if each.kind == "steady, circular" and "Mz" in each.units
    )
    way = Way(cells=8, options=(("tangential", "polach"),))
    found = vc.tradeoff({name: BANK[name]}, [way, Way(cells=8)])
    assert found.runs["outcome"].tolist() == ["refused", "answered"]
    assert found.runs["reason"][0] == "no Mz, which the error counts"
    assert found.classes["way"].tolist() == ["centres 8"]


def test_costs_are_there(measured):
    for name in ("seconds", "processor_seconds", "repeat_seconds", "setup_seconds", "memory"):
        assert (measured.runs[name] >= 0).all(), name
    assert (measured.runs["memory"] > 1000).all()
