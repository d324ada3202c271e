"""Results of CONTACT: tables that are written by its guide's layout are read, and certified."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import varcontact as vc

DATA = Path(__file__).parent.parent / "data" / "contact"
NAMES = ("Tim Sws Xw Yw", "Xcp Ycp Zcp Deltcp", "Mx My Xl Yl Dx Dy Chi Dq", "T M Gg1 Gg2 Poiss1 Poiss2",
         "L dum Veloc Fstat Fkin")  # fmt: skip


def table(sol, T, inside=True, digits=6):
    """A solution in the layout of the guide, with as many digits as a table has."""
    grid, width = sol.grid, 200.0 if sol.grid.line else None
    dx, dy = grid.sides
    y0, dy = (-width / 2, width) if width else (grid.y0, dy)
    heads = (
        (0, 0, 0, 0), (0, 0, 0, 0), (grid.nx, grid.rows, grid.x0, y0, dx, dy, 0.0, 0.04),
        (T, 0, 200, 200, 0.42, 0.42), (0, 0, 30000, 0.4, 0.4))  # fmt: skip
    lines = []
    for name, numbers in zip(NAMES, heads, strict=True):
        lines += [f"% {name}", " ".join(f"{n:.{digits + 1}g}" for n in numbers)]
    lines.append("% i Igs H Mu Pn Px Py Un Ux Uy SRel")
    fields = (sol.state, sol.pressure, sol.traction[0], sol.traction[1])
    for k, (state, pn, px, py) in enumerate(zip(*(each.ravel() for each in fields), strict=True), 1):
        if pn > 0 or not inside:
            lines.append(f"{k} {state} 0.0 0.4 {pn:.{digits}E} {px:.{digits}E} {py:.{digits}E} 0 0 0 0")
    return "\n".join([*lines, ""])


@pytest.fixture(scope="module")
def shifted():
    """Cattaneo's shift, solved at the shift that its force needs."""
    _, scene = vc.read_contact_input(DATA / "cattaneo.inp")
    found = vc.solve(scene)
    at_shift = replace(scene, motion=vc.Shift(ux=float(found.creepage[0])))
    return at_shift, vc.solve(at_shift)


@pytest.mark.parametrize("inside", [True, False])
def test_tractions_of_a_shift_are_certified(tmp_path, shifted, inside):
    """Six digits of the table are six digits of the residual; elements outside may be left out."""
    scene, sol = shifted
    path = tmp_path / "cattaneo.0002.mat"
    path.write_text(table(sol, 1, inside))
    result = vc.read_contact_result(path)
    np.testing.assert_allclose(result.pressure, sol.pressure, rtol=1e-5)
    np.testing.assert_array_equal(result.state, sol.state)
    certificate = vc.certify(scene, *result.on(scene))
    assert 1e-9 < certificate.residual < 1e-4
    assert certificate.relative_gap < 1e-5


def test_wrong_tractions_are_found_out(tmp_path, shifted):
    scene, sol = shifted
    path = tmp_path / "wrong.mat"
    path.write_text(table(replace(sol, traction=0.9 * sol.traction), 1))
    certificate = vc.certify(scene, *vc.read_contact_result(path).on(scene))
    assert certificate.residual > 0.01
    assert certificate.relative_gap > 1e-3


def test_one_long_row_is_line_contact(tmp_path):
    (scene,) = vc.read_contact_input(DATA / "carter.inp")
    sol = vc.solve(scene)
    path = tmp_path / "carter.0001.mat"
    path.write_text(table(sol, 3, digits=8))
    result = vc.read_contact_result(path)
    assert result.grid.line
    assert vc.certify(scene, *result.on(scene)).residual < 1e-5


def test_results_of_something_else_are_refused(tmp_path, shifted):
    scene, sol = shifted
    path = tmp_path / "a.mat"
    path.write_text(table(sol, 1))
    result = vc.read_contact_result(path)
    grid = scene.grid
    moved = replace(scene, grid=replace(grid, x0=grid.x0 + 0.1 * grid.dx))
    for other, words in (
        (moved, "scene.grid = .* must be that of the result"),
        (replace(scene, motion=vc.Steady(vx=0.001)), "scene.motion = .* must be that of the result, which has T = 1"),
    ):
        with pytest.raises(vc.SceneError, match=words):
            result.on(other)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("% Tim", "Tim", "line 1 should be a comment: this is not the layout"),
        ("19 19 ", "% 19 19 ", "line 6 should be numbers: this is not the layout"),
        ("\n1 0 200 200", "\n1 0 200", "line 8 should have 6 numbers or more"),
        ("% i Igs", "i Igs", "line 11 should be a comment"),
        (" 0.0 0.4 ", " *** 0.4 ", "should have 11 numbers or more"),
    ],
)
def test_a_damaged_table_is_refused_by_line(tmp_path, shifted, old, new, words):
    _, sol = shifted
    path = tmp_path / "a.mat"
    path.write_text(table(sol, 1).replace(old, new, 1))
    with pytest.raises(vc.SceneError) as error:
        vc.read_contact_result(path)
    assert words in str(error.value)


def test_elements_that_come_twice_or_are_none_are_refused(tmp_path, shifted):
    _, sol = shifted
    lines = table(sol, 1).splitlines()
    path = tmp_path / "a.mat"
    for rows, words in (
        ([*lines, lines[-1]], f"line {len(lines) + 1} has element"),
        ([*lines, "999" + lines[-1][lines[-1].index(" ") :]], "give each of 1 to 361 once at most"),
        (lines[:11], "should begin a table with pressures"),
        ([*lines[:11], lines[11].replace(" 2 0.0", " 3 0.0", 1)], "has IGS = 3; supported: 0 exterior"),
    ):
        path.write_text("\n".join(rows))
        with pytest.raises(vc.SceneError, match=words):
            vc.read_contact_result(path)
