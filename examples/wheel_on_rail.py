"""A coned wheel on a rail head of arcs: steady rolling with a non-Hertzian contact that spans two
arcs.

Rail: the head of the 60E1 profile, arcs of radius 300, 80 and 13 mm that meet with a common tangent
10.228 and 26.0265 mm from the middle (20.456 and 52.053 mm apart on the drawing of EN 13674-1; the
13 mm arcs then end on flanks inclined 1:20, 72 mm apart, as they must). The rail stands upright.

Wheel: a cone 1:40 with a rolling radius of 460 mm, loaded with 80 kN. It is the right wheel of a
set: x forward, y to the left (towards the flange), z up. Its straight generator touches the 300 mm
arc where that is inclined 1:40, 7.5 mm from the middle of the rail, whatever the lateral position
of the wheel; the 80 mm arc begins only 2.7 mm from there, and the contact reaches into it.

Motion: the wheel set is shifted to the right by 5 mm, which lets the right wheel roll on a radius
larger by 5/40 mm; a tractive creepage, a yaw angle of 1 mrad, and the geometric spin of the cone
are added.

Lengths in mm, forces in N. Run: python examples/wheel_on_rail.py [picture.png]
"""

import sys
from pathlib import Path

import numpy as np

import varcontact as vc

CONICITY = 1 / 40
ROLLING_RADIUS = 460.0
RADII = np.array([300.0, 80.0, 13.0])
TANGENT_POINTS = np.array([10.228, 26.0265])
LATERAL_SHIFT = -5.0  # of the wheel set, to the left positive
METHODS = ("conic", "convex", "active-set", "kalker")


def rail_profile(y: np.ndarray, inclination: float) -> np.ndarray:
    """Height of the rail head over its tangent at the point inclined by an angle, across from that
    point.
    """
    angles = [np.arcsin(TANGENT_POINTS[0] / RADII[0])]
    # of the second arc, from the middle of the rail
    middle = (RADII[0] - RADII[1]) * np.sin(angles[0])
    angles.append(np.arcsin((TANGENT_POINTS[1] - middle) / RADII[1]))
    height = np.full_like(y, np.nan)
    for side in (1, -1):
        centre = np.array([0.0, -RADII[0]])
        start = 0.0
        for i, radius in enumerate(RADII):
            end = angles[i] if i < len(angles) else np.pi / 2
            # In the contact's frame every arc is turned back by the inclination.
            first, last = sorted(
                centre[0] + radius * np.sin(np.array([start, end]) * side - inclination)
            )
            on_arc = (y >= first) & (y <= last)
            height[on_arc] = centre[1] + np.sqrt(radius**2 - (y[on_arc] - centre[0]) ** 2)
            if i < len(angles):
                turned = end * side - inclination
                centre = centre + (radius - RADII[i + 1]) * np.array(
                    [np.sin(turned), np.cos(turned)]
                )
                start = end
    return height


def undeformed_distance(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Distance between wheel and rail along the contact's normal, at all x and y."""
    angle = np.arctan(CONICITY)
    # of curvature of the cone, larger towards the flange
    radius = (ROLLING_RADIUS + CONICITY * y) / np.cos(angle)
    wheel = radius[:, None] - np.sqrt(radius[:, None] ** 2 - x[None, :] ** 2)
    return wheel - rail_profile(y, angle)[:, None]


def scene(nx: int = 32, ny: int = 24) -> vc.Scene:
    """The scene on a potential contact of 15 by 11 mm."""
    grid = vc.Grid(nx=nx, ny=ny, dx=15 / nx, dy=11 / ny, x0=-7.5, y0=-6.0)
    radius = ROLLING_RADIUS - CONICITY * LATERAL_SHIFT
    return vc.Scene(
        bodies=vc.Bodies(G=82e3, nu=0.28),
        surface=vc.SampledDistance(undeformed_distance(grid.x, grid.y)),
        normal_force=80e3,
        friction=0.3,
        motion=vc.Steady(
            vx=(ROLLING_RADIUS - radius) / ROLLING_RADIUS - 0.6e-3,
            vy=-1e-3,
            spin=np.sin(np.arctan(CONICITY)) / radius,
        ),
        grid=grid,
        units=vc.Units(length="mm", force="N"),
    )


def main(picture: str = "wheel_on_rail.png") -> tuple[vc.Solution, dict[str, vc.Solution]]:
    """Solve as convex programs, print the report with its certificate, and draw; then compare four
    methods on elements of twice the size.
    """
    solution = vc.solve(scene(), method="convex")
    print(solution)
    solution.plot().savefig(picture, dpi=150)
    print(f"\npicture: {Path(picture).resolve()}")

    print("\non 16 x 12 elements:")
    print(f"{'method':12} {'Fx [N]':>12} {'Fy [N]':>12} {'residual':>9} {'seconds':>8}")
    compared = {method: vc.solve(scene(16, 12), method=method) for method in METHODS}
    for method, each in compared.items():
        forces = f"{each.Fx:12.5f} {each.Fy:12.5f}"
        print(f"{method:12} {forces} {each.certificate.residual:9.1e} {each.timing['total']:8.3f}")
    return solution, compared


if __name__ == "__main__":
    main(*sys.argv[1:2])
