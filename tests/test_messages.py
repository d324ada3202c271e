"""Every message that is a sentence of its own, as a whole: what is wrong, and what to do instead."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from varcontact import reference
from varcontact.energy import posed
from varcontact.theories import fastsim_on_grid, linear_creepage

SCENE = vc.Scene(
    bodies=vc.Bodies(G=1.0, nu=0.3),
    surface=vc.Paraboloids(1.0, 1.0),
    normal_force=1.0,
    friction=0.3,
    motion=vc.Steady(vx=0.01),
    grid=vc.Grid(nx=6, ny=6),
)
UNLIKE = vc.Bodies(G=(1.0, 3.0), nu=(0.3, 0.2))
BALL = vc.Paraboloids(1.0, 1.0)
LATTICE = {"nx": 4, "ny": 3, "dx": 0.5, "dy": 0.5, "x0": -1.0, "y0": -0.75}
SQUARE = vc.Grid(nx=3, ny=3, dx=1.0, dy=1.0, x0=-1.5, y0=-1.5)
BOWL = np.array([[0.5, 0.2, 0.5], [0.2, 0.0, 0.2], [0.5, 0.2, 0.5]])
AXIS = np.array([-1.0, 0.0, 1.0])
FALLING = vc.ExponentialFalling(0.3, 0.2, half_velocity=0.01)
CONTACT = reference.line_contact(1.0, vc.Bodies(G=1.0, nu=0.3), a=0.1)
TOML = """normal_force = 1.0
friction = 0.3
bodies = {G = 1.0, nu = 0.3}
surface = {kind = "paraboloids", Rx = 1.0, Ry = 1.0}
motion = {kind = "steady", vx = 0.01}
"""


def scene(**changes):
    return vc.Scene(**{**{name: getattr(SCENE, name) for name in SCENE.__dataclass_fields__}, **changes})


def sampled(h=BOWL, grid=SQUARE, **changes):
    return scene(surface=vc.SampledDistance(h), grid=grid, **changes)


def solved(motion=SCENE.motion, **methods):
    return vc.solve(replace(SCENE, motion=motion), **methods)


def read(folder, old, new):
    (folder / "scene.toml").write_text(TOML.replace(old, new))
    return vc.read_scene(folder / "scene.toml")


MESSAGES = [
    (lambda folder: vc.Grid(nx=3, ny=3, dx=1.0), "grid.dy is missing: dx, dy, x0, y0 come together"),
    (
        lambda folder: vc.Grid(nx=3, dy=1.0),
        "grid.dy = 1.0 must be left out: without ny it is line contact, which has no rows",
    ),
    (
        lambda folder: vc.Grid(nx=3, ny=3).x,
        "grid = Grid(nx=3, ny=3, dx=None, dy=None, x0=None, y0=None, margin=1, edge='centres') is "
        "not allowed: must be explicit, with dx, dy, x0 and y0: only such a grid has positions",
    ),
    (
        lambda folder: vc.Steady(vx=0.1, Fx=3.0),
        "motion.Fx, motion.vx = (3.0, 0.1) is not allowed: must be one of the two only",
    ),
    (
        lambda folder: vc.Transient(steps=3, vx=[1e-3, 2e-3]),
        "motion.vx = '2 values' is not allowed: must be one number, or one for each of the 3 steps",
    ),
    (
        lambda folder: vc.Transient(steps=3, Fx=[0.1, None, 0.1], vx=[0, 1e-3, 1e-3]),
        "motion.Fx[2], motion.vx[2] = (0.1, 0.001) is not allowed: must be one of the two only",
    ),
    (
        lambda folder: vc.Transient(steps=2, surface=[BALL]),
        "motion.surface = [Paraboloids(Rx=1.0, Ry=1.0)] is not allowed: must be one surface for each of the 2 steps",
    ),
    (
        lambda folder: vc.Transient(steps=2, surface=[BALL, vc.Cylinders(1.0)]),
        "motion.surface[1] = Cylinders(R=1.0, reference_depth=None) is not allowed: must be line "
        "contact in all steps or in none",
    ),
    (
        lambda folder: vc.Paraboloids.from_bodies(Rx=(1.0, -0.5), Ry=(1.0, 1.0)),
        "surface.Rx = (1.0, -0.5) is not allowed: must be a pair with a positive sum of curvatures 1/R",
    ),
    (
        lambda folder: vc.SampledDistance(h=np.zeros((3, 3)), x=[0.0, 1.0, 2.0]),
        "surface.x, surface.y = ([0.0, 1.0, 2.0], None) is not allowed: must be given both or neither",
    ),
    (
        lambda folder: vc.SampledDistance(h=np.zeros((3, 4)), x=[0.0, 1.0, 2.0], y=[0.0, 1.0, 2.0]),
        "surface.x = array([0., 1., 2.]) is not allowed: must be 4 ascending coordinates, one for "
        "each column of h (at least 2)",
    ),
    (
        lambda folder: vc.SampledDistance(h=0.0),
        "surface.h has shape (); it must be a 2-dimensional array of finite numbers",
    ),
    (
        lambda folder: vc.SampledDistance(np.ones((3, 3)), reference_depth=3.0),
        "surface.reference_depth = 3.0 must be left out: only line contact has one",
    ),
    (
        lambda folder: vc.SampledDistance(np.zeros((2, 2)), [0.0, 1.0], [0.0, 1.0]).distance(vc.Grid(**LATTICE)),
        "grid = (-1.0, 1.0, -0.75, 0.75) is not allowed: must be within the samples: left, right, "
        "bottom, top = (0.0, 1.0, 0.0, 1.0)",
    ),
    (lambda folder: scene(normal_force=None), "neither normal_force nor approach is given: give one of them"),
    (lambda folder: scene(approach=1e-4), "normal_force and approach are both given: give one of them"),
    (
        lambda folder: scene(motion=vc.Transient(steps=2, dq=0.1, normal_force=[1.0, None]), normal_force=None),
        "step 1 has no load: give motion.normal_force[1] or motion.approach[1]",
    ),
    (
        lambda folder: scene(motion=vc.Transient(steps=2, dq=0.1, normal_force=[1.0, 1.0], approach=[None, 0.1])),
        "motion.normal_force[1] and motion.approach[1] are both given: give one of them",
    ),
    (
        lambda folder: scene(
            surface=vc.Ellipse(1.0, 1.0), normal_force=None, motion=vc.Transient(steps=1, dq=0.1, normal_force=1.0)
        ),
        "surface = Ellipse(a=1.0, b=1.0) is not allowed: must be Paraboloids, or an Ellipse with "
        "the scene's own normal_force",
    ),
    (
        lambda folder: scene(
            surface=vc.SampledDistance(np.ones((3, 4))), grid=vc.Grid(**LATTICE), normal_force=None, approach=0.5
        ),
        "approach = 0.5 gives no contact: it must exceed the least undeformed distance, 1",
    ),
    (
        lambda folder: scene(motion=vc.Transient(steps=1, dq=0.1, surface=[vc.Cylinders(1.0)])),
        "motion.surface = Cylinders(R=1.0, reference_depth=None) is not allowed: must be as the "
        "scene's surface: line contact with the same reference_depth, or none",
    ),
    (lambda folder: scene(friction=None), "friction is missing: a motion needs a number, inf, a law, or an array"),
    (
        lambda folder: scene(friction=FALLING, motion=vc.Transient(steps=1, dq=0.0)),
        "friction = ExponentialFalling(static=0.3, kinetic=0.2, memory_distance= ... , "
        "velocity=1.0) is not allowed: must be StaticKinetic, which needs no slip velocity: step 0 "
        "does not roll (motion.dq = 0)",
    ),
    (
        lambda folder: scene(friction=np.ones((3, 4))),
        "grid = Grid(nx=6, ny=6, dx=None, dy=None, x0=None, y0=None, margin=1, edge='centres') is "
        "not allowed: must be explicit (nx, ny, dx, dy, x0, y0), as friction is given on it",
    ),
    (
        lambda folder: scene(friction=np.ones((4, 3)), grid=vc.Grid(**LATTICE)),
        "friction has shape (4, 3); it must be of the grid's shape (ny, nx) = (3, 4)",
    ),
    (lambda folder: scene(grid=vc.Grid(nx=8)), "grid.ny is missing: only line contact has no rows"),
    (
        lambda folder: scene(surface=vc.Cylinders(1.0), grid=vc.Grid(nx=10, ny=10)),
        "grid.ny = 10 must be left out in line contact",
    ),
    (
        lambda folder: read(folder, "friction =", "frictoin ="),
        "frictoin: there is no such key (did you mean friction?)",
    ),
    (
        lambda folder: read(folder, "friction =", "xyz ="),
        "xyz: there is no such key; there are bodies, surface, normal_force, approach, friction, "
        "third_body, thermal, motion, grid, units",
    ),
    (lambda folder: read(folder, "bodies = {G = 1.0, nu = 0.3}", ""), "bodies is missing: add a table [bodies]"),
    (lambda folder: read(folder, ", nu = 0.3", ""), "bodies.nu is missing"),
    (
        lambda folder: vc.read_scene(folder / "none.toml"),
        "scene file '{folder}/none.toml' cannot be read (No such file or directory)",
    ),
    (
        lambda folder: vc.plan(scene(), normal="tang"),
        'normal = "tang": it solves the tangential problem; use "norm" or "clarabel"',
    ),
    (
        lambda folder: vc.plan(scene(bodies=UNLIKE), normal="hertz"),
        'Hertz\'s pressure ignores tangential tractions; with K = 0.075 and friction use "norm" or "clarabel"',
    ),
    (
        lambda folder: vc.plan(sampled(), normal="hertz"),
        'Hertz\'s pressure is for paraboloids, ellipses and cylinders; with sampled distances use "norm" or "clarabel"',
    ),
    (
        lambda folder: vc.plan(
            scene(bodies=vc.Bodies(G=(1.0, 3.0), nu=(0.3, 0.2)), grid=vc.Grid(nx=8, ny=8, edge="touched"))
        ),
        'grid.edge = "touched" is for a pressure that tractions do not change, and the bodies are unlike '
        '(K = 0.075); use "centres"',
    ),
    (
        lambda folder: vc.plan(sampled(grid=replace(SQUARE, edge="touched"))),
        'grid.edge = "touched" needs distances on parts of the elements, and samples without coordinates have none; '
        'give surface.x and surface.y, or use "centres"',
    ),
    (
        lambda folder: vc.plan(scene(), tangential="osqp"),
        'tangential = "osqp": it solves QPs, and Coulomb\'s disks are second-order cones; use one of '
        "tang, tang-exact, tang-safeguarded, newton, clarabel, scs, cvxpy:CLARABEL, cvxpy:SCS, or a "
        "theory",
    ),
    (
        lambda folder: vc.plan(scene(), tangential="norm"),
        'tangential = "norm": it is for normal problems; use one of tang, tang-exact, '
        "tang-safeguarded, newton, clarabel, scs, cvxpy:CLARABEL, cvxpy:SCS, or a theory",
    ),
    (
        lambda folder: vc.plan(scene(bodies=UNLIKE), tangential="fastsim"),
        'tangential = "fastsim": it is for quasi-identical bodies (K = 0), and K is 0.075; use another method',
    ),
    (
        lambda folder: vc.plan(scene(motion=vc.Steady(spin=0.1)), tangential="vermeulen-johnson"),
        'tangential = "vermeulen-johnson": it is for rolling without spin, and spin is 0.1; use another method',
    ),
    (
        lambda folder: vc.plan(scene(), formulation="potential"),
        'steady rolling has no energy formulation; use "gap" or "marching"',
    ),
    (
        lambda folder: vc.plan(scene(motion=vc.Shift(ux=0.1)), formulation="marching"),
        '"marching" is for steady rolling only; use "complementary", "potential" or "gap"',
    ),
    (
        lambda folder: vc.plan(scene(motion=None), normal="clarabel", formulation="gap"),
        'formulation = "gap": only the normal problem is a program here; use "complementary" or "potential"',
    ),
    (
        lambda folder: vc.plan(scene(), tangential="tang", formulation="gap"),
        'formulation = "gap": tang does not solve a program; use "auto" or "marching"',
    ),
    (
        lambda folder: vc.plan(scene(), tangential="fastsim", formulation="gap"),
        'formulation = "gap": no program is solved here; use "auto"',
    ),
    (
        lambda folder: vc.plan(scene(), "clarabel", method="kalker"),
        'normal = "clarabel" does not belong to method = "kalker", which takes norm; with method = '
        '"auto" any solver may be named',
    ),
    (
        lambda folder: vc.plan(scene(), tangential="tang", method="convex"),
        'tangential = "tang" does not belong to method = "convex", which takes a solver of programs, '
        'such as clarabel or scs; with method = "auto" any solver may be named',
    ),
    (
        lambda folder: vc.plan(scene(motion=vc.TimeStep(dq=0.1))),
        "motion: a TimeStep continues from the step before it; give the history as a Transient",
    ),
    (
        lambda folder: vc.plan(scene(surface=vc.Cylinders(1.0), motion=vc.Shift(ux=0.1))),
        "grid.ny = 6 must be left out in line contact",
    ),
    (
        lambda folder: vc.solve(scene(), store="history.nc"),
        "store = 'history.nc' must be left out: only a history of steps, motion Transient, is stored as it grows",
    ),
    (
        lambda folder: vc.solve(scene(), polish=True, method="convex"),
        'polish = True must be left out: method = "convex" calls no active sets',
    ),
    (
        lambda folder: vc.solve(scene(), start="slip"),
        "start = 'slip' must be left out: it chooses between the solutions under a law of friction",
    ),
    (
        lambda folder: vc.solve(scene(grid=vc.Grid(nx=4, ny=4, dx=9.0, dy=9.0, x0=-18.0, y0=-18.0))),
        "grid is too coarse to hold one contact element: the contact is 1.61343 by 1.61343, an element 9 by 9",
    ),
    (
        lambda folder: vc.solve(scene(grid=vc.Grid(nx=4, ny=4, dx=0.1, dy=0.1, x0=5.0, y0=5.0))),
        "grid (left, right, bottom, top) = (5.0, 5.4, 5.0, 5.4) does not contain the contact, which is at (0, 0)",
    ),
    (
        lambda folder: vc.solve(scene(motion=None, grid=vc.Grid(nx=4, ny=4, dx=0.1, dy=0.1, x0=-0.2, y0=-0.2))),
        "grid (left, right, bottom, top) = (-0.2, 0.2, -0.2, 0.2) does not contain the contact, which "
        "extends to (-0.3, 0.3, -0.3, 0.3); make it larger, or, where a body ends, add elements with "
        "a large distance",
    ),
    (
        lambda folder: vc.solve(sampled(h=BOWL + 1e14)),
        "surface.h is measured from a level too far from the contact: distances of 1e+14 are rounded to "
        "0.02, and the bodies approach by only 0.476; subtract a constant",
    ),
    (
        lambda folder: vc.solve(
            scene(motion=vc.Transient(steps=1, dq=0.1, normal_force=0.0), normal_force=None, grid=vc.Grid(nx=8, ny=8))
        ),
        "motion: the bodies never touch; give a load in one step at least",
    ),
    (
        lambda folder: vc.certify(scene(motion=vc.Steady(Fx=0.1)), np.zeros((2, 3, 4))),
        "motion: tractions are certified at given creepages; give Steady or Shift with no prescribed force",
    ),
    (
        lambda folder: vc.certify(sampled(grid=vc.Grid(nx=8, ny=8)), np.zeros((2, 8, 8))),
        "grid = Grid(nx=8, ny=8, dx=None, dy=None, x0=None, y0=None, margin=1, edge='centres') is "
        "not allowed: must be explicit (nx, ny, dx, dy, x0, y0), as surface.h is given on it",
    ),
    (
        lambda folder: vc.certify(scene(surface=vc.SampledDistance(BOWL, AXIS, AXIS)), np.zeros((2, 6, 6))),
        "grid: tractions are certified on an explicit grid; give its dx, dy, x0 and y0",
    ),
    (
        lambda folder: vc.certify(scene(grid=SQUARE), np.zeros((2, 4, 3))),
        "traction has shape (2, 4, 3); it must be of shape (2, 3, 3)",
    ),
    (lambda folder: vc.compare(scene(), ["clarabel+foo"]), 'methods: unknown suffix "+foo"; only "+polish" is known'),
    (
        lambda folder: vc.compare(scene(), ["convex+polish"]),
        '"convex+polish": only a program solver called by name is polished; write "convex"',
    ),
    (lambda folder: vc.compare(scene(), []), "methods = [] is not allowed: must be at least one"),
    (lambda folder: vc.compare({}, ["tang"]), "scenes = [] is not allowed: must be at least one"),
    (lambda folder: vc.compare({1: scene()}, ["tang"]), "scenes = 1 is not allowed: must be named by strings"),
    (
        lambda folder: vc.compare(scene(motion=vc.Transient(steps=1, dq=0.1)), ["tang"]),
        "scene 'scene' is a history: methods are compared on one problem (motion Steady, Shift or none)",
    ),
    (
        lambda folder: vc.converge(scene(), []),
        "cells = [] is not allowed: must be a sequence of grids, each finer than the one before",
    ),
    (lambda folder: vc.converge(scene(), [8, 16], method=[]), "method = [] is not allowed: must be at least one name"),
    (
        lambda folder: vc.converge(scene(motion=vc.Transient(steps=1, dq=0.1)), [8, 16]),
        "motion = Transient(steps=1, dq=0.1, dt=None, direction=1, vx=0.0, vy= ... 66666666666666) "
        "is not allowed: must be Steady, Shift or none: convergence is studied on one problem, not "
        "on a history",
    ),
    (
        lambda folder: vc.converge(scene(friction=np.ones((3, 4)), grid=vc.Grid(**LATTICE)), [8, 16]),
        "friction = 'an array' is not allowed: must be a number or a law: an array fits one grid only",
    ),
    (
        lambda folder: vc.converge(sampled(np.zeros((3, 4)), vc.Grid(**LATTICE)), [8, 16]),
        "surface.x is missing: samples without coordinates fit one grid only",
    ),
    (
        lambda folder: vc.converge(scene(), [8, 16], store=folder),
        "store = '{folder}': the name must end in .csv",
    ),
    (
        lambda folder: vc.scan(scene(motion=None), [(0.0, 0.0, 0.0)]),
        "motion = None is not allowed: must be Steady or Shift with no prescribed force: a scan sets the creepages",
    ),
    (
        lambda folder: vc.scan(scene(), [0.1, 0.2, 0.3]),
        "creepages has shape (3,); it must be of shape (k, 3), a row of vx, vy, spin for each "
        "solution; a single solution is [[vx, vy, spin]]",
    ),
    (lambda folder: vc.stress(solved(), [0.0, 1.0]), "points has shape (2,); it must be of shape (3, ...): x, y and z"),
    (lambda folder: vc.stress_below(solved(), []), "depths has shape (0,); it must be a number or several"),
    (
        lambda folder: solved().plot_passes(),
        "solution has no passes to plot (coupling none); coupling loops (panagiotopoulos, joint) and "
        "laws of friction have them",
    ),
    (lambda folder: solved(motion=None).sensitivity(), "motion is missing: without it there is no creepage"),
    (
        lambda folder: solved(tangential="fastsim").sensitivity(),
        "solution = 'fastsim' is not allowed: must be by an exact method: this one is approximate",
    ),
    (lambda folder: reference.carter(CONTACT, 0.3), "neither creepage nor force is given: give one of them"),
    (
        lambda folder: reference.bufler(1.0, vc.Bodies(G=1.0, nu=0.3), force=1.0, a=1.0),
        "force and a are both given: give one of them",
    ),
    (lambda folder: reference.line_contact(1.0, vc.Bodies(G=1.0, nu=0.3)), "give exactly one of force, a and approach"),
    (
        lambda folder: reference.line_contact(1.0, vc.Bodies(G=1.0, nu=0.3), approach=0.1),
        "depth is missing: the approach is measured from a depth",
    ),
    (
        lambda folder: reference.carter(reference.line_contact(1.0, UNLIKE, a=0.1), 0.3, creepage=0.01),
        "bodies.K = 0.07500000000000002 is not allowed: must be 0: this closed form is for like bodies",
    ),
    (
        lambda folder: reference.hertz_ellipse(1.0, 1.0, vc.Bodies(G=1.0, nu=0.3)),
        "neither force nor approach is given: give one of them",
    ),
    (
        lambda folder: linear_creepage(1.0, 1.0, 1.0, reference.creepage_coefficients(1.0, 1.0, 0.3), vx=0.1, Fx=2.0),
        "vx and Fx are both given: give one of them",
    ),
    (
        lambda folder: fastsim_on_grid(vc.Grid(**LATTICE), 1.0, 1.0, 1.0, np.ones((3, 3)), (0.1, 0, 0)),
        "bound = 'array of shape (3, 3), least entry 1' is not allowed: must be of shape (3, 4) with no entry below 0",
    ),
    (
        lambda folder: vc.solve(sampled(np.zeros((3, 4)))),
        "surface.h has shape (3, 4); it must be of the grid's shape (ny, nx) = (3, 3)",
    ),
    (
        lambda folder: read(folder, "=", "= ="),
        "scene file '{folder}/scene.toml' is not a TOML file (Invalid value (at line 1, column 16))",
    ),
    (
        lambda folder: posed(solved(vc.Transient(steps=1, dq=0.1))[0]),
        "solution is a step of a history; give one of steady rolling, a shift or normal contact",
    ),
]


@pytest.mark.parametrize(("act", "message"), MESSAGES)
def test_message(act, message, tmp_path):
    with pytest.raises(vc.VarcontactError) as refused:
        act(tmp_path)
    assert str(refused.value) == message.replace("{folder}", str(tmp_path))


def test_refusals_keep_their_parts():
    """A sentence of its own does not hide the field, the value and what would have been allowed."""
    with pytest.raises(vc.SceneError) as refused:
        vc.plan(scene(), formulation="potential")
    assert (refused.value.field, refused.value.value) == ("formulation", "potential")
    assert refused.value.allowed == '"gap" or "marching"'


def test_a_stored_study_of_something_else(tmp_path):
    """Neither another tolerance, nor another scene or other methods, may be taken for what was asked."""
    study, table = tmp_path / "study.csv", tmp_path / "table.csv"
    vc.converge(scene(), [6], offsets=1, store=study)
    vc.compare({"one": scene()}, ["tang"], store=table)
    for act, message in [
        (
            lambda: vc.converge(scene(), [6], offsets=1, tol=1e-7, store=study),
            f"store = {str(study)!r} holds a study of another scene or tol; name a new file",
        ),
        (
            lambda: vc.compare({"one": scene()}, ["tang-exact"], store=table),
            f"store = {str(table)!r} compares other methods, or the same in another order; name a new file",
        ),
        (
            lambda: vc.compare({"one": scene(friction=0.2)}, ["tang"], store=table),
            f"store = {str(table)!r} holds another scene named 'one'; name a new file",
        ),
    ]:
        with pytest.raises(vc.SceneError) as refused:
            act()
        assert str(refused.value) == message
