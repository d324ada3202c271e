"""Arguments that nothing can be made of: a SceneError that names them, before any work."""

import numpy as np
import pytest

import varcontact as vc
from varcontact.reference import bufler, cattaneo_mindlin, hertz, hertz_ellipse, line_contact, spence_ratio

BODIES = vc.Bodies(G=1.0, nu=0.3)
FIELD = np.zeros((2, 14, 14))
HERTZIAN = vc.Scene(bodies=BODIES, surface=vc.Paraboloids(1.0, 1.0), normal_force=1e-3)
HISTORY = vc.Scene(
    bodies=BODIES,
    surface=vc.Paraboloids(1.0, 1.0),
    normal_force=1e-3,
    friction=0.3,
    motion=vc.Transient(steps=2, vx=0.01),
)
DIGITS = 10**5000


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: vc.certify(5, FIELD), "scene = 5 is not allowed: must be a Scene"),
        (lambda: vc.load(3), "path = 3 is not allowed: must be the name of a file"),
        (lambda: vc.load(b"a.nc"), "path = b'a.nc' is not allowed"),
        (lambda: vc.read_scene(None), "path is|path = None"),
        (lambda: vc.solve(HISTORY, store=3), "store = 3 is not allowed: must be the name of a file"),
        (lambda: vc.converge(HERTZIAN, [4, 6], method=3), "method = 3 is not allowed: must be a name, or a list of"),
        (lambda: vc.plot_comparison(3), "table = 3 is not allowed"),
        (lambda: hertz(1, 1, 5, force=1.0), "bodies = 5 is not allowed: must be half-spaces"),
        (lambda: hertz_ellipse(1, 1, 5, force=1.0), "bodies = 5"),
        (lambda: line_contact(1, 5, force=1.0), "bodies = 5"),
        (lambda: bufler(1, 5, force=1.0), "bodies = 5"),
        (lambda: spence_ratio(5, 0.3), "bodies = 5"),
        (lambda: cattaneo_mindlin(hertz(1, 1, BODIES, force=1e-3), 5, 0.3, 1e-5), "bodies = 5"),
        (lambda: hertz(1e100, 1e-100, BODIES, force=1.0), r"Rx, Ry = \(1e\+100, 1e-100\) .* at most 1e\+150 times"),
        (lambda: vc.Steady(vx=np.complex128(0.1 + 2j)), r"motion\.vx = \(0\.1\+2j\) is not allowed"),
        (lambda: vc.Steady(vx=np.True_), r"motion\.vx = True is not allowed"),
        (lambda: vc.Grid(nx=np.array(True)), r"grid\.nx = True is not allowed"),
        (lambda: vc.Steady(vx=bytearray(b"1.5")), r"motion\.vx = bytearray"),
        (lambda: vc.Steady(vx=DIGITS), r"motion\.vx = a number of thousands of digits is not allowed"),
        (lambda: vc.Bodies(G=DIGITS, nu=0.3), r"bodies\.G = a number of thousands of digits"),
        (lambda: vc.SampledDistance([[DIGITS, 1], [2, 3]]), r"surface\.h = a list is not allowed"),
        (lambda: vc.SampledDistance([[1, 2], [3]]), r"surface\.h = \[\[1, 2\], \[3\]\] .* with rows of equal length"),
        (lambda: vc.SampledDistance([[1.0, 2.0], [3.0, -1e308]]), r"surface\.h\[1, 1\] = -1e\+308 .* at most 1e\+100"),
        (lambda: vc.Grid(nx=2, ny=2, dx=np.float64(0.0), dy=1, x0=0, y0=0), r"grid\.dx = 0\.0 is not allowed"),
        (lambda: vc.Units(length="m\0", force="N"), r"units\.length = 'm\\x00' is not allowed: must be printable"),
        (lambda: vc.Units(length="m", force="N" * 41), r"units\.force = .* in 40 characters at most"),
        (lambda: vc.Units(length="\ud800", force="N"), r"units\.length = .* must be printable"),
    ],
)
def test_refused_by_name(call, words):
    with pytest.raises(vc.SceneError, match=words):
        call()
