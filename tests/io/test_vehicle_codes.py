"""A table book as C, and as functional mock-up units: the numbers of Python, from other
programs.
"""

import ctypes
import shutil
import subprocess
import zipfile

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

import varcontact as vc
from tests.command import run
from varcontact.data.make_table_book import make_table_book
from varcontact.io.vehicle_codes import write_c, write_fmu
from varcontact.theories import TableBook, table_forces

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
NAMES = ("a", "b", "G", "nu", "Fz", "f", "vx", "vy", "spin")
CONTACT = (6e-3, 4e-3, 82e9, 0.28, 1e5, 0.3, 1e-3, -5e-4, 0.2)
FLAGS = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O1", "-shared", "-fPIC"]


def compiled(folder):
    """A function: status, and forces or also their derivatives, of one contact."""
    library = folder / "vc_forces.so"
    subprocess.run(["gcc", *FLAGS, "-o", library, folder / "vc_forces.c", "-lm"], check=True)
    loaded = ctypes.CDLL(library)

    def call(contact, gradient=False):
        given = np.array(contact, dtype=float)
        out = np.zeros(12 if gradient else 3)
        function = loaded.vc_forces_gradient if gradient else loaded.vc_forces
        return function(*(ctypes.c_void_p(each.ctypes.data) for each in (given, out))), out

    return call


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The book of the package for all vehicle codes, by the command."""
    folder = tmp_path_factory.mktemp("codes")
    done = run("table", "export", "--c", folder, "--fmu", folder, folder=folder)
    assert (done.returncode, done.stderr) == (0, "")
    made = {
        "vc_forces.c",
        "vc_forces.h",
        "vc_forces.m",
        "VcForces.mo",
        "vc_forces_fmi2.fmu",
        "vc_forces_fmi3.fmu",
    }
    assert {path.name for path in folder.iterdir()} == made
    return folder


@pytest.fixture(scope="module")
def forces(folder):
    return compiled(folder)


def contacts(count, seed=1):
    """Random ones in the book, from hardly any slip to far beyond full slip, in millimetres or
    metres.
    """
    random = np.random.default_rng(seed)
    for _ in range(count):
        unit = random.choice([1.0, 1e3])
        b, ratio = (
            unit * random.uniform(1e-3, 1e-2),
            np.exp(random.uniform(np.log(0.2), np.log(5.0))),
        )
        size, way = 10 ** random.uniform(-6, 1), random.normal(size=3)
        yield (
            ratio * b,
            b,
            82e9 / unit**2,
            0.28,
            1e5,
            random.uniform(0.1, 0.6),
            *(size * way * (1, 1, 100 / unit)),
        )


def python(contact, book=None):
    a, b, G, nu, Fz, f, *creepages = contact
    found = table_forces(a, b, G, f * Fz, creepages, nu=nu, book=book, outside="clamp")
    return np.array([*found.force, float(found.moment)])


def scales(contact):
    a, b, _, _, Fz, f, *_ = contact
    return f * Fz * np.array([1.0, 1.0, np.sqrt(a * b)])


@pytest.mark.long
def test_forces_are_those_of_python(forces):
    special = [
        (*CONTACT[:6], *creepage)
        for creepage in np.vstack([np.zeros((1, 3)), np.eye(3), -np.eye(3)]) * 1e-3
    ]
    special += [
        (*CONTACT[:6], 1e9, 1e9, 0.0),
        (2e-3, 1e-2, *CONTACT[2:]),
        (5.0, 1.0, 1e6, 0.28, 1e5, 0.3, 1.0, 1.0, 1.0),
    ]
    for contact in [*contacts(40), *special]:
        status, found = forces(contact)
        assert status == 0
        assert (np.abs(found - python(contact)) <= 1e-12 * scales(contact)).all()


def test_derivatives_are_those_of_differences(forces):
    """Of fourth order; forces have two continuous derivatives, but where they are cut."""
    for contact in contacts(30, seed=2):
        status, found = forces(contact, gradient=True)
        assert status == 0
        assert (found[:3] == forces(contact)[1]).all()
        creepages, unit = (
            np.array(contact[6:]),
            np.array([1.0, 1.0, 1 / np.sqrt(contact[0] * contact[1])]),
        )
        step = 1e-4 * np.linalg.norm(creepages / unit)
        for k in range(3):
            at = [
                forces((*contact[:6], *(creepages + n * step * unit * np.eye(3)[k])))[1]
                for n in (-2, -1, 1, 2)
            ]
            differences = (at[0] - 8 * at[1] + 8 * at[2] - at[3]) / (12 * step * unit[k])
            by_step = np.abs(found[3 + k :: 3] - differences) * step * unit[k] / scales(contact)
            assert by_step.max() < 1e-8


def test_derivatives_without_creepage_are_those_of_the_linear_theory(forces):
    a, b, G, nu, *_ = CONTACT
    C = vc.no_slip_coefficients(a / b, nu)
    ab = G * a * b
    size = np.sqrt(a * b)
    wanted = ab * np.array(
        [[-C.C11, 0.0, 0.0], [0.0, -C.C22, -C.C23 * size], [0.0, C.C23 * size, -C.C33 * size**2]]
    )
    found = forces((*CONTACT[:6], 0.0, 0.0, 0.0), gradient=True)[1][3:].reshape(3, 3)
    assert found == pytest.approx(wanted, rel=1e-12)


def test_derivatives_at_pure_longitudinal_creepage_are_those_of_the_force(forces):
    """The angle of (vy, spin) has no value there: derivatives are those of differences that are not
    small.
    """
    a, b, *_ = CONTACT
    contact = np.array([*CONTACT[:6], 2e-3, 0.0, 0.0])
    found = forces(contact, gradient=True)[1][3:].reshape(3, 3)
    for k, step in enumerate((1e-4, 1e-4, 1e-4 / np.sqrt(a * b))):
        move = step * np.eye(9)[6 + k]
        differences = (forces(contact + move)[1] - forces(contact - move)[1]) / (2 * step)
        assert np.abs(found[:, k] - differences).max() < 0.01 * np.abs(found).max(axis=1)[k]


@pytest.mark.parametrize(
    ("name", "values", "status"),
    [(name, (np.nan, np.inf, -np.inf, 1e101), -1) for name in NAMES]
    + [(name, (0.0, -1.0, 1e-101), -2) for name in ("a", "b", "G", "Fz", "f")]
    + [("nu", (0.26, 0.3, -0.28), -3)],
)
@pytest.mark.parametrize("gradient", [False, True])
def test_bad_input_has_a_code_and_no_number(forces, name, values, status, gradient):
    for value in values:
        contact = [
            value if each == name else good for each, good in zip(NAMES, CONTACT, strict=True)
        ]
        found, out = forces(contact, gradient)
        assert found == status
        assert np.isnan(out).all()


def test_an_ellipse_outside_the_book_is_said(forces):
    for a in (0.5e-3, 40e-3):
        contact = (a, *CONTACT[1:])
        status, found = forces(contact)
        assert status == 1
        assert found == pytest.approx(python(contact), rel=1e-12)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("kind", ["ModelExchange", "CoSimulation"])
def test_a_unit_gives_the_same_forces(folder, forces, version, kind):
    """FMPy checks the description and runs the binary, with a creepage that grows in time."""
    path = str(folder / f"vc_forces_fmi{version}.fmu")
    assert validate_fmu(path) == []
    signals = np.array([(0.0, 0.0), (1.0, 2e-3)], dtype=[("time", float), ("vx", float)])
    start = {name: value for name, value in zip(NAMES, CONTACT, strict=True) if name != "vx"}
    told = []
    result = fmpy.simulate_fmu(
        path, fmi_type=kind, input=signals, start_values=start, stop_time=1.0, output_interval=0.25,
        output=["vx", "Fx", "Fy", "Mz", "dFy_dspin"], logger=lambda *words: told.append(words),
    )  # fmt: skip
    assert result["vx"].max() > 1e-3 and told == []
    for row in result:
        wanted = forces((*CONTACT[:6], row["vx"], *CONTACT[7:]), gradient=True)[1]
        assert [row[name] for name in ("Fx", "Fy", "Mz", "dFy_dspin")] == pytest.approx(
            wanted[[0, 1, 2, 8]], rel=1e-14
        )


@pytest.mark.parametrize("version", [2, 3])
def test_a_unit_refuses_what_the_function_refuses(folder, version):
    path = str(folder / f"vc_forces_fmi{version}.fmu")
    told = []
    with pytest.raises(fmpy.fmi1.FMICallException):
        fmpy.simulate_fmu(
            path,
            start_values={"Fz": -1.0},
            stop_time=1.0,
            logger=lambda *words: told.append(words[-1]),
        )
    assert told == [b"a, b, G, Fz and f must be positive"]


@pytest.mark.long
def test_units_are_compiled_from_their_sources(folder, tmp_path):
    """The same for both versions, without headers of the standard; with the prefix that a static
    link needs.
    """
    contents = []
    for version in (2, 3):
        with zipfile.ZipFile(folder / f"vc_forces_fmi{version}.fmu") as unit:
            contents.append(
                {
                    name: unit.read(f"sources/{name}")
                    for name in ("fmi.c", "vc_forces.c", "vc_forces.h")
                }
            )
    assert contents[0] == contents[1]
    for name, content in contents[0].items():
        (tmp_path / name).write_bytes(content)
    flags = [*FLAGS, "-Wno-unused-parameter", "-DFMI2_FUNCTION_PREFIX=vc_forces_"]
    subprocess.run(["gcc", *flags, "-o", tmp_path / "unit.so", tmp_path / "fmi.c"], check=True)
    symbols = subprocess.run(
        ["nm", tmp_path / "unit.so"], capture_output=True, text=True, check=True
    ).stdout
    assert " T vc_forces_fmi2DoStep" in symbols and " T fmi3DoStep" in symbols


SMALL = {"least": 0.8, "greatest": 1.25, "ratios": 2, "steps": 2, "degree": 3}


@pytest.fixture(scope="module")
def book():
    return make_table_book(0.4, **SMALL)


@pytest.mark.long
def test_a_book_for_other_bodies(book, tmp_path):
    (tmp_path / "book.nc").write_bytes(book.to_bytes())
    done = run("table", "export", "book.nc", "--c", "code", folder=tmp_path)
    assert (done.returncode, done.stdout.split()[0]) == (0, "code/vc_forces.c")
    call = compiled(tmp_path / "code")
    contact = (1.1, 1.0, 1e3, 0.4, 10.0, 0.3, 0.01, 0.02, -0.01)
    status, found = call(contact)
    assert status == 0
    assert found == pytest.approx(python(contact, TableBook.read(tmp_path / "book.nc")), rel=1e-12)
    assert call((1.1, 1.0, 1e3, 0.28, *contact[4:]))[0] == -3
    assert "1270" not in (tmp_path / "code" / "vc_forces.h").read_text()


@pytest.mark.long
def test_files_of_others_stay(book, tmp_path):
    (tmp_path / "vc_forces.h").write_text("mine")
    with pytest.raises(
        vc.OutputError, match="is no export of varcontact's; name another file, or give overwrite"
    ):
        write_c(tmp_path, book)
    assert [path.name for path in tmp_path.iterdir()] == ["vc_forces.h"]
    assert len(write_c(tmp_path, book, overwrite=True)) == len(write_c(tmp_path, book)) == 4
    with pytest.raises(vc.OutputError, match="cannot be made"):
        write_c(tmp_path / "nowhere" / "code", book)
    with pytest.raises(vc.SceneError, match="folder"):
        write_c("", book)
    done = run("table", "export", folder=tmp_path)
    assert (done.returncode, done.stderr) == (
        2,
        "varcontact: --c is missing: name a folder with --c or --fmu\n",
    )


def test_a_unit_without_a_compiler_has_its_sources(book, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", "")
    for path in write_fmu(tmp_path, book):
        with zipfile.ZipFile(path) as unit:
            assert not [name for name in unit.namelist() if name.startswith("binaries")]
