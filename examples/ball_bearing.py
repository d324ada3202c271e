"""A deep-groove ball bearing: pressure, stick and slip, and friction of its most loaded ball.

Bearing 6206: nine balls of 9.525 mm between grooves of slightly larger radius. Left: under a radial
load a ball rolls in its grooves and touches along a narrow, curved ellipse. Points beside the
middle are nearer to the axis of the ball, so that they slip (Heathcote): two lines roll without
slip, between them the ball slips backwards, beside them forwards. Middle: the same slip across the
contact, and Heathcote's parabola without elasticity. Right: under a thrust load the balls touch at
an angle, and spin on the inner race while the outer race leads them (race control): friction and
torque rise.

Lengths in mm, forces in N. Run: python examples/ball_bearing.py [picture.png]
"""

import sys
from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np

import varcontact as vc
from varcontact.kinematics import Creepages, Frame, RigidBody, creepages, rigid_slip
from varcontact.plotting.fields import draw_areas

STEEL = vc.Bodies.from_young(E=206e3, nu=0.3)
BALL = 9.525 / 2  # radius
PITCH = 46.0 / 2  # radius of the circle of the balls' centres
BALLS = 9
GROOVES = {"inner": 0.515 * 2 * BALL, "outer": 0.525 * 2 * BALL}  # radii of their sections
FRICTION = 0.08
RADIAL_LOAD = 2000.0
THRUST_LOAD = 2000.0
CONTACT_ANGLE = np.radians(20.0)  # under thrust


@dataclass(frozen=True)
class Race:
    """A race below a ball, in the frame of their contact: z into the ball, x along the rolling
    direction, and the bearing's axis in the plane of y and z.
    """

    name: str
    angle: float  # of the contact to the radial plane

    @property
    def side(self) -> float:
        """Direction from the race to the bearing's axis, along z."""
        return -1.0 if self.name == "inner" else 1.0

    @property
    def radius(self) -> float:
        """Radius of the race at the contact, round the bearing's axis."""
        return PITCH + self.side * BALL * np.cos(self.angle)

    @property
    def surface(self) -> vc.Paraboloids:
        """Undeformed distance: ball and groove, which is hollow across, and outside along, too."""
        along = -self.side * self.radius / np.cos(self.angle)
        return vc.Paraboloids.from_bodies(Rx=(BALL, along), Ry=(BALL, -GROOVES[self.name]))

    @property
    def curvature(self) -> float:
        """Mean curvature of ball and groove across: that of the surface on which they meet."""
        return (1 / BALL + 1 / GROOVES[self.name]) / 2

    def bodies(self) -> tuple[RigidBody, RigidBody]:
        """Ball and race seen from the cage; the ball rolls at one radian a second.

        Both races roll on the ball without slip in the middle; the ball spins as the outer one.
        """
        axis = np.array([0.0, np.cos(self.angle), -self.side * np.sin(self.angle)])
        outwards = -self.side * np.array([0.0, self.side * np.sin(self.angle), np.cos(self.angle)])
        centre = np.array([0.0, 0.0, BALL])
        outer_rate = BALL / (PITCH + BALL * np.cos(self.angle))
        rate = outer_rate
        if self.name == "inner":
            rate = -BALL / self.radius
        spin = -self.side * outer_rate * np.sin(self.angle)
        ball = RigidBody(position=centre, angular_velocity=[0.0, 1.0, spin])
        race = RigidBody(position=centre - PITCH * outwards, angular_velocity=rate * axis)
        return ball, race

    def slip(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Rigid slip (2, ny, nx) of the ball over the race, divided by the rolling velocity, at arc
        lengths y across the contact.
        """
        ball, race = self.bodies()
        along, across = np.meshgrid(x, y * self.curvature)
        points = np.stack([along, np.sin(across), 1 - np.cos(across)], axis=-1)
        points[..., 1:] /= self.curvature
        velocity = rigid_slip(ball, race, points) / self.motion.speed
        lateral = np.cos(across) * velocity[..., 1] + np.sin(across) * velocity[..., 2]
        return np.array([velocity[..., 0], lateral])

    @property
    def motion(self) -> Creepages:
        """Creepages and rolling velocity in the middle of the contact."""
        return creepages(*self.bodies(), Frame([0.0, 0.0, 0.0], np.eye(3)))

    def solve(self, force: float, elements: int = 48) -> vc.Solution:
        """The contact of a ball that rolls freely, under a normal force."""
        ellipse = vc.Scene(bodies=STEEL, surface=self.surface, normal_force=force).hertz
        nx, ny = elements // 2, elements
        half_x = 1.15 * ellipse.a
        half_y = 1.15 * ellipse.b
        grid = vc.Grid(nx=nx, ny=ny, dx=2 * half_x / nx, dy=2 * half_y / ny, x0=-half_x, y0=-half_y)
        scene = vc.Scene(
            bodies=STEEL,
            surface=vc.SampledDistance(
                self.surface.distance(grid), inclination=grid.y * self.curvature
            ),
            normal_force=force,
            friction=FRICTION,
            motion=vc.Steady(Fx=0.0, rigid_slip=self.slip(grid.x, grid.y)),
            grid=grid,
            units=vc.MM_N,
        )
        return vc.solve(scene)


def heathcote(race: Race, sol: vc.Solution) -> tuple[float, float]:
    """Half the distance of the lines of pure rolling, by half the width of the contact, and the
    resistance [N], if all slips and the ball turns about an axis parallel to the bearing's.

    Pressures are ``1 - t^2`` by length; ``t - t^3/3 = 1/3`` at the lines.
    """
    line = 0.34729635533386066  # 2 sin(10 degrees)
    half = np.count_nonzero(sol.pressure.any(axis=1)) * sol.grid.dy / 2
    steepness = race.curvature / 2 * (1 / BALL - race.side / race.radius)
    t = np.linspace(0.0, 1.0, 2001)
    mean = np.trapezoid(1.5 * np.abs(t**2 - line**2) * (1 - t**2), t)
    return line, FRICTION * sol.normal_force * steepness * half**2 * mean


def torque(inner: vc.Solution, outer: vc.Solution, angle: float) -> float:
    """Friction torque of the bearing whose balls are all alike [N mm]: power by the shaft's
    speed.
    """
    races = [Race(name, angle) for name in ("inner", "outer")]
    shaft = sum(BALL / race.radius for race in races)  # at one radian a second of the ball
    lost = sum(
        sol.friction_work * race.motion.speed
        for sol, race in zip((inner, outer), races, strict=True)
    )
    return BALLS * lost / shaft


def main(picture: str | None = None) -> dict[str, vc.Solution]:
    """Both races under a radial load, and under thrust."""
    radial = 4.37 * RADIAL_LOAD / BALLS  # Stribeck: of the most loaded ball
    thrust = THRUST_LOAD / (BALLS * np.sin(CONTACT_ANGLE))
    sols = {}
    for load, force, angle in (("radial", radial, 0.0), ("thrust", thrust, CONTACT_ANGLE)):
        for name in ("inner", "outer"):
            race = Race(name, angle)
            sol = race.solve(force)
            sols[f"{load}, {name}"] = sol
            stick = sol.elements["stick"] / sol.elements["contact"]
            print(
                f"{load}, {name} race: {force:.0f} N, {sol.max_pressure:.0f} N/mm2, "
                f"{100 * stick:.0f} % sticks, spin {race.motion.spin:.4f} 1/mm, "
                f"friction {1e3 * sol.friction_work:.1f} mN by ball"
            )
    _, without_stick = heathcote(Race("inner", 0.0), sols["radial, inner"])
    print(f"Heathcote without elasticity: {1e3 * without_stick:.1f} mN")
    under_thrust = torque(sols["thrust, inner"], sols["thrust, outer"], CONTACT_ANGLE)
    print(f"friction torque under thrust: {under_thrust:.1f} N mm")
    draw(sols, picture)
    return sols


def draw(sols: dict[str, vc.Solution], picture: str | None) -> None:
    """Stick and slip of the inner race under both loads, and slip across the contact."""
    figure, axes = plt.subplots(1, 3, figsize=(10, 4.2), layout="constrained")
    radial = sols["radial, inner"]
    draw_areas(axes[0], radial)
    draw_areas(axes[2], sols["thrust, inner"])
    middle = radial.grid.nx // 2
    inside = radial.pressure[:, middle] > 0
    y = radial.grid.y[inside]
    rigid = Race("inner", 0.0).slip(radial.grid.x, y)[0, :, middle] + radial.creepage[0]
    axes[1].plot(1e3 * rigid, y, label="rigid")
    axes[1].plot(1e3 * radial.slip[0, inside, middle], y, label="elastic")
    axes[1].axvline(0.0, color="0.7", linewidth=0.8)
    axes[1].set(xlabel="slip [mm/m]", ylabel="y [mm]", title="radial load: slip in the middle")
    axes[1].legend()
    axes[0].set_title("radial load, inner race")
    axes[2].set_title("thrust, inner race")
    if picture:
        figure.savefig(picture)
    else:
        plt.show()
    plt.close(figure)


if __name__ == "__main__":
    main(*sys.argv[1:2])
