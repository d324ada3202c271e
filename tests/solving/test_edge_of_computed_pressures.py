"""Elements that the edge of a computed contact cuts: their pressure is solved for on parts of
them.
"""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene, refused
from varcontact.discrete.state import SQUARE, means

PLACES = np.linspace(-2.0, 2.0, 161)
ROLLS = vc.Steady(vx=0.03, vy=-0.02, spin=0.04)


def surface():
    """A bowl that is no paraboloid."""
    x, y = np.meshgrid(PLACES, PLACES)
    return vc.SampledDistance(
        0.5 * x**2 + 0.8 * y**2 + 0.05 * x**3 + 0.2 * y**4, x=PLACES, y=PLACES
    )


def posed(edge="softened", cells=12, **changes):
    scene = make_scene(surface(), 1.0, ROLLS, vc.Grid(nx=cells, ny=cells, edge=edge))
    return dataclasses.replace(scene, **changes)


def loads(scene, **options):
    """Fx, Fy and Mz by f Fz; the contact is about as long as one."""
    return loads_of(vc.solve(scene, **options))


def loads_of(sol):
    return np.array([*sol.force, sol.moment]) / (0.3 * sol.normal_force)


def second_order(scene):
    """The slip of the second order, on the grid as it is."""
    return dataclasses.replace(scene.second_order(), grid=scene.grid)


@pytest.mark.parametrize("edge", ["touched", "softened"])
def test_means_are_hertzs(rolling, edge):
    """Pressures and what the contact covers tend to the closed forms; forces are those by these."""
    off = []
    for cells in (12, 24):
        scene = second_order(rolling(grid=vc.Grid(nx=cells, ny=cells, edge=edge)))
        exact, found = vc.solve(scene), vc.solve(scene, normal="newton")
        assert found.pressure_on_parts.shape == (
            SQUARE[0] * found.grid.rows,
            SQUARE[1] * found.grid.nx,
        )
        np.testing.assert_allclose(
            found.pressure, means(found.pressure_on_parts, SQUARE), rtol=1e-14
        )
        assert exact.pressure_on_parts is None
        off.append(np.abs(found.pressure - exact.pressure).max() / exact.pressure.max())
        covered = means((found.pressure_on_parts > 0).astype(float), SQUARE)
        assert np.abs(covered - exact.scene.hertz.covered(*exact.grid.lines)).max() < 0.45
        assert covered.sum() * found.grid.area == pytest.approx(np.pi * 1.2 * 0.9, rel=0.5 / cells)
        moment = abs(found.moment - exact.moment)
        assert np.max([*np.abs(found.force - exact.force), moment]) < 0.3 * 0.1 / cells
    assert max(off) < 0.015


def moved_lattice(cells, moved, edge):
    """So many elements across 2.2 by 1.6, moved by a part of an element."""
    dx, dy = 2.2 / cells, 1.6 / cells
    left, bottom = -1.1 - moved * dx, -0.8 - 0.7 * moved * dy
    return vc.Grid(nx=cells + 1, ny=cells + 1, dx=dx, dy=dy, x0=left, y0=bottom, edge=edge)


@pytest.mark.long
def test_errors_are_smaller_than_by_centres():
    """On lattices moved by parts of an element: half the error on one grid, a third of that
    extrapolated from two.
    """
    fine = [loads(second_order(posed("softened", cells)), certify="none") for cells in (64, 96)]
    limit = fine[1] + (fine[1] - fine[0]) / (1.5**1.5 - 1)
    off = {}
    for edge in ("centres", "softened"):
        single, two = [], []
        for moved in (0.0, 0.3, 0.5, 0.8):
            scenes = [
                second_order(posed(edge, grid=moved_lattice(cells, moved, edge)))
                for cells in (10, 20)
            ]
            coarse, finer = (loads(scene, certify="none") for scene in scenes)
            single.append(finer - limit)
            two.append(finer + (finer - coarse) / 3 - limit)
        off[edge] = [np.sqrt(np.mean(np.square(each))) for each in (single, two)]
    assert off["softened"][0] < 0.6 * off["centres"][0]
    assert off["softened"][1] < 0.4 * off["centres"][1]


def test_the_certificate_judges_the_pressure_on_the_parts():
    """A rough pressure: residual and gap tell, and the bound on forces holds what it does to
    them.
    """
    exact = vc.solve(second_order(posed()))
    rough = vc.solve(second_order(posed()), tol=1e-3, polish=False)
    found = rough.certificate
    assert exact.certificate.normal_residual < 1e-8
    assert found.normal_residual > 10 * exact.certificate.normal_residual
    off = np.abs([*(rough.force - exact.force), rough.moment - exact.moment])
    assert np.all(off <= found.force_bound + exact.certificate.force_bound)


def test_mirror():
    sol = vc.solve(second_order(posed()))
    mirrored = vc.solve(second_order(posed(motion=vc.Steady(vx=0.03, vy=0.02, spin=-0.04))))
    np.testing.assert_allclose(mirrored.force, sol.force * [1, -1], rtol=1e-7)
    assert mirrored.moment == pytest.approx(-sol.moment, rel=1e-7)


def test_a_grid_that_does_not_hold_the_contact_is_refused():
    grid = vc.Grid(nx=12, ny=12, dx=0.14, dy=0.12, x0=-0.84, y0=-0.72, edge="softened")
    refused(lambda: vc.solve(posed(grid=grid)), match="does not contain the contact")


@pytest.mark.parametrize("cells", [8, 12, 16, 21])
def test_parts_beyond_the_samples(cells):
    """Samples that end close to the contact: parts of elements at the rim lie beyond them, and
    change nothing.
    """
    near = np.linspace(-1.0, 1.0, 81)
    x, y = np.meshgrid(near, near)
    bowl = vc.SampledDistance(0.8 * x**2 + 1.2 * y**2, x=near, y=near)
    wide = vc.Paraboloids(Rx=0.625, Ry=1 / 2.4)
    scenes = [
        second_order(posed(cells=cells, surface=each, normal_force=2.0)) for each in (bowl, wide)
    ]
    ends, goes_on = (vc.solve(scene, normal="newton") for scene in scenes)
    assert ends.grid.box[1] > 0.9
    np.testing.assert_allclose(loads_of(ends), loads_of(goes_on), rtol=0, atol=0.01)
    with pytest.raises(vc.SceneError, match="the contact reaches the edge of the samples"):
        vc.solve(posed(cells=cells, surface=bowl, normal_force=5.0))


def test_a_bound_on_forces_needs_a_pressure_that_tells_what_is_covered():
    """Pressures so small that they may be none: the softening they cause is open, and so are the
    forces.
    """
    sol = vc.solve(second_order(posed()))
    parts = np.where(sol.pressure_on_parts > 0, sol.pressure_on_parts, 1e-9 * sol.pressure.max())
    rows, columns = SQUARE
    in_contact = (sol.pressure > 0).repeat(rows, axis=0).repeat(columns, axis=1)
    scene = dataclasses.replace(sol.scene, grid=sol.grid)
    found = vc.certify(scene, sol.traction, parts * in_contact)
    assert np.isinf(found.force_bound).all() and np.isnan(found.pressure_part).all()


def test_a_start_keeps_its_elements():
    steady = vc.solve(posed("touched"))
    motion = vc.Transient(steps=2, start=steady, vx=0.03, vy=-0.02, spin=0.04)
    history = vc.solve(posed(grid="auto", motion=motion))
    assert history.grid.edge == "touched"
    np.testing.assert_allclose(history[1].force, steady.force, rtol=1e-7)
    softened = vc.solve(posed("softened"))
    history = vc.solve(posed(grid="auto", motion=dataclasses.replace(motion, start=softened)))
    assert history.grid.edge == "touched"


def test_a_step_in_which_only_parts_touch():
    """Elements so long that their centres do not touch at a small approach."""
    grid = vc.Grid(nx=4, ny=4, dx=0.7, dy=0.7, x0=-1.4, y0=-1.4, edge="touched")
    motion = vc.Transient(steps=3, vx=0.03, approach=[0.7, 0.1, 0.7])
    history = vc.solve(posed(normal_force=None, approach=0.7, grid=grid, motion=motion))
    fine = vc.solve(posed("centres", 40, normal_force=None, approach=0.1))
    assert history[1].normal_force == pytest.approx(fine.normal_force, rel=0.25)


@pytest.mark.long
def test_files(tmp_path):
    """The pressure on the parts is kept, and measured again; one with other means than the elements is
    refused.
    """
    sol, path = vc.solve(second_order(posed())), tmp_path / "sol.nc"
    rows, columns = sol.pressure_on_parts.shape
    assert sol.to_xarray()["pressure_on_parts"].sizes == {"y_parts": rows, "x_parts": columns}
    wrong = dataclasses.replace(sol, pressure_on_parts=1.01 * sol.pressure_on_parts)
    wrong.save(path)
    refused(lambda: vc.load(path), match="has other means than the elements", error=vc.OutputError)
    wrong = dataclasses.replace(sol, pressure_on_parts=None)
    wrong.save(path)
    refused(lambda: vc.load(path), match="that is missing", error=vc.OutputError)
    rows, columns = SQUARE
    whole = (
        (means((sol.pressure_on_parts > 0).astype(float), SQUARE) == 1)
        .repeat(rows, axis=0)
        .repeat(columns, axis=1)
    )
    # whose mean is zero
    pattern = np.arange(rows * columns).reshape(SQUARE) - (rows * columns - 1) / 2
    uneven = 0.01 * sol.pressure.max() * np.tile(pattern, sol.grid.shape) * whole
    other = dataclasses.replace(sol, pressure_on_parts=sol.pressure_on_parts + uneven)
    other.save(path)
    assert "made anew" in vc.load(path).note


@pytest.mark.long
def test_a_history(tmp_path):
    steady = vc.solve(posed("touched"))
    motion = vc.Transient(
        steps=3, start=steady, vx=0.03, vy=-0.02, spin=0.04, normal_force=[1.0, 1.0, 0.0]
    )
    history = vc.solve(
        posed("touched", motion=motion, grid=steady.grid), store=tmp_path / "history.nc"
    )
    assert np.abs(history[1].traction - steady.traction).max() < 1e-8 * steady.pressure.max()
    parts = history[2].pressure_on_parts
    assert not parts.any() and parts.shape == steady.pressure_on_parts.shape
    again = vc.load(tmp_path / "history.nc")
    for k in range(3):
        assert again[k].note == ""
        np.testing.assert_array_equal(again[k].pressure_on_parts, history[k].pressure_on_parts)
