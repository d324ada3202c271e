"""Misspelt options: every public call says what is meant, before any work and any file."""

import dataclasses
import inspect

import pytest

import varcontact as vc
from varcontact import wheel_rail
from varcontact.checks import Checked
from varcontact.wheel_rail import Position, Profile, Track, WheelOnRail, WheelSet, WheelSetOnTrack

TRACK = {
    "track": Track(rail=Profile.rail_60e1(), cant=1 / 40),
    "wheelset": WheelSet(wheel=Profile.s1002()),
}
BALL = vc.Scene(
    bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Paraboloids(1.0, 1.0), normal_force=1e-3, friction=0.3,
    motion=vc.Steady(vx=1e-3),
)  # fmt: skip
METHODS = [
    "Bodies.from_young", "Carried.flat", "ContactResult.scene", "Convergence.plot", "FrequencyResponse.plot",
    "History.save", "History.plot", "History.animate", "Paraboloids.from_bodies", "SampledDistance.smoothed",
    "Scene.save", "Solution.save", "Solution.to_html", "Solution.frequency_response", "Solution.plot",
    "GeometryTable.forces", "Profile.read", "Profile.save", "Profile.smoothed", "ProfileSlices.read",
    "WheelOnRail.patches", "WheelOnRail.solve", "WheelOnRail.estimate", "WheelSetOnTrack.solve",
    "WheelSetOnTrack.estimate",
]  # fmt: skip


def public():
    """Functions and classes of both modules, and methods that work for long, draw, or read and
    write files.
    """
    calls = {}
    for module in (vc, wheel_rail):
        for name in module.__all__:
            entry = getattr(module, name)
            if inspect.isroutine(entry) or (inspect.isclass(entry) and issubclass(entry, Checked)):
                calls[f"{module.__name__}.{name}"] = entry
    for name in METHODS:
        of, method = name.split(".")
        entry = inspect.getattr_static(getattr(vc, of, None) or getattr(wheel_rail, of), method)
        calls[name] = getattr(entry, "__func__", entry)
    return calls


CALLS = public()


def test_all_functions_are_here():
    assert {
        "varcontact.solve",
        "varcontact.sweep",
        "varcontact.wheel_rail.sweep_wheel_sets",
    } <= CALLS.keys()
    assert len(CALLS) > 80


@pytest.mark.parametrize("name", CALLS)
def test_a_misspelt_option_says_what_is_meant(name, tmp_path, monkeypatch):
    """Each option with one letter missing; nothing else is looked at, and nothing written."""
    monkeypatch.chdir(tmp_path)
    call = CALLS[name]
    if inspect.isclass(call):
        names = [field.name for field in dataclasses.fields(call) if field.init]
    else:
        kinds = (inspect.Parameter.KEYWORD_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
        entries = inspect.signature(call).parameters.values()
        names = [
            each.name for each in entries if each.kind in kinds and each.name not in ("self", "cls")
        ]
    for option in (each for each in names if len(each) > 4):
        wrong = option[:2] + option[3:]
        with pytest.raises(vc.SceneError, match=f"has no (option )?{wrong}.*{option}") as refused:
            call(**{wrong: None})
        assert "did you mean" in str(refused.value) or ": write" in str(refused.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("call", "words"), [
    (lambda: vc.Paraboloids(line=True), "^Paraboloids has no line; it has Rx, Ry$"),
    (lambda: vc.solve(BALL, acuracy=0.01), r"^solve has no option acuracy \(did you mean accuracy\?\)$"),
    (lambda: WheelOnRail(**TRACK, z=0.1).solve(acuracy=0.01), r"no option acuracy \(did you mean accuracy\?\)$"),
    (lambda: WheelSetOnTrack(**TRACK, z=0.1).solve(acuracy=0.01), r"no option acuracy \(did you mean accuracy\?\)$"),
    (lambda: WheelOnRail(**TRACK, z=0.1).estimate(tangental="table"), r"did you mean tangential\?"),
    (lambda: WheelOnRail(**TRACK, z=0.1).estimate(tangential="table", outsid="clamp"), r"did you mean outside\?"),
    (lambda: WheelOnRail(**TRACK, z=-9.0).estimate(tangential="polach", m=20), "m is no option of polach"),
    (lambda: vc.solve(BALL, method="newton"), 'must be one of auto, .* did you mean tangential="newton" or normal='),
    (lambda: vc.solve(BALL, method="fastsim"), r'did you mean tangential="fastsim"\?'),
    (lambda: vc.creep_forces("polach", a=1.0, b=1.0, normal_force=1.0, friction=0.3, G=1.0, nu=0.3, k_a=1.0),
     r"creep_forces has no option k_a \(did you mean k_A\?\)"),
])  # fmt: skip
def test_what_people_write(call, words):
    with pytest.raises(vc.SceneError, match=words):
        call()


@pytest.mark.parametrize(("fast", "options", "words"), [
    (False, {"law": 0.3}, "sweep_wheel_sets has no option law; it has cases, over, .* tol, certify"),
    (True, {"acuracy": 0.01}, "sweep_wheel_sets has no option acuracy"),
    (True, {"tangental": "table"}, r"did you mean tangential\?"),
    (False, {"acuracy": 0.01}, r"did you mean accuracy\?"),
])  # fmt: skip
def test_a_sweep_is_refused_before_its_table(tmp_path, fast, options, words):
    case = WheelSetOnTrack(**TRACK, vertical_force=1e5, position=Position(y=0.0))
    with pytest.raises(vc.SceneError, match=words):
        wheel_rail.sweep_wheel_sets(
            case, {"position.y": [0.0]}, fast=fast, store=tmp_path / "table.csv", **options
        )
    assert list(tmp_path.iterdir()) == []
