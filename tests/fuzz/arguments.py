"""Cases of bad arguments: every public function, with one argument or two replaced by what nobody
means.

Functions are called in an empty folder. A call that succeeds is no failure, unless it took a truth
value or a complex number for a number.
"""

import contextlib
import dataclasses
import functools
import tempfile

import numpy as np

import varcontact as vc
from tests.fuzz.junk import PLAIN, Deep, objects
from tests.fuzz.outcome import Case, says_what
from tests.scenes import make_scene
from varcontact.errors import shortened

reference = vc.reference


def arguments(rng: np.random.Generator) -> Case:
    """Replace arguments of a call, and make it in an empty folder."""
    name = str(rng.choice(list(calls())))
    function, meant = calls()[name]
    junk, given = [*PLAIN, *objects()], dict(meant)
    number = min(int(rng.choice([1, 1, 1, 2])), len(given))
    bad = [str(each) for each in rng.choice(list(given), size=number, replace=False)]
    for argument in bad:
        value = junk[rng.integers(len(junk))]
        given[argument] = value.made() if isinstance(value, Deep) else value

    def called() -> list[str]:
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            function(**given)
        return [
            f"took {each} for a number"
            for each in bad
            if _taken_for_a_number(meant[each], given[each])
        ]

    words = f"{name}({', '.join(f'{argument}={shortened(given[argument])}' for argument in bad)})"
    return Case(
        words,
        called,
        lambda e: says_what(e) or (_unnamed(e, bad[0]) if len(bad) == 1 else ""),
        bad_input=True,
    )


def _unnamed(error: vc.VarcontactError, argument: str) -> str:
    """In words, where an error names neither the argument that is bad nor the file that is its
    value.
    """
    if isinstance(error, vc.Saturated | vc.TooLarge | vc.SolverUnavailable) or argument in str(
        error
    ):
        return ""
    if argument == "path" and "scene file" in str(error):
        return ""
    return f"the message does not name {argument!r}: {str(error)[:300]}"


def _taken_for_a_number(meant, given) -> bool:
    """Whether a truth value or a complex number was accepted in place of a number."""
    return type(meant) in (int, float) and isinstance(given, bool | np.bool_ | complex)


@functools.cache
def calls() -> dict:
    """The public functions by name."""
    return {**_parts(), **_studies(), **_references()}


def _parts() -> dict:
    falling = {"static": 0.3, "kinetic": 0.2, "half_velocity": 1e-3, "velocity": 2.0}
    parts = [
        scene(),
        vc.Bodies(1.0, 0.3),
        vc.Paraboloids(1.0, 2.0),
        vc.Ellipse(1.0, 2.0),
        vc.Cylinders(1.0, 9.0),
        vc.SampledDistance(np.eye(3), [0.0, 1.0, 2.0], [0.0, 1.0, 2.0]),
        vc.Grid(nx=3, ny=3, dx=1.0, dy=1.0, x0=-1.5, y0=-1.5),
        vc.Units(length="mm", force="N"),
        vc.Steady(spin=0.1, Fx=1e-3, vy=0.1, dq=0.1),
        vc.Shift(ux=0.1, Fy=1e-3, rotation=0.1),
        vc.Transient(steps=3, dq=[0.0, 0.1, 0.1], vx=1e-3, normal_force=1.0, friction=0.3),
    ]
    named = {type(each).__name__: (type(each), given_to(each)) for each in parts}
    return named | {
        "Bodies.from_young": (vc.Bodies.from_young, {"E": 1.0, "nu": (0.3, 0.2)}),
        "Paraboloids.from_bodies": (
            vc.Paraboloids.from_bodies,
            {"Rx": (1.0, 2.0), "Ry": (1.0, 2.0)},
        ),
        "StaticKinetic": (vc.StaticKinetic, {"static": 0.3, "kinetic": 0.2}),
        **{
            law.__name__: (law, falling)
            for law in (vc.LinearFalling, vc.RationalFalling, vc.ExponentialFalling)
        },
    }


def given_to(part: object) -> dict:
    """The arguments that a part of a scene was made of."""
    return {
        field.name: getattr(part, field.name) for field in dataclasses.fields(part) if field.init
    }


def scene() -> vc.Scene:
    surface, bodies = vc.Paraboloids(3.0, 2.0), vc.Bodies(1.0, 0.3)
    return make_scene(surface, 4e-3, vc.Steady(vx=1e-3), vc.Grid(nx=4, ny=4), bodies=bodies)


def _studies() -> dict:
    """What takes scenes and solutions."""
    posed = scene()
    sol = vc.solve(posed)
    methods = dict.fromkeys(("normal", "tangential", "coupling", "formulation", "method"), "auto")
    solving = {
        "scene": posed,
        **methods,
        "tol": 1e-8,
        "polish": None,
        "certify": "auto",
        "progress": None,
    }
    study = {"tol": 1e-6, "store": None, "progress": None}
    return {
        "plan": (vc.plan, {"scene": posed, **methods}),
        "solve": (vc.solve, {**solving, "start": None, "store": None}),
        "scan": (vc.scan, {**solving, "creepages": np.zeros((2, 3))}),
        "certify": (
            vc.certify,
            {"scene": posed, "traction": sol.traction, "pressure": sol.pressure},
        ),
        "compare": (vc.compare, {"scenes": posed, "methods": ["tang"], **study}),
        "converge": (
            vc.converge,
            {"scene": posed, "cells": [3, 4], "method": "tang", "offsets": 1, **study},
        ),
        "load": (vc.load, {"path": "x.nc", "certify": True}),
        "read_scene": (vc.read_scene, {"path": "x.toml"}),
        "Solution.save": (sol.save, {"path": "x.nc", "overwrite": False}),
        "stress": (vc.stress, {"solution": sol, "points": [[0.0], [0.0], [0.0]], "body": 1}),
        "stress_below": (vc.stress_below, {"solution": sol, "depths": [0.1], "body": 1}),
        "Solution.plot": (
            sol.plot,
            {"what": "section", "y": 0.0, "ax": None, "figsize": (3.0, 3.0)},
        ),
        "Scene.save": (posed.save, {"path": "x.toml", "overwrite": False}),
        "plot_curve": (
            vc.plot_curve,
            {"solutions": [sol], "against": "auto", "normalised": True, "figsize": None},
        ),
        "plot_stress": (
            vc.plot_stress,
            {"sol": sol, "quantity": "xx", "plane": "xz", "y": None, "depth": None},
        ),
        "plot_comparison": (vc.plot_comparison, {"table": None}),
        "standard_bank": (vc.standard_bank, {"cells": 4}),
        "unlike_bank": (vc.unlike_bank, {"cells": 4}),
    }


def _references() -> dict:
    bodies = vc.Bodies(1.0, 0.3)
    unlike = vc.Bodies((1.0, np.inf), 0.3)
    line = reference.line_contact(1.0, bodies, force=1e-3)
    loaded = {"friction": 0.3, "force": 1e-4}
    ball = reference.hertz(1.0, 1.0, bodies, force=1e-3)
    return {
        "elliptic_integrals": (reference.elliptic_integrals, {"axial_ratio": 0.5}),
        "hertz": (
            reference.hertz,
            {"Rx": 1.0, "Ry": 2.0, "bodies": bodies, "force": 1e-3, "approach": None},
        ),
        "hertz_ellipse": (
            reference.hertz_ellipse,
            {"a": 1.0, "b": 2.0, "bodies": bodies, "force": 1e-3},
        ),
        "line_contact": (reference.line_contact, {"R": 1.0, "bodies": bodies, "force": 1e-3}),
        "carter": (reference.carter, {"contact": line, "friction": 0.3, "creepage": 1e-3}),
        "bufler": (reference.bufler, {"R": 1.0, "bodies": unlike, "force": 1e-3}),
        "cattaneo_line": (reference.cattaneo_line, {"contact": line, **loaded}),
        "cattaneo_mindlin": (
            reference.cattaneo_mindlin,
            {"contact": ball, "bodies": bodies, **loaded},
        ),
        "creepage_coefficients": (reference.creepage_coefficients, {"a": 1.0, "b": 1.0, "nu": 0.3}),
        "spence_ratio": (
            reference.spence_ratio,
            {"bodies": unlike, "friction": 0.3, "shape": "circle"},
        ),
    }
