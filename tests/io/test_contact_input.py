"""Input files of CONTACT: what is read is solved, and held against closed forms and what CONTACT's
guide prints.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import varcontact as vc
from tests.command import assert_bad_input, run
from tests.scenes import refused
from varcontact.elasticity.halfspace import influence_numbers
from varcontact.reference.bufler import bufler

DATA = Path(__file__).parent.parent / "data" / "contact"

CASE = """
 3  MODULE
 203100   P-B-T-N-F-S
 022020   L-D-C-M-Z-E
 0000001  H-G-I-A-O-W-R
 100 100 30 1 1e-6            MAXGS, MAXIN, MAXNR, MAXOUT, EPS
 1000.  0.001  0.002  0.0003  FN, CKSI, CETA, CPHI
 0.3  0.3                     FSTAT, FKIN
 0.0  0.2  5000.              CHI, DQ, VELOC
 0.28  0.28  82000. 82000.    POISS 1,2, GG 1,2
 1                            IPOTCN
 4 3   -1.0 -0.6  0.5 0.4     MX, MY, XL, YL, DX, DY
 1 1                          IBASE, IPLAN
 0.01 0.002 0.02 0.003 -0.004 0.005   B1 to B6
 0  MODULE
"""
FORMULA = (
    " 1 1                          IBASE, IPLAN\n 0.01 0.002 0.02 0.003 -0.004 0.005   B1 to B6"
)
SURFACE = CASE[CASE.index(" 1                            IPOTCN") : CASE.index(" 0  MODULE")]


def read(tmp_path, *changes, text=CASE):
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    path = tmp_path / "case.inp"
    path.write_text(text)
    return vc.read_contact_input(path)


def test_cattaneos_shift_has_the_numbers_that_contact_prints():
    """The guide, section 5.1: FX = -3.218, SHIFT X = 8.155E-03, APPROACH = 1.998E-02, PMAX = 4.393
    on this grid.
    """
    normal, shift = vc.read_contact_input(DATA / "cattaneo.inp")
    assert normal.motion is None
    assert normal.surface == vc.Ellipse(a=1.0, b=1.0)
    assert normal.grid.shape == (19, 19)
    assert normal.grid.x0 == pytest.approx(-1.26667)
    assert normal.hertz.peak_pressure == pytest.approx(4.3905, abs=5e-5)
    sol = vc.solve(shift)
    assert sol.force[0] == pytest.approx(-3.218, abs=5e-4)
    assert sol.creepage[0] == pytest.approx(8.155e-3, abs=5e-7)
    assert sol.approach == pytest.approx(1.998e-2, abs=5e-6)
    assert sol.pressure.max() == pytest.approx(4.393, abs=5e-4)
    assert shift.units == vc.MM_N
    closed = 0.75 * 3 * 0.4 * 9.1954 / (2 * np.pi * 200) * (np.pi / 2 - 0.42 * np.pi / 4)
    assert sol.creepage[0] == pytest.approx(closed, rel=0.003)


def test_carters_cylinder():
    """One long row is near plane strain: 60 % of the strip sticks, and Fx = (1 - 0.36) f Fz; the
    traction opposes.
    """
    (scene,) = vc.read_contact_input(DATA / "carter.inp")
    assert scene.normal_force == 35780
    assert scene.grid.x[1] == pytest.approx(-1.05)
    assert scene.motion == vc.Steady(vx=-0.00024, dq=0.04)
    sol = vc.solve(scene)
    assert sol.force[0] / (0.3 * scene.normal_force) == pytest.approx(0.64, rel=0.02)
    assert sol.elements["stick"] / sol.elements["contact"] == pytest.approx(0.6, abs=0.02)


def test_unlike_rollers_of_bentall_and_johnson():
    """With almost no friction free rolling is near CKSI = 0.00052 as the guide has it, mirrored;
    without slip Bufler's.

    The second case keeps grid, material, distance and solver of the first.
    """
    slipping, sticking = vc.read_contact_input(DATA / "bentall_johnson.inp")
    assert slipping.bodies == vc.Bodies(G=(23000.0, 82000.0), nu=(0.31, 0.28))
    assert slipping.bodies.K == pytest.approx(0.100, abs=5e-4)
    sol = vc.solve(slipping)
    assert abs(sol.force[0]) < 0.1 * 1e-4 * slipping.normal_force
    assert sticking.grid == slipping.grid
    np.testing.assert_array_equal(sticking.surface.h, slipping.surface.h)
    assert sticking.motion.Fx == 0.0
    free = vc.solve(sticking)
    assert free.elements["slip"] == 0
    cylinders = replace(
        sticking,
        surface=vc.Cylinders(R=25.0),
        normal_force=16.2019,
        friction=np.inf,
        grid=vc.Grid(nx=sticking.grid.nx, dx=sticking.grid.dx, x0=sticking.grid.x0),
    )
    assert free.creepage[0] == pytest.approx(vc.solve(cylinders).creepage[0], rel=1e-3)
    closed = bufler(25.0, slipping.bodies, force=16.2019)
    # what 50 elements across the contact miss
    assert free.creepage[0] == pytest.approx(closed.creepage, rel=0.04)


def test_a_sequence_is_one_history():
    (scene,) = vc.read_contact_input(DATA / "onset_of_rolling.inp")
    force = -0.657 * 0.4013 * 0.4705
    assert isinstance(scene.motion, vc.Transient)
    assert scene.motion.dq == (0.0, 0.5, 0.5)
    assert scene.motion.Fx == pytest.approx((force,) * 3)
    history = vc.solve(scene)
    text = (DATA / "onset_of_rolling.inp").read_text()
    shift = vc.solve(
        replace(scene, motion=vc.Shift(Fx=force), normal_force=0.4705, friction=0.4013)
    )
    np.testing.assert_allclose(history[0].traction, shift.traction, atol=1e-10)
    assert text.count("MODULE") == 4
    assert (
        np.abs(history[1].traction - history[0].traction).max()
        > 0.01 * np.abs(shift.traction).max()
    )


def test_a_formula_for_the_distance(tmp_path):
    (scene,) = read(tmp_path)
    assert scene.grid == vc.Grid(nx=4, ny=3, dx=0.5, dy=0.4, x0=-1.0, y0=-0.6)
    assert scene.motion == vc.Steady(vx=0.001, vy=0.002, spin=0.0003, dq=0.5)
    assert (scene.normal_force, scene.friction) == (1000.0, 0.3)
    x, y = -0.75, -0.4
    expected = 0.01 * x**2 + 0.002 * x * y + 0.02 * y**2 + 0.003 * x - 0.004 * y + 0.005
    assert scene.surface.h[0, 0] == pytest.approx(expected, rel=1e-14)
    assert scene.surface.h[0, 3] == pytest.approx(
        expected + 0.003 * 1.5 + 0.002 * 1.5 * y, rel=1e-14
    )


@pytest.mark.parametrize(
    "given",
    [
        " 2                            IPOTCN\n 4 3   -1.0 -0.6  1.0 0.6     MX",
        " 3                            IPOTCN\n 4 3   -0.75 -0.4  0.5 0.4    MX",
        " 4                            IPOTCN\n 4 3   -0.75 -0.4  0.75 0.4   MX",
    ],
)
def test_every_form_of_the_potential_contact_is_the_same(tmp_path, given):
    (first,) = read(tmp_path)
    form = " 1                            IPOTCN\n 4 3   -1.0 -0.6  0.5 0.4     MX"
    (scene,) = read(tmp_path, (form, given))
    np.testing.assert_allclose(scene.grid.x, first.grid.x, atol=1e-15)
    np.testing.assert_allclose(scene.grid.y, first.grid.y, atol=1e-15)
    np.testing.assert_allclose(scene.surface.h, first.surface.h, rtol=1e-12)


def test_distances_by_element_have_x_running_first(tmp_path):
    values = "0 1 2 3\n4 5 6 7\n8 9 10 11  H"
    (scene,) = read(tmp_path, (FORMULA, f" 9 1\n{values}"))
    np.testing.assert_array_equal(scene.surface.h, np.arange(12.0).reshape(3, 4))


def test_a_profile_is_linear_between_its_points_and_beyond(tmp_path):
    (scene,) = read(tmp_path, (FORMULA, " 2 1\n 3 0.25 500. -0.2 0.2\n 0.3 0.1 0.2"))
    # at y = -0.4, 0, 0.4 of points -0.2, 0, 0.2
    lower, upper = 0.3 - (0.1 - 0.3) * 1.0, 0.2 + (0.2 - 0.1) * 1.0
    expected = np.array([lower, 0.1, upper])[:, None] + (scene.grid.x - 0.25) ** 2 / 1000
    np.testing.assert_allclose(scene.surface.h, expected, rtol=1e-12)


def test_hertzian_contacts_by_curvature_and_by_ratio(tmp_path):
    (by_axes,) = read(tmp_path, (SURFACE, " -3\n 10 8  2.0 1.0 1.25\n"))
    contact = by_axes.hertz
    A, B = 1 / (2 * contact.Rx), 1 / (2 * contact.Ry)
    (by_curvatures,) = read(tmp_path, (SURFACE, f" -1\n 10 8  {A!r} {B!r} 1.25\n"))
    (by_ratio,) = read(tmp_path, (SURFACE, f" -2\n 10 8  {A!r} 2.0 1.25\n"))
    for scene in (by_curvatures, by_ratio):
        assert scene.hertz.a == pytest.approx(2.0, rel=1e-9)
        assert scene.hertz.b == pytest.approx(1.0, rel=1e-9)
        assert scene.grid.sides == pytest.approx((0.5, 0.3125), rel=1e-9)
        assert scene.grid.x0 == pytest.approx(-2.5, rel=1e-9)


@pytest.mark.parametrize(
    ("digit", "law"), [(2, vc.LinearFalling), (3, vc.RationalFalling), (4, vc.ExponentialFalling)]
)
def test_laws_of_friction(tmp_path, digit, law):
    friction = (
        " 0.3  0.3                     FSTAT, FKIN",
        " 0.2 0.1 50. 0 1. \n 0.0 1.0  MEMDST, MEM_S0",
    )
    (scene,) = read(tmp_path, friction, (" 022020 ", f" {digit}22020 "))
    assert scene.friction == law(static=0.2 + 0.1, kinetic=0.2, half_velocity=50.0, velocity=5000.0)


def test_forces_are_parts_of_what_friction_carries(tmp_path):
    (one,) = read(tmp_path, (" 203100 ", " 203110 "), ("0.001  0.002", "-0.5  0.002"))
    assert one.motion == vc.Steady(Fx=-150.0, vy=0.002, spin=0.0003, dq=0.5)
    (two,) = read(tmp_path, (" 203100 ", " 203120 "), ("0.001  0.002", "-0.5  0.25"))
    assert two.motion == vc.Steady(Fx=-150.0, Fy=75.0, spin=0.0003, dq=0.5)


@pytest.mark.parametrize("ratio", [0.5, 1, 2, 10])
@pytest.mark.parametrize("surface", ["elements", "hertz", "one row"])
def test_steady_rolling_has_the_step_dx_whatever_dq_is(tmp_path, ratio, surface):
    """As CONTACT has it (its subroutine check_roll_stepsize): only its solver ConvexGS, G = 2,
    takes DQ.
    """
    place = {"elements": SURFACE, "hertz": " -3\n 10 8  2.0 1.0 1.25\n",
             "one row": SURFACE.replace("4 3   -1.0 -0.6  0.5 0.4", "4 1   -1.0 -0.6  0.5 400.")}[surface]  # fmt: skip
    dq = ratio * 0.5
    changes = (SURFACE, place), ("0.0  0.2  5000.", f"0.0  {dq}  5000."), ("0.0003  FN", "0.0  FN")
    (scene,) = read(tmp_path, *changes)
    assert scene.grid.dx == pytest.approx(0.5)
    assert scene.motion.dq == scene.grid.dx
    convex_gs = (
        (" 0000001 ", " 0200001 "),
        ("MAXOUT, EPS", "MAXOUT, EPS\n 0.5 1.0 1 1.1  OMEGAH, OMEGAS, INISLP, OMGSLP"),
    )
    (by_convex_gs,) = read(tmp_path, *changes, *convex_gs)
    assert by_convex_gs.motion.dq == dq


NEXT = """ 3  MODULE
 {problem}   P-B-T-N-F-S
 {kept}   L-D-C-M-Z-E
 0100001  H-G-I-A-O-W-R
 500.  0.004  0.0  0.0  FN, CKSI, CETA, CPHI
"""


def test_transient_rolling_has_the_step_dq(tmp_path):
    """Of its own case or the case before, which in steady rolling is DX: CONTACT overwrites DQ."""
    kept = NEXT.format(problem="202100", kept="100000") + " 0  MODULE\n"
    transient = (" 203100 ", " 202100 ")
    for changes, dq in (([transient], 0.2), ([], 0.5), ([(" 0000001 ", " 0000003 ")], 0.2)):
        *_, after = read(tmp_path, (" 0  MODULE\n", kept), *changes)
        assert after.motion.dq == (dq,)
    more = (
        NEXT.format(problem="002100", kept="102000")
        + " 0.0 0.7 5000. CHI\n 0.28 0.28 82000. 82000. POISS\n"
    )
    (history,) = read(tmp_path, transient, (" 0  MODULE\n", more + " 0  MODULE\n"))
    assert history.motion.dq == (0.2, 0.7)


def test_a_step_is_not_kept_through_a_shift(tmp_path):
    """CONTACT needs CHI, DQ and VELOC anew (its error 2041)."""
    shift, rolling = (
        NEXT.format(problem="201100", kept="100000"),
        NEXT.format(problem="202100", kept="100000"),
    )
    with pytest.raises(
        vc.SceneError,
        match=r"T \(TANG\) = 2 needs CHI, DQ and VELOC, which the case before does not",
    ):
        read(tmp_path, (" 0  MODULE\n", shift + rolling + " 0  MODULE\n"))


def test_the_point_where_spin_is_sampled_may_be_given(tmp_path):
    step = (" 0.0  0.2  5000.  ", " 0.0  0.2  5000. {} ")
    for given, offset in (("0.5", 0.5), ("", 1 / 6), ("words 0.5", 1 / 6)):
        (scene,) = read(tmp_path, (step[0], step[1].format(given)))
        assert scene.motion.spin_offset == offset


def test_debug_output_and_every_solver_are_passed_over(tmp_path):
    """Each brings parameters on a line of its own; the problem is the same."""
    (plain,) = read(tmp_path)
    parameters = {0: "", 3: "0.5 1.0 1 1.1", 4: "1 1.1", 5: "1.0 0.05 1 1.0 0.0 1.0 1.0 0.9"}
    for digit, line in parameters.items():
        solver = (" 0000001 ", f" {digit:02d}00001 "), ("MAXOUT, EPS", f"MAXOUT, EPS\n {line}")
        (found,) = read(tmp_path, *solver)
        assert (found.motion, found.grid) == (plain.motion, plain.grid)
    debug = (" 0000001  H-G-I-A-O-W-R", "10000001  X-H-G-I-A-O-W-R\n 1000005  P-S-F-L-R-I-N")
    (found,) = read(tmp_path, debug)
    assert (found.motion, found.grid) == (plain.motion, plain.grid)


@pytest.mark.parametrize(("kind", "points"), [
    (1, " 2 0.1 0.1  NZ, ZL, DZ\n"),
    (2, " 1 1 4   FIRST, STEP, LAST COLUMN\n 1 1 3  FIRST, STEP, LAST ROW\n 2 0.1 0.1  NZ, ZL, DZ\n"),
    (3, " 2 1  NX, NY\n 1\n 4  THE COLUMNS\n 2  THE ROW\n 2 0.1 0.1  NZ, ZL, DZ\n"),
    (5, " 3  NZ\n 0.1 0.2\n 0.5  DEPTHS\n"),
    (6, " 1 1 4   COLUMNS\n 1 1 3  ROWS\n 2  NZ\n 0.1 0.2 DEPTHS\n"),
    (7, " 1 1  NX, NY\n 4  COLUMN\n 2  ROW\n 1  NZ\n 0.1  DEPTH\n"),
    (9, " 1 1 2  NX, NY, NZ\n 0.5 X\n 0.1 Y\n 0.1\n 0.2 Z\n"),
])  # fmt: skip
def test_words_behind_the_points_of_stress_are_no_numbers(tmp_path, kind, points):
    stresses = f" 1 0  MATFIL, OUTPUT\n {kind}  ISUBS\n{points} 0  ISUBS\n"
    more = NEXT.format(problem="203100", kept="100000")
    first, second = read(
        tmp_path, (" 203100 ", " 203103 "), (" 0  MODULE\n", stresses + more + " 0  MODULE\n")
    )
    assert (first.motion.vx, second.motion.vx) == (0.001, 0.004)


def test_the_centre_of_spin(tmp_path):
    """Spin about (x0, y0) is spin about the origin and a creepage: vx - spin (y - y0), vy + spin (x
    - x0).
    """
    (scene,) = read(tmp_path, ("0.0003  FN", "0.0003 2.0 3.0  FN"))
    assert scene.motion.vx == pytest.approx(0.001 + 0.0003 * 3.0)
    assert scene.motion.vy == pytest.approx(0.002 - 0.0003 * 2.0)


def test_rolling_backwards_in_time_and_points_of_stress(tmp_path):
    """Transient rolling may go towards negative x; degrees are angles, and blocks of stress points
    are passed over.
    """
    stresses = " 0.01 0.002 0.02 0.003 -0.004 0.005\n 1 0\n 2\n 1 1 4\n 1 1 3\n 2 0.1 0.1\n 0\n 0  MODULE\n"
    changes = (" 0.01 0.002 0.02 0.003 -0.004 0.005   B1 to B6\n 0  MODULE\n", stresses)
    (scene,) = read(
        tmp_path, (" 203100 ", " 202103 "), (" 0.0  0.2  5000.", " 180d 0.2  5000."), changes
    )
    assert (scene.motion.steps, scene.motion.direction, scene.motion.dq) == (1, (-1,), (0.2,))
    assert scene.motion.vx == (0.001,)


@pytest.mark.parametrize(("old", "new", "words"), [
    (" 3  MODULE\n 2", " 2  MODULE\n 2", "line 2: MODULE = 2 is not supported; supported: 1 (wheel on rail), 3 (basic"),
    (" 203100 ", " 204100 ", "line 3: T (TANG) = 4 is not supported; supported: 0 (no tangential problem), 1"),
    (" 203100 ", " 223100 ", "line 3: B (BOUND) = 2 needs a Hertzian contact, IPOTCN < 0"),
    (" 203100 ", " 402100 ", "line 3: P (PVTIME) = 4 is not supported; supported: 0 (continues the case before)"),
    (" 022020 ", " 722020 ", "line 4: L (FRCLAW) = 7 is not supported; supported: 0 (Coulomb), 1 (as before)"),
    (" 022020 ", " 032020 ", "line 4: D (DISCNS) = 3 is not supported"),
    (" 022020 ", " 023020 ", "line 4: C (INFLCF) = 3 is not supported: tractions are constant on elements here;"),
    (" 022020 ", " 029020 ", "line 10: CFNAME = '0.28' is not a name in quotes"),
    (" 022020 ", " 022620 ", "line 4: M (MATER) = 6 is not supported: it is reserved in CONTACT; supported: 0 (elastic)"),
    (" 022020 ", " 022220 ", "line 11: K0_MF = 'IPOTCN' is not a number"),
    (" 022020 ", " 022029 ", "ends before 24 values of EXRHS"),
    (" 022020 ", " 1022020 ", "line 4: V (VARFRC) = 1 is not supported: by inclination, friction varies on rails"),
    (" 022020  ", " 022020 3 ", "line 4: M2 (MATER2) = 3 is not 0, 1 or 2"),
    (" 022020 ", " 002000 ", "line 4: D (DISCNS) = 0 keeps the elements of the case before, and there is none: use D = 2"),
    (" 0000001 ", " 2000001 ", "line 5: H (HEAT) = 2 is not supported; supported: 0 (no temperatures)"),
    (" 0000001 ", " 0000004 ", "line 5: R (RETURN) = 4 is not supported; supported: 0 (calculate), 1 (calculate), 2"),
    (" 0000001 ", " 0000003 ", "holds no case that is to be calculated"),
    (" 0000001 ", " zero ", "line 5: XHGIAOWR = 'zero' is not a control word of at most 8 digits"),
    (" 0.3  0.3 ", " 0.4  0.3 ", "line 8: FKIN = 0.3 is not FSTAT = 0.4"),
    (" 0.0  0.2  5000. ", " 90d  0.2  5000. ", "line 9: CHI, DQ, VELOC ="),
    (" 1                            IPOTCN", " -7  IPOTCN", "line 11: IPOTCN = -7 is not supported; supported: -1"),
    (" 1 1                          IBASE", " 4 1  IBASE", "line 13: IBASE = 4 is not supported; supported: 1"),
    (" 1 1                          IBASE", " 1 5  IBASE", "line 13: IPLAN = 5 is not supported; supported: 1"),
    (" 4 3   -1.0", " 4.5 3  -1.0", "line 12: MX = '4.5' is not a whole number"),
    (" 4 3   -1.0", " 9999 9999  -1.0", "line 12: MX MY = 99980001 is more than the 10000000 elements"),
    (" 0.3  0.3 ", " 0.3 0.3 0.3 ", "line 8: line = 0.3 is a number too many behind FSTAT, FKIN; remarks begin with %"),
    (" 0.0003  FN", "  FN", "line 7: CPHI = 'FN' is not a number"),
    (" 0.3  0.3                     FSTAT, FKIN\n", " 0.3\n", "line 8: line = 0.2 is a number too many behind FSTAT, FKIN"),
    (" 1000. ", " much ", "line 7: FN = 'much' is not a number"),
    (
        " 1 1                          IBASE",
        " 2 1\n 999999 0 500. 0 0.1",
        "ends before 999999 values of B",
    ),
    (" -0.004 0.005   B1 to B6\n 0  MODULE", "", "ends before 6 values of B"),
])  # fmt: skip
def test_what_is_not_read_is_said_by_line_and_digit(tmp_path, old, new, words):
    refused(lambda: read(tmp_path, (old, new)), words=words)


def test_laws_have_a_memory_and_a_second_term(tmp_path):
    old, digit = " 0.3  0.3                     FSTAT, FKIN", (" 022020 ", " 422020 ")
    (scene,) = read(tmp_path, (old, "0.2 0.1 50. 0 9.\n 0.001 2"), digit)
    law = scene.friction
    assert (law.memory_distance, law.memory_velocity, law.memory_step) == (0.001, 2.0, "implicit")
    # a step of Euler: d/(d + slid), of many steps the exact part
    own = law(np.array([1e-3]))
    kept = (law.after(0.3, own, np.array([1e-3]), 0.2) - own) / (0.3 - own)
    assert kept == pytest.approx(0.001 / (0.001 + 1e-3 * 0.2))
    many = law.after(0.3, own, np.array([1e-3]), 2e-6)
    exact = replace(law, memory_step="exact").after(0.3, own, np.array([1e-3]), 2e-6)
    assert many == pytest.approx(exact, abs=1e-9)
    scene.save(tmp_path / "law.toml")
    assert vc.read_scene(tmp_path / "law.toml")[0].friction == law
    refused(lambda: replace(law, memory_step="other"), words="memory_step")
    (scene,) = read(tmp_path, (old, "0.2 0.1 50. 0.1 9.\n 0 1"), digit)
    terms = [0.1 * np.exp2(-s / h) for s, h in ((20.0, 50.0), (20.0, 9.0))]
    assert scene.friction.on(np.array([[20.0 / 5000]])) == pytest.approx(0.2 + sum(terms))


def test_an_elliptic_bound_is_for_like_bodies(tmp_path):
    hertz, bound = (SURFACE, " -3\n 10 8  2.0 1.0 1.25\n"), (" 203100 ", " 223100 ")
    (scene,) = read(tmp_path, hertz, bound)
    assert vc.plan(scene).normal == "hertz"
    with pytest.raises(
        vc.SceneError, match=r"line 3: B \(BOUND\) = 2 with unlike bodies is not supported"
    ):
        read(tmp_path, hertz, bound, (" 82000. 82000. ", " 82000. 23000. "))


def test_a_case_that_is_skipped_gives_what_the_next_keeps(tmp_path):
    one = CASE[: CASE.index(" 0  MODULE")].replace(" 0000001 ", " 0000003 ")
    other = """ 3  MODULE
 203100   P-B-T-N-F-S
 100000   L-D-C-M-Z-E
 0100001  H-G-I-A-O-W-R
 500.  0.004  0.0  0.0  FN, CKSI, CETA, CPHI
 0  MODULE
"""
    (scene,) = read(tmp_path, text=one + other)
    (first,) = read(tmp_path)
    assert scene.motion == vc.Steady(vx=0.004, dq=0.5)
    assert (scene.normal_force, scene.friction, scene.grid) == (500.0, 0.3, first.grid)
    np.testing.assert_array_equal(scene.surface.h, first.surface.h)


def test_no_such_file(tmp_path):
    refused(lambda: vc.read_contact_input(tmp_path / "none.inp"), words="cannot be read")


def test_the_command_solves_one_scene_of_a_file(tmp_path):
    path = DATA / "cattaneo.inp"
    done = run("solve", path, "--case", "2", "--json", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["force"][0] == pytest.approx(-3.2184, abs=1e-4)
    for case, words in (
        ([], "holds 2 scenes; give a number from 1 to 2"),
        (["--case", "3"], "from 1 to 2, not 3"),
    ):
        assert_bad_input(run("solve", path, *case, folder=tmp_path), words)
    (tmp_path / "scene.toml").write_text("")
    told = "--case = 1 must be left out: only an input file of CONTACT (.inp) has several scenes"
    assert_bad_input(run("solve", "scene.toml", "--case", "1", folder=tmp_path), told)


@pytest.mark.parametrize("length", [0.5, 1000.0])
def test_one_row_has_rows_without_contact_beside_it(tmp_path, length):
    """Whatever its length, it is three-dimensional, as in CONTACT."""
    row = f" 4 1   -1.0 {-length / 2}  0.5 {length}"
    (scene,) = read(tmp_path, (" 4 3   -1.0 -0.6  0.5 0.4", row))
    (alone,) = read(tmp_path)
    grid = vc.Grid(nx=6, ny=3, dx=0.5, dy=length, x0=-1.5, y0=-1.5 * length)
    assert (scene.grid, scene.normal_force) == (grid, alone.normal_force)
    assert scene.surface.h[1, 1] < 0.1 < scene.surface.h[0].min()
    sol = vc.solve(scene)
    assert not sol.pressure[[0, 2]].any()
    assert sol.normal_force == pytest.approx(1000.0)


RECTANGLE = """ {potential}   IPOTCN
 24 11 {sizes} 1.2   MX, MY, SIZES, SCALE
"""


@pytest.mark.parametrize(
    ("bound", "potential", "sizes", "peak"),
    [
        (2, -5, "1.5 2.0", 2 / (np.pi * 1.5 * 4.0)),
        (3, -5, "1.5 2.0", 3 / (4 * 1.5 * 4.0)),
        (4, -6, "1.5 1.0 3.0", 3 / (2 * np.pi * 1.5 * 2.0)),
        (3, -3, "1.5 2.0", 2 / (np.pi * 1.5 * 2.0)),
    ],
)
def test_prescribed_pressures(tmp_path, bound, potential, sizes, peak):
    """Of two-dimensional Hertz's contact, two half-ellipses and a paraboloid: the guide, 4.3."""
    changes = [
        (SURFACE, RECTANGLE.format(potential=potential, sizes=sizes)),
        (" 203100 ", f" 2{bound}3100 "),
    ]
    (scene,) = read(tmp_path, *changes)
    pressure = vc.solve(replace(scene, motion=None, friction=None)).pressure
    y, x = np.meshgrid(scene.grid.y, scene.grid.x / 1.5, indexing="ij")
    if potential == -5:
        inside = (1 - x**2) * (np.abs(y) < 2.0)
    elif potential == -6:
        y = y + 1.0  # the half-ellipses meet at (bneg - bpos)/2
        inside = 1 - x**2 - np.where(y > 0, y / 3.0, y) ** 2
    else:
        inside = 1 - x**2 - (y / 2.0) ** 2
    form = np.maximum(inside, 0.0) ** (1.0 if bound == 3 else 0.5)
    np.testing.assert_allclose(pressure, 1000.0 * peak * form, atol=1e-6 * 1000.0 * peak)
    assert pressure.sum() * scene.grid.area == pytest.approx(1000.0, rel=0.03)


def test_a_cylinder_of_finite_length_has_hertz_half_width(tmp_path):
    """IPOTCN = -4: the curvature A1 = 1/(2 R), the load per length FN/(2 BB)."""
    by_curvature = RECTANGLE.format(potential=-4, sizes="0.01 2.0")
    (scene,) = read(tmp_path, (SURFACE, by_curvature), (" 203100 ", " 223100 "))
    line = vc.Scene(
        bodies=scene.bodies, surface=vc.Cylinders(R=50.0), normal_force=250.0, grid=vc.Grid(nx=9)
    )
    assert scene.grid.box[1] == pytest.approx(1.2 * line.hertz.a)


def test_prescribed_pressures_are_refused_by_name(tmp_path):
    for potential, bound, words in [
        (-5, 0, "IPOTCN = -5 needs B = 2 or 3"),
        (-6, 2, "IPOTCN = -6 needs B = 4"),
        (-3, 4, "B (BOUND) = 4 needs two half-ellipses, IPOTCN = -6"),
        (-3, 1, "B (BOUND) = 1 needs a contact by its distance"),
    ]:
        sizes = "1.5 1.0 3.0" if potential == -6 else "1.5 2.0"
        changes = [
            (SURFACE, RECTANGLE.format(potential=potential, sizes=sizes)),
            (" 203100 ", f" 2{bound}3100 "),
        ]
        if bound == 1:
            changes.append((" 82000. 82000. ", " 82000. 82000.\n 1e-5  FLX_Z\n%"))
        refused(lambda changes=changes: read(tmp_path, *changes), words=words)


def test_a_thin_sheet_gives_way(tmp_path):
    """B = 1: half-spaces with a sheet whose elements give way by FLX_Z times their own pressure."""
    sheet = (" 82000. 82000. ", " 82000. 82000.\n 2e-6  FLX_Z\n%")
    (scene,) = read(tmp_path, (" 203100 ", " 213100 "), sheet)
    sheeted = vc.solve(scene)
    (pressed,) = read(tmp_path)  # half-spaces on a distance that the sheet makes smaller
    own = replace(pressed.surface, h=pressed.surface.h + 2e-6 * sheeted.pressure)
    load = {"normal_force": None, "approach": sheeted.approach}
    without = vc.solve(replace(pressed, surface=own, **load))
    np.testing.assert_allclose(without.pressure, sheeted.pressure, atol=1e-4)
    assert without.force == pytest.approx(sheeted.force, rel=1e-4)
    assert sheeted.approach > vc.solve(pressed).approach


def test_influence_numbers_of_a_file(tmp_path):
    """C = 9: those of half-spaces in a file are half-spaces."""
    (bare,) = read(tmp_path)
    grid = bare.grid
    nx, ny = grid.nx + 1, grid.rows
    dx, dy = grid.sides
    x = dx * np.arange(nx)
    pairs = ("zz", "zx", "zy", "xz", "xx", "xy", "yz", "yx", "yy")
    lines = ["1 2", "0 312", "1 0", f"{nx} {ny} {dx!r} {dy!r}"]
    for j in range(1 - ny, ny):
        numbers = influence_numbers(x, j * dy, dx, dy, nu=0.28, components=pairs)
        lines += [f"% {j}", "% numbers"]
        for i in range(nx):
            row = " ".join(repr(float(numbers[pair][i])) for pair in pairs)
            lines.append(f"{i} {float(x[i])!r} {row}")
    (tmp_path / "numbers.txt").write_text("\n".join(lines) + "\n")
    velocity = "5000.              CHI, DQ, VELOC"
    named = (velocity, f"{velocity}\n 'numbers.txt'  CFNAME")
    (scene,) = read(tmp_path, (" 022020 ", " 029020 "), named)
    forces = [vc.solve(each).force for each in (scene, bare)]
    np.testing.assert_allclose(forces[0], forces[1], rtol=1e-6)
    missing = (velocity, f"{velocity}\n 'none.txt'  CFNAME")
    refused(lambda: read(tmp_path, (" 022020 ", " 029020 "), missing), words="line 10: ")
    other = (" 4 3   -1.0 -0.6  0.5 0.4", " 4 3   -1.0 -0.6  0.25 0.4")
    refused(lambda: read(tmp_path, (" 022020 ", " 029020 "), named, other), words="sides")


def test_a_case_may_be_an_iteration_of_the_one_before(tmp_path):
    """P = 3: it goes on from the tractions that the case before went on from."""
    first = CASE.replace(" 203100 ", " 202100 ")
    more = first[: first.index(" 0  MODULE")]
    text = more + more.replace(" 202100 ", " 002100 ") + more.replace(" 202100 ", " 302100 ")
    path = tmp_path / "case.inp"
    path.write_text(text + " 0  MODULE\n")
    before = [case.before and case.before.number for case in vc.read_contact_input(path).cases]
    assert before == [None, 1, 1]


def test_a_case_may_stay_in_its_module(tmp_path):
    """R = 0 and 2: the next case does not name its module; R = 0 before one that does is read, too."""
    case = CASE[CASE.index(" 203100 ") : CASE.index(" 0  MODULE")]
    heavier = case.replace(" 1000. ", " 2000. ")
    for digit, loads in ((0, [1000.0, 2000.0]), (2, [2000.0])):
        first = case.replace(" 0000001 ", f" 000000{digit} ")
        path = tmp_path / "case.inp"
        path.write_text(f" 3 MODULE\n{first}{heavier} 0\n")
        found = vc.read_contact_input(path)
        assert [scene.normal_force for scene in found] == loads
        assert [each.line for each in found.cases][-1] == 2 + len(first.splitlines())
        path.write_text(f" 3 MODULE\n{first} 3 MODULE\n{heavier} 0 MODULE\n")
        assert [scene.normal_force for scene in vc.read_contact_input(path)] == loads


def test_the_second_rational_term_falls_with_the_square(tmp_path):
    """The guide, section 4.2.2; linear and exponential terms are alike."""
    old = " 0.3  0.3                     FSTAT, FKIN"
    (scene,) = read(tmp_path, (old, "0.2 0.1 50. 0.05 20.\n 0 1"), (" 022020 ", " 322020 "))
    expected = 0.2 + 0.1 / (1 + 30.0 / 50.0) + 0.05 / (1 + (30.0 / 20.0) ** 2)
    assert scene.friction.on(np.array([[30.0 / 5000]])) == pytest.approx(expected)


@pytest.mark.parametrize("damping", [0, 1, 2])
def test_damping_changes_no_force_that_is_printed(tmp_path, damping):
    """The guide, section 4.1.6: forces of damping are not in the output."""
    entries = (" 022020  ", f" 022020 {damping} ")
    changes = [entries]
    if damping == 2:
        material = " 0.28  0.28  82000. 82000.    POISS 1,2, GG 1,2"
        changes.append((material, f"{material}\n 1. 1. 1e3 1e3  CDAMPN, CDAMPT, DFNMAX, DFTMAX"))
    (known,) = read(tmp_path)
    (scene,) = read(tmp_path, *changes)
    assert scene.motion == known.motion
    assert scene.bodies == known.bodies


def test_errors_name_one_line(tmp_path):
    """That of the entry which is wrong, where another group asks for it."""
    conformal = (
        (" 022020 ", " 024020 "),
        (" 0.28  0.28  82000.", " 1 1 2\n -2 0 2 1d\n .28 .28 82000."),
    )
    refused(
        lambda: read(tmp_path, *conformal), match=r"^[^,]*case.inp, line 10: VARIANT = 1 is not"
    )
