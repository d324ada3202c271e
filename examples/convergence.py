"""Orders of convergence and extrapolated values, where the exact ones are known: Hertz, Carter,
Kalker's coefficients.

Run: python examples/convergence.py [picture.png]
"""

from __future__ import annotations

import sys

from matplotlib import pyplot as plt
from matplotlib.figure import Figure

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
    studies = {}
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
        studies[name] = (study, quantity, exact)
    if picture is not None:
        draw(studies).savefig(picture, dpi=150)
    return found


def draw(studies: dict[str, tuple[vc.Convergence, str, float]]) -> Figure:
    """Errors of all solves and of their means by grid, and the error bar of the extrapolated
    value, a panel for each study.
    """
    figure, axes = plt.subplots(1, len(studies), figsize=(9.6, 3.6), layout="constrained")
    for ax, (name, (study, quantity, exact)) in zip(axes, studies.items(), strict=True):
        row = study.limit(quantity)
        runs = study.runs
        means = runs.groupby("cells")[quantity].mean()
        cells = means.index.to_numpy(dtype=float)
        ax.loglog(runs["cells"], abs(runs[quantity] / exact - 1), "C0.", ms=4, label="single solve")
        ax.loglog(cells, abs(means / exact - 1), "C0o", label="mean of a grid")
        size = abs((row["finest"] - row["value"]) / exact) * (cells[-1] / cells) ** row["order"]
        ax.loglog(cells, size, "k--", lw=1, label="fitted order")
        bar = row["error"] / abs(exact)
        lowest = ax.get_ylim()[0]
        ax.axhspan(lowest, bar, color="C0", alpha=0.12, lw=0, label="error bar of the limit")
        ax.set_ylim(bottom=lowest)
        ax.set(title=f"{name}, order {row['order']:.2f}", xlabel="elements across the contact")
        ax.set_xticks(cells, [f"{n:.0f}" for n in cells])
        ax.minorticks_off()
    axes[0].set_ylabel("relative distance from the exact value")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False)
    return figure


if __name__ == "__main__":
    main(*(sys.argv[1:2] or ["convergence.png"]))
