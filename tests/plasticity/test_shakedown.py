"""Shakedown limits: closed forms, theorems, symmetries, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.plasticity.fields import ellipse, line, mcewen
from tests.plasticity.march import marched
from varcontact.errors import NotConverged, SceneError
from varcontact.plasticity.balls import ANY, AXIAL, families, smallest_balls
from varcontact.plasticity.half_plane import HalfPlane
from varcontact.plasticity.limits import LimitSearch, _by_programs, _Found, of_half_the_elements
from varcontact.plasticity.line_contact import line_limit, line_passage, with_proof
from varcontact.plasticity.melan import lower_bound
from varcontact.plasticity.passage import _layer as stress_layer
from varcontact.plasticity.passage import coordinates, loaded_part, passage, yield_strength
from varcontact.plasticity.proof import Proof
from varcontact.plasticity.residual_stress import ResidualSpace
from varcontact.results.stress import BodyField

LINE = {(0.0, 0.3): 4.0, (0.1, 0.3): 3.5642, (0.2, 0.5): 3.2024, (0.3, 0.3): 2.8996}
SURFACE = {(0.4, 0.3): 2.316, (0.5, 0.3): 1.882, (0.4, 0.5): 2.5, (0.5, 0.5): 2.0}


def quiet(stage):
    pass


def ones(depth):
    return np.ones_like(depth)


def exact_line(f, nu, **options):
    return vc.shakedown(line(f, nu, n=20), 0.5 / (1 - nu), elastic=mcewen(f, nu), **options)


@pytest.fixture(scope="module")
def sliding():
    return ellipse(f=0.3)


@pytest.fixture(scope="module")
def small():
    return ellipse(f=0.3, n=8)


@pytest.fixture(scope="module")
def plain(small):
    """Its limit, by bounds of closed form."""
    return vc.shakedown(small, 1.0, gap=None)


@pytest.mark.long
@pytest.mark.parametrize(("f", "nu"), LINE)
def test_line_contacts_ratchet_below_the_surface_at_the_largest_shear_stress(f, nu):
    """Johnson (1962): the limit is 1/max|sxz|, from both sides."""
    limit = exact_line(f, nu)
    assert limit.lower == pytest.approx(LINE[f, nu], rel=2e-4)
    assert limit.upper == pytest.approx(LINE[f, nu], rel=2e-4)
    assert limit.lower <= limit.upper


@pytest.mark.parametrize(("f", "nu"), SURFACE)
def test_line_contacts_flow_at_the_surface_below_one_by_f_unless_incompressible(f, nu):
    limit = exact_line(f, nu)
    assert limit.upper == pytest.approx(SURFACE[f, nu], rel=5e-4)
    assert limit.lower == pytest.approx(SURFACE[f, nu], rel=4e-3)
    assert limit.depth < 0.02


@pytest.mark.long
def test_line_contact_by_its_own_tractions():
    """First order or better in the strips; the change by half of them is of that size."""
    limit = vc.shakedown(line(0.2), 0.5 / 0.7)
    assert limit.upper == pytest.approx(3.2024, rel=1e-3)
    assert limit.field_error < 1e-3
    assert limit.mode == "subsurface ratchetting"
    # rho_zz and rho_xz are zero: each depth for itself
    assert np.all(limit.section.stress[2, 0] == 0)


@pytest.mark.long
@pytest.mark.parametrize(("f", "nu"), [(0.0, 0.3), (0.2, 0.3), (0.3, 0.5), (0.4, 0.3)])
def test_lower_bounds_by_an_elastic_plastic_march(f, nu):
    """Thirty passages: plastic strain dies out a little below the limit, and goes on above it."""
    limit = exact_line(f, nu)
    every = limit.critical[::8]
    below = marched(0.98 * limit.lower * every, nu)
    above = marched(1.03 * limit.upper * every, nu)
    assert below[-1] <= 1e-9
    assert above[-1] > 1e-3


def test_smallest_balls():
    """Of a circle its radius; with one free component the distance from a line."""
    angle = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    circle = np.zeros((2, 60, 5))
    circle[0, :, 1] = 3 + 2 * np.cos(angle)
    circle[0, :, 3] = 4 + 2 * np.sin(angle)
    circle[1] = circle[0] / 2
    balls = smallest_balls(circle, ANY, 400)
    # the origin, the load far away, belongs to each: 5 from the centre
    assert balls.least[0] == pytest.approx(3.5, rel=1e-3)
    assert balls.most[0] == pytest.approx(3.5, rel=1e-3)
    assert np.all(balls.least <= balls.most + 1e-12)
    axial = smallest_balls(circle[:1], AXIAL, 400)
    assert axial.least[0] == pytest.approx(6.0, rel=1e-2)


@pytest.mark.long
def test_circle_without_friction():
    """Exact field: 4.6753; bounds of closed form are from above on a grid."""
    limit = vc.shakedown(ellipse(n=40), 1.0, gap=None)
    assert limit.upper * limit.peak_pressure == pytest.approx(4.6753, rel=8e-3)
    assert limit.mode == "alternating plasticity"
    assert limit.depth == pytest.approx(0.35, abs=0.03)
    assert limit.lower < limit.kinematic[0] <= limit.kinematic[1] == limit.upper


@pytest.mark.long
@pytest.mark.slow
def test_programs_close_the_gap():
    sliding = ellipse(f=0.3, n=20)
    stages = []
    limit = vc.shakedown(sliding, 1.0, gap=0.025, progress=stages.append)
    assert limit.gap <= 0.025
    assert limit.proved
    assert "proved between them" in limit.report()
    assert 3.24 < limit.lower <= limit.sampled <= limit.upper * 1.0001
    assert limit.upper <= 1.0001 / limit.local / limit.peak_pressure
    assert limit.mode == "surface flow"
    assert limit.flow[0] == pytest.approx(1.0, abs=0.02) or limit.flow[0] < -0.98
    assert any("lower bound" in stage for stage in stages)
    # a sample to an element is enough where the surface slides
    assert np.diff(limit.section.y).min() == pytest.approx(sliding.grid.sides[1])


def test_where_the_surface_slides_alone_no_velocities_are_sought():
    stages = []
    sliding = ellipse(f=0.4, n=8)
    way = passage(sliding, 2, ones).half()
    search = LimitSearch(sliding, 2, ones, "none", 1e-4, None, stages.append)
    found = _by_programs(_Found.closed(families(way), way, search), search, 1e-4, last=True)
    assert found.place[1] == 0
    assert any("lower bound" in stage for stage in stages)
    assert not any("upper bound" in stage for stage in stages)


@pytest.mark.parametrize(("f", "slides"), [(0.2, False), (0.4, True)])
def test_programs_dissipate_where_the_body_flows(f, slides):
    way = passage(ellipse(f=f, n=8), 2, ones).half()
    bound = lower_bound(way, ResidualSpace.around(way, 6, 3, 7), np.inf, quiet)
    assert (bound.at_surface > 0.98, bound.at_surface < 0.2) == (slides, not slides)


@pytest.mark.long
@pytest.mark.slow
def test_no_bound_crosses_k_by_the_largest_traction():
    """A theorem: a thin layer slides where the traction reaches k."""
    for motion in ({"Fx": 0.4}, {"spin": 2.0}):
        limit = vc.shakedown(ellipse(f=0.4, n=8, **motion), 1.0, gap=None)
        assert limit.lower <= limit.upper <= (1 + 1e-9) / limit.local / limit.peak_pressure


@pytest.mark.long
def test_factors_scale_with_the_yield_stress(small, plain):
    twice = vc.shakedown(small, 2.0, gap=None)
    for name in ("lower", "upper", "elastic"):
        assert getattr(twice, name) == pytest.approx(2 * getattr(plain, name), rel=1e-9)
    assert plain.outcome == "shakes down" or plain.outcome == "elastic"
    assert vc.shakedown(small, 0.25, gap=None).outcome == "surface flow"


@pytest.mark.long
def test_both_bodies_alike_without_friction():
    solution = ellipse(n=8)
    limits = [vc.shakedown(solution, 1.0, body, gap=None) for body in ("upper", "lower")]
    assert limits[0].upper == pytest.approx(limits[1].upper, rel=1e-12)


@pytest.mark.long
def test_mirror_images_have_the_same_limits():
    solution = ellipse(f=0.4, spin=1.5, vy=0.1, n=8)
    traction = solution.traction[:, ::-1] * np.array([1.0, -1.0])[:, None, None]
    mirrored = replace(solution, traction=traction, pressure=solution.pressure[::-1])
    limits = [vc.shakedown(each, 1.0, gap=None) for each in (solution, mirrored)]
    assert limits[0].upper == pytest.approx(limits[1].upper, rel=1e-6)
    assert limits[0].lower == pytest.approx(limits[1].lower, rel=1e-6)
    assert limits[0].place == pytest.approx(-limits[1].place, abs=1e-9)


@pytest.mark.long
def test_case_hardening(small, plain):
    """Constant values by depth are a number; a hard layer lets the core decide."""
    same = vc.shakedown(small, ([0.0, 10.0], [1.0, 1.0]), gap=None)
    assert same.upper == pytest.approx(plain.upper, rel=1e-12)
    hard = vc.shakedown(small, lambda depth: np.where(depth < 0.1, 2.0, 1.0), gap=None)
    assert plain.upper < hard.upper < 2 * plain.upper
    assert hard.depth > 0.1


def test_own_field_in_place_of_that_of_the_tractions(sliding):
    """A field without shear at depths that grows to the middle: uniaxial, its limit is by hand."""

    def compressed(points):
        x, y, z = points
        stress = np.zeros((3, 3, *x.shape))
        stress[0, 0] = -3.0 * np.exp(-(x**2 + y**2 + (z + 1.0) ** 2))
        return stress

    field = vc.shakedown(sliding, 1.0, gap=None, elastic=compressed)
    assert np.isnan(field.field_error)
    # sxx alone: |e| = 3/sqrt(3) at first yield, and half of the range about the centre
    assert field.elastic == pytest.approx(1 / np.sqrt(3), rel=1.5e-2)
    assert field.upper == pytest.approx(2 / np.sqrt(3), rel=1.5e-2)
    assert field.lower == pytest.approx(field.upper, rel=3e-2)


@pytest.mark.slow
def test_a_layer_of_the_same_material():
    bodies = vc.Bodies(1.0, 0.3)
    layered = vc.Layered([vc.Layer(h=0.3, G=1.0, nu=0.3)], base=(1.0, 0.3))
    scene = vc.Scene(
        bodies=bodies,
        surface=vc.Paraboloids(1.0, 1.0),
        normal_force=0.5,
        grid=vc.Grid(nx=6, ny=6, dx=0.3, dy=0.3, x0=-0.9, y0=-0.9),
    )
    solution = vc.solve(scene)
    coated = replace(solution, scene=replace(scene, bodies=(bodies, layered)))
    load, grid = loaded_part(solution, 2)
    for depth in (0.1, 0.5):  # near the surface, and in the base
        plain = stress_layer(BodyField(solution, 2), load, grid, depth, (2, 2))
        own = stress_layer(BodyField(coated, 2), load, grid, depth, (2, 2))
        np.testing.assert_allclose(own, plain, atol=2e-3 * np.abs(plain).max())


@pytest.mark.long
def test_surface_stresses_of_bilinear_tractions():
    """Second order at the middle of a slipping circle: constant tractions err by the first."""
    errors = []
    for n in (8, 16, 32):
        solution = ellipse(f=0.5, n=n)
        way = passage(solution, 2, ones)
        row = np.abs(way.y).argmin()
        own = way.curves[0, row]
        inside = np.abs(way.x) < 0.5
        # Hamilton and Goodman (1966): sxx by traction alone rises as -(3 + nu/4) pi/4 ... x
        slope = np.polyfit(way.x[inside], own[inside, 1], 1)[0]
        errors.append(slope)
    assert abs(errors[2] - errors[1]) < 0.4 * abs(errors[1] - errors[0])
    # the surface's shear stress is the traction itself
    assert np.allclose(own[:, 3].min(), -0.5 * solution.pressure.max(), rtol=1e-9) or np.allclose(
        own[:, 3].max(), 0.5 * solution.pressure.max(), rtol=1e-9
    )


@pytest.mark.long
@pytest.mark.slow
def test_residual_stress_is_in_equilibrium_and_holds_between_samples():
    solution = ellipse(f=0.2, n=12)
    way = passage(solution, 2, ones, refined=2).half()
    space = ResidualSpace.around(way, 8, 4, 10)
    bound = lower_bound(way, space, 4.0, quiet)
    rho = bound.residual
    # no tractions at the surface
    assert np.abs(rho[2, :, 0]).max() < 1e-9
    # equilibrium by differences: it vanishes with their steps
    y, z = way.y, way.depth
    across = np.gradient(rho[1, 2], y, axis=1) + np.gradient(rho[2, 2], z, axis=0)
    size = np.abs(np.gradient(rho[2, 2], z, axis=0))[2:-2, 2:-2].max()
    assert np.abs(across[2:-2, 2:-2]).max() < 0.2 * size
    # a closer lattice finds nothing beyond the yield surface but what the estimate allows
    closer = passage(solution, 2, ones, refined=4).half()
    residual = np.moveaxis(coordinates(rho), -1, 0)
    interpolated = np.array(
        [[np.interp(closer.y, way.y, row) for row in each] for each in residual]
    )
    total = bound.factor * closer.curves + np.moveaxis(interpolated, 0, -1)[:, :, None]
    assert np.linalg.norm(total, axis=-1).max() < 1.003


def test_a_shallow_passage_is_the_upper_part_of_the_whole(small):
    whole = passage(small, 2, ones)
    shallow = passage(small, 2, ones, deepest=1.0)
    count = len(shallow.depth)
    assert shallow.depth == pytest.approx(whole.depth[:count])
    assert shallow.depth[-1] <= 1.0 < whole.depth[count]
    assert (shallow.curves == whole.curves[:count]).all()


def test_half_the_elements_carry_the_same_load(sliding):
    half = of_half_the_elements(sliding)
    assert half.pressure.sum() * half.grid.area == pytest.approx(sliding.normal_force, rel=1e-12)
    assert half.grid.sides[0] == pytest.approx(2 * sliding.grid.sides[0])


@pytest.mark.long
def test_report_and_pictures(sliding):
    limit = vc.shakedown(sliding, 1.0, gap=None, hardening="kinematic")
    assert limit.lower == limit.kinematic[0]
    words = limit.report()
    assert "largest traction 0.300" in words
    assert "load factor" in words
    assert len(limit.plot().axes) >= 2
    figure = vc.plot_shakedown_map({"circle": limit})
    assert "circle" in [text.get_text() for text in figure.axes[0].get_legend().get_texts()]


REFUSED = {
    "k": [0.0, -1.0, "steel", 1e-4, [1.0], ([0.0, 1.0], [1.0]), ([1.0, 0.0], [1.0, 1.0])],
    "body": ["rail", 3],
    "hardening": ["isotropic"],
    "gap": [0.0, -0.1],
    "elastic": [3.0, lambda points: points],
    "progress": [1],
}


@pytest.mark.parametrize(
    ("name", "value"), [(name, value) for name, values in REFUSED.items() for value in values]
)
def test_what_is_refused(sliding, name, value):
    with pytest.raises(SceneError, match=name):
        vc.shakedown(**{"solution": sliding, "k": 1.0, "gap": None, name: value})


def test_a_yield_stress_in_another_unit(sliding):
    with pytest.raises(SceneError, match="in the unit of the scene's pressures"):
        vc.shakedown(sliding, 3e-4)


def test_solutions_without_a_limit(sliding):
    empty = replace(sliding, pressure=0 * sliding.pressure, traction=0 * sliding.traction)
    with pytest.raises(SceneError, match="with contact"):
        vc.shakedown(empty, 1.0)
    with pytest.raises(NotConverged, match="has not converged"):
        vc.shakedown(replace(sliding, converged=False), 1.0)
    shifted = vc.solve(replace(sliding.scene, motion=vc.Shift(ux=0.1)))
    with pytest.raises(SceneError, match="Steady"):
        vc.shakedown(shifted, 1.0)
    stuck = vc.solve(replace(sliding.scene, friction=np.inf, motion=vc.Steady(vx=0.01)))
    with pytest.raises(SceneError, match="friction"):
        vc.shakedown(stuck, 1.0)
    with pytest.raises(SceneError, match="solution"):
        vc.shakedown("contact", 1.0)


def test_bodies_whose_stresses_are_not_known():
    rolling = vc.Steady(vx=1e-3)
    steel = vc.Bodies(G=80e9, nu=0.3)
    pin = vc.Scene(
        bodies=steel,
        surface=vc.PinInHole(R=0.010, clearance=5e-6),
        normal_force=1e6,
        friction=0.3,
        motion=rolling,
        grid=vc.Grid(nx=40),
    )
    springs = vc.Scene(
        bodies=vc.Winkler(h=1e-3, E=200e9, G=80e9),
        surface=vc.Paraboloids(Rx=0.3, Ry=0.3),
        normal_force=1e4,
        friction=0.3,
        motion=rolling,
        grid=vc.Grid(nx=8, ny=8),
    )
    for scene, reason in ((pin, "pin"), (springs, "not known")):
        with pytest.raises(SceneError, match=reason):
            vc.shakedown(vc.solve(scene), 1e9)


# ----------------------------------------------------------------------- proofs of line contacts


def of_line(sol):
    load, grid = loaded_part(sol, 2)
    return HalfPlane.of(load[:, 0], grid, sol.scene.bodies.combined_nu, beyond=60)


@pytest.fixture(scope="module")
def along_and_across():
    """A line contact with all three tractions."""
    scene = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.3),
        surface=vc.Cylinders(R=1.0),
        normal_force=0.9,
        friction=0.4,
        motion=vc.Steady(vx=0.05, vy=0.1),
        grid=vc.Grid(nx=60, tractions="linear"),
    )
    return vc.solve(scene)


def test_closed_field_of_linear_tractions(along_and_across):
    field = of_line(along_and_across)
    x = field.x
    for depth in (0.5 * field.spacing, 4 * field.spacing):
        points = np.array([x, 0 * x, np.full(x.shape, -depth)])
        stress = vc.stress(along_and_across, points, "lower").stress
        mirrored = np.array([1.0, 1.0, 1.0, -1.0, -1.0])
        assert field.curve(depth) == pytest.approx(coordinates(stress) * mirrored, abs=3e-5)
        assert _moved(field, x, depth) == pytest.approx(field.curve(depth), abs=1e-13)


def _moved(field, x, depth, ahead=0.0):
    mean, slope = field.stress_at(x, depth)
    if depth == 0:
        return mean
    return mean + (depth + ahead) * slope


@pytest.mark.parametrize("depth", [0.0, 0.05, 0.5, 3.0])
@pytest.mark.parametrize("parts", [1, 4])
def test_bounds_between_samples_hold(along_and_across, depth, parts):
    field = of_line(along_and_across)
    step = field.spacing / parts
    depth *= field.spacing
    ahead = 0.1 * depth
    x = field.x[0] + step * np.arange(parts * (len(field.x) - 1) + 1)
    samples = _moved(field, x, depth, ahead)
    bound = field.between_at(x[:-1], step, depth, ahead)
    if parts == 1:
        assert field.between(depth, ahead)[:-1] == pytest.approx(bound, rel=1e-9, abs=1e-13)
    for part in (0.1, 0.5, 0.8):
        linear = (1 - part) * samples[:-1] + part * samples[1:]
        apart = np.linalg.norm(_moved(field, x[:-1] + part * step, depth, ahead) - linear, axis=1)
        assert (apart <= bound).all()


@pytest.mark.long
@pytest.mark.parametrize(("f", "hardening"), [(0.0, "none"), (0.4, "none"), (0.3, "kinematic")])
def test_lower_bounds_of_lines_are_proved(f, hardening):
    """No stress at random places, beside and between the samples, is above the proved one."""
    sol = line(f, n=60)
    strength = yield_strength(0.5 / 0.7, 1.0)
    passage = line_passage(sol, 2)
    limit = with_proof(passage, strength, line_limit(passage, strength, hardening))
    assert limit.proved
    assert 0.985 * limit.upper < limit.lower < limit.sampled * (1 + 1e-12)
    field = passage.field
    proof = Proof(field, strength, limit.depths, limit.centres, passage.unit)
    layers = sorted(proof.layers(1.002 / limit.upper), key=lambda layer: layer.top)
    assert [each.end for each in layers[:-1]] == [each.top for each in layers[1:]]
    rng = np.random.default_rng(1)
    largest = 0.0
    for layer in layers[:: max(1, len(layers) // 60)]:
        depth = float(rng.uniform(layer.top, layer.end))
        x = np.concatenate([rng.uniform(-1.2, 1.2, 300), rng.uniform(-9, 9, 50)])
        residual = proof.centre((layer.top + layer.end) / 2)
        stress = _moved(field, x, depth) / (0.5 / 0.7) - residual
        size = np.linalg.norm(stress, axis=1).max()
        assert size <= layer.radius
        largest = max(largest, size)
    assert largest > 0.97 / limit.upper


@pytest.mark.long
def test_the_branches_of_line_contact_cross_at_johnsons_friction():
    """Below the surface 1/max|sxz|, at the surface 1/f: both at f = 0.3672 (Johnson: 0.367)."""
    below, crossing, above = (
        vc.shakedown(line(f, 0.5, n=20), 1.0, elastic=mcewen(f, 0.5))
        for f in (0.366, 0.3672, 0.3685)
    )
    assert below.depth > 0.3
    assert below.upper < 0.999 / 0.366
    assert crossing.upper == pytest.approx(1 / 0.3672, rel=1e-4)
    assert above.depth == 0
    assert above.upper == pytest.approx(1 / 0.3685, rel=1e-6)
