"""For every test process: one BLAS thread, before anything imports NumPy."""

import os

collect_ignore = ["varcontact/benchmark/shipped"]
"""Files for others, which import what is beside them; tests/benchmark/ runs them."""

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")
