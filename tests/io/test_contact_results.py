"""Results of CONTACT: tables that are written by its guide's layout are read, and certified."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene, refused

DATA = Path(__file__).parent.parent / "data" / "contact"
NAMES = ("Tim Sws Xw Yw", "Xcp Ycp Zcp Deltcp", "Mx My Xl Yl Dx Dy Chi Dq", "T M Gg1 Gg2 Poiss1 Poiss2",
         "L dum Veloc Fstat Fkin")  # fmt: skip


HEADER = """
%  TIM S_WS(FC) TH_WS(FC) Y_R(TR) Z_R(TR) ROLL_R(TR) RNOM_ROL - - - FMT
0.00000 160.000 0.00000 750.000 0.00000 0.00000 0.00000 0 0 0 2410
%  X_W(TR) Y_W(TR) Z_W(TR) ROLL_W(TR) YAW_W(TR) RNOM_WHL - - - -
0.00000 753.520 -0.923882 0.00000 -0.00000 460.000 0.00000 0.00000 0.00000 0.00000 0.00000
%  X_CP(R) Y_CP(R) Z_CP(R) DELT_CP(R) X_CP(W) Y_CP(W) Z_CP(W) NPATCH IPATCH SPINXO SPINYO - -
-2.46012 32.0806 -1.51770 -0.499435E-01 -2.46012 28.5606 -0.593822 2 1 {spin} 0.00000
%   MX    MY     XL            YL            DX            DY            CHI           DQ       C1  D  YNOM_WHL
{place} 0.00000 0.0400000 1 5 750.000
%    T    M      GG1           GG2           POISS1        POISS2          -             -             -
{T} {M} {elastic} 0.00000 0.00000 0.00000
%    L    H      VELOC         FSTAT         FKIN            -             -             -             -
0 0 30000.0 {friction} {friction} 0.00000 0.00000 0.00000 0.00000 0.00000 0.00000
%    I    IGS    H             MU            PN            PX            PY            UN            UX           UY"""
"""Of the open-source release of 2025, with the names and the places of its columns."""


def release(scene, sol, T, M=0, inside=True, more=(), spin="0.00000  0.00000"):
    """A solution in the layout of the open-source release of 2025, with further columns."""
    grid, (G, nu) = sol.grid, scene.bodies.pairs
    y0, dy = (-100.0, 200.0) if grid.line else (grid.y0, grid.sides[1])
    place = f"{grid.nx} {grid.rows} {_row(grid.x0, y0, grid.sides[0], dy)}"
    friction = _row(0.0 if scene.friction is None else scene.friction)
    head = HEADER.strip().format(
        T=T, M=M, place=place, elastic=_row(*G, *nu), friction=friction, spin=spin
    )
    lines = [" ".join([head, "SREL" if T > 1 else "SHFT", *more])]
    h = np.broadcast_to(scene.surface.h, sol.pressure.shape)
    approach = 2 * h.max() if grid.line else sol.approach  # of a long row CONTACT has one, too
    mu, zero = np.full_like(h, scene.friction or 0.0), np.zeros_like(h)
    fields = (h, mu, sol.pressure, *sol.traction, approach - h, zero, zero, zero)
    fields += tuple(np.full_like(h, 20.0 + k) for k in range(len(more)))
    for k, (state, *values) in enumerate(
        zip(sol.state.ravel(), *map(np.ravel, fields), strict=True), 1
    ):
        if values[2] > 0 or not inside:
            lines.append(f"{k:7d} {state:4d}  {_row(*values)}")
    return "\n".join([*lines, ""])


def _row(*values):
    """Six digits each, as Fortran writes them: an exponent of three digits has no E."""
    return "".join(re.sub(r"E(?=[+-]\d{3}$)", "", f"{value:14.5E}") for value in values)


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
    for k, (state, pn, px, py) in enumerate(
        zip(*(each.ravel() for each in fields), strict=True), 1
    ):
        if pn > 0 or not inside:
            lines.append(
                f"{k} {state} 0.0 0.4 {pn:.{digits}E} {px:.{digits}E} {py:.{digits}E} 0 0 0 0"
            )
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


@pytest.mark.parametrize("inside", [True, False])
def test_files_of_the_release_of_2025_are_certified_by_what_they_have(tmp_path, shifted, inside):
    """Thirteen lines above the table, of which the sixth is not the grid's, and names of columns in
    capitals.
    """
    scene, sol = shifted
    path = tmp_path / "cattaneo.0002.mat"
    path.write_text(release(scene, sol, 1, inside=inside))
    result = vc.read_contact_result(path)
    np.testing.assert_allclose(result.traction, sol.traction, rtol=1e-5, atol=1e-20)
    assert result.normal_force == pytest.approx(sol.normal_force, rel=1e-5)
    assert result.force == pytest.approx(sol.force, rel=1e-5, abs=1e-6)
    assert result.values["X_CP(R)"] == -2.46012
    assert (result.values["NPATCH"], result.values["YNOM_WHL"], result.values["FMT"]) == (
        2,
        750,
        2410,
    )
    assert np.isnan(result.columns["H"]).any() == inside
    own = result.scene(scene.motion)
    assert own.approach == pytest.approx(sol.approach, rel=1e-5)
    assert own.bodies == vc.Bodies(G=(200.0, 200.0), nu=(0.42, 0.42))
    for judged in (scene, own):
        certificate = vc.certify(judged, *result.on(judged))
        assert 1e-9 < certificate.residual < 1e-4
    wrong = result.scene(vc.Shift(ux=0.9 * scene.motion.ux))
    assert vc.certify(wrong, *result.on(wrong)).residual > 0.01


def test_columns_are_found_by_name(tmp_path, shifted):
    """Those of a plastic layer and of temperatures come after the others."""
    scene, sol = shifted
    path = tmp_path / "layer.mat"
    path.write_text(
        release(scene, sol, 3, M=4, more=("TAUCRT", "UPLSX", "UPLSY", "TEMP1", "TEMP2"))
    )
    result = vc.read_contact_result(path)
    inside = sol.pressure > 0
    for place, name in enumerate(("TAUCRT", "UPLSX", "UPLSY", "TEMP1", "TEMP2")):
        np.testing.assert_array_equal(result.columns[name][inside], 20.0 + place)
        assert np.isnan(result.columns[name][~inside]).all()
    with pytest.raises(
        vc.SceneError, match="bodies: M = 4, with an interfacial layer, cannot be certified"
    ):
        result.on(scene)


def test_tractions_of_viscoelastic_bodies_are_data(tmp_path):
    (scene,) = vc.read_contact_input(DATA / "carter.inp")
    sol = vc.solve(scene)
    path = tmp_path / "visc.0001.mat"
    path.write_text(release(scene, sol, 3, M=1))
    result = vc.read_contact_result(path)
    assert result.normal_force == pytest.approx(35780, rel=1e-5)
    assert result.force[0] == pytest.approx(sol.force[0], rel=1e-5)
    assert result.moment == pytest.approx(0, abs=1e-6 * abs(result.force[0]))
    for certified in (lambda: result.on(scene), lambda: result.scene(scene.motion)):
        with pytest.raises(
            vc.SceneError, match=r"M = 1, viscoelastic, cannot be certified; elastic half-spaces"
        ):
            certified()


def test_spin_is_about_the_centre_of_the_file(tmp_path):
    """Of a patch that rolls with spin about (x0, y0): the same tractions with creepages about the
    origin.
    """
    x0, y0, spin = 0.5, -0.3, 3e-4
    scene = make_scene(
        vc.SampledDistance(
            np.add.outer(np.linspace(-2, 2, 10) ** 2, np.linspace(-2, 2, 12) ** 2) / 600
        ),
        2000.0,
        vc.Steady(vx=1e-4 + spin * y0, vy=2e-4 - spin * x0, spin=spin, dq=0.04),
        vc.Grid(nx=12, ny=10, dx=0.4, dy=0.4, x0=-2.4, y0=-2.0),
        bodies=vc.Bodies(G=82000.0, nu=0.28),
        units=vc.MM_N,
    )
    sol = vc.solve(scene)
    path = tmp_path / "spin.0001a.mat"
    path.write_text(release(scene, sol, 3, spin=f"{x0} {y0}"))
    result = vc.read_contact_result(path)
    assert result.moment == pytest.approx(sol.moment, rel=1e-4)
    own = result.scene(vc.Steady(vx=1e-4, vy=2e-4, spin=spin))
    assert vc.certify(own, *result.on(own)).residual < 1e-4


def test_a_normal_problem_alone_is_one_without_shift(tmp_path):
    normal, _ = vc.read_contact_input(DATA / "cattaneo.inp")
    x, y = normal.grid.x, normal.grid.y
    scene = replace(normal, surface=vc.SampledDistance(0.01 * np.add.outer(y**2, x**2)))
    sol = vc.solve(scene)
    path = tmp_path / "cattaneo.0001.mat"
    path.write_text(release(scene, sol, 0))
    result = vc.read_contact_result(path)
    judged = replace(scene, motion=vc.Shift(), friction=0.4)
    assert vc.certify(judged, *result.on(judged)).normal_residual < 1e-4
    with pytest.raises(
        vc.SceneError, match=r"must be that of the result, which has T = 0: Shift\(\)"
    ):
        result.on(replace(judged, motion=vc.Shift(ux=0.001)))


def test_an_exponent_of_three_digits_has_no_e(tmp_path, shifted):
    scene, sol = shifted
    small = replace(
        sol, traction=np.stack([sol.traction[0], np.full_like(sol.traction[1], -1.25e-107)])
    )
    path = tmp_path / "small.mat"
    path.write_text(release(scene, small, 1))
    assert "-1.25000-107" in path.read_text()
    assert vc.read_contact_result(path).traction[1].min() == -1.25e-107


def test_wrong_tractions_are_found_out(tmp_path, shifted):
    scene, sol = shifted
    path = tmp_path / "wrong.mat"
    path.write_text(table(replace(sol, traction=0.9 * sol.traction), 1))
    certificate = vc.certify(scene, *vc.read_contact_result(path).on(scene))
    assert certificate.residual > 0.01
    assert certificate.relative_gap > 1e-3


def test_one_row_is_certified_with_rows_beside_it(tmp_path):
    (scene,) = vc.read_contact_input(DATA / "carter.inp")
    sol = vc.solve(scene)
    path = tmp_path / "carter.0001.mat"
    path.write_text(table(sol, 3, digits=8))
    result = vc.read_contact_result(path)
    assert vc.certify(scene, *result.on(scene)).residual < 1e-5
    path.write_text(release(scene, sol, 3))
    result = vc.read_contact_result(path)
    own = result.scene(scene.motion)
    assert own.approach == pytest.approx(sol.approach, rel=1e-5)
    assert vc.certify(own, *result.on(own)).residual < 1e-4


def test_results_of_something_else_are_refused(tmp_path, shifted):
    scene, sol = shifted
    path = tmp_path / "a.mat"
    path.write_text(table(sol, 1))
    result = vc.read_contact_result(path)
    grid = scene.grid
    moved = replace(scene, grid=replace(grid, x0=grid.x0 + 0.1 * grid.dx))
    for other, words in (
        (moved, "scene.grid = .* must be that of the result"),
        (
            replace(scene, motion=vc.Steady(vx=0.001)),
            "scene.motion = .* must be that of the result, which has T = 1",
        ),
    ):
        with pytest.raises(vc.SceneError, match=words):
            result.on(other)


@pytest.mark.parametrize(("layout", "old", "new", "words"), [
    ("guide", "% Tim", "Tim", "line 1 should be a comment: this is not the layout"),
    ("guide", "19 19 ", "% 19 19 ", "line 6 should be numbers: this is not the layout"),
    ("guide", "\n1 0 200 200", "\n1 0 200", "line 8 should have 6 numbers or more"),
    ("guide", "% i Igs", "i Igs", "line 11 should be a comment"),
    ("guide", " 0.0 0.4 ", " *** 0.4 ", "should have 11 numbers or more"),
    ("release", " MX ", " NX ", "line 13 begins the table without MX"),
    ("release", " PX ", " PT ", "line 13 begins the table without PX"),
    ("release", "\n1 0 ", "\n% 1 0 ", "line 10 should be numbers"),
    ("release", "2410", "****", "line 2 should have 8 numbers or more"),
])  # fmt: skip
def test_a_damaged_file_is_refused_by_line(tmp_path, shifted, layout, old, new, words):
    path, text = (
        tmp_path / "a.mat",
        table(shifted[1], 1) if layout == "guide" else release(*shifted, 1),
    )
    assert old in text
    path.write_text(text.replace(old, new, 1))
    refused(lambda: vc.read_contact_result(path), words=words)


@pytest.mark.long
def test_a_file_that_is_cut_short_is_refused_wherever(tmp_path, shifted):
    """Within a number, too, where it would be another one; but for whole lines of the table at its
    end.
    """
    text = release(*shifted, 1)
    path = tmp_path / "a.mat"
    for end in [*range(0, len(text) - 150, 997), *range(len(text) - 150, len(text))]:
        path.write_text(text[:end])
        if text[:end].endswith("\n") and text[:end].count("\n") > 13:
            continue
        with pytest.raises(vc.SceneError, match=r"a\.mat, line \d+ "):
            vc.read_contact_result(path)


def test_elements_that_come_twice_or_are_none_are_refused(tmp_path, shifted):
    _, sol = shifted
    lines = table(sol, 1).splitlines()
    path = tmp_path / "a.mat"
    for rows, words in (
        ([*lines, lines[-1]], f"line {len(lines) + 1} has element"),
        ([*lines, "999" + lines[-1][lines[-1].index(" ") :]], "give each of 1 to 361 once at most"),
        (lines[:11], "should begin a table with pressures"),
        ([*lines[:11], lines[11].replace(" 2 0.0", " 4 0.0", 1)], "has IGS = 4; supported: 0, 1"),
        (lines, f"line {len(lines)} has no end: the file was cut short"),
    ):
        path.write_text("\n".join(rows))
        with pytest.raises(vc.SceneError, match=words):
            vc.read_contact_result(path)


MATERIALS = {
    0: ("", ""),
    1: ("FG1 FG2 TC1 TC2", "1.0 1.0 0.9000E-02 0.9000E-02"),
    2: ("FLX1 FLX2 FLX3 K0_MF ALFAMF BETAMF", "1e-5 1e-5 1e-5 1. 1. 1."),
    4: ("GG3 LAYTHK TAU_C0 K_TAU", "8200. 0.01 50. 0."),
}
LAWS = {
    0: ("FSTAT FKIN", "0.4 0.4"),
    2: ("FKIN FLIN1 SABSH1 FLIN2 SABSH2 MEMDST MEM_S0", "0.2 0.1 50. 0. 1. 0. 1."),
    6: ("FREF TREF DFHEAT DTHEAT MEMDST MEM_S0", "0.3 0. -0.1 400. 0. 1."),
}
PLASTIC = ("TAUCRT", "UPLSX", "UPLSY")
HEATED = ("TEMP1", "TEMP2")


@pytest.mark.parametrize("M", MATERIALS)
@pytest.mark.parametrize("L", LAWS)
@pytest.mark.parametrize("more", [(), PLASTIC, (*PLASTIC, *HEATED)], ids=len)
def test_every_kind_of_result_is_read(tmp_path, M, L, more):
    """Layers, viscoelastic bodies, simplified theories, laws, plasticity and temperatures."""
    names, numbers = MATERIALS[M]
    poisson = (" POISS2", " 0.42") if M != 2 else ("", "")
    law_names, law = LAWS[L]
    rows = "".join(
        f" {k} {state} 0.01 0.4 {4 - k:.1f} 1.0 0.5 0.02 0. 0. 0.-100 {'7.5 ' * len(more)}\n"
        for k, state in enumerate((1, 2, 3), 1)
    )
    path = tmp_path / "kinds.0001.mat"
    path.write_text(
        "%  TIM S_WS(FC) TH_WS(FC) Y_R(TR) Z_R(TR) ROLL_R(TR) RNOM_ROL - FMT\n 7*0. 0 2410\n".replace(
            "7*0.", "0. 0. 0. 0. 0. 0. 0."
        )
        + "% X_CP(R) Y_CP(R) NPATCH IPATCH SPINXO SPINYO -\n 1. 2. 1 1 0. 0. 0.\n"
        + "% MX MY XL YL DX DY CHI DQ C1 D YNOM_WHL -\n 3 1 0. 0. .5 .5 0. .5 1 4 750. 0.\n"
        + f"% T M GG1 GG2 POISS1{poisson[0]} {names} -\n 3 {M} 200. 200. .42{poisson[1]} {numbers} 0.\n"
        + f"% L H VELOC {law_names} -\n {L} 3 1000. {law} 0.\n"
        + f"% I IGS H MU PN PX PY UN UX UY SREL {' '.join(more)}\n{rows}"
    )
    result = vc.read_contact_result(path)
    assert result.normal_force == pytest.approx(6.0 * 0.25)
    assert result.state.tolist() == [[1, 2, 3]]
    assert result.values["D"] == 4.0
    assert all(result.columns[name].tolist() == [[7.5] * 3] for name in more)
    assert result.values[law_names.split()[0]] == float(law.split()[0])
