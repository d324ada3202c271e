"""The elastic-plastic response of one depth of a line contact, passage after passage."""

import numpy as np
from scipy.optimize import brentq


def hardening_free_response(nu):
    """Residual r = -A g of the three free coordinates by plastic strains g of a depth that neither
    stretches along x and y nor shears in their plane, by the shear modulus.
    """
    young = 2 * (1 + nu)
    plane = young / (1 - nu**2) * np.array([[1, nu], [nu, 1]])
    strain = np.array([[0, 1 / np.sqrt(3)], [0.5, -0.5 / np.sqrt(3)]])  # xx, yy by g1, g2
    stress = np.array([[0, 0.5], [1 / np.sqrt(3), -0.5 / np.sqrt(3)]])  # r1, r2 by xx, yy
    A = np.zeros((3, 3))
    A[:2, :2] = stress @ plane @ strain
    A[2, 2] = 1.0
    return (A + A.T) / 2


def marched(curve, nu, cycles=30):
    """Plastic strain of each passage of a curve (n, 5), by the yield stress, from a body without
    residual stress; infinite where no residual stress holds it.
    """
    values, vectors = np.linalg.eigh(hardening_free_response(nu))
    residual = np.zeros(3)
    grown = []
    for _ in range(cycles):
        strain = 0.0
        for elastic in curve:
            free = vectors.T @ (elastic[:3] + residual)
            room = 1 - elastic[3] ** 2 - elastic[4] ** 2
            if free @ free <= room:
                continue
            if room <= 0:
                return np.array([np.inf])

            def excess(mu, free=free, room=room):
                return np.sum((free / (1 + mu * values)) ** 2) - room

            mu = brentq(excess, 0.0, 1e9)
            returned = free / (1 + mu * values)
            strain += mu * np.sqrt(returned @ returned + elastic[3] ** 2 + elastic[4] ** 2)
            residual = vectors @ returned - elastic[:3]
        grown.append(strain)
    return np.array(grown)
