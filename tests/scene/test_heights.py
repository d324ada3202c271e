"""Measured heights: objects, files and arrays give the same surface; what is removed; roughness."""

import pickle

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import refused
from varcontact.scene.heights import levelled

X = 0.1 * (np.arange(12) - 5.5)
Y = 0.2 * (np.arange(9) - 4.0)
HEIGHTS = np.random.default_rng(0).normal(size=(9, 12))
EXPECTED = HEIGHTS.max() - HEIGHTS


class Topography:
    """As SurfaceTopography has them: the first index counts along x."""

    def __init__(self, heights, *positions):
        self.given = heights, positions

    def heights(self):
        return self.given[0]

    def positions(self):
        return self.given[1] if len(self.given[1]) > 1 else self.given[1][0]


def topography(heights=HEIGHTS, x=X, y=Y):
    return Topography(heights.T, *np.meshgrid(x + 3.0, y - 1.0, indexing="ij"))


def columns(order=None):
    x, y = np.meshgrid(X, Y)
    rows = np.stack([x.ravel(), y.ravel(), HEIGHTS.ravel()], axis=1)
    return rows if order is None else rows[order]


def sources(folder):
    np.save(folder / "heights.npy", HEIGHTS)
    np.savetxt(folder / "heights.csv", HEIGHTS, delimiter=",", fmt="%.17g")
    shuffled = np.random.default_rng(1).permutation(HEIGHTS.size)
    np.savetxt(folder / "heights.xyz", columns(shuffled), fmt="%.17g")
    np.savetxt(folder / "columns.txt", columns(), fmt="%.17g", header="x y z")
    even = {"spacing": (0.1, 0.2)}
    return [
        (HEIGHTS, even),
        (topography(), {}),
        (Topography(HEIGHTS, *np.meshgrid(X, Y)), {}),
        (folder / "heights.npy", even),
        (str(folder / "heights.csv"), even),
        (folder / "heights.xyz", {}),
        (folder / "columns.txt", {}),
    ]


def test_all_sources_are_the_same_surface(tmp_path):
    for source, options in sources(tmp_path):
        surface = vc.SampledDistance.from_heights(source, **options)
        assert surface.h == pytest.approx(EXPECTED, abs=1e-12)
        assert surface.x == pytest.approx(X, abs=1e-12)
        assert surface.y == pytest.approx(Y, abs=1e-12)


def test_a_line_scan_is_line_contact():
    scan = Topography(HEIGHTS[0], X)
    surface = vc.SampledDistance.from_heights(scan, reference_depth=10.0)
    assert surface.line and surface.h == pytest.approx(HEIGHTS[0].max() - HEIGHTS[0])


@pytest.mark.parametrize(
    ("remove", "left"),
    [("mean", (0, 1, 1)), ("plane", (0, 0, 1)), ("curvature", (0, 0, 0))],
)
def test_removal_leaves_what_is_of_higher_order(remove, left):
    """Of constant, plane and paraboloid, in coordinates about the middle."""
    x, y = np.meshgrid(X, Y)
    squares = x**2 - np.mean(x**2) + 0.5 * x * y - (y**2 - np.mean(y**2))
    parts = (np.full(x.shape, 5.0), 2 * x - 3 * y, squares)
    rest = levelled(sum(parts), X, Y, remove)
    wanted = sum(keep * part for keep, part in zip(left, parts, strict=True))
    assert rest == pytest.approx(wanted + np.zeros(x.shape), abs=1e-12)


def test_scale_and_smooth_body():
    ball = vc.Paraboloids(Rx=10.0, Ry=5.0)
    flat = np.zeros_like(HEIGHTS)
    surface = vc.SampledDistance.from_heights(flat, spacing=(0.1, 0.2), on=ball)
    wanted = X**2 / 20 + Y[:, None] ** 2 / 10
    assert surface.h == pytest.approx(wanted - wanted.min(), abs=1e-12)
    small = vc.SampledDistance.from_heights(HEIGHTS, spacing=0.1, scale=1e-3)
    assert small.h == pytest.approx(1e-3 * EXPECTED)


def test_roughness_of_waves():
    """A wave of amplitude A and length L: Sq = A/sqrt(2), slope 2 pi/L times it; paraboloids have
    none.
    """
    x = y = np.linspace(-1.0, 1.0, 401)
    wave = 1e-3 * np.sin(2 * np.pi * x / 0.05) + 0 * y[:, None]
    rough = vc.SampledDistance(wave + x**2 / 2 + y[:, None] ** 2, x, y).roughness
    assert rough.Sq == pytest.approx(1e-3 / np.sqrt(2), rel=0.01)
    assert rough.slope_x == pytest.approx(2 * np.pi / 0.05 * 1e-3 / np.sqrt(2), rel=0.05)
    assert rough.slope_y == pytest.approx(0.0, abs=1e-9)


def test_the_report_has_the_roughness():
    ball = vc.Paraboloids(Rx=10.0, Ry=10.0)
    x = np.linspace(-0.5, 0.5, 41)
    heights = 1e-5 * np.random.default_rng(2).normal(size=(41, 41))
    surface = vc.SampledDistance.from_heights(heights, spacing=float(x[1] - x[0]), on=ball)
    scene = vc.Scene(
        bodies=vc.Bodies(G=82e3, nu=0.28),
        surface=surface,
        normal_force=100.0,
        grid=vc.Grid(nx=12, ny=12),
        units=vc.MM_N,
    )
    (line,) = [line for line in vc.solve(scene).report().splitlines() if "Sq" in line]
    assert f"Sq = {surface.roughness.Sq:.4g} mm" in line and "along y" in line


class Opened:
    """Would leave a file behind if it were unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return (open, (str(self.path), "w"))


def test_npy_is_never_unpickled(tmp_path):
    trap = tmp_path / "trap"
    (tmp_path / "bad.npy").write_bytes(pickle.dumps(Opened(trap)))
    np.save(tmp_path / "objects.npy", np.array([Opened(trap)], dtype=object), allow_pickle=True)
    for name in ("bad.npy", "objects.npy"):
        refused(
            lambda name=name: vc.SampledDistance.from_heights(tmp_path / name, spacing=0.1),
            "source",
            "a readable file of numbers",
        )
    assert not trap.exists()


def with_hole():
    heights = HEIGHTS.copy()
    heights[3, 4] = np.nan
    return heights


@pytest.mark.parametrize(
    ("source", "options", "field", "words"),
    [
        (with_hole(), {"spacing": 0.1}, "source", "heights missing, the first at (3, 4)"),
        (np.ma.masked_greater(HEIGHTS, 1.0), {"spacing": 0.1}, "source", "without holes"),
        (topography(x=np.append(X[:-1], 9.0)), {}, "source", "evenly spaced"),
        (topography(), {"spacing": 0.1}, "spacing", "left out"),
        (HEIGHTS, {}, "spacing", "the distance of samples"),
        (HEIGHTS, {"spacing": (1.0, 2.0, 3.0)}, "spacing", "(dx, dy)"),
        (HEIGHTS, {"spacing": -1.0}, "spacing", "positive"),
        (HEIGHTS, {"spacing": 0.1, "remove": "planes"}, "remove", "did you mean"),
        (HEIGHTS, {"spacing": 0.1, "on": 3.0}, "on", "closed form"),
        ("heights.doc", {"spacing": 0.1}, "source", ".npy"),
        ("there_is_none.npy", {"spacing": 0.1}, "source", "a readable file"),
        (np.array([["a"]]), {"spacing": 0.1}, "source", "numbers"),
    ],
)
def test_bad_heights_are_named(source, options, field, words):
    refused(lambda: vc.SampledDistance.from_heights(source, **options), field, words)


def test_holes_in_columns_are_refused(tmp_path):
    np.savetxt(tmp_path / "holes.xyz", columns()[:-1])
    path = tmp_path / "holes.xyz"
    refused(lambda: vc.SampledDistance.from_heights(path), "source", "no holes, none twice")
