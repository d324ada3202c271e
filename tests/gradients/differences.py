"""Contacts whose gradients are checked, and differences of their solutions."""

import numpy as np

import varcontact as vc
from varcontact.gradients.adjoint import LinearisedSolution
from varcontact.gradients.inputs import number_of, path_of
from varcontact.gradients.outputs import output_of

GRID = vc.Grid(nx=14, ny=14, dx=0.2, dy=0.2, x0=-1.4, y0=-1.37)
COARSE = vc.Grid(nx=12, ny=12, dx=0.24, dy=0.24, x0=-1.42, y0=-1.37)
LIKE = vc.Bodies(G=1.0, nu=0.28)
UNLIKE = vc.Bodies(G=(1.0, 3.0), nu=(0.2, 0.3))
COATED = vc.BodyPair(vc.Layered([vc.Layer(0.4, 2.0, 0.3)], base=(1.0, 0.28)), LIKE)
ROLLING = vc.Steady(vx=4e-4, vy=3e-4, spin=6e-4)
EXACT = {"tol": 1e-12, "certify": None}
STEP = 1e-6


def contact(bodies=LIKE, motion=ROLLING, **more):
    """A contact whose pressure solves the equations of its grid."""
    entries = {
        "surface": vc.Paraboloids(100.0, 90.0),
        "normal_force": 0.02,
        "friction": 0.3,
        "grid": GRID,
    }
    return vc.Scene(bodies=bodies, motion=motion, **entries | more)


def solved(scene):
    normal = "auto" if scene.coupled else "norm"
    return vc.solve(scene, normal=normal, **EXACT)


def fields(scene):
    """What outputs of a scene are taken from."""
    return LinearisedSolution.of(solved(scene), "held").fields


def values(scene, names):
    """Outputs of a scene."""
    found = fields(scene)
    return np.array([output_of(name)[1].value(found) for name in names])


def difference(scene_of, at, name):
    """Central difference of an output."""
    return float(differences(scene_of, at, [name])[0])


def differences(scene_of, at, names, step=STEP):
    """Central differences of outputs."""
    above = values(scene_of(at * (1 + step)), names)
    below = values(scene_of(at * (1 - step)), names)
    return (above - below) / (2 * step * at)


def check_gradients(scene, paths, outputs=("Fx", "Mz", "friction_work"), tol=1e-6, step=STEP):
    """Held gradients are differences of solutions, inside a pattern."""
    found = solved(scene).gradient(list(outputs), paths, edge="held")
    for path in paths:
        scene_of, at = number_of(scene, path_of(path))
        expected = differences(scene_of, at, outputs, step)
        small = 1e-4 * abs(found.value.to_numpy() / at)
        assert (abs(found[path] - expected) <= tol * (abs(found[path]) + small)).all(), path
