"""Scenes in one line or two."""

import varcontact as vc

LIKE = vc.Bodies(G=1.0, nu=0.28)


def make_scene(surface, normal_force=1.0, motion=None, grid="auto", friction=0.3, bodies=LIKE, **more):
    """A scene of like bodies under a friction of 0.3, unless other ones are given."""
    given = {"normal_force": normal_force, "motion": motion, "grid": grid, "friction": friction, "bodies": bodies}
    return vc.Scene(surface=surface, **given, **more)
