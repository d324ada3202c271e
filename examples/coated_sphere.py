"""A coated sphere on a coated plane: hard and soft coatings on steel, in steady rolling with
creepage.

Both bodies have the same coating, so that pressure and tractions do not depend on each other. A
hard coating narrows the contact and raises the pressure; a soft one widens it, and sticks in more
of it.

Run: python examples/coated_sphere.py [picture.png]
"""

import sys

import matplotlib.pyplot as plt

import varcontact as vc

STEEL = (82e3, 0.28)  # N/mm^2
COATINGS = {"soft, G/4": 0.25, "none": 1.0, "hard, 4 G": 4.0}


def main(
    picture: str = "coated_sphere.png", cells: int = 60, thickness: float = 0.05
) -> dict[str, vc.Solution]:
    """Solve for each coating and draw pressure and traction along the middle."""
    found, (ax, below) = (
        {},
        plt.subplots(2, sharex=True, figsize=(6.4, 6.4), layout="constrained")[1],
    )
    for name, times in COATINGS.items():
        coated = vc.Layered([vc.Layer(h=thickness, G=times * STEEL[0], nu=STEEL[1])], base=STEEL)
        rolling = {"motion": vc.Steady(vx=1.5e-3), "friction": 0.3, "normal_force": 100.0}
        scene = vc.Scene(
            bodies=coated, surface=vc.Paraboloids(10.0, 10.0), grid=vc.Grid(cells, cells), **rolling
        )
        sol = found[name] = vc.solve(scene)
        row = sol.grid.ny // 2
        (line,) = ax.plot(sol.grid.x, sol.pressure[row], label=f"coating: {name}")
        below.plot(sol.grid.x, -sol.traction[0, row], color=line.get_color())
        below.plot(sol.grid.x, sol.traction_bound[row], "--", color=line.get_color(), linewidth=0.8)
        stick = 100 * sol.areas["stick"] / sol.areas["contact"]
        print(
            f"{name:10} Fx = {sol.force[0]:6.2f} N, peak {sol.pressure.max():5.0f} N/mm2, "
            f"{stick:.0f} % sticks"
        )
    ax.set_ylabel("Pressure [N/mm²]")
    below.set_ylabel("Traction and its bound [N/mm²]")
    below.set_xlabel("x [mm], rolling to the right")
    ax.legend()
    plt.gcf().savefig(picture, dpi=150)
    print(f"picture: {picture}")
    return found


if __name__ == "__main__":
    main(*sys.argv[1:2])
