"""The fast way: Hertz in closed form, virtual penetration against Hertz and CONTACT, and what it
refuses.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from tests.wheel_rail.conditions import benchmark, circles, manchester, published, wheel
from varcontact import creep_forces, reference
from varcontact.errors import SceneError
from varcontact.kinematics import rotation
from varcontact.scene.bodies import Bodies
from varcontact.scene.friction import StaticKinetic
from varcontact.theories import table_forces
from varcontact.wheel_rail.virtual_penetration import NORMAL, fast_ellipse


@pytest.mark.parametrize("normal", ["analyn", "hertz"])
def test_two_circles_are_hertz_contact(normal):
    case = circles(y=-12.0, yaw=1e-3)
    found = case.estimate(normal)
    (each,) = found.patches
    assert found.force[2] == pytest.approx(80e3, rel=1e-6)
    rolling = 460.0 / np.cos(each.angle)
    exact = reference.hertz(
        rolling, 1 / (1 / 300 + 1 / 500), case.bodies, force=float(each.force[2])
    )
    ellipse = each.ellipse
    assert (ellipse.a, ellipse.b, ellipse.peak_pressure, each.approach) == pytest.approx(
        (exact.a, exact.b, exact.peak_pressure, exact.approach), rel=2e-3
    )
    rolled = each.creepage
    forces = creep_forces(
        "fastsim", a=ellipse.a, b=ellipse.b, bodies=case.bodies, normal_force=float(each.force[2]), friction=0.3,
        vx=rolled.vx, vy=rolled.vy, spin=rolled.spin,
    )  # fmt: skip
    assert (*each.force[:2], each.moment) == (forces.Fx, forces.Fy, forces.Mz)


def test_virtual_penetration_of_two_circles_from_its_definition():
    """The deflection at the middle by quadrature over the ellipse that 0.55 of the approach
    overlaps.
    """
    case = circles()
    (each,) = case.estimate().patches
    Rx, Ry, overlap = 460.0, 1 / (1 / 300 + 1 / 500), 0.55 * each.approach
    a, b = np.sqrt(2 * Rx * overlap), np.sqrt(2 * Ry * overlap)
    assert (each.ellipse.a, each.ellipse.b) == pytest.approx((a, b), rel=5e-3)

    # p/p0 = sqrt(1 - y^2/b^2 - x^2/a^2): the integral of p/distance in polar coordinates
    def along_ray(t):
        return np.pi / 4 / np.sqrt((np.cos(t) / a) ** 2 + (np.sin(t) / b) ** 2)

    felt = quad(along_ray, 0, 2 * np.pi)[0]
    modulus = np.pi * case.bodies.combined_G / (1 - case.bodies.combined_nu)
    p0 = each.approach * modulus / felt
    assert each.ellipse.peak_pressure == pytest.approx(p0, rel=5e-3)
    assert each.force[2] == pytest.approx(2 / 3 * np.pi * a * b * p0, rel=5e-3)


CLAMP = {"outside": "clamp"}


@pytest.mark.long
@pytest.mark.parametrize(("normal", "theory", "options", "typical", "worst", "peak"), [
    ("virtual-penetration", "fastsim", {}, 0.035, 0.08, 0.3),
    ("hertz", "fastsim", {}, 0.035, 0.10, 0.3),
    ("virtual-penetration", "table", CLAMP, 0.0015, 0.08, 0.3),
    ("analyn", "table", CLAMP, 0.0015, 0.08, 0.11),
    ("hertz", "table", CLAMP, 0.0015, 0.09, 0.3),
])  # fmt: skip
def test_the_benchmarks_positions(normal, theory, options, typical, worst, peak):
    """All 42 of them against CONTACT: forces by f Fn, peak pressure, location; one has two
    ellipses.
    """
    apart = []
    for row in manchester():
        found = benchmark(row).estimate(normal, theory, **options)
        each = max(found.patches, key=lambda patch: patch.force[2])
        wanted = np.array([row["fx"], row["fs"], row["fn"]])
        force = (
            rotation(roll=row["angle"]).T @ found.force if len(found.patches) > 1 else each.force
        )
        apart.append(np.hypot(*(force - wanted)[:2]) / (0.3 * row["fn"]))
        assert force[2] == pytest.approx(row["fn"], rel=0.015)
        assert found.force[2] == pytest.approx(10e3, rel=1e-6)
        assert each.frame.origin[1] == pytest.approx(row["y"], abs=1.1)
        assert len(found.patches) > 1 or each.ellipse.peak_pressure == pytest.approx(
            row["pmax"], rel=peak
        )
        assert found.z == pytest.approx(row["z_ws"], abs=0.01)
    assert np.median(apart) < typical
    assert max(apart) < worst


@pytest.mark.parametrize(("y", "options"), [(2.0, {}), (9.0, CLAMP)])
def test_forces_of_the_table_are_those_of_the_table_by_hand(y, options):
    """On the tread, and at the flange, where patches are longer than the ellipses of the book."""
    case = benchmark(published("right", y))
    (each,) = case.estimate(tangential="table", **options).patches
    rolled, ellipse = each.creepage, each.ellipse
    assert (ellipse.a / ellipse.b > 5) == (options == CLAMP)
    G, limit = case.bodies.combined_G, 0.3 * ellipse.normal_force
    found = table_forces(
        ellipse.a, ellipse.b, G, limit, (rolled.vx, rolled.vy, rolled.spin), **options
    )
    assert each.force[:2] == pytest.approx(found.force, rel=1e-9)
    assert each.moment == pytest.approx(float(found.moment), rel=1e-9)


@pytest.mark.parametrize(("more", "arguments", "words"), [
    ({}, {"tangential": "table", "outside": "nearest"}, r"outside = 'nearest' .* refuse, clamp"),
    ({"bodies": Bodies(G=82e3, nu=0.3)}, {"tangential": "table"}, r"nu = 0\.3 .* within 0\.01 of the book's, 0\.28"),
    ({"bodies": Bodies(G=(82e3, 26e3), nu=(0.28, 0.33))}, {"tangential": "table"}, "bodies: .* quasi-identical bodies"),
    ({}, {"outside": "clamp"}, "outside is no option of fastsim"),
    ({}, {"normal": "herz"}, "normal = 'herz'.*did you mean hertz"),
    ({"friction": StaticKinetic(0.4, 0.3)}, {}, "fast theories have one coefficient"),
    ({}, {"tangential": "contact"}, "theory"),
])  # fmt: skip
def test_what_is_refused(more, arguments, words):
    with pytest.raises(SceneError, match=words):
        circles(**more).estimate(**arguments)


def test_an_ellipse_that_the_table_has_not_is_refused():
    with pytest.raises(
        SceneError,
        match=r'a/b = 9\.\d+ .* the range of the book \(outside="clamp" takes the nearest',
    ):
        benchmark(published("right", 9.0)).estimate(tangential="table")


@pytest.mark.parametrize(
    ("depth", "circles", "within"),
    [(1e-6, 1, 0.55), (1e-4, 1, 0.3), (1e-3, 4, 0.1), (1e-2, 13, 0.05)],
)
def test_overlaps_of_few_circles_are_near_hertz(depth, circles, within):
    """At the flange, where a light load makes a patch narrower than the step of the locus."""
    case = benchmark(manchester()[-1])
    case = replace(case, vertical_force=None, z=case.touching + depth)
    (overlap,) = case.locus.overlaps(case.z)
    (found,), (strips,), (exact,) = (case.estimate(normal).patches for normal in NORMAL)
    assert overlap.depth.size == circles
    for each in (found, strips)[: 1 + (circles > 1)]:  # one circle is not the lowest point
        assert each.ellipse.normal_force == pytest.approx(exact.ellipse.normal_force, rel=within)


@pytest.mark.filterwarnings("ignore:with dy")
@pytest.mark.parametrize("normal", NORMAL)
def test_each_overlap_has_its_ellipse(normal):
    """Tread and flange root 8 mm apart: nothing jumps where the exact way begins to see one
    patch.
    """
    case = wheel(5.05, yaw=0.01, vertical_force=4e3, dx=0.4, dy=0.2)
    for depth in (0.007, 0.008):
        at = replace(case, vertical_force=None, z=case.touching + depth)
        fast = at.estimate(normal)
        assert len(fast.patches) == 2
        assert fast.force[2] == pytest.approx(at.solve().force[2], rel=0.03)
    found = replace(case, with_friction=False).estimate(normal)
    borne = sum(each.force[2] * np.cos(each.angle) for each in found.patches)
    assert borne == pytest.approx(4e3, rel=1e-6)


@pytest.mark.parametrize("normal", ["virtual-penetration", "analyn"])
def test_two_circles_that_touch_at_one_place_are_too_rough(normal):
    """As where a profile has a corner: no strip lies between them, and no spline passes through
    both.
    """
    case = circles()
    locus, z = case.locus, case.touching + 0.05
    (whole,) = locus.overlaps(z)
    assert fast_ellipse(case, [whole], z, normal).normal_force > 0
    twice = whole.run.start + 3
    points, gap = locus.points.copy(), locus.gap.copy()
    points[twice + 1], gap[twice + 1] = points[twice], gap[twice]
    (cornered,) = replace(locus, points=points, gap=gap).overlaps(z)
    with pytest.raises(SceneError, match="rough"):
        fast_ellipse(case, [cornered], z, normal)
