"""Pictures of profiles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from varcontact.wheel_rail.profile import Profile

STEP = 0.05
"""Between points of a drawn curve [mm]."""


def plot_profile(profile: Profile) -> Figure:
    """Points, curve and kinks of a profile, and below them the curvature of the part that can be touched.

    Parameters
    ----------
    profile : Profile

    Returns
    -------
    Figure
        Not shown: call its ``savefig``, or ``plt.show()``.
    """
    import matplotlib.pyplot as plt

    figure, (above, below) = plt.subplots(
        2, 1, figsize=(8.0, 6.4), layout="constrained", sharex=True, height_ratios=[3, 2]
    )
    above.plot(profile.y, profile.z, ".", color="0.6", markersize=3, label="points")
    curve = profile.curve.points(profile.curve.sampled(STEP))
    above.plot(*curve.T, color="C0", linewidth=1.2, label="spline")
    kinks = profile.kink_points
    if kinks.size:
        above.plot(profile.y[kinks], profile.z[kinks], "x", color="C3", label="kinks")
    above.set(ylabel="z [mm]", aspect="equal", title=profile.name or profile.kind)
    above.invert_yaxis()
    above.legend(fontsize="small", frameon=False)
    for side, place in (("track side", "left"), ("field side", "right")):
        above.text(0.01 if place == "left" else 0.99, 0.03, side, transform=above.transAxes, ha=place, color="0.4")
    at = profile.running.sampled(STEP)
    turned = profile.running.curvatures(at) * (1 if profile.kind == "rail" else -1)
    below.axhline(0, color="0.7", linewidth=0.8)
    below.plot(profile.running.points(at)[:, 0], turned, color="C0", linewidth=1.0)
    reach = max(float(np.percentile(np.abs(turned), 98)), 1e-6)
    below.set(xlabel="y [mm]", ylabel="curvature [1/mm], convex +", ylim=(-1.2 * reach, 1.2 * reach))
    below.grid(alpha=0.3)
    plt.close(figure)
    return figure
