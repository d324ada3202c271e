"""Corrugation of a rail under a driven wheel: which wavelengths grow, on a stiff and on a soft
track.

At a constant load rolling wears every wave away, the shorter the faster. The dynamics of wheel and
track make the load swing, and waves grow in a band below the resonance of the wheel on the track,
at any traction. Printed: the response of the force to a creepage that swings, as a system of low
order for models of vehicles.

Run: python examples/corrugation.py [picture.png]
"""

import sys
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

import varcontact as vc

SPEED = 25.0  # m/s
WHEEL = 300.0  # unsprung mass [kg]
# of the rail [N m^2], [kg/m], loss factor of its foundation [-]
BENDING, MASS, LOSS = 6.4e6, 60.0, 0.2
TRACKS = {"stiff track": 250e6, "soft track": 50e6}  # foundation [N/m^2]
LOAD, FRICTION, LEVELS = 80e3, 0.3, (0.3, 0.5, 0.9)  # [N], [-], tractions by their largest [-]


def rail(omega: float, foundation: float) -> complex:
    """Receptance of an infinite beam on a foundation [m/N]."""
    stiffness = foundation * (1 + 1j * LOSS) - MASS * omega**2
    return 1 / (8 * BENDING * (stiffness / (4 * BENDING)) ** 0.75)


def dynamics(foundation: float) -> dict[str, object]:
    """Wheel and track for `corrugation_growth`."""
    return {
        "wheel": lambda omega: -1 / (WHEEL * omega**2),
        "track": lambda omega: rail(omega, foundation),
        "speed": SPEED,
    }


def main(
    picture: str = "corrugation.png", cells: int = 24, waves: int = 41
) -> dict[str, xr.Dataset]:
    """Growth by wavelength on the tracks, without dynamics, and on the stiff track by traction."""
    scene = vc.Scene(
        bodies=vc.Bodies(G=82e9, nu=0.28),
        surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
        normal_force=LOAD,
        friction=FRICTION,
        motion=vc.Steady(Fx=-0.5 * FRICTION * LOAD),
        grid=vc.Grid(nx=cells, ny=cells),
        units=vc.SI,
    )
    sol = vc.solve(scene)
    wavelengths = np.geomspace(0.02, 0.4, waves)
    found = {"constant load": vc.corrugation_growth(sol, wavelengths)}
    for name, foundation in TRACKS.items():
        found[name] = vc.corrugation_growth(sol, wavelengths, **dynamics(foundation))
    figure, (ax, beside) = plt.subplots(1, 2, sharey=True, figsize=(9.5, 4.2), layout="constrained")
    for name, growth in found.items():
        vc.plot_growth(growth, label=name, ax=ax)
    for level in LEVELS:
        driven = vc.solve(replace(scene, motion=vc.Steady(Fx=-level * FRICTION * LOAD)))
        growth = vc.corrugation_growth(driven, wavelengths, **dynamics(TRACKS["stiff track"]))
        found[f"{level:g}"] = growth
        vc.plot_growth(growth, label=f"Fx = {level:g} of the largest", ax=beside)
    beside.set_ylabel("")
    figure.savefig(picture, dpi=150)
    response = sol.frequency_response(np.geomspace(5.0, 500.0, 30))
    system = response.state_space(4, speed=SPEED)
    print(f"dFx/dvx slow: {response.of('Fx', 'vx')[0].real:.3g} N; its system's poles [1/s]:")
    print(np.linalg.eigvals(system.A).round())
    return found


if __name__ == "__main__":
    main(*sys.argv[1:])
