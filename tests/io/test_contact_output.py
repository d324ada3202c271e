"""Output files of CONTACT: what it printed of forces, by case and patch. The texts are short ones
in its layout.
"""

import math

import pytest

import varcontact as vc
from tests.conftest import DATA
from tests.scenes import refused

HEAD = """   ------------------------------------------------------------------------
   |  CONTACT - detailed investigation of 3D frictional contact problems  |
   |  Version: open(linux64), $Revision: 2707 $, $Date:: 2025-07-23$      |
   ------------------------------------------------------------------------
"""
BASIC = (DATA / "contact_basic.out").read_text()
WHEEL = (DATA / "contact_wheel.out").read_text()
TAIL = """Performance timers:
|Total                |        1 |        9.3 | 100.0 |       10.4 | 100.0 |
 The CONTACT program ended succesfully.
"""


def read(tmp_path, text):
    path = tmp_path / "a.out"
    path.write_text(text)
    return vc.read_contact_output(path)


def test_basic_contacts(tmp_path):
    """All tables of a case are its one patch's; pictures, sensitivities by row and fields by
    element are no tables.
    """
    normal, shift = read(tmp_path, HEAD + BASIC + TAIL)
    assert (normal.case, normal.side, shift.case) == (1, None, 2)
    assert normal.values == {
        "NU": 0.42, "G": 200.0, "AK": 0.0, "EPS": 1e-4, "FN": 9.195, "FX": 0.0, "FY": 0.0, "MZ": 0.0,
        "ELAST.EN.": 7.35e-5, "FRIC.WORK": 0.0, "FN/G": 0.04598, "FX/FSTAT/FN": 0.0, "FY/FSTAT/FN": 0.0,
        "APPROACH": 0.01998, "PMAX": 4.393, "DFN/DPEN": 0.0}  # fmt: skip
    assert shift.patches == (shift.values,)
    assert (shift.values["SHIFT X"], shift.values["FX"], shift.values["FX/FSTAT/FN"]) == (
        8.155e-3,
        -3.218,
        -0.875,
    )
    assert shift.values["NCON"] == 177
    assert math.isnan(shift.values["MZ"])
    assert "EPS" not in shift.values


def test_wheels_on_rails(tmp_path):
    """Patches have tables of their own; what both profiles have by the same names is left out."""
    wheel, lifted = read(tmp_path, HEAD + WHEEL + TAIL)
    assert wheel.side == "right"
    assert (wheel.values["FY(TR)"], wheel.values["FZ(WS)"], wheel.values["Z_WS"]) == (
        3390.0,
        1e4,
        -0.9239,
    )
    assert (wheel.values["RAILY0"], wheel.values["G"]) == (750.0, 82000.0)
    assert not {"LAMBDA", "KINKHIG", "FN", "CKSI"} & wheel.values.keys()
    first, second = wheel.patches
    assert (first["FN"], first["FS"], first["MN"], first["APPROACH"]) == (
        6144.0,
        153.5,
        -168.5,
        0.01718,
    )
    assert (first["CKSI"], first["CETA"], first["CPHI"]) == (-1.187e-3, -2.672e-4, 1.086e-4)
    assert (first["YCP(R)"], first["DELTCP(TR)"], first["PMAX"]) == (32.0806, -0.0499, 617.4)
    assert (second["FN"], second["FRIC.POWER"], second["MAX(T1,T2)"]) == (4822.0, -48.58, 169.2)
    assert "PMAX" not in second
    vertical = sum(
        p["FN"] * math.cos(a) + p["FS"] * math.sin(a)
        for p, a in zip(wheel.patches, (-0.0499, -0.7638), strict=True)
    )
    assert vertical == pytest.approx(wheel.values["FZ(TR)"], rel=1e-3)
    assert (lifted.case, lifted.side, lifted.patches, lifted.values["FZ(TR)"]) == (
        2,
        "left",
        (),
        0.0,
    )


def test_of_o_1_the_forces_alone(tmp_path):
    """Without the line that says how many patches there are."""
    start, end = WHEEL.index(" WHEEL-RAIL"), WHEEL.index("     FX(TR)")
    (wheel,) = read(
        tmp_path, (WHEEL[:start] + WHEEL[end:])[: WHEEL.index(" Case     2") - (end - start)]
    )
    assert wheel.side is None
    assert wheel.values.keys() == {"FX(TR)", "FY(TR)", "FZ(TR)", "FX(WS)", "FY(WS)", "FZ(WS)"}
    assert [patch["FN"] for patch in wheel.patches] == [6144.0, 4822.0]


def test_results_of_result_elements(tmp_path):
    """Of CONTACT's library: one case of each element may have the same number."""
    normal = BASIC[: BASIC.index(" Case     2")]
    text = "".join(
        normal.replace("Case     1", f"Case     1, result element   {k}") for k in (1, 2, 15)
    )
    found = read(tmp_path, HEAD + text + TAIL)
    assert [(each.case, each.result_element, each.values["FN"]) for each in found] == [
        (1, 1, 9.195), (1, 2, 9.195), (1, 15, 9.195)]  # fmt: skip
    wheel, lifted = read(tmp_path, HEAD + WHEEL + TAIL)
    assert (wheel.result_element, lifted.result_element) == (None, 2)


def test_conformal_patches(tmp_path):
    """They have sums of components along the curved surface, under names of their own."""
    changes = (("     FN          FX          FS   ", "     BAR_FN      BAR_FX      BAR_FS"),
               ("     FN/G      FX/FSTAT/FN FS/FSTAT/FN", "     TILDE_FN    FX/FN       FS/FN"))  # fmt: skip
    text = WHEEL
    for old, new in changes:
        assert text.count(old) == 2
        text = text.replace(old, new)
    wheel, _ = read(tmp_path, HEAD + text + TAIL)
    first, second = wheel.patches
    assert (first["FN"], first["FX"], first["FS"]) == (6144.0, 1626.0, 153.5)
    assert (first["BAR_FN"], first["TILDE_FN"], first["FX/FN"]) == (6144.0, 7.493e-2, 0.8823)
    assert (second["FN"], second["APPROACH"]) == (4822.0, 2.063e-2)


@pytest.mark.parametrize(("text", "words"), [
    ("", "line 1 ends without a case: this is no output file of CONTACT"),
    (HEAD, "line 4 ends without a case"),
    (BASIC.replace("9.195       0.000", "9.195", 1), "line 14 has 5 numbers for 6 names: FN, FX, FY, MZ, ELAST"),
    (
        BASIC[: BASIC.index("     FN/G       SHIFT")],
        "ends case 2, whose contact patch 1 has no APPROACH: the program",
    ),
    (WHEEL.replace("2 CONTACT PATCHES", "3 CONTACT PATCHES"), "ends case 1, which has 2 of 3 contact patches"),
    (WHEEL.replace("PATCH  2", "PATCH  3"), "begins contact patch 3, not 2"),
    (BASIC[:-30], "has no end: the file was cut short"),
])  # fmt: skip
def test_broken_files_are_refused_by_line(tmp_path, text, words):
    refused(lambda: read(tmp_path, text), words=words, match=r"a.out, line \d+ ")


@pytest.mark.long
def test_a_run_that_was_cut_short_is_refused_wherever(tmp_path):
    """But for the end of a case whose forces are all there."""
    text = HEAD + WHEEL[: WHEEL.index(" Case     2")]
    whole = text.index("169.2\n") + len("169.2\n")
    for end in (*range(0, whole, 3), whole - 2, whole - 1):
        with pytest.raises(vc.SceneError):
            read(tmp_path, text[:end])
    for end in range(whole, len(text) + 1):
        if text[:end].endswith("\n"):
            assert read(tmp_path, text[:end])[0].patches[1]["FN"] == 4822.0


def test_a_case_without_output_has_no_patches(tmp_path):
    """O = 0, or its input stopped it; of the last one it is not known."""
    path = tmp_path / "a.out"
    result = "     FN          FX          APPROACH\n     1.000       0.000       0.000\n"
    path.write_text(f" Case     1\n Input: WARNING.\n Case     2\n{result}")
    first, second = vc.read_contact_output(path)
    assert (first.patches, second.patches[0]["FN"]) == ((), 1.0)
    for text in ("", f" Case     1\n{result}"):
        path.write_text(f"{text} Case     2\n Input: ERROR. FSTAT and FKIN must be the same\n")
        assert vc.read_contact_output(path)[-1].patches == ()
    path.write_text(f" Case     1\n{result} Case     2\n NORM\n")
    with pytest.raises(vc.SceneError, match="ends case 2, whose contact patch 1 has no FN"):
        vc.read_contact_output(path)


SUBSURFACE = """%   NX          NY          NZ           -
     2           1           2         0.000
%    X           Y           Z          SIGVM
  0.0  0.5  0.0  1.0
  1.0  0.5  0.0  2.0
  0.0  0.5  0.3  3.0
  1.0  0.5  0.3  4.0
"""


def test_stresses_below_the_surface_by_block(tmp_path):
    path = tmp_path / "a.0001.subs"
    path.write_text(SUBSURFACE + SUBSURFACE.replace("4.0", "5.0"))
    first, second = vc.read_contact_stresses(path)
    assert first["SIGVM"].tolist() == [[[1.0, 2.0]], [[3.0, 4.0]]]
    assert (first["Z"][1, 0, 1], second["SIGVM"][1, 0, 1]) == (0.3, 5.0)


@pytest.mark.parametrize(("old", "new", "words"), [
    ("NX ", "MX ", "line 1 should name NX, NY and NZ"),
    ("     2           1  ", "     0           1  ", "line 2 has"),
    ("     2           1  ", "     9           1  ", "line 7 ends before 18 points"),
    ("%    X ", "%    R ", "line 3 should name the columns X, Y, Z"),
    ("  3.0\n", "  ***\n", "line 6 should have 4 numbers"),
    (SUBSURFACE, "\n", "has no stresses"),
])  # fmt: skip
def test_damaged_stresses_are_refused_by_line(tmp_path, old, new, words):
    path = tmp_path / "a.0001.subs"
    path.write_text(SUBSURFACE.replace(old, new))
    refused(lambda: vc.read_contact_stresses(path), words=words)
