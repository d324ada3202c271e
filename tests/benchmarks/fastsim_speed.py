"""Triples per second of FASTSIM with 10 x 20 elements in one call; run with OMP_NUM_THREADS=1."""

import time

import numpy as np

from varcontact.reference import creepage_coefficients
from varcontact.theories import fastsim

TRIPLES = 100_000

if __name__ == "__main__":
    table = creepage_coefficients(6.8, 6.5, 0.28)
    creepages = np.random.default_rng(0).normal(size=(TRIPLES, 3)) * (2e-3, 2e-3, 4e-4)
    seconds = []
    for _ in range(5):
        start = time.perf_counter()
        fastsim(6.8, 6.5, 8.2e4, 45000.0, creepages, table, m=10, n=20)
        seconds.append(time.perf_counter() - start)
    print(f"{TRIPLES / min(seconds):.0f} triples per second")
