"""Pictures of corrected solutions: the field on the parts of the elements, whose force is the solution's."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from matplotlib.patches import PathPatch
from matplotlib.quiver import Quiver

import varcontact as vc
from tests.plotting.test_pictures import RAIL, check_readable

SCENES = {
    "rolling": RAIL,
    "law": dataclasses.replace(RAIL, friction=vc.StaticKinetic(0.33, 0.28)),
    "full slip": dataclasses.replace(RAIL, motion=vc.Steady(vx=0.1)),
    "next to no slip": dataclasses.replace(RAIL, motion=vc.Steady(vx=2e-6)),
}


@pytest.fixture(scope="module", params=SCENES)
def corrected(request):
    return vc.solve(SCENES[request.param], refine="continuum", certify=None)


def areas(ax):
    """Areas of stick and slip in the picture, in mm^2."""
    found = {}
    for patch in ax.patches:
        if isinstance(patch, PathPatch):
            corners = patch.get_path().vertices.reshape(-1, 5, 2)
            found[patch.get_gid()] = float(np.prod(np.ptp(corners, axis=1), axis=1).sum())
    return found


def test_maps_are_of_the_parts(corrected):
    """Arrows and their legend are of the field on the parts; stick and slip together are the contact."""
    field, ax = corrected.refinement, corrected.plot("traction").axes[0]
    assert ax.get_title() == "Tangential traction on body 1\n(corrected, on 2 x 2 parts)"
    (arrows,) = [each for each in ax.collections if isinstance(each, Quiver)]
    places = 1e-3 * np.array([arrows.X, arrows.Y])
    column, row = (
        np.abs(line - place[:, None]).argmin(axis=1)
        for line, place in zip((field.grid.x, field.grid.y), places, strict=True)
    )
    np.testing.assert_allclose(places, [field.grid.x[column], field.grid.y[row]], rtol=1e-12)
    assert len(arrows.X) > 0.2 * corrected.elements["contact"]
    largest = np.hypot(*field.traction).max()
    np.testing.assert_allclose([arrows.U, arrows.V], field.traction[:, row, column] / largest, atol=1e-12)
    assert f"traction, up to {largest / 1e6:.3g} MPa" in [text.get_text() for text in ax.get_legend().get_texts()]
    found, part = areas(ax), 1e6 * field.grid.area
    assert found["stick"] / part == pytest.approx(round(found["stick"] / part), abs=1e-6), "whole parts"
    assert sum(found.values()) == pytest.approx(1e6 * np.pi * RAIL.hertz.a * RAIL.hertz.b, rel=0.1)


def test_nothing_lies_over_anything(corrected):
    check_readable(corrected.plot(["pressure", "traction", "slip", "power_density", "section", "distance"]))


def test_plain_solutions_are_drawn_on_their_elements():
    plain = vc.solve(RAIL, certify=None)
    ax = plain.plot("traction").axes[0]
    assert "corrected" not in ax.get_title()
    assert sum(areas(ax).values()) == pytest.approx(1e6 * plain.areas["contact"])


def test_films_of_corrected_histories(tmp_path):
    """Of a file of an earlier version: every step is drawn with its field on the parts."""
    history = vc.load(Path(__file__).parents[1] / "data" / "refined_history.nc")
    history.animate(tmp_path / "film.gif")
    assert (tmp_path / "film.gif").stat().st_size > 1000
    assert history[1].plot().axes[0].get_title().endswith("(corrected, on 2 parts)")
