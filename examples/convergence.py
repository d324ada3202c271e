"""Orders of convergence and extrapolated values, where the exact ones are known: Hertz, Carter,
Kalker's coefficients.

Run: python examples/convergence.py [picture.png]
"""

from __future__ import annotations

import sys

import varcontact as vc
from varcontact.reference import carter, creepage_coefficients, line_contact

BODIES = vc.Bodies(G=1.0, nu=0.25)


def main(
    picture: str | None = None, cells: tuple[int, ...] = (8, 12, 16, 24)
) -> dict[str, tuple[float, float, float]]:
    """Study three scenes, print, draw the last; extrapolated value, its error and the exact value
    of each.
    """
    spheres = vc.Scene(bodies=BODIES, surface=vc.Paraboloids(Rx=1.0, Ry=0.5), normal_force=1e-3)
    contact = line_contact(1.0, BODIES, a=0.01)
    rolling = carter(contact, 0.3, force=-0.6 * 0.3 * contact.force)
    cylinders = vc.Scene(
        bodies=BODIES,
        surface=vc.Cylinders(R=1.0),
        normal_force=contact.force,
        friction=0.3,
        motion=vc.Steady(vx=rolling.creepage),
    )
    sticking = vc.Scene(
        bodies=BODIES,
        surface=vc.Ellipse(a=1.0, b=1.0),
        normal_force=1.0,
        friction=float("inf"),
        motion=vc.Steady(vx=1.0),
    )
    cases = (
        ("Hertz: approach", spheres, "approach", cells, spheres.hertz.approach),
        ("Carter: force", cylinders, "Fx", tuple(2 * n for n in cells), rolling.force),
        ("Kalker: -C11", sticking, "Fx", cells, -creepage_coefficients(1.0, 1.0, 0.25).C11),
    )
    found = {}
    for name, scene, quantity, numbers, exact in cases:
        study = vc.converge(scene, numbers)
        row = study.limit(quantity)
        print(
            f"{name}: {row['value']:.6g} +- {row['error']:.2g}, exactly {exact:.6g}; "
            f"finest grid {row['finest']:.6g}, ",
            end="",
        )
        print(f"order {row['order']:.2f} ({row['order_low']:.2f} to {row['order_high']:.2f})")
        found[name] = (row["value"], row["error"], exact)
    if picture is not None:
        study.plot().savefig(picture, dpi=150)
    return found


if __name__ == "__main__":
    main(*(sys.argv[1:2] or ["convergence.png"]))
