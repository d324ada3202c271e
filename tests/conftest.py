"""What many tests share."""

import csv
import dataclasses
import gc
from pathlib import Path
from types import SimpleNamespace

import hypothesis
import matplotlib as mpl
import pytest
from matplotlib.figure import Figure

import varcontact as vc
from tests.conditions import violations
from varcontact.elasticity.operators import Homogeneous
from varcontact.solvers import interface
from varcontact.solving import adaptive
from varcontact.solving.on_grid import ContactOnGrid
from varcontact.transports import HERE, Stencil
from varcontact.wheel_rail import solve_to_target as wheels
from varcontact.wheel_rail import wheel_on_elements

mpl.use("Agg")
DATA = Path(__file__).parent / "data"

hypothesis.settings.register_profile("default", deadline=None, derandomize=True, print_blob=True)
hypothesis.settings.load_profile("default")


SLOW = """
study plotting io wheel_rail fuzz adaptive friction system results conic line_contact
plasticity gradients benchmark benchmarks
test_viscoelastic_histories test_viscoelastic test_conformal test_carried test_third_body test_registry
test_every_kind test_no_slip test_documentation test_examples test_transient test_table test_memory
test_style test_smear test_mutants
test_method test_program test_own_solvers test_layered_bodies test_halfspace
"""


def pytest_collection_modifyitems(items):
    """Long tests, folders and files that take most of the time, and the command line are slow:
    `-m "not slow"` leaves the rest.
    """
    for item in items:
        path = item.path
        of_slow_folder = {path.parent.name, path.stem} & {*SLOW.split()}
        of_command_line = path.stem.startswith("test_cli")
        if of_slow_folder or of_command_line or item.get_closest_marker("long"):
            item.add_marker("slow")


def pytest_collection_finish():
    """Thousands of tests stay to the end: the garbage collector need not look through them again
    and again.
    """
    gc.collect()
    gc.freeze()


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


@pytest.fixture
def clock(monkeypatch):
    """Time that goes by with the elements solved: the same however busy the machine is."""
    clock, solve = SimpleNamespace(now=0.0), adaptive._solved

    def timed(scene, *rest):
        clock.now += 0.01 + 5e-5 * scene.grid.size
        return solve(scene, *rest)

    class TimedContact(ContactOnGrid):
        @classmethod
        def of(cls, scene, *rest):
            clock.now += 0.01 + 5e-5 * scene.grid.size
            return super().of(scene, *rest)

        @classmethod
        def begun(cls, scene, *rest):
            clock.now += 0.01 + 5e-5 * scene.grid.size
            return super().begun(scene, *rest)

        def with_tractions(self):
            clock.now += 0.01 + 5e-5 * self.scene.grid.size
            return super().with_tractions()

    monkeypatch.setattr(adaptive, "_solved", timed)
    monkeypatch.setattr(wheel_on_elements, "ContactOnGrid", TimedContact)
    for module in (adaptive, interface, wheels):
        monkeypatch.setattr(module, "time", SimpleNamespace(perf_counter=lambda: clock.now))
    return clock


@pytest.fixture
def pictures(monkeypatch):
    """The figures that are written to files during a test, in their order."""
    written, write = [], Figure.savefig

    def savefig(figure, *arguments, **options):
        write(figure, *arguments, **options)
        written.append(figure)

    monkeypatch.setattr(Figure, "savefig", savefig)
    return written


@pytest.fixture(scope="session")
def paper_table():
    """A function: a table of the paper as a list of dictionaries of floats."""

    def read(name: str) -> list[dict[str, float]]:
        with open(DATA / name) as lines:
            return [
                {key: float(value) for key, value in row.items()} for row in csv.DictReader(lines)
            ]

    return read


def table_name(rows: str, columns: str, stencil: Stencil) -> str:
    """A table as a plan names it: "A_zz", "A_tt - C_tt", "C_tt and C_tz"; t is along x and y, z
    normal.
    """
    row = "z" if rows == "z" else "t"
    blocks = [f"{row}{column}" for column in ("t", "z") if column.replace("t", "x") in columns]
    if len(stencil) == 1 and stencil != HERE:
        return " and ".join(f"C_{block}" for block in blocks)
    return f"A_{blocks[0]}" + (f" - C_{blocks[0]}" if len(stencil) > 1 else "")


@pytest.fixture
def built(monkeypatch):
    """The tables of influence numbers that are built from now on: (name, operator), named as in a
    plan.
    """
    tables, make = [], Homogeneous.operator

    def counted(medium, lattice, rows, columns, stencil=HERE):
        operator = make(medium, lattice, rows, columns, stencil)
        tables.append((table_name(rows, columns, stencil), operator))
        return operator

    monkeypatch.setattr(Homogeneous, "operator", counted)
    return tables


@pytest.fixture(scope="session")
def check_kkt():
    """A function: assert that a solution meets Kalker's conditions to a tolerance, see
    `tests.conditions`.
    """

    def check(sol: vc.Solution, tol: float, previous: vc.Solution | None = None) -> None:
        found = violations(sol, tol, previous)
        assert not found, "; ".join(found)

    return check
