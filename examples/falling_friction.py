"""Friction that falls: creep forces with a maximum, and the two solutions that one creepage can
have.

A cylinder rolls over another under three laws of friction. From stick all over the search comes
down to the solution with much friction, from slip all over it rises to that with little. Where the
two are one, the law falls so slowly that less friction does not make itself up in slip; with a
static and a kinetic coefficient they are two until all slips.
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import varcontact as vc

STATIC, KINETIC = 0.3, 0.15
LAWS = {
    "static and kinetic": vc.StaticKinetic(STATIC, KINETIC),
    "exponential, fast": vc.ExponentialFalling(STATIC, KINETIC, half_velocity=0.002, velocity=20.0),
    "exponential, slow": vc.ExponentialFalling(STATIC, KINETIC, half_velocity=0.02, velocity=20.0),
}
"""Rolling at 20 m/s, half of the excess lost at a slip velocity of 2 and of 20 mm/s."""
SHOWN = 3e-4


def scene(friction, vx, cells):
    """Steel rollers, 1 m in combined radius, 1 MN/m."""
    return vc.Scene(
        bodies=vc.Bodies(G=82e9, nu=0.28),
        surface=vc.Cylinders(R=1.0),
        normal_force=1e6,
        friction=friction,
        motion=vc.Steady(vx=vx),
        grid=vc.Grid(nx=cells),
        units=vc.Units(length="m", force="N"),
    )


def force(solution):
    """By the normal force."""
    return -solution.force[0] / solution.normal_force


def main(picture="falling_friction.png", cells=100, points=20):
    """Both branches of every law over the creepage; and at one creepage, printed and drawn."""
    # more of them where solutions may be two
    creepages = 5e-5 + 1.45e-3 * np.linspace(0, 1, points) ** 1.5
    curves = {
        (name, start): np.array(
            [force(vc.solve(scene(law, vx, cells), start=start)) for vx in creepages]
        )
        for name, law in LAWS.items()
        for start in ("stick", "slip")
    }
    shown = {
        (name, start): vc.solve(scene(law, SHOWN, cells), start=start)
        for name, law in LAWS.items()
        for start in ("stick", "slip")
    }
    for (name, start), sol in shown.items():
        print(
            f"{name:20} from {start:5}: Fx/Fz = {-force(sol):.5f}, {sol.elements['stick']:3d} of "
            f"{sol.elements['contact']} elements stick, {len(sol.passes)} passes, "
            f"residual {sol.certificate.residual:.0e}"
        )
    draw(creepages, curves, shown, cells, picture)
    return creepages, curves, shown


def draw(creepages, curves, shown, cells, picture):
    """Creep forces; how far the branches are apart; tractions of both."""
    figure, (left, middle, right) = plt.subplots(1, 3, figsize=(10.5, 4), layout="constrained")
    fine = np.linspace(creepages[0], creepages[-1], 30)
    for f, style in ((STATIC, "k:"), (KINETIC, "k--")):
        left.plot(
            1e3 * fine,
            [force(vc.solve(scene(f, vx, cells))) for vx in fine],
            style,
            lw=1,
            label=f"f = {f} alone",
        )
    for i, name in enumerate(LAWS):
        stick, slip = curves[name, "stick"], curves[name, "slip"]
        left.plot(1e3 * creepages, stick, f"C{i}-", label=f"{name}, from stick")
        left.plot(1e3 * creepages, slip, f"C{i}o", ms=3, mfc="none", label=f"{name}, from slip")
        apart = np.where(stick - slip > 1e-6, stick - slip, np.nan)  # below it is the tolerance
        label = name if np.isfinite(apart).any() else f"{name}: one solution"
        middle.semilogy(1e3 * creepages, apart, f"C{i}o-", ms=4, label=label)
    left.set(xlabel="creepage $10^3 v_x$", ylabel="$-F_x/F_z$", title="Creep force")
    middle.set(
        xlabel="creepage $10^3 v_x$",
        ylabel="from stick less from slip",
        title="Two solutions: $-F_x/F_z$ apart",
        ylim=(1e-5, 1e-2),
        xlim=(0.0, 0.7),
    )
    for i, start in enumerate(("stick", "slip")):
        sol = shown["static and kinetic", start]
        x, peak = sol.grid.x / sol.scene.hertz.a, sol.pressure.max()
        right.plot(x, -sol.traction[0, 0] / peak, f"C{i + 3}.-", ms=3, label=f"from {start}")
    for f, style in ((STATIC, "k:"), (KINETIC, "k--")):
        right.plot(x, f * sol.pressure[0] / peak, style, lw=1, label=f"{f} $p_z$")
    right.set(xlabel="$x/a$", ylabel="$-p_x/p_0$", title=f"Static and kinetic, $v_x$ = {SHOWN:g}")
    for axes in (left, middle, right):
        axes.legend(fontsize=7)
    figure.savefig(picture, dpi=150)
    plt.close(figure)


if __name__ == "__main__":
    main(*sys.argv[1:])
