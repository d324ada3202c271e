"""Scenes in one line or two, the same scene in other units, and what is refused."""

from dataclasses import fields, is_dataclass, replace
from functools import partial

import pytest

import varcontact as vc
from varcontact.reference import carter, line_contact

LIKE, STEEL = vc.Bodies(G=1.0, nu=0.28), vc.Bodies(G=82e9, nu=0.28)


def make_scene(
    surface, normal_force=1.0, motion=None, grid="auto", friction=0.3, bodies=LIKE, **more
):
    """A scene of like bodies under a friction of 0.3, unless other ones are given."""
    given = {
        "normal_force": normal_force,
        "motion": motion,
        "grid": grid,
        "friction": friction,
        "bodies": bodies,
    }
    return vc.Scene(surface=surface, **given, **more)


def wheel_on_rail(motion, grid="auto", **more):
    """A wheel on a rail by its radii, in metres and newtons."""
    return make_scene(vc.Paraboloids(Rx=0.46, Ry=0.30), 106.7e3, motion, grid, 0.33, STEEL, **more)


def carters_cylinders(part=0.6):
    """Carter's solution under a part of what friction carries, and the cylinders that roll so."""
    bodies = vc.Bodies(G=1.0, nu=0.3)
    contact = line_contact(1.0, bodies, a=0.01)
    exact = carter(contact, 0.3, force=-part * 0.3 * contact.force)
    return exact, make_scene(
        vc.Cylinders(R=1.0), contact.force, vc.Steady(vx=exact.creepage), bodies=bodies
    )


def in_units(scene, length, stress, time=1.0):
    """The same scene, where so many are one old unit of length, of force by area, and of time."""
    force = stress * length ** (1 if scene.line else 2)
    lengths = {
        "a",
        "b",
        "R",
        "clearance",
        "Rx",
        "Ry",
        "reference_depth",
        "h",
        "x",
        "y",
        "dx",
        "dy",
        "x0",
        "y0",
        "ux",
        "uy",
        "dq",
        "normal",
        "tangential",
    }
    units = dict.fromkeys(lengths | {"approach", "memory_distance"}, length)
    units |= dict.fromkeys(("Fx", "Fy", "normal_force"), force)
    units |= dict.fromkeys(("G", "tau_c0", "strength", "density"), stress)
    units |= {
        "k_tau": stress / length,
        "spin": 1 / length,
        "dt": time,
        "conductivity": stress * length**2 / time,
    }
    units |= dict.fromkeys(("speed", "velocity", "half_velocity"), length / time)

    def scaled(name, value):
        if value is None or isinstance(value, str):
            return value
        if name == "base":
            return (value[0] * stress, *value[1:])
        if name == "relaxations":
            return [(part, time * tau) for part, tau in value]
        if name in units and isinstance(value, tuple):
            return tuple(None if each is None else each * units[name] for each in value)
        if name in units:
            return value * units[name]
        if isinstance(value, tuple | list) and any(map(is_dataclass, value)):
            return tuple(scaled(name, each) for each in value)
        if not is_dataclass(value):
            return value
        return replace(
            value,
            **{f.name: scaled(f.name, getattr(value, f.name)) for f in fields(value) if f.init},
        )

    return scaled("scene", scene)


def refused(call, field=None, words="", match=None, error=vc.SceneError):
    """Assert that a call raises this error, of this field, with these words in its message."""
    with pytest.raises(error, match=match) as found:
        call()
    assert field is None or found.value.field == field
    assert words in str(found.value)


def refusals(*cases, of=None, by="match", fixture=None):
    """A test for each pair of a call, or of arguments `of` one, and its error's pattern or field;
    after a fixture.
    """

    @pytest.mark.parametrize(("given", "said"), cases)
    def test(request, given, said):
        first = [request.getfixturevalue(fixture)] if fixture else []
        call = partial(of, *first, **given) if of else partial(given, *first)
        refused(call, **{by: said})

    return test
