"""Rollers, forces along the track, layers and heat of wheels in CONTACT's input files."""

import shutil

import numpy as np
import pytest

import varcontact as vc
from tests.command import assert_bad_input
from tests.command import run as run_command
from tests.scenes import refused
from tests.wheel_rail.conditions import DATA
from tests.wheel_rail.test_contact_input import PLACE, RATES, RIG, TRACK, read
from varcontact.study.contact_comparison import compared, compared_stresses
from varcontact.wheel_rail import Track, read_contact_input, wheel_on_rail_history
from varcontact.wheel_rail.contact_runs import run_wheels

COARSE = ("  0.200   0.200   1.000", "  0.5   0.5   1.000")
COARSEST = ("  0.200   0.200   1.000", "  1.0   1.0   1.000")


@pytest.fixture
def profiles(tmp_path):
    shutil.copy(DATA / "profiles" / "rail_UIC60.csv", tmp_path / "rail.csv")
    shutil.copy(DATA / "profiles" / "wheel_S1002.csv", tmp_path / "the wheel, new.csv")
    return tmp_path


def cases(folder, *changes):
    read(folder, *changes)
    return read_contact_input(folder / "case.inp", strict=False).cases


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_wheel_on_a_roller_has_hertz_pressure(profiles):
    """CONFIG = 5: the radii of wheel and roller along x; a roller that turns as fast does not
    creep.
    """
    y = np.linspace(-15.0, 15.0, 301)
    np.savetxt(profiles / "groove.csv", np.stack([y, 300.0 - np.sqrt(300.0**2 - y**2)], axis=1))
    ball = np.linspace(-9.0, 9.0, 181)
    np.savetxt(profiles / "ball.csv", np.stack([ball, np.sqrt(150.0**2 - ball**2) - 150.0], axis=1))
    changes = [(old, new.format(mirrored="-1")) for old, new in RIG]
    changes[1] = (TRACK, " -1.0 0.0 0.0 500.0 ")
    changes[4] = (PLACE, " 0.0 0.0 20000. 0.0 0.0 0.0 ")
    changes[5] = (RATES, " 0.0 0.0 -20.0 ")
    changes[6] = ("  0.200   0.200   1.000", "  0.2   0.2   0.5 ")
    more = [(" 1203100 ", " 5203100 "), (" 2000.   0.0 ", " 4.0   0.0 ")]
    (case,) = cases(profiles, *changes, *more)
    assert (case.wheel.track.roller_radius, case.wheel.velocity.speed) == (500.0, 2000.0)
    (run,) = run_wheels([case])
    surface = vc.Paraboloids(1 / (1 / 100.0 + 1 / 500.0), 1 / (1 / 300.0 + 1 / 150.0))
    hertz = vc.Scene(bodies=case.wheel.bodies, surface=surface, normal_force=20000.0).hertz
    (patch,) = run.patches
    assert patch["FN"] == pytest.approx(20000.0, rel=1e-4)
    assert patch["PMAX"] == pytest.approx(hertz.peak_pressure, rel=0.01)
    assert abs(patch["CKSI"]) < 1e-4
    with pytest.raises(vc.SceneError, match=r"track.roller_radius = 20.0 is not allowed"):
        Track(rail=case.wheel.track.rail, gauge_height=0.0, roller_radius=20.0)


@pytest.mark.long
def test_a_longitudinal_force_is_met(profiles):
    """F = 1: FX in place of the pitch rate."""
    changes = [COARSE, (" 1203100 ", " 1203110 "), (RATES, "         0.0    0.0  1500. ")]
    (case,) = cases(profiles, *changes)
    assert case.longitudinal_force == 1500.0
    (run,) = run_wheels([case])
    assert run.solution.force[0] == pytest.approx(1500.0, rel=1e-4)
    (case,) = cases(profiles, *changes[:2], (RATES, "         0.0    0.0  15000. "))
    (run,) = run_wheels([case])
    assert "at most what friction can carry" in run.reason


@pytest.mark.long
def test_a_moment_about_the_axle_is_met(profiles):
    """F = 2: MY in place of the pitch rate, about the force times the rolling radius."""
    changes = [COARSEST, (" 1203100 ", " 1203120 "), (RATES, "         0.0    0.0  6.9e5 ")]
    (case,) = cases(profiles, *changes)
    assert (case.axle_moment, case.longitudinal_force) == (6.9e5, None)
    (run,) = run_wheels([case])
    (patch,) = run.solution.patches
    assert -run.solution.moment_on_wheelset[1] == pytest.approx(6.9e5, rel=1e-4)
    assert patch.force_on_track[0] * patch.rolling_radius == pytest.approx(6.9e5, rel=0.01)
    (case,) = cases(profiles, *changes[:2], (RATES, "         0.0    0.0  6.9e6 "))
    (run,) = run_wheels([case])
    assert run.reason.startswith("MY = 6900000.0")


def sprung(sideways, down):
    """Springs of F = 3 after the deviations."""
    line = "     0.0    0.0   0.000   0.0   0.0   0.000     DY, DZ, ROLL, VY, VZ, VROLL\n"
    return line, f"{line} 4000. {sideways} 9000. {down}  KYRAIL, FYRAIL, KZRAIL, FZRAIL\n"


@pytest.mark.long
def test_a_rail_on_springs_is_deflected(profiles):
    """F = 3: the forces on the rail, those of contact and of the springs, are in balance; the
    height that carries a force is given back by that force.
    """
    changes = [COARSEST, (" 1203100 ", " 1203130 "), sprung(-900.0, -1000.0)]
    (case,) = cases(profiles, *changes)
    assert case.springs.stiffness == (4000.0, 9000.0)
    (run,) = run_wheels([case])
    rail = run.solution.case.track.right
    Fy, Fz = run.solution.force[1:]
    assert Fy - 900.0 - 4000.0 * rail.y == pytest.approx(0.0, abs=1.0)
    assert rail.z == pytest.approx((Fz - 1000.0) / 9000.0)
    assert abs(rail.y) > 0.1
    at_height = (PLACE, f" 0.0 0.0 {run.solution.z} 0. 0. 0. ")
    (case,) = cases(profiles, *changes[:1], (" 1203100 ", " 1203030 "), changes[2], at_height)
    (again,) = run_wheels([case])
    assert again.solution.force == pytest.approx(run.solution.force, abs=2.0)


def test_stresses_below_a_wheel(profiles):
    """S = 3: extremes at points below the patch, in its coordinates."""
    points = (
        " 0 1  MATFIL, OUTPUT\n 9  ISUBS\n 1 1 2  NX, NY, NZ\n 0.5\n 0.0\n 1.0 2.0\n 0  ISUBS\n"
    )
    (case,) = cases(
        profiles,
        COARSEST,
        (" 1203100 ", " 1203103 "),
        ("\n  0 MODULE", "\n" + points + "  0 MODULE"),
    )
    (run,) = run_wheels([case])
    (patch,) = run.solution.patches
    (extremes,) = run.stresses
    below = vc.stress(patch.solution, np.array([[0.5, 0.5], [0.0, 0.0], [1.0, 2.0]]))
    assert extremes["SIGVM"] == pytest.approx(below.von_mises.max())
    assert extremes["SIGZZ"] == pytest.approx(below.stress[2, 2].min())


@pytest.mark.long
def test_steps_in_time_go_on_from_each_other(profiles):
    """T = 1, then T = 2: a shift in a second, steps of DQREL elements, and one anew (P = 2)."""
    head = "  1 MODULE\n 1{}0100  C-P-B-T-N-F-S\n 0100002  V-L-D-C-M-Z-E\n 0101331  H-G-I-A-O-W-R\n"
    place = " 0. 0. 10000. 0. 0. 0.\n 2000. 0. 0. 0. 0. -4.34\n"
    more = [head.replace("{}0", first) + place for first in ("002", "002", "202")]
    changes = [
        ("  0.200   0.200   1.000", "  1.0   1.0   1.500"),
        (" 1203100 ", " 1201100 "),
        (" 2000.   0.0    0.0 ", " 0.0   2e-3    0.0 "),
        (RATES, " 0.0 0.0 -1e-6"),
        ("\n  0 MODULE", "\n" + "".join(more) + "  0 MODULE"),
    ]
    found = cases(profiles, *changes)
    assert [case.rolled for case in found] == [0.0, 1.5, 1.5, 1.5]
    assert [case.before and case.before.number for case in found] == [None, 1, 2, None]
    assert len(read_contact_input(profiles / "case.inp")) == 0
    runs = [run.solution for run in run_wheels(found)]
    assert runs[0].patches[0].creepage.vy == pytest.approx(-2e-3, rel=0.01)
    steps = wheel_on_rail_history([case.wheel for case in found[:3]], rolled=[0.0, 1.5, 1.5])
    for run, step in zip(runs, steps, strict=False):
        assert run.force == pytest.approx(step.force)
    assert abs(runs[3].force[0]) < abs(runs[2].force[0])
    done = run_command("wheelrail", "case.inp", folder=profiles)
    assert_bad_input(done, "cases [1, 2, 3, 4] are steps in time")


def test_forces_that_no_motion_gives_are_refused(profiles):
    for changes, reason in [
        ([(" 1203100 ", " 1203020 ")], "F .FORCE. = 2 needs the vertical force, N = 1"),
        ([(" 1203100 ", " 1200130 "), sprung(0.0, 0.0)], "F .FORCE. = 3 needs friction, T = 3"),
        ([(" 1203100 ", " 1203130 "), sprung(0.0, "x")], "FZRAIL = 'x' is not a number"),
    ]:
        with pytest.raises(vc.SceneError, match=reason):
            read(profiles, *changes)


def test_a_layer_and_heat_are_those_of_the_scene(profiles):
    heat = "\n 0.0 450. 50e-3 7.85e-6\n 150. 450. 50e-3 7.85e-6\n"
    (case,) = cases(
        profiles,
        COARSE,
        (" 0022033 ", " 0022433 "),
        (" 0001331 ", " 3001331 "),
        (
            "  0.280   0.280   82000.  82000.  ",
            "  0.28 0.28 82000. 82000.\n 5. 0.02 0. 0." + heat + " 1.0 BETAPL\n %",
        ),
    )
    (patch,) = case.wheel.patches(case.wheel.touching + 0.05)
    assert patch.scene.third_body == vc.ThirdBody(h=0.02, G=5.0)
    assert [each.temperature for each in patch.scene.thermal] == [0.0, 150.0]
    assert patch.scene.motion.speed == pytest.approx(2000.0, rel=1e-3)
    with pytest.raises(vc.SceneError, match="third_body"):
        case.wheel.estimate()


def test_rigid_slip_by_element_is_near_that_of_creepages(profiles):
    """D = 3: in the middle of a patch it is the same; a rail that moves as the wheel does slips
    less.
    """
    (plain,) = cases(profiles, COARSE, (PLACE, " 0.0 3.0 1e4 0. 0.005 0. "))
    (case,) = cases(
        profiles, COARSE, (PLACE, " 0.0 3.0 1e4 0. 0.005 0. "), (" 0022033 ", " 0032033 ")
    )
    assert (plain.wheel.slip_by_element, case.wheel.slip_by_element) == (False, True)
    z = plain.wheel.touching + 0.02
    (one,), (other,) = plain.wheel.patches(z), case.wheel.patches(z)
    grid = other.scene.grid
    middle = (int(np.abs(grid.y).argmin()), int(np.abs(grid.x).argmin()))
    slip = other.scene.motion.rigid_slip[:, *middle]
    place = (grid.x[middle[1]], grid.y[middle[0]])
    spin = one.creepage.spin
    expected = [one.creepage.vx - spin * place[1], one.creepage.vy + spin * place[0]]
    assert slip == pytest.approx(expected, abs=1e-5)
    forces = [run.solution.force for run in run_wheels([plain, case])]
    assert forces[1] == pytest.approx(forces[0], abs=20.0)


@pytest.mark.long
def test_an_angle_that_would_part_a_patch_is_said(profiles):
    """Of one overlap A_SEP does not count; of two that are one patch here it does."""
    fine = ("1.000   90d   8.0   4.0 ", "1.000   {}   {} {} ")
    (one,) = cases(profiles, (fine[0], fine[1].format("1d", 8.0, 4.0)))
    (run,) = run_wheels([one])
    assert run.patches
    at = (PLACE, " 0.0 5.0 1e4 -0.00035540 0.012 0. ")
    for angle, reason in (("90d", ""), ("1d", "A_SEP")):
        (two,) = cases(profiles, at, (fine[0], fine[1].format(angle, 40.0, 20.0)))
        (run,) = run_wheels([two])
        assert run.reason.startswith(reason)
        assert bool(run.patches) == (reason == "")


@pytest.mark.long
def test_a_near_miss_that_would_move_a_patch_is_said(profiles):
    """GAP_MISS: the flange comes near the rail; a smaller gap than that counts nothing."""
    fine = "1.000   90d   8.0   4.0 "
    at = (PLACE, " 0.0 5.6 1e4 0. 0. 0. "), COARSE
    (plain,) = run_wheels(cases(profiles, *at))
    gap = plain.solution.case.locus.gap - plain.solution.z
    for miss, words in ((1e-6, ""), (5.0, "GAP_MISS = 5.0 is not allowed: must be at most ")):
        given = (COARSE[0] + fine[5:], f"{COARSE[1]}{fine[5:]} 12. {miss} ")
        (run,) = run_wheels(cases(profiles, at[0], given))
        assert run.reason.startswith(words)
        assert bool(run.patches) == (words == "")
    assert (gap > 0).any()


def test_deviations_of_a_wheel_move_it_alone(profiles):
    """E = 5: a wheel that is turned about its own middle, and moved, is one of a wheel set that
    is.
    """
    flexible = " 0.0 0.5 0.1 0.001 0.002 0.0\n 0.0 3.0 4.0 0.01 0.02 0.1\n"
    (case,) = cases(
        profiles,
        (" 1203100 ", " 1203000 "),
        (" 0022033 ", " 0022035 "),
        (PLACE, " 0.0 1.0 0.2 0. 0. 0. "),
        ("\n  0 MODULE", "\n" + flexible + "  0 MODULE"),
    )
    wheel = case.wheel
    arm = wheel.wheelset.middle
    assert (wheel.position.y, wheel.position.roll, wheel.position.yaw) == (1.5, 0.001, 0.002)
    rigid = wheel.body(wheel.z).globally(np.array([0.0, arm, 0.0]))
    assert rigid[1:] == pytest.approx([arm + 1.5, 0.3 - wheel.wheelset.radius], abs=2e-3)
    # the wheel's middle moves with the wheel set, and by its own velocity
    moving = wheel.body(wheel.z, pitching=False).velocity_at(rigid)
    assert moving == pytest.approx([2000.0, 3.0, 4.0], abs=0.05)


def test_friction_varies_by_inclination_and_along_the_track(profiles):
    by_angle = (
        (" 0022033 ", " 1022033 "),
        ("  0.300   0.300 ", " 2\n -20d 0.2 0.2\n -10d 0.3 0.3\n %"),
    )
    (case,) = cases(profiles, *by_angle)
    friction = case.wheel.friction
    assert [friction(np.radians(each)) for each in (0.0, 15.0, 30.0)] == pytest.approx(
        [0.3, 0.25, 0.2]
    )
    # one coefficient by the angle of the plane
    (patch,) = case.wheel.patches(case.wheel.touching + 0.02)
    assert patch.scene.friction == pytest.approx(float(friction(-patch.angle)))
    along = (" 0022033 ", " 2022033 "), ("  0.300   0.300 ", " 2\n 0. 0.2 0.2\n 100. 0.3 0.3\n %")
    (case,) = cases(profiles, *along, (PLACE, PLACE.replace("0.0", "60.", 1)))
    assert case.wheel.friction == pytest.approx(0.26)


def test_laws_vary_along_the_track(profiles):
    """Their parameters are linear between the places."""
    along = (
        (" 0022033 ", " 2422033 "),
        (
            "  0.300   0.300 ",
            " 2\n 0. 0.2 0.1 50. 0. 1.\n 100. 0.3 0.2 70. 0. 1.\n 0. 1.\n %",
        ),
    )
    (case,) = cases(profiles, *along, (PLACE, PLACE.replace("0.0", "25.", 1)))
    law = case.wheel.friction
    assert (law.kinetic, law.static, law.half_velocity) == pytest.approx((0.225, 0.35, 55.0))
    equal = along[0], (along[1][0], along[1][1].replace("100.", "0."))
    refused(lambda: read(profiles, *equal), words="SVF = [0.0, 0.0] does not ascend")
    inclined = (" 0022033 ", " 1422033 "), along[1]
    refused(lambda: read(profiles, *inclined), words="friction that varies by inclination is not")


@pytest.mark.parametrize(("distance", "back"), [(0.0, 0.0), (-140.0, -70.0), (-110.0, -55.0)])
def test_a_single_wheel_is_above_the_middle_of_the_axle(profiles, distance, back):
    """The guide, section 3.1: FBDIST = 2 FBPOS, and a rail at RAILY0 = 0."""
    place = (TRACK, " -1. 0. 0. 0. "), ("  1360.0  -70.0   460.0 ", f" {distance} {back} 460. ")
    (case,) = cases(profiles, *place)
    assert case.wheel.wheelset.middle == 0.0
    assert case.wheel.track.origin[0] == pytest.approx(0.0, abs=1e-9)
    (known,) = cases(profiles, (TRACK, " -1. 750. 0. 0. "))
    assert case.wheel.touching == pytest.approx(known.wheel.touching, abs=1e-9)


MATERIAL = "  0.280   0.280   82000.  82000. "


def forces(folder, *changes):
    (run,) = run_wheels(cases(folder, COARSEST, *changes))
    assert not run.reason
    (patch,) = run.patches
    return np.array([patch[name] for name in ("FN", "FX", "FS", "PMAX")])


@pytest.mark.long
def test_viscoelastic_wheels_are_between_their_limits(profiles):
    """M = 1: relaxed at once they have the modulus G/(1 + FG), and that of glass if never."""

    def visco(time):
        return (" 0022033 ", " 0022133 "), (MATERIAL, f"{MATERIAL}\n 1. 1. {time} {time}\n %")

    soft = forces(profiles, (MATERIAL, " .28 .28 41e3 41e3 "))
    hard = forces(profiles)
    assert forces(profiles, *visco(1e-7)) == pytest.approx(soft, rel=2e-3, abs=1.0)
    assert forces(profiles, *visco(1e5)) == pytest.approx(hard, rel=2e-3, abs=1.0)
    between = forces(profiles, *visco(1e-3))[3]
    assert soft[3] < between < hard[3]
    in_time = (" 1203100 ", " 1202100 "), *visco(1e-3)
    refused(lambda: read(profiles, *in_time), words="M (MATER) = 1 needs steady rolling, T = 3")


@pytest.mark.long
def test_wheels_of_simplified_theory(profiles):
    """M = 2, 3: the pressure of half-spaces, saturated tractions, and the load of all forces."""
    slope = (" 0022033 ", " 0022333 "), (MATERIAL, f"{MATERIAL}\n 1. 1. 1.\n %")
    marched = forces(profiles, *slope)
    exact = forces(profiles)
    assert marched == pytest.approx(exact, abs=0.05 * exact[0])
    turned = (RATES, " 0.0 0.0 -5.0 ")
    saturated = forces(profiles, *slope, turned)
    assert saturated[1] == pytest.approx(-0.3 * saturated[0], rel=1e-3)
    own = (" 0022033 ", " 0022233 "), (MATERIAL, f"{MATERIAL}\n 1e-9 1. 1. 1.\n %")
    assert forces(profiles, *own, turned) == pytest.approx(saturated, rel=1e-3, abs=5.0)
    in_time = (" 1203100 ", " 1202100 "), *slope
    refused(lambda: read(profiles, *in_time), words="needs steady rolling (T = 3) by creepages")
    strips = (" 0022033 ", " 0022533 "), slope[1]
    refused(lambda: read(profiles, *strips), words="FaStrip is for Hertz's contact")


def test_damping_of_wheels_is_refused_where_it_acts(profiles):
    (case,) = cases(profiles, (" 0022033  ", " 0022033 1 "))
    assert not case.reason
    damped = (" 0022033  ", " 0022033 2 "), ("  0.200   0.200   1.000", " 1 1 1 1\n .2 .2 1.")
    refused(lambda: read(profiles, *damped), words="M2 (MATER2) = 2 is not supported: damping")


def test_patches_are_compared_by_their_place():
    """Forces to 1e-3 of the normal force, whatever the order."""
    theirs = (
        {"FN": 9000.0, "FX": 0.0, "FS": 1.0, "YCP(R)": 5.0},
        {"FN": 1000.0, "FX": 0.0, "FS": 0.0, "YCP(R)": -9.0},
    )
    ours = [{**theirs[1], "FN": 1009.0}, {**theirs[0], "FS": 20.0}]
    rows = compared(1, ours, vc.ContactOutput(1, None, "right", {}, theirs))
    assert [row.quantity for row in rows if row.verdict == "differs"] == ["FS"]
    (row,) = compared(1, ours[:1], vc.ContactOutput(1, None, "right", {}, theirs))
    assert (row.quantity, row.theirs, row.ours) == ("PATCHES", 2.0, 1.0)
    # and stresses below, by block
    printed = ({"SIGVM": 9.0}, {"SIGVM": 8.0}, {"SIGVM": 1.0}, {"SIGVM": 2.0})
    own = (printed[2], printed[3], printed[0], printed[1])
    output = vc.ContactOutput(1, None, "right", {}, theirs, printed)
    assert {row.verdict for row in compared_stresses(1, own, output, ours)} == {"equal"}


def test_estimates_are_of_elastic_wheels(profiles):
    visco = (" 0022033 ", " 0022133 "), (MATERIAL, f"{MATERIAL}\n 1. 1. 1e-3 1e-3\n %")
    (case,) = cases(profiles, COARSEST, *visco)
    refused(case.wheel.estimate, words="elastic half-spaces: estimates are of these")
