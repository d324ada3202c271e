"""``progress=True``: a line in terminals, an output in notebooks, nothing elsewhere."""

import inspect
import sys
from types import ModuleType

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene, refused
from varcontact import checks, wheel_rail
from varcontact.system.progress import shown_progress

SCENE = make_scene(vc.Ellipse(a=1.0, b=1.0), 1.0, vc.Steady(vx=0.01), vc.Grid(nx=6, ny=6))
STEPS = make_scene(
    vc.Ellipse(a=1.0, b=1.0), 1.0, vc.Transient(steps=2, dq=0.1, vx=0.01), vc.Grid(nx=6, ny=6)
)
TRACK = wheel_rail.Track(rail=wheel_rail.Profile.rail_60e1(), cant=1 / 40)
WHEELSET = wheel_rail.WheelSet(wheel=wheel_rail.Profile.s1002())
AXLE = wheel_rail.WheelSetOnTrack(track=TRACK, wheelset=WHEELSET, vertical_force=160e3)
CREEPAGES = np.linspace(1e-3, 8e-3, 4)
CALLS = {
    "sweep": lambda: vc.sweep(SCENE, {"friction": [0.2, 0.3]}, progress=True),
    "scan": lambda: vc.scan(SCENE, [(0.01, 0.0, 0.0), (0.02, 0.0, 0.0)], progress=True),
    "compare": lambda: vc.compare([SCENE], methods=["auto"], progress=True),
    "converge": lambda: vc.converge(SCENE, cells=[4, 6, 8], progress=True),
    "history": lambda: vc.solve(STEPS, progress=True),
    "fit": lambda: vc.fit_creep_curve(
        SCENE,
        {"k_A": (0.9, 0.1, 1.0), "k_S": (0.4, 0.1, 1.0)},
        vx=CREEPAGES,
        Fx=-50 * CREEPAGES,
        method="polach",
        progress=True,
    ),
    "table": lambda: wheel_rail.geometry_table(
        TRACK, WHEELSET, y=[-1.0, 1.0], yaw=[-1e-3, 1e-3], vertical_force=5e4, progress=True
    ),
    "wheel sets": lambda: wheel_rail.sweep_wheel_sets(
        AXLE, {"position.y": [0.0, 1.0]}, fast=True, progress=True
    ),
}


@pytest.mark.parametrize("name", CALLS)
def test_terminals_show_a_line(name, monkeypatch, capsys):
    monkeypatch.setenv("FORCE_COLOR", "1")
    CALLS[name]()
    shown = capsys.readouterr()
    assert shown.out == ""
    assert "\x1b[" in shown.err


def test_elsewhere_nothing_is_shown(monkeypatch, capsys):
    monkeypatch.delenv("FORCE_COLOR", raising=False)
    CALLS["scan"]()
    assert capsys.readouterr().err == ""


def test_stages_are_no_markup_and_do_not_clash(monkeypatch, capsys):
    monkeypatch.setenv("FORCE_COLOR", "1")
    with shown_progress() as show, shown_progress() as inner:
        show("[bold]friction[0]")
        inner("beside")
    assert "[bold]friction[0]" in capsys.readouterr().err


def test_notebooks_show_one_output(monkeypatch):
    texts = []

    class Output:
        def update(self, data, raw):
            texts.append(data["text/plain"])

    module = ModuleType("IPython.display")
    module.display = lambda data, raw, display_id: Output()
    monkeypatch.setitem(sys.modules, "IPython", ModuleType("IPython"))
    monkeypatch.setitem(sys.modules, "IPython.display", module)
    monkeypatch.setattr("rich.console._is_jupyter", lambda: True)
    CALLS["table"]()
    assert texts[-1] == "3 of 4 positions"


def test_every_public_function_with_progress_takes_true():
    functions = []
    for module in (vc, wheel_rail):
        for name in module.__all__:
            value = getattr(module, name)
            if inspect.isfunction(value) and "progress" in inspect.signature(value).parameters:
                functions.append(name)
                assert hasattr(value, "forwarded"), name
    assert len(functions) >= 10


def test_what_is_no_function_is_refused():
    for given in ("yes", 3, str):
        refused(lambda given=given: vc.scan(SCENE, [(0.01, 0, 0)], progress=given), "progress")
    for quiet in (None, False):
        assert checks.progress(quiet)("stage") is None
