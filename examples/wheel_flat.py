"""A wheel with a flat rolls over a rail: contact force, and the work that friction loses along the
rail.

The wheel, a mass under its load, rolls on a track that is a spring and a damper, and its flat
passes at several speeds. The flat is carried through the contact; the approach of each step comes
from the force of the step before.

Run: python examples/wheel_flat.py [picture.png]
"""

import sys
from dataclasses import dataclass

import matplotlib.pyplot as plt

import varcontact as vc

LOAD, MASS, RADIUS = 80e3, 600e-3, 460.0  # N, t, mm
STIFFNESS, DAMPING = 50e3, 100.0  # of the track [N/mm], [N s/mm]
DX = 1.0  # mm


@dataclass
class Wheel:
    """A wheel on a track, moved by the contact force of the step before, in steps of `dt` s."""

    dt: float
    velocity: float = 0.0  # of the wheel, down [mm/s]
    depth: float = 0.0  # of the wheel [mm]
    track: float = LOAD / STIFFNESS  # its deflection [mm]

    def __call__(self, k: int, before: vc.Solution | None) -> dict[str, float]:
        """What step k is given: the load first, then the approach."""
        if before is None:
            return {"normal_force": LOAD}
        if k == 1:
            self.depth = before.approach + self.track
        self.velocity += (LOAD - before.normal_force) / MASS * self.dt
        self.depth += self.velocity * self.dt
        self.track += (before.normal_force - STIFFNESS * self.track) / DAMPING * self.dt
        return {"approach": self.depth - self.track}


def main(
    picture: str = "wheel_flat.png",
    speeds: tuple[float, ...] = (10.0, 20.0, 40.0),
    steps: int = 160,
) -> dict[float, vc.History]:
    """Pass at speeds in m/s, and draw forces and work over the way."""
    flat = vc.Carried.flat(length=30.0, radius=RADIUS, at=40.0, worn=True)
    grid = vc.Grid(nx=37, ny=25, dx=DX, dy=DX, x0=-18.5, y0=-12.5)
    found, (ax, below) = (
        {},
        plt.subplots(2, sharex=True, figsize=(6.4, 6.4), layout="constrained")[1],
    )
    for speed in speeds:
        wheel = Wheel(dt=DX / (1e3 * speed))
        scene = vc.Scene(
            bodies=vc.Bodies(G=82e3, nu=0.28),
            surface=vc.Paraboloids(Rx=RADIUS, Ry=300.0),
            normal_force=LOAD,
            friction=0.3,
            motion=vc.Transient(steps=steps, dq=DX, vx=1e-3, carried=flat, control=wheel),
            grid=grid,
        )
        history = found[speed] = vc.solve(scene)
        work = history.work_along().sum("y") * DX
        ax.plot(history.position, history.normal_force / 1e3, label=f"{speed:g} m/s")
        below.plot(work.X, work)
        print(
            f"{speed:4g} m/s: {history.normal_force.min() / 1e3:5.1f} "
            f"to {history.normal_force.max() / 1e3:5.1f} kN"
        )
    ax.axvspan(25.0, 55.0, color="0.92", zorder=0)
    ax.set_ylabel("Normal force [kN]")
    below.set_ylabel("Work by friction along the rail [N]")
    below.set_xlabel("Distance rolled [mm]; shaded: the flat")
    ax.legend()
    plt.gcf().savefig(picture, dpi=150)
    print(f"picture: {picture}")
    return found


if __name__ == "__main__":
    main(*sys.argv[1:])
