"""Input files of CONTACT's module 1: as wheels on rails they give what CONTACT publishes of the
same input.
"""

import csv
import inspect
import shutil
import warnings
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.command import assert_bad_input, run
from tests.scenes import refused
from tests.wheel_rail.conditions import DATA, RAIL, WHEEL, benchmark, manchester
from varcontact.wheel_rail import (
    DoubtfulProfile,
    Position,
    ProfileSlices,
    Velocity,
    read_contact_input,
)
from varcontact.wheel_rail.case_file import read_case
from varcontact.wheel_rail.curve import smoothed_in_third_order
from varcontact.wheel_rail.slices import surface_of

CASE = """
% Manchester contact benchmark - tangential contact
  1 MODULE
 1203100    C-P-B-T-N-F-S   CONFIG, PVTIME, BOUND,  TANG,   NORM,   FORCE,  STRESS
 0022033    V-L-D-C-M-Z-E   VARFRC, FRCLAW, DISCNS, INFLCF, MATER,  ZTRACK, EWHEEL
 0001331    H-G-I-A-O-W-R     HEAT, GAUSEI, IESTIM, MATFIL, OUTPUT, FLOW,   RETURN
    999     100    30    1     1e-5         MAXGS , MAXIN , MAXNR , MAXOUT, EPS
  0.300   0.300                                 FSTAT, FKIN
  0.280   0.280   82000.  82000.                POISS 1,2,  GG 1,2
  0.200   0.200   1.000   90d   8.0   4.0       DX, DS, DQREL, A_SEP, D_SEP, D_COMB
   14.0     0     1435.0  0.000                 GAUGHT, GAUGSQ, GAUGWD, CANT
  'rail.csv'   0     1.0    0.0   -1            RFNAME, MIRRORY, SCALE, SMOOTH, MIRRORZ
     0.0    0.0   0.000   0.0   0.0   0.000     DY, DZ, ROLL, VY, VZ, VROLL
  1360.0  -70.0   460.0                         FBDIST, FBPOS, NOMRAD
  'the wheel, new.csv' 0    1.0  0.0            WFNAME, MIRRORY, SCALE, SMOOTH
    0.0  0.0 10000.  0.0  0.0  0.0              S, Y,  FZ, ROLL, YAW, PITCH
 2000.   0.0    0.0                             % VS, VY, VZ
         0.0    0.0  -4.34811810                  VROLL, VYAW, VPITCH

  0 MODULE
"""
STOP = "\n  0 MODULE\n"
TRACK = "   14.0     0     1435.0  0.000 "
PLACE = "    0.0  0.0 10000.  0.0  0.0  0.0 "
RATES = "         0.0    0.0  -4.34811810 "


def with_profiles(folder):
    """A folder with the profiles that the case names."""
    shutil.copy(DATA / "profiles" / "rail_UIC60.csv", folder / "rail.csv")
    shutil.copy(DATA / "profiles" / "wheel_S1002.csv", folder / "the wheel, new.csv")
    return folder


@pytest.fixture
def folder(tmp_path):
    return with_profiles(tmp_path)


def read(folder, *changes, text=CASE):
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    path = folder / "case.inp"
    path.write_text(text)
    return read_contact_input(path)


def test_cases_beside_the_wheels_are_told(folder):
    """Here one of a longitudinal force, F = 1, between two at given velocities."""
    once = CASE.removesuffix(STOP)
    forced = once.replace(" 1203100 ", " 1203110 ")
    path = folder / "case.inp"
    path.write_text(once + forced + once + STOP)
    found = read_contact_input(path)
    assert [case.number for case in found.beside] == [2]
    assert len(found) == 2 and found.left_out == ()
    assert "case 2: not among the wheels, as it is a step in time, by a force" in str(found)
    assert "3 cases, 2 wheels" in repr(found)


@pytest.mark.parametrize(
    "row",
    [row for row in manchester() if row["y_ws"] in (0, 5, 9)],
    ids=lambda row: f"{row['side']} {row['y_ws']:g}",
)
def test_the_benchmark_has_the_forces_that_contact_publishes(folder, row):
    """Case A-2.2 as an input file of CONTACT; its FZ is all forces on the rail, those of friction
    included.
    """
    (wheel,) = read(
        folder,
        (" 1203100 ", f" {'1' if row['side'] == 'right' else '0'}203100 "),
        (PLACE, f" 0.0 {row['y_ws']} 10000. {row['roll']} {row['yaw']} 0.0 "),
        (RATES, f" 0.0 0.0 {row['pitch_rate']} "),
    )
    expected = benchmark(row)
    for name in (
        "side",
        "position",
        "velocity",
        "bodies",
        "friction",
        "dx",
        "dy",
        "join",
        "separate",
    ):
        assert getattr(wheel, name) == getattr(expected, name), name
    np.testing.assert_array_equal(wheel.wheelset.wheel.y, WHEEL.y)
    if (row["side"], row["y_ws"]) == ("right", 5):
        solution = wheel.solve()
        assert solution.z == pytest.approx(row["z_ws"], abs=1e-3)
        (patch,) = solution.patches
        assert patch.normal_force == pytest.approx(row["fn"], rel=2e-3)
        assert patch.force[1] == pytest.approx(row["fs"], rel=0.01)


def test_a_rail_may_be_placed_by_its_origin(folder):
    """GAUGHT <= 0: the rail's origin is at RAILY0, RAILZ0, and heights are of that track."""
    (gauged,) = read(folder)
    (by_z,) = read(folder, (" 1203100 ", " 1203000 "), (PLACE, " 0.0 0.0 0.25 0.0 0.0 0.0 "))
    assert (by_z.z, by_z.vertical_force) == (0.25, None)
    y, z = gauged.track.origin.tolist()
    for side, sign in ((1, 1.0), (0, -1.0)):
        (placed,) = read(
            folder,
            (" 1203100 ", f" {side}203000 "),
            (TRACK, f" -1.0 {sign * (y + 2.5)} {z + 3.0} 0.000 "),
            (PLACE, " 0.0 0.0 3.25 0.0 0.0 0.0 "),
        )
        assert placed.track.origin == pytest.approx([y + 2.5, z], abs=1e-9)
        assert placed.z == pytest.approx(0.25, abs=1e-9)


def test_what_a_case_does_not_give_is_kept(folder):
    """E = 1, 2: position, and velocity; Z = 0 to 2: parts of the track; a skipped case gives what
    the next keeps.
    """
    head = "  1 MODULE\n 1203100  C-P-B-T-N-F-S\n {}  V-L-D-C-M-Z-E\n 0101331  H-G-I-A-O-W-R\n"
    more = head.format("0100001") + " 0.0 3.0 20000. 0.01 90d 0.0\n"
    more = more.replace("90d", "0.5d")
    more += (
        head.format("0100012")
        + " 16.0 0 1435. 0.025\n 0.0 -3.0 20000. 0 0 0\n 1000. 1 2 0.1 0.2 -2.\n"
    )
    more += head.format("0120020") + " 0.5 0.4 1.0 90d 9.0 5.0 11.0\n 0 0 0 0 0 0\n"
    first, moved, rolling, finer = read(folder, ("\n  0 MODULE", "\n" + more + "  0 MODULE"))
    assert moved.position == Position(y=3.0, roll=0.01, yaw=np.radians(0.5))
    assert (moved.vertical_force, moved.velocity, moved.friction) == (20000.0, first.velocity, 0.3)
    assert moved.track.gauge_height == 14.0
    assert (rolling.track.gauge_height, rolling.track.cant) == (16.0, 0.025)
    assert rolling.velocity == Velocity(
        speed=1000.0, lateral=1, vertical=2, roll_rate=0.1, yaw_rate=0.2, pitch_rate=-2
    )
    assert (finer.dx, finer.dy, finer.separate, finer.join, finer.turn) == (
        0.5,
        0.4,
        9.0,
        5.0,
        11.0,
    )
    assert (finer.position, finer.track.rail) == (rolling.position, first.track.rail)
    skipped = [("\n  0 MODULE", "\n" + more + "  0 MODULE"), (" 0001331 ", " 0001333 ")]
    assert [wheel.position.y for wheel in read(folder, *skipped)] == [3.0, -3.0, -3.0]


RIG = (
    ("'rail.csv'   0     1.0    0.0   -1 ", "'groove.csv' 0 1.0 0.0 {mirrored} "),
    (TRACK, " -1.0 0.0 0.0 0.0 "),
    ("  1360.0  -70.0   460.0  ", "  0.0  0.0   100.0  "),
    ("'the wheel, new.csv' 0    1.0  0.0 ", "'ball.csv' 0 1.0 0.0 "),
    (PLACE, " 0.0 0.0 1000. 0.0 0.0 0.0 "),
    (RATES, " 0.0 0.0 -20.0 "),
    ("  0.200   0.200   1.000", "  0.05   0.05   1.000"),
)


@pytest.mark.parametrize("mirrored", ["-1", "0", ""])
def test_a_roller_in_a_groove_of_a_rig(folder, mirrored):
    """FBDIST = 0: the only wheel is in the middle; the pressure is that of Hertz, not that on a
    rail turned over.
    """
    y = np.linspace(-15.0, 15.0, 301)
    np.savetxt(folder / "groove.csv", np.stack([y, np.sqrt(20.0**2 - y**2) - 20.0], axis=1))
    ball = np.linspace(-9.0, 9.0, 181)
    np.savetxt(folder / "ball.csv", np.stack([ball, np.sqrt(10.0**2 - ball**2) - 10.0], axis=1))
    changes = [(old, new.format(mirrored=mirrored)) for old, new in RIG]
    with pytest.warns(DoubtfulProfile, match="hollow") if mirrored != "-1" else nullcontext():
        (wheel,) = read(folder, *changes)
    (patch,) = wheel.solve().patches
    surface = vc.Paraboloids(100.0, 1 / (1 / 10.0 - 1 / 20.0))
    hertz = vc.Scene(bodies=wheel.bodies, surface=surface, normal_force=1000.0).hertz
    assert patch.normal_force == pytest.approx(1000.0, rel=1e-3)
    assert patch.peak_pressure == pytest.approx(hertz.peak_pressure, rel=0.02)
    assert patch.patch.location[:2] == pytest.approx([0.0, 0.0], abs=0.02)


def test_curves_tape_circles_and_near_misses(folder):
    """CURV = 1/R, positive to the right; NOMRAD is the radius at YTAPE; GAP_MISS < 0 is none."""
    (wheel,) = read(
        folder,
        (TRACK, "   14.0     0     1435.0  0.000 -2e-6 "),
        ("8.0   4.0 ", "8.0   4.0  12. -1. "),
    )
    assert (wheel.track.curve_radius, wheel.turn) == (-5e5, 12.0)
    (plain,) = read(folder)
    (taped,) = read(folder, ("  1360.0  -70.0   460.0  ", "  1360.0  -70.0   460.0  10.0  YTAPE "))
    profile = taped.wheelset.wheel
    at_tape = taped.wheelset.radius + float(profile.z_at(10.0))
    assert at_tape == pytest.approx(460.0)
    at_height = [(" 1203100 ", " 1203000 "), (PLACE, " 0.0 0.0 0.25 0.0 0.0 0.0 ")]
    (low,) = read(
        folder, *at_height, ("  1360.0  -70.0   460.0  ", "  1360.0  -70.0   460.0  10.0  YTAPE ")
    )
    assert low.z - low.wheelset.radius == pytest.approx(0.25 - 460.0)
    (beyond,) = read(folder, ("  1360.0  -70.0   460.0  ", "  1360.0  -70.0   460.0  999. "))
    assert beyond.wheelset.radius == plain.wheelset.radius == 460.0


def test_laws_and_no_friction(folder):
    law = ("  0.300   0.300 ", " 0.2 0.1 50. 0. 1.\n 0.0 1.0 ")
    (wheel,) = read(folder, law, (" 0022033 ", " 0222033 "))
    assert wheel.friction == vc.LinearFalling(
        static=0.2 + 0.1, kinetic=0.2, half_velocity=50.0, velocity=2000.0
    )
    (smooth,) = read(folder, (" 1203100 ", " 1200100 "))
    assert smooth.friction == 0.0


def test_profiles_are_mirrored_scaled_and_smoothed(folder):
    """z up is guessed where MIRRORZ = 0; otherwise it is what the file says."""
    points = np.stack([RAIL.y, -RAIL.z], axis=1) / 1000
    np.savetxt(folder / "up.csv", points)
    old = "'rail.csv'   0     1.0    0.0   -1 "
    for mirrored in ("", "0"):
        with pytest.warns(DoubtfulProfile, match=r"up[.]csv: the sign of z is changed"):
            (wheel,) = read(folder, (old, f"'up.csv' -1 1000. 0.0 {mirrored} "))
        np.testing.assert_allclose(wheel.track.rail.z, RAIL.z, atol=1e-9)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        (wheel,) = read(folder, (old, "'up.csv' -1 1000. 0.0 1 "))
    np.testing.assert_allclose(wheel.track.rail.z, RAIL.z, atol=1e-9)
    with (
        pytest.warns(DoubtfulProfile, match="upside down"),
        pytest.raises(vc.SceneError, match="line 11: track"),
    ):
        read(folder, (old, "'up.csv' -1 1000. 0.0 -1 "))
    (wheel,) = read(folder, (old, "'rail.csv' 1 1.0 0.0 -1 "))
    np.testing.assert_allclose(wheel.track.rail.y[1:-1], -RAIL.y[-2:0:-1], atol=1e-12)
    (wheel,) = read(folder, (old, "'rail.csv' 0 1.0 5.0 -1 2 \n 1 150d 30d 6d 2.0\n 0 0.5"))
    assert wheel.track.rail.smoothing == 5.0


def test_the_older_smoothing_passes_the_same_waves(folder):
    """ISMOOTH = 0 minimises the sum of squared distances plus SMOOTH times the integral of the
    squared curvature.
    """
    y = np.arange(-40.0, 40.0 + 1e-9, 0.25)
    length, size = 6.0, 0.01
    wave = size * np.sin(2 * np.pi * y / length)
    np.savetxt(folder / "wave.csv", np.stack([y, y**2 / 600 + wave], axis=1))
    weight = (length / (2 * np.pi)) ** 4 / 0.25
    low = (TRACK, " 1.0 0 1435. 0.0 ")
    (wheel,) = read(
        folder, low, ("'rail.csv'   0     1.0    0.0   -1 ", f"'wave.csv' 0 1.0 {weight!r} -1 ")
    )
    middle = np.abs(y) < 12
    passed = wheel.track.rail.z_at(y[middle]) - y[middle] ** 2 / 600
    assert np.ptp(passed) == pytest.approx(size, rel=0.02)
    (barely,) = read(
        folder, low, ("'rail.csv'   0     1.0    0.0   -1 ", "'wave.csv' 0 1.0 1e-6 -1 ")
    )
    assert barely.track.rail.smoothing == 0.0


@pytest.mark.parametrize(("ratio", "part"), [(0.5, 1 / 65), (1.0, 0.5), (2.0, 64 / 65)])
def test_smoothing_of_the_third_order_halves_its_wavelength(ratio, part):
    """ISMOOTH = 2: a wave of length L passes by 1/(1 + (L_FILT/L)^6), parabolas and kinks stay."""
    y = np.arange(-60.0, 60.0 + 1e-9, 0.25)
    length = 8.0
    wave = 0.01 * np.sin(2 * np.pi * y / (ratio * length))
    parabola = np.stack([y, y**2 / 600], axis=1)
    none = np.zeros(0, dtype=int)
    noisy = parabola + wave[:, None] * [0.0, 1.0]
    found = smoothed_in_third_order(noisy, none, length)
    middle = np.abs(y) < 5
    assert np.ptp((found - parabola)[middle, 1]) == pytest.approx(part * 0.02, rel=0.02)
    same = smoothed_in_third_order(parabola, none, length)
    assert np.abs(same - parabola)[middle].max() < 1e-4
    roof = np.stack([y, np.abs(y)], axis=1)
    kinks = np.array([y.size // 2])
    assert smoothed_in_third_order(roof, kinks, length) == pytest.approx(roof, abs=1e-9)


def test_profiles_are_smoothed_in_the_third_order(folder):
    old = "'rail.csv'   0     1.0    0.0   -1 "
    (wheel,) = read(folder, (old, "'rail.csv' 0 1.0 5.0 -1 1 \n 2 150d 30d 6d 2.0 "))
    assert wheel.track.rail.smoothing == 0.0
    points = np.stack([RAIL.y, RAIL.z], axis=1)
    expected = smoothed_in_third_order(points, RAIL.kink_points, 5.0)
    assert wheel.track.rail.z == pytest.approx(expected[:, 1])
    (free,) = read(folder, (old, "'rail.csv' 0 1.0 0.0 -1 1 \n 2 150d 30d 6d 2.0 "))
    assert free.track.rail.z == pytest.approx(RAIL.z)
    words = "ISMOOTH = 3 is not supported; supported: 0, 1, 2"
    refused(
        lambda: read(folder, (old, "'rail.csv' 0 1.0 5.0 -1 1 \n 3 150d 30d 6d 2.0 ")), words=words
    )


@pytest.mark.parametrize(("old", "new", "words"), [
    ("  1 MODULE", "  2 MODULE", "line 3: MODULE = 2 is not supported; supported: 1 (wheel on rail), 3"),
    (" 1203100 ", " 2203100 ", "line 4: C (CONFIG) = 2 is not supported; supported: 0 (left wheel on a track), 1"),
    (" 1203100 ", " 1253100 ", "line 4: B (BOUND) = 5 is not supported: KPEC is a fast theory"),
    (" 1203100 ", " 1201110 ", "line 4: F (FORCE) = 1 needs rolling, T = 2 or 3"),
    (" 1203100 ", " 1203020 ", "line 4: F (FORCE) = 2 needs the vertical force, N = 1"),
    (" 0022033 ", " 3022033 ", "line 5: V (VARFRC) = 3 is not supported: rows of elements are not known"),
    (" 0022033 ", " 0092033 ", "line 5: D (DISCNS) = 9 is not supported: a search of CONTACT's developers; supp"),
    (" 0022033 ", " 0023033 ", "line 5: C (INFLCF) = 3 is not supported: tractions are constant on elements here; "),
    (" 0022033 ", " 0022633 ", "line 5: M (MATER) = 6 is not supported: it is reserved in CONTACT; supported: 0 (elastic)"),
    (" 0022033 ", " 0022036 ", "line 5: E (EWHEEL) = 6 is not supported; supported: 0 (as before)"),
    (" 0022033  ", " 0022033 3 ", "line 5: M2 (MATER2) = 3 is not 0, 1 or 2"),
    (" 0022033 ", " 0002033 ", "line 10: line = 4.0 is a number too many behind GAUGHT"),
    (" 0001331 ", " 0001333 ", "holds no case that is to be calculated"),
    ("8.0   4.0 ", "4.0   8.0 ", "line 3: separate = 4.0 is not allowed: must be at least join, 8 mm"),
    (TRACK, "   14.0     0     1435.0  0.000 1e-2 ", "line 11: track.curve_radius = 100.0 is not allowed"),
    (TRACK, "   140.     0     1435.0  0.000 ", "line 11: track.gauge_height = 140.0 is not allowed"),
    ("'rail.csv' ", "'rail.slcs' ", "line 12: path "),
    ("'rail.csv'   0     1.0    0.0   -1 ", "'rail.csv'   0  1.0  0.0  -3 ", "line 12: MIRRORZ = -3.0 is not -1, 0 or 1"),
    (TRACK, f"{TRACK} 0.0 7.0 ", "line 11: line = 7.0 is a number too many behind GAUGHT, GAUGSQ or RAILY0"),
    ("'rail.csv' ", "'none.csv' ", "line 12: path "),
    ("1360.0  -70.0   460.0 ", "-2e3 -70.0 460. ", "line 14: wheelset.inside_distance = -2000.0 is"),
    (PLACE, " 0.0 0.0 1e4 2.0 0.0 0.0 ", "line 16: position.roll = 2.0 is not allowed"),
    (PLACE, " 0.0 0.0 -1e4 0.0 0.0 0.0 ", "line 3: vertical_force = -10000.0 is not allowed"),
    (PLACE, " 0.0 0.0 much 0.0 0.0 0.0 ", "line 16: FZ = 'much' is not a number"),
    (" 2000.   0.0 ", " -2000.   0.0 ", "line 17: velocity.speed = -2000.0 is not allowed"),
    (CASE[CASE.index(" 2000. ") :], "", "ends where VS, VY, VZ, VROLL, VYAW, VPITCH should be given"),
])  # fmt: skip
def test_what_is_not_read_is_said_by_line(folder, old, new, words):
    refused(lambda: read(folder, (old, new)), words=words)


SLICES = """% a rail that widens behind 0, from which a nose begins
 0.0   1.0               S_OFFSET, S_SCALE
 3                       NSLC
 {features}        NFEAT, NKINK, NACCEL
 1                       S_METHOD
 -100.0   'rail.csv'
    0.0   'rail.csv'   ! as before
  150.0   'rail.csv'
"""
FEATURES = """ -100.0  -1.0  0.0  40.0  999.0
    0.0   0.0  5.0  45.0  999.0
  150.0   0.0  5.0  45.0  999.0
"""


def test_slices_of_one_profile_are_that_profile(folder):
    (known,) = read(folder)
    (folder / "rail.slcs").write_text(SLICES.format(features="0 0 0"))
    (found,) = read(
        folder, ("'rail.csv' ", "'rail.slcs' "), (PLACE, PLACE.replace("0.0", "20.", 1))
    )
    assert found.position.s == 20.0
    assert list(found.track.rail.positions) == [-100.0, 0.0, 150.0]
    assert found.touching == known.touching


def test_slices_of_the_second_method_are_control_points(folder):
    text = SLICES.format(features="0 0 0")
    (folder / "rail.slcs").write_text(
        text.replace(" 1                       S_METHOD", " 2  S_METHOD")
    )
    (found,) = read(folder, ("'rail.csv' ", "'rail.slcs' "))
    assert found.track.rail.approximating
    (folder / "rail.slcs").write_text(
        text.replace(" 1                       S_METHOD", " 3  S_METHOD")
    )
    with pytest.raises(
        vc.SceneError, match=r"rail.slcs, line 5: S_METHOD = 3 is neither 1 .* nor 2"
    ):
        read(folder, ("'rail.csv' ", "'rail.slcs' "))


def test_slices_are_read_with_the_scale_of_their_profiles(folder):
    (folder / "rail.slcs").write_text(SLICES.format(features="0 0 0"))
    known, scaled = (
        ProfileSlices.read(folder / "rail.slcs", "rail", scale=scale) for scale in (1.0, 2.0)
    )
    assert scaled.first.y == pytest.approx(2.0 * known.first.y)
    assert list(scaled.positions) == list(known.positions) == [-100.0, 0.0, 150.0]
    assert "scale" in inspect.signature(ProfileSlices.read).parameters
    with pytest.raises(vc.SceneError, match="scale"):
        ProfileSlices.read(folder / "rail.slcs", "rail", scale=0.0)


@pytest.mark.long
def test_parts_that_slices_lack_are_rails_of_their_own(folder):
    (folder / "rail.slcs").write_text(SLICES.format(features="4 0 0") + FEATURES)
    (found,) = read(folder, ("'rail.csv' ", "'rail.slcs' "))
    nose, rail = found.track.rail
    assert (list(nose.positions), nose.features[0].tolist()) == ([0.0, 150.0], [0.0, 5.0])
    assert rail.features.shape == (3, 3)
    assert rail.features[0, :2].tolist() == [0.0, 40.0]
    assert np.isfinite(found.touching)
    # arc lengths are of the profile as it is mirrored
    (turned,) = read(folder, ("'rail.csv'   0 ", "'rail.slcs' 1 "))
    assert turned.track.rail[1].features == pytest.approx(rail.features, abs=1e-4)


def test_slices_have_kinks_at_features(folder):
    """Two planes that meet at a feature, NKINK = 1: sections have their edge, not a rounded one;
    NACCEL and numbers out of range.
    """
    y = np.linspace(-40.0, 40.0, 161)
    for name, edge in (("first.csv", 0.0), ("last.csv", 5.0)):
        z = np.abs(y - edge) * 0.3
        np.savetxt(folder / name, np.stack([y, z], axis=1))
    text = """ 0.0 1.0
 3
 3 1 1   NFEAT, NKINK, NACCEL
 1 0     S_METHOD, PERTURB
 0.0 'first.csv'
 100. 'last.csv'
 200. 'last.csv'
 1  KINK
 1  ACCEL
 0.   0. {first!r} 999.
 100. 0. {last!r} 999.
 200. 0. {last!r} 999.
"""
    arc = float(np.hypot(1.0, 0.3))
    path = folder / "edge.slcs"
    whole = text.format(first=40.0 * arc, last=45.0 * arc)
    path.write_text(whole)
    found = ProfileSlices.read(path, "rail", kinks="auto")
    assert found.kinks == (1,)
    surface = surface_of(found, lambda profile: profile.curve, 0.0, backwards=False)
    section = surface.section(50.0)
    at = section.at(surface.points(np.array(50.0), np.array([1.0]))[0][:, 0])
    before, behind = section.directions(np.array([at[0] - 1e-6, at[0] + 1e-6]))
    turn = np.arctan2(*behind[::-1]) - np.arctan2(*before[::-1])
    assert turn == pytest.approx(2 * np.arctan(0.3), abs=1e-3)
    for old, new, words in (
        (" 1  KINK", " 2  KINK", "line 8: KINK = 2 is not in the range 1 to NFEAT - 2 = 1"),
        (" 1  ACCEL", " 0  ACCEL", "line 9: ACCEL = 0 is not in the range"),
        ("\n 100. 0. ", "\n 101. 0. ", "line 11: S = 101.0 is not the position of the slice, 100"),
        (" 1 0     S", " 1 2     S", "line 4: PERTURB = 2 is not supported: waves"),
    ):
        path.write_text(whole.replace(old, new))
        refused(lambda: ProfileSlices.read(path, "rail"), words=words)
    refused(lambda: replace(found, kinks=(2,)), words="numbers of inner features, 1 to 1")
    refused(lambda: replace(found, features=None), words="none: there are no features")


def test_slices_of_a_wheel_are_round_beyond_the_last_one(folder):
    """The radius does not change between the last slice and the first, and whole turns are closed;
    features of wheels are counted from the field side.
    """
    y = np.linspace(-60.0, 60.0, 121)
    for name, depth in (("round.csv", 0.0), ("deep.csv", 0.4)):
        np.savetxt(folder / name, np.stack([y, 0 * y - depth], axis=1))
    path = folder / "flat.slcw"
    path.write_text(
        " 0 1\n 4\n 3 0 0\n 1\n -.2 'round.csv'\n 0. 'deep.csv'\n .1 'deep.csv'\n .3 'round.csv'\n"
        " -.2 0. 20. 999.\n 0. 0. 20. 999.\n .1 0. 20. 999.\n .3 0. 20. 999.\n"
    )
    found = ProfileSlices.read(path, "wheel", mirror_z=False)
    assert found.features[0].tolist() == [0.0, 100.0, 120.0]
    surface = surface_of(found, lambda profile: profile.curve, 0.0, backwards=False)
    beyond = surface.points(np.array([0.3, 0.35, 1.0, 3.0, -0.25]), np.array(0.7))[0][:, 1]
    assert beyond == pytest.approx(0.0, abs=1e-12)
    # around the whole wheel, where the last slices are the first ones
    steps = np.linspace(-3.2, 3.2, 33)
    rows = "".join(f" {step!r} 'round.csv'\n" for step in steps.tolist())
    path.write_text(f" 0 1\n 33\n 0 0 0\n 1\n{rows}")
    closed = ProfileSlices.read(path, "wheel", mirror_z=False)
    assert np.ptp(closed.positions) < 2 * np.pi


def test_a_case_file_takes_slices(folder):
    (folder / "rail.slcs").write_text(SLICES.format(features="0 0 0"))
    path = folder / "case.toml"
    path.write_text(
        'vertical_force = 80e3\ntrack = { rail = "rail.slcs" }\nwheelset = { wheel = "s1002" }\n'
        "position = { s = [0.0, 50.0], pitch = 0.1 }\n"
    )
    cases = read_case(path).cases
    assert [(case.position.s, case.position.pitch) for case in cases] == [(0.0, 0.1), (50.0, 0.1)]
    assert cases[0].track.rail.positions.size == 3


def test_slices_out_of_order_are_named(folder):
    (folder / "rail.slcs").write_text(SLICES.format(features="0 0 0").replace("150.0", "-50.0"))
    with pytest.raises(
        vc.SceneError, match=r"rail.slcs, line 8: S = -50.0 of slice 3 is out of order"
    ):
        read(folder, ("'rail.csv' ", "'rail.slcs' "))


def test_a_height_does_not_become_a_force(folder):
    more = "  1 MODULE\n 1203000 C-P-B-T-N-F-S\n 0100000 V-L-D-C-M-Z-E\n 0101331 H-G-I-A-O-W-R\n"
    with pytest.raises(
        vc.SceneError, match=r"line 21: N \(NORM\) = 0 is another than the case before has"
    ):
        read(folder, ("\n  0 MODULE", "\n" + more + "  0 MODULE"))


@pytest.mark.long
def test_the_command_solves_all_wheels_of_a_file(folder):
    """And writes nothing where the file is cut short; the command of scenes names the other."""
    path, table = folder / "case.inp", folder / "table.csv"
    path.write_text(CASE[: CASE.index(" 2000. ")])
    cut_short = run("wheelrail", "case.inp", "--out", "table.csv", folder=folder)
    assert_bad_input(
        cut_short, "case.inp ends where VS, VY, VZ, VROLL, VYAW, VPITCH should be given"
    )
    assert not table.exists()
    more = "  1 MODULE\n 1203100 C-P-B-T-N-F-S\n 0100001 V-L-D-C-M-Z-E\n 0101331 H-G-I-A-O-W-R\n 0 2. 5e3 0 0 0\n"
    coarse = CASE.replace("0.200   0.200", "0.500   0.500")
    path.write_text(coarse.replace("\n  0 MODULE", "\n" + more + "  0 MODULE"))
    done = run("wheelrail", "case.inp", "--out", "table.csv", folder=folder)
    assert done.returncode == 0, done.stderr
    with open(table, newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["position"], row["outcome"]) for row in rows] == [("1", "solved"), ("2", "solved")]
    assert [float(row["track_Fz"]) for row in rows] == pytest.approx([10e3, 5e3], rel=1e-5)
    assert_bad_input(run("solve", "case.inp", folder=folder), "`varcontact wheelrail` solves it")


def test_slices_are_turned_as_the_first_one(folder):
    """By itself the second, a crown alone, would be taken for hollow."""
    whole, crown = np.abs(RAIL.y) < 50.0, np.abs(RAIL.y + 7.5) < 20.0
    for name, part in (("whole", whole), ("crown", crown)):
        np.savetxt(folder / f"{name}.txt", np.stack([RAIL.y[part], -RAIL.z[part]], axis=1))
    text = SLICES.format(features="0 0 0").splitlines()
    rows = iter(["whole.txt", "crown.txt", "whole.txt"])
    text = [line if "'" not in line else f" {line.split()[0]} '{next(rows)}'" for line in text]
    (folder / "up.slcs").write_text("\n".join(text))
    with pytest.warns(DoubtfulProfile, match="whole.txt: the sign of z is changed"):
        slices = ProfileSlices.read(folder / "up.slcs", "rail")
    assert [each.z.min() for each in slices.profiles] == pytest.approx([RAIL.z.min()] * 3, abs=1e-9)
