"""Cases of CONTACT's input files run as it runs them, and compared with what it prints."""

import json
import math

import numpy as np
import pytest

import varcontact as vc
from tests.command import assert_bad_input, run
from tests.io.test_contact_input import CASE, DATA, FORMULA, SURFACE
from varcontact.study.contact_comparison import (
    Compared,
    by_case,
    compared,
    compared_stresses,
    report,
    summary_of,
    with_refined,
)
from varcontact.study.contact_runs import run_cases
from varcontact.study.contact_suite import FileCompared, page_of

STOP = " 0  MODULE\n"
FIRST = CASE[: CASE.index(STOP)]


def cases(tmp_path, text, strict=False):
    path = tmp_path / "case.inp"
    path.write_text(text)
    return vc.read_contact_input(path, strict=strict).cases


def values(tmp_path, text):
    """What each case has by CONTACT's names."""
    runs = list(run_cases(cases(tmp_path, text)))
    assert not any(run.reason for run in runs), [run.reason for run in runs]
    return [run.patches[0] for run in runs]


def changed(*changes, text=FIRST):
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


BALL = (FORMULA, " 1 1\n 0.01 0 0.01 0 0 0")
WIDE = (" 4 3   -1.0 -0.6  0.5 0.4", " 20 20   -2.0 -2.0  0.2 0.2")


def test_rolling_towards_negative_x_is_the_mirror_image(tmp_path):
    """x to -x: CKSI, CPHI, FX and MZ change their signs."""
    forth = changed(BALL, WIDE)
    back = changed(
        BALL,
        WIDE,
        (" 0.0  0.2  5000.", " 180.d 0.2  5000."),
        (" 1000.  0.001  0.002  0.0003 ", " 1000.  -0.001  0.002  -0.0003 "),
    )
    one, other = values(tmp_path, forth + back + STOP)
    for name, sign in (("FX", -1), ("FY", 1), ("MZ", -1), ("PMAX", 1)):
        assert other[name] == pytest.approx(sign * one[name], rel=1e-6), name


def test_forces_are_parts_of_a_normal_force_that_is_solved_for(tmp_path):
    """N = 0 and F = 1: FX is half of FSTAT FN."""
    given = changed(
        BALL,
        WIDE,
        (" 203100 ", " 203010 "),
        (" 1000.  0.001  0.002  0.0003 ", " 0.01  -0.5  0.0  0.0 "),
    )
    (case,) = cases(tmp_path, given + STOP)
    assert case.force_parts == (pytest.approx(-0.15), None)
    (found,) = values(tmp_path, given + STOP)
    assert found["FX"] == pytest.approx(-0.15 * found["FN"], rel=1e-6)
    assert found["APPROACH"] == pytest.approx(0.01)


def test_a_case_goes_on_on_elements_that_moved(tmp_path):
    """A second shift from the tractions of the first: on elements two columns further the same."""
    first = changed(
        BALL,
        WIDE,
        (" 203100 ", " 201100 "),
        (" 0.0  0.2  5000.              CHI, DQ, VELOC\n", ""),
        ("0.002  0.0003 ", "0.0  0.0 "),
    )
    second = changed((" 201100 ", " 001100 "), text=first)
    moved = changed(("20 20   -2.0", "22 20   -2.4"), text=second)
    (_, same), (_, other) = (values(tmp_path, first + each + STOP) for each in (second, moved))
    assert same == pytest.approx(other, abs=1e-6)
    (_, alone) = values(tmp_path, first + changed((" 001100 ", " 201100 "), text=second) + STOP)
    assert abs(alone["FX"] - same["FX"]) > 0.1 * abs(same["FX"])


def test_result_elements_keep_their_own_entries(tmp_path):
    """Cases of two result elements in turn: each keeps the friction of its own."""
    kept = """ 3 {}  MODULE
 203100
 100000
 0100001
 500.  0.004  0.0  0.0
"""
    one = FIRST.replace(" 3  MODULE", " 3 1  MODULE")
    two = changed((" 0.3  0.3 ", " 0.1  0.1 ")).replace(" 3  MODULE", " 3 2  MODULE")
    found = cases(tmp_path, one + two + kept.format(1) + kept.format(2) + STOP)
    assert [case.element for case in found] == [(1,), (2,), (1,), (2,)]
    assert [case.scene.friction for case in found] == [0.3, 0.1, 0.3, 0.1]


def test_what_cannot_be_run_is_left_out_by_name(tmp_path):
    """The other cases are read; one that goes on from it is left out, too."""
    fast = changed((" 203100 ", " 253100 "))
    path = tmp_path / "case.inp"
    path.write_text(FIRST + fast + FIRST + STOP)
    found = vc.read_contact_input(path, strict=False)
    assert [case.scene is None for case in found.cases] == [False, True, False]
    assert len(found) == 2
    assert [case.number for case in found.left_out] == [2]
    assert "3 cases, 1 of them left out\ncase 2: " in str(found)
    assert "line 17: B (BOUND) = 5 is not supported: KPEC" in found.left_out[0].reason
    with pytest.raises(vc.SceneError, match="line 17: B"):
        vc.read_contact_input(path)
    path.write_text(FIRST + " 3 MODULE\n 2031")
    cut = vc.read_contact_input(path, strict=False)
    assert [bool(case.reason) for case in cut.cases] == [False, True]
    # what cannot be read is passed over up to the next case, which keeps nothing of it
    kept = " 3 MODULE\n 203100\n 100000\n 0100001\n 500. 0.004 0. 0.\n"
    path.write_text(FIRST + changed((" 1000. ", " much ")) + FIRST + kept + STOP)
    found = vc.read_contact_input(path, strict=False)
    assert [case.number for case in found.left_out] == [2]
    assert "FN = 'much' is not a number" in found.left_out[0].reason
    path.write_text(FIRST + changed((" 1000. ", " much ")) + kept + STOP)
    found = vc.read_contact_input(path, strict=False)
    assert "keeps a material of the case before, and there is none" in found.left_out[1].reason


def test_numbers_as_fortran_reads_them(tmp_path):
    given = changed(
        (" 1000.  0.001  0.002  0.0003 ", " 1d3, 1.D-3,2-3  .3e-3 "),
        (" 0.28  0.28  82000. 82000. ", " 2*.28 2*82.q+3 "),
        (" 0.3  0.3 ", " 2*0.3 "),
    )
    assert values(tmp_path, given + STOP) == values(tmp_path, CASE)


def test_one_element_on_a_third_body_flows(tmp_path):
    """The traction of a layer that is perfectly plastic is its yield stress, against the shift."""
    element = " -3\n 1 1  0.5 0.5 1.0\n"
    given = changed(
        (SURFACE, element),
        (" 203100 ", " 201100 "),
        (" 022020 ", " 022420 "),
        (" 0.0  0.2  5000.              CHI, DQ, VELOC\n", ""),
        (" 0.28  0.28  82000. 82000. ", " 0.28  0.28  82000. 82000.\n 176. 0.02 150. 0.0 "),
        ("0.001  0.002  0.0003 ", "-0.05  0.0  0.0 "),
    )
    (found,) = values(tmp_path, given + STOP)
    assert found["FX"] == pytest.approx(150.0, rel=1e-6)
    assert found["PMAX"] == pytest.approx(1000.0)


def test_slip_from_above_is_the_other_solution(tmp_path):
    """INISLP < 0 of G = 4: solvers begin with slip all over."""
    law = (" 0.3  0.3                     FSTAT, FKIN", " 0.2 0.1 50. 0 1.\n 0 1")
    for slip, start in (("-1", "slip"), ("1", None)):
        given = changed(
            law,
            (" 022020 ", " 422020 "),
            (" 0000001 ", " 0400001 "),
            ("MAXGS, MAXIN, MAXNR, MAXOUT, EPS", f"\n {slip} 1.0"),
        )
        (case,) = cases(tmp_path, given + STOP)
        assert case.methods.get("start") == start


SIMPLIFIED = """ 3 MODULE
 2{bound}3100
 022320
 0000001
 80 200 5 1 1e-6
 82000. 0.0 -0.000625 0.000625
 0.3 0.3
 0.0 0.4 30000.
 0.28 0.28 82000. 82000.
 1.0 1.0 1.0
"""
"""Simplified theory with three flexibilities; the pressure by `bound`."""


@pytest.mark.parametrize(("bound", "FY", "MZ"), [(3, -15050.0, -39000.0), (2, -14800.0, -48290.0)])
def test_fastsim_as_contact_marches_it(tmp_path, bound, FY, MZ):
    """Published of the guide's section 5.13 (revision 2707): a = 8, b = 4 mm, CETA = -CPHI."""
    given = SIMPLIFIED.format(bound=bound) + " -3\n 44 44 8.0 4.0 1.1\n"
    (found,) = values(tmp_path, given + STOP)
    assert found["FY"] == pytest.approx(FY, abs=5)
    assert found["MZ"] == pytest.approx(MZ, abs=5)


def test_fastsim_under_pressures_that_are_solved_for(tmp_path):
    """B = 0: of Hertz's surface they are nearly elliptic; of another contact the flexibilities are
    those of its equivalent ellipse.
    """
    hertz = " -3\n 44 44 8.0 4.0 1.1\n"
    (prescribed,) = values(tmp_path, SIMPLIFIED.format(bound=2) + hertz + STOP)
    (solved,) = values(tmp_path, SIMPLIFIED.format(bound=0) + hertz + STOP)
    for name in ("FN", "FY", "MZ", "PMAX"):
        assert solved[name] == pytest.approx(prescribed[name], rel=0.01)
    scene = cases(tmp_path, SIMPLIFIED.format(bound=0) + hertz + STOP)[0].scene
    load = scene.hertz
    quadratic = (
        f" 1\n 44 44 -8.8 -4.4 0.4 0.2\n 1 1\n {0.5 / load.Rx!r} 0. {0.5 / load.Ry!r} 0. 0. 0.\n"
    )
    (sampled,) = values(tmp_path, SIMPLIFIED.format(bound=0) + quadratic + STOP)
    for name in ("FN", "FY", "MZ", "PMAX"):
        assert sampled[name] == pytest.approx(solved[name], rel=0.02)


def test_temperatures_and_laws_by_them(tmp_path):
    """A body that comes in warm warms the other, to the mean of both where they are alike."""
    heat = " 0.0 450. 50e-3 7.85e-6\n 150. 450. 50e-3 7.85e-6\n 1                            IPOTCN"
    still = ("0.001  0.002  0.0003 ", "0.0  0.0  0.0 ")
    given = changed(
        BALL,
        WIDE,
        still,
        (" 0000001 ", " 3000001 "),
        (" 1                            IPOTCN", heat),
    )
    (found,) = values(tmp_path, given + STOP)
    assert found["MAX(T1,T2)"] == pytest.approx(75.0, rel=1e-3)
    by_heat = changed(
        (" 022020 ", " 622020 "),
        (" 0.3  0.3                     FSTAT, FKIN", " 0.4 0. -0.2 400.\n 0 1"),
        text=given,
    )
    (case,) = cases(tmp_path, by_heat + STOP)
    assert case.scene.friction == vc.TemperatureFalling(0.4, 0.2, reference=0.0, over=400.0)


def test_friction_by_row_and_rigid_slip_by_element(tmp_path):
    rows = "\n 0.1 0.1\n 0.2 0.2\n 0.3 0.3\n" + " ".join(f"{k} {-k}" for k in range(12)) + "\n"
    given = changed(
        (" 022020 ", " 3022029 "),
        (" 0.3  0.3                     FSTAT, FKIN\n", ""),
        (FORMULA, FORMULA + rows),
    )
    (case,) = cases(tmp_path, given + STOP)
    np.testing.assert_array_equal(case.scene.friction, np.repeat([[0.1], [0.2], [0.3]], 4, axis=1))
    np.testing.assert_array_equal(case.scene.motion.rigid_slip[0], np.arange(12).reshape(3, 4))
    np.testing.assert_array_equal(case.scene.motion.rigid_slip[1], -np.arange(12).reshape(3, 4))


def test_a_planform_bounds_the_contact(tmp_path):
    """Two rectangles: nothing touches between them."""
    plan = (FORMULA, " 1 3\n 0.01 0 0.01 0 0 0\n -9 -0.2 -9 9\n 0.2 9 -9 9")
    (run,) = run_cases(cases(tmp_path, changed(WIDE, plan) + STOP))
    touching = run.solution.pressure.any(axis=0)
    between = np.abs(run.solution.grid.x) < 0.2
    assert touching.any()
    assert not touching[between].any()


def test_conformal_rows_have_inclinations(tmp_path):
    flat = changed(BALL, WIDE)
    curved = changed(
        (" 022020 ", " 024020 "),
        (
            " 0.28  0.28  82000. 82000. ",
            " 1 4 2\n -2.0 -10d\n 2.0 10d\n 0.28  0.28  82000. 82000. ",
        ),
        text=flat,
    )
    (case,) = cases(tmp_path, curved + STOP)
    assert case.scene.surface.inclination[0] == pytest.approx(-np.radians(9.5))
    (other,) = cases(tmp_path, changed((" 1 4 2\n", " 1 1 2\n"), text=curved) + STOP)
    assert "VARIANT = 1 is not reciprocal, and not supported; supported: 4" in other.reason


BLOCKS = {
    "all, regular": " 1\n 2 0.1 0.1\n",
    "selected, regular": " 2\n 1 1 4\n 1 1 3\n 2 0.1 0.1\n",
    "listed, regular": " 3\n 4 3\n 4 3 2 1\n 1 2 3\n 2 0.1 0.1\n",
    "all, listed": " 5\n 2\n 0.2 0.1\n",
    "selected, listed": " 6\n 1 1 99\n 1 1 3\n 2\n 0.1 0.2\n",
    "listed, listed": " 7\n 4 3\n 1 2 3 4\n 1 2 3\n 2\n 0.1 0.2\n",
    "by coordinates": " 9\n 4 3 2\n -.75 -.25 .25 .75\n -.4 0 .4\n 0.1 0.2\n",
}


@pytest.mark.parametrize("block", BLOCKS.values(), ids=BLOCKS)
def test_points_of_stresses_in_every_form(tmp_path, block):
    given = changed((" 203100 ", " 203103 ")) + f" 1 0\n{block} 0\n"
    kept = given.replace(" 203103 ", " 203102 ").replace(f"{block} 0\n", "")
    first, second = cases(tmp_path, given + kept + STOP)
    (points,) = first.stress_points
    assert points.shape == (3, 24)
    np.testing.assert_allclose(points[:, [0, 1, 4, 12]].T, [
        [-0.75, -0.4, 0.1], [-0.25, -0.4, 0.1], [-0.75, 0.0, 0.1], [-0.75, -0.4, 0.2],
    ], atol=1e-12)  # fmt: skip
    np.testing.assert_array_equal(second.stress_points[0], points)


def test_stresses_below_a_unit_load(tmp_path):
    """Published of the guide's section 5.6 (revision 2707): pressure 1 on a square."""
    given = """ 3 MODULE
 200103
 022020
 0000001
 80 100 30 1 1e-6
 1. 0. 0. 0.
 1. 1.
 0.28 0.28 1. 1.
 1
 1 1 -0.4999 -0.4998 1. 1.
 1 1
 2.16 0 2.16 0 0 0
 2 1
 9
 1 1 4
 1e-5
 1e-5
 0.0 0.3 0.4 1.25
 0
"""
    path = tmp_path / "unit.out"
    path.write_text(""" Case     1
     FN          FX          APPROACH     PMAX
     1.000       0.000       0.000        1.000
 SUBSURFACE STRESSES BLOCK  1:
 ABSMAX SIGHYD =    -0.853 AT (X,Y,Z) = (   0.000,   0.000,   0.000)
 MAX     SIGVM =     0.665 AT (X,Y,Z) = (   0.000,   0.000,   0.400)
 MAX    SIGMA1 =     0.008 AT (X,Y,Z) = (   0.000,   0.000,   1.250)
 MIN    SIGMA3 =    -1.000 AT (X,Y,Z) = (   0.000,   0.000,   0.000)
""")
    (run_,) = run_cases(cases(tmp_path, given + STOP))
    (output,) = vc.read_contact_output(path)
    rows = compared_stresses(1, run_.stresses, output)
    assert [row.quantity for row in rows] == ["SIGHYD", "SIGVM", "SIGMA1", "SIGMA3"]
    assert {row.verdict for row in rows} == {"equal"}


OUTPUT = """ Case     1
 TOTAL FORCES, TORSIONAL MOMENT, ELASTIC ENERGY, FRICTIONAL POWER
     FN          FX          FY          MZ         ELAST.EN.   FRIC.WORK
         9.195       0.000       0.000       0.000   8.525E-05       0.000
     FN/G      FX/FSTAT/FN  FY/FSTAT/FN  APPROACH     PMAX
     4.598E-02       0.000       0.000   1.998E-02       4.393
 Case     2
 TOTAL FORCES, TORSIONAL MOMENT, ELASTIC ENERGY, FRICTIONAL POWER
     FN          FX          FY          MZ         ELAST.EN.   FRIC.WORK
         9.195      {}       0.000       0.000   8.525E-05  -2.750E-06
     FN/G       SHIFT X      SHIFT Y     APPROACH     PMAX
     4.598E-02   8.155E-03       0.000   1.998E-02       4.393
"""
"""Cattaneo's shift of the user guide, section 5.1."""
TIMES = "|Total                |        1 |        1.2 | 100.0 |        1.5 | 100.0 |\n"


@pytest.mark.long
def test_the_command_compares_all_cases(tmp_path):
    path = tmp_path / "cattaneo.out"
    path.write_text(OUTPUT.format("-3.218") + TIMES)
    done = run("solve", DATA / "cattaneo.inp", "--compare", path, "--table", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "cases: 2 equal" in done.stdout
    assert " Case     2" in done.stdout
    assert "seconds: 1.5 theirs" in done.stdout
    path.write_text(OUTPUT.format("-3.200"))
    done = run(
        "solve",
        DATA / "cattaneo.inp",
        "--compare",
        path,
        "--json",
        "--save",
        "all",
        folder=tmp_path,
    )
    assert done.returncode == 3
    assert "1 of 2 cases are not equal" in done.stderr
    (row,) = [row for row in json.loads(done.stdout) if row["verdict"] != "equal"]
    assert (row["case"], row["quantity"], row["theirs"]) == (2, "FX", -3.2)
    assert row["refined"] == pytest.approx(row["ours"], rel=1e-3)
    assert vc.load(tmp_path / "all" / "case_0002.nc").force[0] == pytest.approx(row["ours"])
    (tmp_path / "cattaneo.inp").write_text((DATA / "cattaneo.inp").read_text())
    done = run("suite", tmp_path, "--json", folder=tmp_path)
    (summary,) = json.loads(done.stdout)
    assert (summary["file"], summary["equal"], summary["differs"]) == ("cattaneo.inp", 1, 1)
    assert summary["reasons"] == {"FX differs": 1}
    assert summary["theirs"] is None
    assert summary["ours"] > 0
    assert_bad_input(
        run("solve", DATA / "cattaneo.inp", "--compare", "none.out", folder=tmp_path), "none.out"
    )
    assert_bad_input(run("suite", "none", folder=tmp_path), "a folder with input files of CONTACT")
    # no number stands in JSON for what is not known; a file is no folder
    case = ("solve", DATA / "cattaneo.inp", "--compare", path)
    done = run(*case, "--json", folder=tmp_path)
    equal = json.loads(done.stdout, parse_constant=pytest.fail)[0]
    assert equal["verdict"] == "equal" and equal["refined"] is None
    assert_bad_input(run(*case, "--save", path, folder=tmp_path), "the folder cannot be made")


def test_digits_that_are_printed_are_compared():
    output = vc.ContactOutput(1, None, None, {}, ({"FN": 9.195, "FX": -3.218, "MAX(T1,T2)": 90.0},))
    rows = compared(1, [{"FN": 9.1954, "FX": -3.2196, "MAX(T1,T2)": 80.0, "MZ": 1.0}], output)
    assert [row.verdict for row in rows] == ["equal", "differs", "differs"]
    assert "counts the heat of an element twice" in report(rows)
    assert list(by_case(rows)) == [(1, "differs", "FX differs")]
    assert summary_of(rows) == {"equal": 0, "differs": 1, "not run": 0, "not printed": 0}
    assert compared(2, [{"FN": 1.0}], None)[0].verdict == "not printed"


def test_files_and_values_that_differ_are_tables_of_a_page():
    """Equal files have a number and no reason; a wheel's finer patches are found by their place."""
    theirs = ({"FN": 9.0, "YCP(R)": 5.0}, {"FN": 1.0, "YCP(R)": -9.0})
    output = vc.ContactOutput(3, None, "right", {}, theirs)
    rows = [Compared(3, 2, "FN", 1.0, 1.1, "differs")]
    finer = [{"FN": 1.05, "YCP(R)": -9.0}, {"FN": 9.0, "YCP(R)": 5.0}]
    (row,) = with_refined(rows, finer, output)
    assert row.refined == 1.05
    refused = Compared(
        4, 1, "", math.nan, math.nan, "not run", "a.inp, line 4: path 'b/c.txt' is no"
    )
    files = [
        FileCompared("wheels.inp", [row, refused], None, 1.25),
        FileCompared("plain.inp", [Compared(1, 1, "FX", 1.0, 1.0, "equal")], 0.5, 0.25),
    ]
    lines = page_of(files).splitlines()
    reasons = "1 differs: FN differs; 1 not run: path 'c.txt' is no"
    assert lines[2] == f"| wheels | 2 |  | 1 | 1 | -, 1.2 | {reasons} |"
    assert lines[3] == "| plain | 1 | 1 |  |  | 0.5, 0.2 |  |"
    assert lines[4] == "| all | 3 | 1 | 1 | 1 | | |"
    assert lines[-1] == "| wheels | 3, patch 2 | FN | 1 | 1.1 | 1.05 |  |"
