"""Scenes and closed fields of contacts that roll."""

import numpy as np

import varcontact as vc


def line(f, nu=0.3, n=200):
    """Two cylinders with the half-width 1 in full slip along x; 1/2/(1 - nu) is the peak pressure."""
    rolling = {"friction": f, "motion": vc.Steady(vx=-100.0)} if f else {}
    return vc.solve(
        vc.Scene(
            bodies=vc.Bodies(G=1.0, nu=nu),
            surface=vc.Cylinders(R=1.0),
            normal_force=np.pi / 4 / (1 - nu),
            grid=vc.Grid(nx=n),
            **rolling,
        )
    )


def mcewen(f, nu):
    """Stress in the lower body of `line` (McEwen 1949; Johnson 1985, section 4.2 and 7.1)."""

    def stress(points):
        x, _, z = points
        z = -z
        s = 1 - x**2 + z**2
        root = np.sqrt(s**2 + 4 * x**2 * z**2)
        m = np.sqrt(np.maximum(root + s, 0) / 2)
        n = np.sign(x) * np.sqrt(np.maximum(root - s, 0) / 2)
        square = np.maximum(m**2 + n**2, 1e-300)
        # by pressure, then by traction along +x
        xx = -(m * (1 + (z**2 + n**2) / square) - 2 * z)
        zz = -m * (1 - (z**2 + n**2) / square)
        xz = -n * (m**2 - z**2) / square
        sheared = -(2 * x - n * (2 - (z**2 - m**2) / square))
        xx, zz, xz = xx + f * sheared, zz + f * xz, xz + f * xx
        none = 0 * x
        tensor = np.array([[xx, none, -xz], [none, nu * (xx + zz), none], [-xz, none, zz]])
        return tensor / 2 / (1 - nu)

    return stress


def ellipse(a=1.0, b=1.0, f=0.0, n=16, nu=0.3, **motion):
    """Hertz's ellipse with the peak pressure 1, in full slip along x if no motion is given."""
    rolling = {}
    if f:
        rolling = {"friction": f, "motion": vc.Steady(**(motion or {"vx": -100.0}))}
    return vc.solve(
        vc.Scene(
            bodies=vc.Bodies(G=1.0, nu=nu),
            surface=vc.Ellipse(a=a, b=b),
            normal_force=2 * np.pi / 3 * a * b,
            grid=vc.Grid(nx=n, ny=n),
            **rolling,
        )
    )
