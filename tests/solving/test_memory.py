"""What does not fit into memory is told before any work, and what is told is what is taken."""

import gc
import subprocess
import sys
import weakref

import numpy as np
import pytest

import varcontact as vc
from tests.command import run, scene_file
from varcontact.elasticity.operators import GridOperator

MEASURE = """
import re

import psutil

import varcontact as vc
from varcontact.solving.pipeline import peak

def scene(n):
    return vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28), normal_force=1.0, grid=vc.Grid(nx=n, ny=n), surface=vc.Ellipse(a=1.2, b=0.9),
        friction=0.3, motion=vc.Steady(vx=0.04, vy=-0.02, spin=0.05))

vc.solve(scene(6), tangential="{tangential}")  # imports
before = psutil.Process().memory_info().rss
sol = vc.solve(scene({cells}), tangential="{tangential}")
most = 1024 * int(re.search(r"VmHWM:\\s*([0-9]+) kB", open("/proc/self/status").read())[1])
said = peak(sol.plan.solver_of("tangential"), sol.plan.formulation, 2 * sol.elements["contact"])
print((most - before) / said)
"""


@pytest.mark.long
@pytest.mark.parametrize(
    ("tangential", "cells"), [("tang-safeguarded", 25), ("clarabel", 20), ("newton", 240)]
)
def test_peak_memory_is_as_estimated(tangential, cells):
    """In a process of its own, to a third."""
    code = MEASURE.format(tangential=tangential, cells=cells)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert 0.66 < float(done.stdout) < 1.5


SCENE = scene_file("vx = 0.04", (1.2, 0.9), 700)


def test_a_plan_that_does_not_fit_says_so_and_fails(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE)
    planned = run("plan", "scene.toml", "--tangential", "clarabel", folder=tmp_path)
    solved = run("solve", "scene.toml", "--tangential", "clarabel", folder=tmp_path)
    assert planned.returncode == solved.returncode == 2
    assert "does not fit: " in planned.stdout and "are available" in planned.stdout
    assert solved.stdout == ""
    for done in (planned, solved):
        assert done.stderr.startswith("varcontact: the tangential problem needs about ")
        assert done.stderr.endswith("a grid with fewer elements would fit\n")
    fits = run("plan", "scene.toml", "--tangential", "newton", folder=tmp_path)
    assert (fits.returncode, fits.stderr) == (0, "")
    assert "not fit" not in fits.stdout


@pytest.mark.parametrize("tangential", ["tang", "clarabel"])
def test_what_is_known_not_to_fit_is_refused_before_any_table_is_made(rolling, built, tangential):
    with pytest.raises(vc.TooLarge, match="the tangential problem needs about"):
        vc.solve(rolling(grid=vc.Grid(nx=700, ny=700)), tangential=tangential)
    assert not built


def test_a_study_is_refused_before_its_first_solve(rolling, built):
    surface, solved = vc.Paraboloids(1.0, 0.8), []
    scene = rolling(surface=surface, normal_force=1e-3)
    with pytest.raises(
        vc.TooLarge, match=r"cells = 20000: tang-safeguarded needs about .* leave these cells out"
    ):
        vc.converge(scene, [4, 20000], progress=solved.append)
    with pytest.raises(vc.TooLarge, match="cells = 400: clarabel needs about"):
        vc.converge(scene, [4, 400], ["newton", "clarabel"], progress=solved.append)
    with pytest.raises(
        vc.SceneError, match="offsets = 1000000000 is not allowed: must be a whole number from 1 to"
    ):
        vc.converge(scene, [4, 6, 8], offsets=10**9)
    assert not solved
    assert not built


def test_histories_without_end():
    for steps in (10**20, 1_000_001):
        with pytest.raises(
            vc.SceneError,
            match=r"motion.steps = .*from 1 to 1000000; a longer history goes on from",
        ):
            vc.Transient(steps=steps)
    with pytest.raises(vc.SceneError, match=r"motion\.steps = 1000.* a whole number"):
        vc.Transient(steps=10**400)


def test_a_history_that_does_not_fit_into_memory_is_sent_to_a_file(rolling, built):
    """And is refused before its steps are looked at one by one."""
    motion, grid = vc.Transient(steps=10**5, vx=0.01), vc.Grid(nx=900, ny=900)
    scene = rolling(surface=vc.Paraboloids(1.0, 0.8), motion=motion, grid=grid)
    with pytest.raises(
        vc.TooLarge, match=r"the history in memory needs about .* with store = a file"
    ):
        vc.solve(scene)
    assert not built


def test_matrices_go_with_the_solve(rolling, monkeypatch):
    """They and their operators refer to each other: they must not wait until Python looks for
    cycles.
    """
    matrices, assemble = [], GridOperator.dense

    def dense(self, elements, loaded=None):
        matrix = assemble(self, elements, loaded)
        matrices.append(weakref.ref(matrix))
        return matrix

    monkeypatch.setattr(GridOperator, "dense", dense)
    unlike = vc.Bodies(G=(2.0, 0.7), nu=(0.25, 0.4))
    history = vc.Transient(steps=2, vx=0.05)
    gc.collect()
    gc.disable()
    try:
        sol = vc.solve(rolling(normal_force=1.0), normal="norm")
        vc.certify(sol.scene, sol.traction)
        vc.solve(rolling(bodies=unlike, friction=0.5))
        vc.solve(rolling(surface=vc.Paraboloids(1.0, 0.8), motion=history))
        list(vc.scan(rolling(), np.array([[0.01, 0.0, 0.0], [0.02, 0.0, 0.0]])))
        assert len(matrices) > 5
        assert not [matrix for matrix in matrices if matrix() is not None]
    finally:
        gc.enable()
