"""What many tests share."""

import csv
import dataclasses
from pathlib import Path

import hypothesis
import pytest

import varcontact as vc

DATA = Path(__file__).parent / "data"

hypothesis.settings.register_profile("default", deadline=None, derandomize=True, print_blob=True)
hypothesis.settings.load_profile("default")


@pytest.fixture(scope="session")
def rolling():
    """A function: a small steady rolling scene, with whatever is to be different."""
    base = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Ellipse(a=1.2, b=0.9),
        normal_force=1.0,
        friction=0.3,
        motion=vc.Steady(vx=0.04, vy=-0.02, spin=0.05),
        grid=vc.Grid(nx=12, ny=12),
    )
    return lambda **changes: dataclasses.replace(base, **changes)


@pytest.fixture(scope="session")
def paper_table():
    """A function: a table of the paper as a list of dictionaries of floats."""

    def read(name: str) -> list[dict[str, float]]:
        with open(DATA / name) as lines:
            return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(lines)]

    return read
