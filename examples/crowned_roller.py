"""A roller is crowned by gradients: eleven numbers of its profile, so that its pressure has no peak
at the ends.

The crown is a sum of B-splines along the roller. L-BFGS-B lowers the 12-norm of the pressure with
the derivative by the undeformed distance of all elements, one transposed solve for each design;
Lundberg's logarithmic crown is the known answer (G. Lundberg, Forsch. Ingenieurwes. 10 (1939)).

Run: python examples/crowned_roller.py [picture.png]
"""

import sys
from dataclasses import dataclass, field

import matplotlib.pyplot as plt
import numpy as np
from scipy.interpolate import BSpline
from scipy.optimize import minimize

import varcontact as vc

RADIUS, LENGTH, LOAD = 10.0, 12.0, 3e3  # mm, mm, N
STEEL = vc.Bodies(G=(82e3, 82e3), nu=0.28)
NUMBERS = 11
UNIT = 1e-3  # a number of the profile in micrometres


@dataclass
class Design:
    """Rollers with a symmetric crown, whose distance is linear in its numbers."""

    grid: vc.Grid
    solutions: list[vc.Solution] = field(default_factory=list)

    @property
    def splines(self) -> np.ndarray:
        """Cubic splines at the rows, the first of which is left out: it is flat; (ny, numbers)."""
        inner = np.linspace(0.0, 1.0, NUMBERS - 1) ** 0.5
        knots = np.concatenate([np.zeros(3), inner, np.ones(3)])
        along = np.minimum(np.abs(self.grid.y) / (LENGTH / 2), 1.0)
        return BSpline.design_matrix(along, knots, 3).toarray()[:, 1:]

    def crown(self, numbers: np.ndarray) -> np.ndarray:
        """Height that is taken off at the rows [mm]."""
        return self.splines @ numbers * UNIT

    def solve(self, numbers: np.ndarray) -> vc.Solution:
        round_part = self.grid.x**2 / (2 * RADIUS)
        beyond = 1.0 * (np.abs(self.grid.y) > LENGTH / 2)  # the roller ends
        distance = (self.crown(numbers) + beyond)[:, None] + round_part
        scene = vc.Scene(
            bodies=STEEL,
            surface=vc.SampledDistance(distance),
            normal_force=LOAD,
            grid=self.grid,
            units=vc.MM_N,
        )
        return vc.solve(scene, certify="none")

    def __call__(self, numbers: np.ndarray) -> tuple[float, np.ndarray]:
        """The 12-norm of the pressure, and its derivatives by the numbers."""
        solution = self.solve(numbers)
        self.solutions.append(solution)
        found = solution.gradient(vc.PeakPressure(power=12), by="distance", error=False)
        by_rows = found.distance.sum("x").to_numpy()
        return float(found.value), by_rows @ self.splines * UNIT


def lundberg(y: np.ndarray, line_load: float) -> np.ndarray:
    """Lundberg's crown for a uniform pressure [mm]."""
    modulus = STEEL.combined_G / (1 - STEEL.combined_nu)
    return -line_load / (np.pi * modulus) * np.log(1 - (2 * y / LENGTH) ** 2)


def main(
    picture: str = "crowned_roller.png", rows: int = 48
) -> tuple[vc.Solution, vc.Solution, np.ndarray]:
    """The roller as a cylinder, as designed, and its crown less Lundberg's [mm]."""
    dy = LENGTH / rows
    grid = vc.Grid(nx=20, ny=rows + 2, dx=0.03, dy=dy, x0=-0.3, y0=-LENGTH / 2 - dy)
    design = Design(grid)
    start = np.zeros(design.splines.shape[1])
    best = minimize(
        design,
        start,
        jac=True,
        method="L-BFGS-B",
        bounds=[(0.0, 4.0)] * start.size,
        options={"maxiter": 60},
    )
    cylinder = design.solutions[0]
    designed = design.solve(best.x)
    crown = design.crown(best.x)
    print(
        f"peak pressure {cylinder.max_pressure:.0f} to {designed.max_pressure:.0f} N/mm2 "
        f"in {len(design.solutions)} solves"
    )

    figure, (above, below) = plt.subplots(2, sharex=True, figsize=(6.4, 6.0), layout="constrained")
    for name, solution in (("cylinder", cylinder), ("designed", designed)):
        above.plot(grid.y, solution.pressure.max(axis=1), label=name)
    above.set(ylabel="largest pressure [N/mm$^2$]", ylim=(0, None))
    above.legend()
    y = grid.y[1:-1]
    ideal = lundberg(y, LOAD / LENGTH)
    off = crown[1:-1] - ideal
    below.plot(y, 1e3 * crown[1:-1], label="designed")
    below.plot(y, 1e3 * (ideal + off[rows // 2]), "--", label="Lundberg")
    below.set(xlabel="along the roller [mm]", ylabel="crown [µm]")
    below.legend()
    figure.savefig(picture, dpi=150)
    return cylinder, designed, off - off[rows // 2]


if __name__ == "__main__":
    main(*sys.argv[1:])
