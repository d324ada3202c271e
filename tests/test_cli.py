"""The command line: output, files, exit statuses, and no traceback ever; as a process where that
matters.
"""

import json
import os
import re
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

import varcontact as vc
from tests.command import run, scene_file
from tests.test_cli_wheelrail import CASE

SCENE = scene_file()


HISTORY = SCENE.replace('kind = "steady"', 'kind = "transient"\nsteps = 2\ndq = 0.1').replace(
    'kind = "ellipse"\na = 1.0\nb = 1.0\n', 'kind = "paraboloids"\nRx = 1.0\nRy = 1.0\n'
)


def test_law_of_friction(folder):
    law = '[friction]\nkind = "static-kinetic"\nstatic = 0.3\nkinetic = 0.2\n'
    (folder / "law.toml").write_text(SCENE.replace("friction = 0.3\n", "") + law)
    done = run("solve", "law.toml", "--json", "--start", "slip", folder=folder)
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert result["branch"] == "slip"
    assert result["coefficient"] == [0.2, 0.2]
    assert result["passes"] == len(result["convergence"]) == 1
    assert result["convergence"][0][1] < 1e-9
    refused = run("solve", "law.toml", "--start", "rest", folder=folder)
    assert refused.returncode == 2
    assert "start = 'rest'" in refused.stderr
    told = run("plan", "law.toml", folder=folder)
    assert "friction            static-kinetic" in told.stdout


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE)
    return tmp_path


def untimed(report):
    """The lines of a report but for those of seconds, which differ from run to run."""
    return [
        line for line in report.splitlines() if not line.startswith(("  time ", "  solver calls "))
    ]


@pytest.mark.long
def test_installed_command(folder):
    """As processes: the report that this one makes, and an error on one line with its exit
    status.
    """
    script = str(Path(sysconfig.get_path("scripts")) / "varcontact")
    done = subprocess.run(
        [script, "solve", "scene.toml"], cwd=folder, capture_output=True, text=True, check=True
    )
    assert done.stderr == ""
    assert untimed(done.stdout) == untimed(run("solve", "scene.toml", folder=folder).stdout)
    module = [sys.executable, "-m", "varcontact", "plan", "none.toml"]
    refused = subprocess.run(module, cwd=folder, capture_output=True, text=True, check=False)
    assert (refused.returncode, refused.stdout) == (2, "")
    assert len(refused.stderr.splitlines()) == 1 and "none.toml" in refused.stderr
    assert run("solv", folder=folder).returncode == 2


def test_json(folder):
    done = run("solve", "scene.toml", "--json", folder=folder)
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    expected = vc.solve(vc.read_scene(folder / "scene.toml")[0])
    assert result["force"] == pytest.approx(list(expected.force), rel=1e-12, abs=1e-12)
    assert result["normal_force"] == pytest.approx(1.0)
    assert result["creepage"] == [0.05, 0.0, 0.0]
    assert result["elements"] == {"contact": 52, "stick": 34, "slip": 18}
    assert set(result["certificate"]) >= {"gap", "relative_gap", "force_bound", "residual"}
    assert result["certificate"]["relative_gap"] < 1e-12
    assert len(result["certificate"]["force_bound"]) == 3
    assert result["method"] == {
        "normal": "hertz",
        "tangential": "tang-safeguarded",
        "coupling": "none",
    }
    assert set(result) >= {"moment", "approach", "iterations", "seconds"}


def test_method_as_an_option_and_in_the_file(folder):
    (folder / "conic.toml").write_text(SCENE + '[solve]\nmethod = "conic"\n')
    done = run("solve", "conic.toml", folder=folder)
    assert done.returncode == 0, done.stderr
    assert "  method            conic: requested: QP and SOCP by conic solvers" in done.stdout
    assert "  solver calls      normal: hertz once" in done.stdout
    assert "                    tangential: clarabel once (" in done.stdout
    result = json.loads(
        run("solve", "conic.toml", "--method", "kalker", "--json", folder=folder).stdout
    )
    assert result["road"] == "kalker"
    assert result["solved_by"] == {"normal": "hertz", "tangential": "tang-exact"}
    assert list(result["calls"]["tangential"]) == ["tang-exact"]
    assert set(result["calls"]["tangential"]["tang-exact"]) == {"count", "iterations", "seconds"}
    planned = json.loads(
        run("plan", "scene.toml", "--method", "conic", "--json", folder=folder).stdout
    )
    assert (planned["method"], planned["tangential"], planned["formulation"]) == (
        "conic",
        "clarabel",
        "gap",
    )
    refused = run("solve", "scene.toml", "--method", "konvex", folder=folder)
    assert refused.returncode == 2
    assert (
        "method = 'konvex' is not allowed: must be one of auto, convex, conic, active-set, kalker"
        in refused.stderr
    )


def test_a_plan_is_printed(folder):
    done = run("plan", "scene.toml", folder=folder)
    assert done.returncode == 0, done.stderr
    for words in (
        "quasi-identical: K = 0",
        "hertz: ",
        "tang-safeguarded: active sets",
        "52 elements, 52 unknowns",
        "peak memory",
    ):
        assert words in done.stdout
    assert "at most" not in done.stdout


def test_a_plan_in_json_is_that_of_the_solution(folder):
    (folder / "scene.toml").write_text(SCENE + '[solve]\ntangential = "tang"\ntol = 1e-9\n')
    done = run("plan", "scene.toml", "--json", "--normal", "norm", folder=folder)
    assert done.returncode == 0, done.stderr
    printed, scene = json.loads(done.stdout), vc.read_scene(folder / "scene.toml")[0]
    assert printed == vc.plan(scene, normal="norm", tangential="tang").summary()
    assert printed["sizes"]["exact"] is False
    assert (printed["normal"], printed["tangential"], printed["special"]) == ("norm", "tang", [])


@pytest.mark.long
def test_report_file_and_picture(folder, pictures):
    done = run("solve", "scene.toml", "--out", "result.nc", "--plot", "result.png", folder=folder)
    assert done.returncode == 0, done.stderr
    assert "certificate" in done.stdout
    assert "relative gap" in done.stdout
    assert vc.load(folder / "result.nc").normal_force == pytest.approx(1.0)
    assert (folder / "result.png").read_bytes().startswith(b"\x89PNG")
    assert (
        pictures[0].axes[0].images[0].get_array().max()
        == vc.load(folder / "result.nc").pressure.max()
    )
    assert sorted(os.listdir(folder)) == ["result.nc", "result.png", "scene.toml"], (
        "nothing half-written is left"
    )


@pytest.mark.parametrize(
    ("command", "scene", "options", "words"),
    [
        ("solve", SCENE.replace("nu = 0.28", "nu = 0.6"), (), ["bodies.nu", "0.6", "(-1, 0.5]"]),
        ("solve", SCENE.replace("friction", "frictoin"), (), ["frictoin", "friction"]),
        ("solve", "no toml at all", (), ["scene.toml", "TOML"]),
        ("solve", SCENE, ("--normal", "hertzz"), ["normal", "hertzz", "did you mean hertz"]),
        ("solve", SCENE, ("--tol", "-1"), ["tol", "-1"]),
        (
            "solve",
            SCENE,
            ("--refine", "continuum"),
            ["refine = 'continuum'", "this version has accuracy"],
        ),
        ("solve", SCENE, ("--out", "no/such/folder/a.nc"), ["--out", "no/such/folder"]),
        ("solve", SCENE, ("--plot", "picture.xyz"), ["--plot", "picture.xyz", ".png"]),
        ("solve", SCENE, ("--out", "a.vtk"), ["--out = 'a.vtk'", "must end in .nc, .csv, .vtu"]),
        ("solve", SCENE, ("--out", "a"), ["--out = 'a'", "must end in .nc, .csv"]),
        (
            "solve",
            SCENE,
            ("--out", "a.png", "--plot", "a.png"),
            ["--out = 'a.png'", "must end in .nc, .csv"],
        ),
        ("solve", SCENE, ("--out", "a" * 300 + ".nc"), ["--out", "cannot be written"]),
        ("solve", SCENE.replace("nx = 8", "nx = 100000000"), (), ["grid of this size", "GiB"]),
        ("plan", SCENE, ("--tangential", "fastism"), ["tangential", "fastism", "fastsim"]),
        ("compare", SCENE, ("--methods", "clarable"), ["methods", "did you mean clarabel?"]),
        ("compare", SCENE, ("--methods", ""), ["methods", "at least one"]),
        ("compare", SCENE, ("nothing.toml",), ["nothing.toml"]),
        ("compare", SCENE, ("scene.toml",), ["scenes", "each file once"]),
        ("compare", SCENE, ("--out", "none/t.csv"), ["--out", "no folder"]),
        ("compare", SCENE, ("--out", "a.png"), ["--out = 'a.png'", "must end in .csv"]),
        (
            "converge",
            SCENE,
            ("--cells", "6,8", "--store", "a.nc"),
            ["--store = 'a.nc'", "the name must end in .csv"],
        ),
    ],
)
def test_bad_input(folder, command, scene, options, words):
    (folder / "scene.toml").write_text(scene)
    done = run(command, "scene.toml", *options, folder=folder)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert done.stdout == ""
    assert all(word in done.stderr for word in words), done.stderr
    assert os.listdir(folder) == ["scene.toml"]


@pytest.mark.parametrize("certify", ["auto", "none"])
def test_not_solved_to_tolerance(folder, certify):
    options = ("--json", "--out", "result.nc", "--tol", "1e-30", "--certify", certify)
    options += ("--tangential", "tang")  # alone, without those that come to its help
    done = run("solve", "scene.toml", *options, folder=folder)
    assert done.returncode == 3
    assert "residual" in done.stderr
    assert "Traceback" not in done.stderr
    printed = json.loads(done.stdout, parse_constant=pytest.fail)  # NaN, Infinity
    assert printed["converged"] is False
    assert (printed["certificate"]["gap"] is None) == (certify == "none")
    assert not vc.load(folder / "result.nc").converged


@pytest.mark.long
@pytest.mark.parametrize(
    "arguments", [("solve", "scene.toml", "--json", "--out", "a.nc"), ("solve", "--help")]
)
def test_reader_that_has_gone(folder, arguments):
    """As in ``varcontact ... | true``: no complaint, and the files are written."""
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-m", "varcontact", *arguments]
    done = subprocess.run(
        command, cwd=folder, stdout=writing, stderr=subprocess.PIPE, text=True, check=False
    )
    os.close(writing)
    assert done.stderr == ""
    # printed by click, which calls it an error
    assert done.returncode == 0 or "--help" in arguments
    assert sorted(os.listdir(folder)) == sorted(
        {"scene.toml", *(name for name in arguments if name.startswith("a."))}
    )


@pytest.mark.long
def test_output_that_cannot_be_written(folder):
    """Standard output that takes nothing: one line, and the file of --out is written all the
    same.
    """
    command = [sys.executable, "-m", "varcontact", "solve", "scene.toml", "--out", "a.nc"]
    with open(os.devnull) as closed:  # for reading
        done = subprocess.run(
            command, cwd=folder, stdout=closed, stderr=subprocess.PIPE, text=True, check=False
        )
    assert done.returncode == 2
    assert "standard output" in done.stderr
    assert "Traceback" not in done.stderr
    assert vc.load(folder / "a.nc").converged


def test_import_is_light():
    """Heavy packages are imported where they are used, and so is what a script may not need of
    varcontact.
    """
    heavy = (
        "scipy",
        "clarabel",
        "cvxpy",
        "pandas",
        "xarray",
        "matplotlib",
        "typer",
        "varcontact.solvers",
    )
    code = f"import sys, varcontact; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.long
def test_a_small_solve_imports_no_more_than_it_needs():
    """Other solvers, grids for an accuracy, time stepping, files, and SciPy's rooms for these."""
    unused = (
        "scipy.interpolate",
        "scipy.optimize",
        "scipy.sparse",
        "filelock",
        "varcontact.io",
        "varcontact.plotting",
        "varcontact.results.linearised",
        "varcontact.solvers.conic.programs",
        "varcontact.solvers.newton",
        "varcontact.solvers.splitting",
        "varcontact.solving.adaptive",
        "varcontact.solving.time_step",
    )
    code = f"""
import sys
import varcontact as vc
vc.solve(vc.Scene(
    bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
    normal_force=106.7e3, friction=0.33, motion=vc.Steady(vx=1e-3), grid=vc.Grid(nx=8, ny=8)))
print([name for name in {unused} if name in sys.modules])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.long
@pytest.mark.parametrize(("words", "unused"), [
    ("solve scene.toml", "matplotlib|xarray|pandas|cvxpy|scipy.special"),
    ("wheelrail wheel.toml", "matplotlib|xarray|pandas|cvxpy"),
])  # fmt: skip
def test_a_command_without_a_picture_imports_nothing_that_draws_or_tabulates(folder, words, unused):
    (folder / "wheel.toml").write_text(CASE)
    command = [sys.executable, "-X", "importtime", "-m", "varcontact", *words.split()]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    assert "varcontact.solving.on_grid" in done.stderr
    assert not re.search(rf"\| +({unused})\b", done.stderr)


@pytest.mark.long
def test_matplotlib_says_nothing_of_its_caches(folder):
    """Where its folder is not one, it warns on standard error, as it does of the fonts it looks
    for.
    """
    (folder / "no folder").touch()
    files = ("--out", "report.html", "--plot", "picture.png")
    command = [sys.executable, "-m", "varcontact", "solve", "scene.toml", *files]
    environment = os.environ | {"MPLCONFIGDIR": str(folder / "no folder")}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert (folder / "report.html").stat().st_size > 1000
    assert (folder / "picture.png").stat().st_size > 1000


WITHOUT_PICTURES = """
import sys
from varcontact.__main__ import main
for words in ("solve scene.toml", "scan scene.toml --vx 0:0.01:2",
              "curve scene.toml --vx 0:0.01:2", "compare scene.toml --methods fastsim,linear",
              "wheelrail wheel.toml"):
    sys.argv = ["varcontact", *words.split()]
    try:
        main()
    except SystemExit as ended:
        assert not ended.code, words
    assert "matplotlib" not in sys.modules, words
"""


def test_without_a_picture_matplotlib_is_not_loaded(folder):
    """It takes half a second or more, and as long as the work itself."""
    (folder / "wheel.toml").write_text(CASE)
    command = [sys.executable, "-c", WITHOUT_PICTURES]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.long
def test_compare(folder, pictures):
    methods = "tang-safeguarded,fastsim,cvxpy:CVXOPT"
    done = run(
        "compare",
        "scene.toml",
        "--methods",
        methods,
        "--out",
        "t.csv",
        "--plot",
        "t.png",
        folder=folder,
    )
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0] == "scene"
    assert [line.split()[:2] for line in lines[2:5]] == [
        ["tang-safeguarded", "solved"],
        ["fastsim", "approximate"],
        ["cvxpy:CVXOPT", "unavailable"],
    ]
    assert "pip install cvxopt" in lines[5]
    assert (folder / "t.png").read_bytes()[:4] == b"\x89PNG"
    assert [entry.get_text() for entry in pictures[0].legends[0].get_texts()] == [
        "tang-safeguarded",
        "fastsim",
    ]
    again = run(
        "compare", "scene.toml", "--methods", methods, "--out", "t.csv", "--json", folder=folder
    )
    rows = json.loads(again.stdout)
    assert [row["method"] for row in rows] == methods.split(",")
    assert rows[0]["traction_distance"] == 0
    assert 0.01 < rows[1]["force_distance"] < 0.2
    assert rows[2]["Fx"] is None


@pytest.mark.long
def test_compare_takes_the_accuracy_of_a_file(folder):
    """As of the command line; files that ask for different ones are refused."""
    asked = SCENE.split("[grid]")[0] + "\n[solve]\naccuracy = 0.1\n"
    (folder / "asked.toml").write_text(asked)
    table = [
        run("compare", "asked.toml", "--methods", "tang", "--json", *more, folder=folder)
        for more in ([], ["--accuracy", "0.1"])
    ]
    (fx,), (same,) = ([row["Fx"] for row in json.loads(done.stdout)] for done in table)
    (folder / "plain.toml").write_text(asked.split("[solve]")[0])
    (plain,) = json.loads(
        run("compare", "plain.toml", "--methods", "tang", "--json", folder=folder).stdout
    )
    assert fx == same != plain["Fx"]
    done = run("compare", "asked.toml", "plain.toml", folder=folder)
    assert done.returncode == 2
    assert "must be the same for all scene files" in done.stderr


@pytest.mark.long
@pytest.mark.parametrize(("options", "accuracy"), [((), 0.01), (("--accuracy", "0.1"), 0.1)])
def test_a_history_to_an_accuracy_is_saved_at_the_end(folder, options, accuracy):
    (folder / "history.toml").write_text(HISTORY.split("[grid]")[0])
    done = run("solve", "history.toml", *options, "--out", "h.nc", folder=folder)
    assert done.returncode == 0, done.stderr
    assert vc.load(folder / "h.nc").error_estimate.largest <= accuracy
    (folder / "text.nc").write_text("mine")
    done = run("solve", "history.toml", *options, "--out", "text.nc", folder=folder)
    assert (done.returncode, (folder / "text.nc").read_text()) == (2, "mine")


def test_how_much_of_the_certificate(folder):
    (folder / "less.toml").write_text(SCENE + '[solve]\ncertify = "none"\n')
    for options, level in (((), "none"), (("--certify", "gap"), "gap")):
        done = run("solve", "less.toml", "--json", *options, folder=folder)
        certificate = json.loads(done.stdout)["certificate"]
        assert certificate["level"] == level
        assert (certificate["gap"] is None) == (level == "none")
        assert certificate["force_bound"] == [None, None, None]
    refused = run("solve", "less.toml", "--certify", "all", folder=folder)
    assert refused.returncode == 2
    assert "certify = 'all'" in refused.stderr
