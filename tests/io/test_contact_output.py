"""Output files of CONTACT: what it printed of forces, by case and patch. The texts are short ones in its layout."""

import math

import pytest

import varcontact as vc

HEAD = """   ------------------------------------------------------------------------
   |  CONTACT - detailed investigation of 3D frictional contact problems  |
   |  Version: open(linux64), $Revision: 2707 $, $Date:: 2025-07-23$      |
   ------------------------------------------------------------------------
"""

BASIC = """
 Case     1
      Norm: final element division: C, E=    177    184  ItCG=     4

  PBTNFS.            PVTIME 2, BOUND  0, TANG   0, NORM   1, FORCE  0, STRESS 0
 NORMAL PROBLEM WITH PRESCRIBED NORMAL FORCE, FULL SOLUTION

 MATERIAL CONSTANTS
     NU          G           AK          EPS
    0.4200       200.0       0.000      0.1000E-03

 TOTAL FORCES, TORSIONAL MOMENT, ELASTIC ENERGY, FRICTIONAL POWER
     FN          FX          FY          MZ         ELAST.EN.   FRIC.WORK
         9.195       0.000       0.000       0.000   7.350E-05       0.000
     FN/G      FX/FSTAT/FN  FY/FSTAT/FN  APPROACH     PMAX
     4.598E-02       0.000       0.000   1.998E-02       4.393

 THE SENSITIVITIES.
 A ZERO MEANS THAT IT HAS NOT BEEN CALCULATED.
  DFN/DPEN
        0.00

 FORM OF THE CONTACT, ADHESION AND SLIP-AREA`S:
     2   . * * .
     1   o . . o
                           1
         1 2 3 4
     X  -->

 Case     2
 TANG: SHIFT TRANSIENT
         0, NR_Fy,    Cksi, Fxk:    1.000E-06  -1.356E-04
 KINEMATIC CONSTANTS
     DT          VELOC     FX/FSTAT/FN FY/FSTAT/FN   CPHI
     1.000           1.000     -0.8750       0.000       0.000

 TOTAL FORCES, TORSIONAL MOMENT, ELASTIC ENERGY, FRICTIONAL POWER
     FN          FX          FY          MZ         ELAST.EN.   FRIC.WORK
         9.195      -3.218       0.000    ********   8.525E-05  -2.750E-06
     FN/G       SHIFT X      SHIFT Y     APPROACH     PMAX
     4.598E-02   8.155E-03       0.000   1.998E-02       4.393

 THE SENSITIVITIES. (FX,FY) MEANS: (FX,FY)/FN/FSTAT.
         DF/DPEN     DF/DKSI     DF/DETA     DF/DPHI
   FX         0.00       -67.6        0.00        0.00

 CONTACT STATISTICS
    NPOT   NCON   NADH  NSLIP  INORM  ITANG
     361    177     45    132      1      1

 Y =  -0.1334     ROW  9 OF THE POTENTIAL CONTACT

  -0.9333     -0.111E-01   1.31      0.523      0.523         177.3    0.225E-02  0.815E-02   0.00
"""

WHEEL = """
 Case     1
 WARNING: potential contact area too small;  140 elements next to boundary.
         0, NR,  z_ws, Fz:      -0.9525       0.000, dFz/dz:       0.000

 WHEEL-RAIL CONTACT, RIGHT WHEEL,  2 CONTACT PATCHES

 MATERIAL CONSTANTS
     NU          G           AK          EPS
    0.2800       8.200E+04   0.000       1.000E-05

 RAIL PROFILE "../profiles/rail.prr"
   MIRRORY     MIRRORZ     ISMOOTH      LAMBDA
      0          -1           0         1.5000

   ZIGTHRS     KINKHIG     KINKLOW      KINKWID     MAXOMIT
     2.618      0.5236      0.1047       2.000      0.5000

 TRACK DIMENSIONS AND RAIL POSITION
    GAUGHT      RAILY0      RAILZ0        CANT        CURV
    -1.000    750.0000      0.0000      0.0000       0.000

 WHEEL PROFILE "../profiles/wheel.prw"
   MIRRORY     MIRRORZ     ISMOOTH      LAMBDA
      0          -1           0         0.0000

 WHEEL-SET POSITION AND VELOCITY
     S_WS        Y_WS        Z_WS        ROLL_WS     YAW_WS      PITCH_WS
         160.0       3.520     -0.9239       0.000       0.000       0.000

 TOTAL FORCES ON RAIL
     FX(TR)      FY(TR)      FZ(TR)      FX(WS)      FY(WS)      FZ(WS)
       304.6       3390.   1.000E+04       304.6       3390.   1.000E+04

 ----- DATA FOR CONTACT PATCH  1 -----

 CONTACT REFERENCE LOCATION
     XCP(TR)     YCP(TR)     ZCP(TR)    DELTCP(TR)   YCP(R)      ZCP(R)
     -2.4601    782.0806     -1.5177     -0.0499     32.0806     -1.5177

 KINEMATIC CONSTANTS
     CHI         DQ          VELOC       CKSI        CETA        CPHI
     0.000      0.4000           1999.  -1.187E-03  -2.672E-04   1.086E-04

 TOTAL FORCES, TORSIONAL MOMENT, ELASTIC ENERGY, FRICTIONAL POWER
     FN          FX          FS          MN         ELAST.EN.   FRIC.POWER
         6144.       1626.       153.5      -168.5   4.505E-02      -3.516
     FN/G      FX/FSTAT/FN FS/FSTAT/FN   APPROACH     PMAX
     7.493E-02      0.8823   8.326E-02   1.718E-02       617.4

 ----- DATA FOR CONTACT PATCH  2 (NEW PATCH) -----

     FN          FX          FS          MN         ELAST.EN.   FRIC.POWER
         4822.      -1322.      -561.3      -256.7   4.389E-02      -48.58
     FN/G      FX/FSTAT/FN FS/FSTAT/FN   APPROACH  MAX(T1,T2)
     5.881E-02     -0.9136     -0.3880   2.063E-02       169.2

 Case     2 for w/r contact on result element  2, t=      0.08706221

 WHEEL-RAIL CONTACT, LEFT WHEEL,  0 CONTACT PATCHES

 ----- NO CONTACT FOUND FOR THIS WHEEL / WHEEL-SET -----
     FX(TR)      FY(TR)      FZ(TR)      FX(WS)      FY(WS)      FZ(WS)
       0.000       0.000       0.000       0.000       0.000       0.000
"""
TAIL = """Performance timers:
|Total                |        1 |        9.3 | 100.0 |       10.4 | 100.0 |
 The CONTACT program ended succesfully.
"""


def read(tmp_path, text):
    path = tmp_path / "a.out"
    path.write_text(text)
    return vc.read_contact_output(path)


def test_basic_contacts(tmp_path):
    """All tables of a case are its one patch's; pictures, sensitivities by row and fields by element are no tables."""
    normal, shift = read(tmp_path, HEAD + BASIC + TAIL)
    assert (normal.case, normal.side, shift.case) == (1, None, 2)
    assert normal.values == {
        "NU": 0.42, "G": 200.0, "AK": 0.0, "EPS": 1e-4, "FN": 9.195, "FX": 0.0, "FY": 0.0, "MZ": 0.0,
        "ELAST.EN.": 7.35e-5, "FRIC.WORK": 0.0, "FN/G": 0.04598, "FX/FSTAT/FN": 0.0, "FY/FSTAT/FN": 0.0,
        "APPROACH": 0.01998, "PMAX": 4.393, "DFN/DPEN": 0.0}  # fmt: skip
    assert shift.patches == (shift.values,)
    assert (shift.values["SHIFT X"], shift.values["FX"], shift.values["FX/FSTAT/FN"]) == (8.155e-3, -3.218, -0.875)
    assert shift.values["NCON"] == 177
    assert math.isnan(shift.values["MZ"])
    assert "EPS" not in shift.values


def test_wheels_on_rails(tmp_path):
    """Patches have tables of their own; what both profiles have by the same names is left out."""
    wheel, lifted = read(tmp_path, HEAD + WHEEL + TAIL)
    assert wheel.side == "right"
    assert (wheel.values["FY(TR)"], wheel.values["FZ(WS)"], wheel.values["Z_WS"]) == (3390.0, 1e4, -0.9239)
    assert (wheel.values["RAILY0"], wheel.values["G"]) == (750.0, 82000.0)
    assert not {"LAMBDA", "KINKHIG", "FN", "CKSI"} & wheel.values.keys()
    first, second = wheel.patches
    assert (first["FN"], first["FS"], first["MN"], first["APPROACH"]) == (6144.0, 153.5, -168.5, 0.01718)
    assert (first["CKSI"], first["CETA"], first["CPHI"]) == (-1.187e-3, -2.672e-4, 1.086e-4)
    assert (first["YCP(R)"], first["DELTCP(TR)"], first["PMAX"]) == (32.0806, -0.0499, 617.4)
    assert (second["FN"], second["FRIC.POWER"], second["MAX(T1,T2)"]) == (4822.0, -48.58, 169.2)
    assert "PMAX" not in second
    vertical = sum(
        p["FN"] * math.cos(a) + p["FS"] * math.sin(a) for p, a in zip(wheel.patches, (-0.0499, -0.7638), strict=True)
    )
    assert vertical == pytest.approx(wheel.values["FZ(TR)"], rel=1e-3)
    assert (lifted.case, lifted.side, lifted.patches, lifted.values["FZ(TR)"]) == (2, "left", (), 0.0)


def test_of_o_1_the_forces_alone(tmp_path):
    """Without the line that says how many patches there are."""
    start, end = WHEEL.index(" WHEEL-RAIL"), WHEEL.index("     FX(TR)")
    (wheel,) = read(tmp_path, (WHEEL[:start] + WHEEL[end:])[: WHEEL.index(" Case     2") - (end - start)])
    assert wheel.side is None
    assert wheel.values.keys() == {"FX(TR)", "FY(TR)", "FZ(TR)", "FX(WS)", "FY(WS)", "FZ(WS)"}
    assert [patch["FN"] for patch in wheel.patches] == [6144.0, 4822.0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "line 1 ends without a case: this is no output file of CONTACT"),
        (HEAD, "line 4 ends without a case"),
        (BASIC.replace("9.195       0.000", "9.195", 1), "line 14 has 5 numbers for 6 names: FN, FX, FY, MZ, ELAST"),
        (
            BASIC[: BASIC.index("     FN/G       SHIFT")],
            "ends case 2, whose contact patch 1 has no APPROACH: the program",
        ),
        (WHEEL.replace("2 CONTACT PATCHES", "3 CONTACT PATCHES"), "ends case 1, which has 2 of 3 contact patches"),
        (WHEEL.replace("PATCH  2", "PATCH  3"), "begins contact patch 3, where 2 should follow"),
        (BASIC[:-30], "has no end: the file was cut short"),
    ],
)
def test_broken_files_are_refused_by_line(tmp_path, text, words):
    with pytest.raises(vc.SceneError, match=r"a.out, line \d+ ") as error:
        read(tmp_path, text)
    assert words in str(error.value)


def test_a_run_that_was_cut_short_is_refused_wherever(tmp_path):
    """But for the end of a case whose forces are all there."""
    text = HEAD + WHEEL[: WHEEL.index(" Case     2")]
    whole = text.index("169.2\n") + len("169.2\n")
    for end in range(whole):
        with pytest.raises(vc.SceneError):
            read(tmp_path, text[:end])
    for end in range(whole, len(text) + 1):
        if text[:end].endswith("\n"):
            assert read(tmp_path, text[:end])[0].patches[1]["FN"] == 4822.0
