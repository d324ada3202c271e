"""Corrugation of a rail under a driven wheel: which wavelengths grow, on a stiff and on a soft track.

At a constant load rolling wears every wave away, the shorter the faster. The dynamics of wheel and track make the load
swing, and waves grow in a band below the resonance of the wheel on the track. Printed: the response of the force to a
creepage that swings, as a system of low order for models of vehicles.

Run: python examples/corrugation.py [picture.png]
"""

import sys

import numpy as np
import xarray as xr

import varcontact as vc

SPEED = 25.0  # m/s
WHEEL = 300.0  # unsprung mass [kg]
BENDING, MASS, LOSS = 6.4e6, 60.0, 0.2  # of the rail [N m^2], [kg/m], loss factor of its foundation [-]
TRACKS = {"stiff track": 250e6, "soft track": 50e6}  # foundation [N/m^2]


def rail(omega: float, foundation: float) -> complex:
    """Receptance of an infinite beam on a foundation [m/N]."""
    stiffness = foundation * (1 + 1j * LOSS) - MASS * omega**2
    return 1 / (8 * BENDING * (stiffness / (4 * BENDING)) ** 0.75)


def main(picture: str = "corrugation.png", cells: int = 24, waves: int = 41) -> dict[str, xr.Dataset]:
    """Growth by wavelength on the tracks, and without dynamics."""
    scene = vc.Scene(
        bodies=vc.Bodies(G=82e9, nu=0.28),
        surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
        normal_force=80e3,
        friction=0.3,
        motion=vc.Steady(Fx=-12e3),
        grid=vc.Grid(nx=cells, ny=cells),
        units=vc.SI,
    )
    sol = vc.solve(scene)
    wavelengths = np.geomspace(0.02, 0.4, waves)
    found = {"constant load": vc.corrugation_growth(sol, wavelengths)}
    for name, foundation in TRACKS.items():
        found[name] = vc.corrugation_growth(
            sol,
            wavelengths,
            wheel=lambda omega: -1 / (WHEEL * omega**2),
            track=lambda omega, foundation=foundation: rail(omega, foundation),
            speed=SPEED,
        )
    figure = vc.plot_growth(found["constant load"], label="constant load")
    for name in TRACKS:
        vc.plot_growth(found[name], label=name, ax=figure.axes[0])
    figure.savefig(picture, dpi=150)
    response = sol.frequency_response(np.geomspace(5.0, 500.0, 30))
    system = response.state_space(4, speed=SPEED)
    print(f"dFx/dvx slow: {response.of('Fx', 'vx')[0].real:.3g} N; its system's poles [1/s]:")
    print(np.linalg.eigvals(system.A).round())
    return found


if __name__ == "__main__":
    main(*sys.argv[1:])
