"""Case files: what they say is the case in Python, and what they cannot say is named."""

import dataclasses
import shutil

import numpy as np
import pytest

from tests.wheel_rail.conditions import DATA, WHEEL
from varcontact import (
    Bodies,
    FrictionLaw,
    LinearFalling,
    ShearStrength,
    TemperatureFalling,
    Thermal,
    ThirdBody,
    Viscoelastic,
)
from varcontact.errors import Interrupted, PlausibilityWarning, SceneError
from varcontact.scene.friction import ExponentialFalling
from varcontact.wheel_rail import (
    Archard,
    ArchardMap,
    FrictionByAngle,
    Irregularity,
    Position,
    Profile,
    ProfileSlices,
    Velocity,
    case_file,
)
from varcontact.wheel_rail import solve as side_by_side
from varcontact.wheel_rail.case_file import _identities, read_case, solve_cases
from varcontact.wheel_rail.plots import plot_positions
from varcontact.wheel_rail.quantities import columns
from varcontact.wheel_rail.solve import SIDE_BY_SIDE

CASE = """
vertical_force = 20e3
dx = 1.0
dy = 1.0
track = { rail = "60e1", cant = 0.025 }
wheelset = { wheel = "s1002" }
position = { y = [1.0, 2.0, 9e2], yaw = 1e-3 }
"""


def read(folder, text):
    (folder / "case.toml").write_text(text)
    return read_case(folder / "case.toml")


def test_it_is_the_case_in_python(tmp_path):
    text = """
    side = "left"
    vertical_force = 50e3
    with_friction = false
    dx = 0.4
    friction = { kind = "exponential", static = 0.4, kinetic = 0.2, half_velocity = 10.0, velocity = 2e4 }
    [bodies]
    E = 210e3
    nu = 0.3
    [track]
    rail = "60E1"
    cant = 0.025
    gauge = 1440.0
    [wheelset]
    wheel = { file = "wheel.csv", smoothing = 5.0 }
    radius = 500.0
    [position]
    y = 2.0
    roll = 1e-3
    [velocity]
    speed = 20e3
    pitch_rate = -40.0
    [solve]
    tol = 1e-5
    tangential = "newton"
    """
    shutil.copy(DATA / "profiles" / "wheel_S1002.csv", tmp_path / "wheel.csv")
    found = read(tmp_path, text)
    (case,) = found.cases
    assert found.options == {"tol": 1e-5, "tangential": "newton"}
    assert found.archard is None
    assert (case.side, case.vertical_force, case.with_friction, case.dx, case.dy) == (
        "left",
        50e3,
        False,
        0.4,
        None,
    )
    assert case.friction == ExponentialFalling(
        static=0.4, kinetic=0.2, half_velocity=10.0, velocity=2e4
    )
    assert case.bodies.combined_G == pytest.approx(210e3 / 2.6)
    assert case.position == Position(y=2.0, roll=1e-3)
    assert case.velocity == Velocity(speed=20e3, pitch_rate=-40.0)
    assert (case.track.gauge, case.wheelset.radius) == (1440.0, 500.0)
    assert np.array_equal(case.wheelset.wheel.y, WHEEL.y)
    assert case.wheelset.wheel.smoothing == 5.0
    assert np.array_equal(case.track.rail.z, Profile.rail_60e1().z)


def test_a_sequence_of_both_wheels(tmp_path):
    found = read(
        tmp_path,
        'side = "both"\n'
        + CASE.replace("yaw = 1e-3", "yaw = { from = 0.0, to = 0.01, count = 3 }").replace(
            "20e3", "[1e4, 2e4, 3e4]"
        ),
    )
    assert found.numbers == (1, 1, 2, 2, 3, 3)
    assert [case.side for case in found.cases] == ["left", "right"] * 3
    assert [case.position.y for case in found.cases[::2]] == [1.0, 2.0, 900.0]
    assert [case.position.yaw for case in found.cases[::2]] == [0.0, 0.005, 0.01]
    assert [case.vertical_force for case in found.cases[1::2]] == [1e4, 2e4, 3e4]
    assert len({id(case.track) for case in found.cases}) == 1
    assert np.array_equal(found.cases[0].wheelset.wheel.z, Profile.s1002().z)


@pytest.mark.parametrize(("old", "new", "said"), [
    ('"60e1"', '"s1002"', "track.rail = 's1002' .* the name of a file beside the case file, .60e1., or a table"),
    ('"60e1"', '{ file = "60e1", smoothing = 5.0 }', "track.rail: 60e1 has no options"),
    ('"60e1"', "3", r"track.rail = 3 .* the name of a file"),
    ('rail = "60e1", ', "", "track.rail is missing"),
    ("track =", "rails =", "rails: there is no such key"),
    ("yaw", "jaw", r"position.jaw: there is no such key \(did you mean yaw\?\)"),
    ("yaw = 1e-3", "yaw = [0.0, 1e-3]", "same length.*position.y has 3, position.yaw has 2"),
    ("9e2", '"three"', "position.y"),
    ("20e3", "-20e3", "vertical_force = -20000"),
    ("dx = 1.0", "z = 0.1", "vertical_force"),
    ("dx = 1.0", 'side = "middle"', "side = 'middle'"),
    ("dx = 1.0", "wear = { k = 1e-4 }", "wear.hardness is missing"),
    ("dx = 1.0", "solve = { polish = true }", "solve.polish: there is no such key"),
    ("wheelset = ", "wheelset = 1 #", r"wheelset = 1 .* a table, \[wheelset\]"),
    ("dx = 1.0", "dx", "case file .* is not a TOML file"),
])  # fmt: skip
def test_what_a_case_cannot_be(tmp_path, old, new, said):
    with pytest.raises(SceneError, match=said):
        read(tmp_path, CASE.replace(old, new))


ONE = """
vertical_force = 20e3
dx = 1.0
dy = 1.0
position = { y = 1.0 }
wheelset = { wheel = "s1002" }
track = { rail = "60e1", cant = 0.025 }
"""
STEEL = "conductivity = 50.0, density = 7.85e-9, heat_capacity = 4.5e8"
FALLING = "kind = 'linear', static = 0.4, kinetic = 0.2, half_velocity = 30.0, velocity = 1e3"


def with_track(entries):
    return ONE.replace("0.025", f"0.025, {entries}")


def the_case(folder, text):
    (case,) = read(folder, text).cases
    return case


def test_irregularities_of_rails_are_tables(tmp_path):
    text = with_track("left = { y = 1.0, roll_rate = 0.1 }, right = { y = -2.0, roll = 0.01 }")
    track = the_case(tmp_path, text).track
    assert track.left == Irregularity(y=1.0, roll_rate=0.1)
    assert track.right == Irregularity(y=-2.0, roll=0.01)


def test_what_is_between_rail_and_wheel_is_tables(tmp_path):
    """Third body, heat and their friction: the same forces as in Python."""
    text = f"""
    third_body = {{ G = 8000.0, h = 0.02 }}
    thermal = {{ rail = {{ {STEEL} }}, wheel = {{ {STEEL}, temperature = 60.0 }} }}
    friction = {{ kind = "temperature", static = 0.4, kinetic = 0.2, over = 300.0 }}
    """
    case = the_case(tmp_path, text + ONE)
    layer = ThirdBody(h=0.02, G=8000.0)
    rail = Thermal(conductivity=50.0, density=7.85e-9, heat_capacity=4.5e8)
    wheel = dataclasses.replace(rail, temperature=60.0)
    law = TemperatureFalling(static=0.4, kinetic=0.2, over=300.0)
    assert (case.third_body, case.thermal, case.friction) == (layer, (rail, wheel), law)
    plain = the_case(tmp_path, ONE)
    python = dataclasses.replace(plain, third_body=layer, thermal=(rail, wheel), friction=law)
    found = case.solve().force
    assert np.array_equal(found, python.solve().force)
    assert not np.allclose(found, plain.solve().force, rtol=1e-3)
    assert the_case(tmp_path, f"thermal = {{ {STEEL} }}\n{ONE}").thermal == rail


@pytest.mark.parametrize(("text", "friction"), [
    ("{ kind = 'shear-strength', coefficient = 0.3, strength = 10.0 }", ShearStrength(0.3, 10.0)),
    ("{ kind = 'by_angle', angles = [0.2, 0.6], coefficients = [0.3, 0.1] }", FrictionByAngle([0.2, 0.6], [0.3, 0.1])),
])  # fmt: skip
def test_frictions_are_tables(tmp_path, text, friction):
    assert the_case(tmp_path, f"friction = {text}\n{ONE}").friction == friction


def test_a_product_of_laws_is_a_table(tmp_path):
    text = f"friction = {{ kind = 'product', static = 0.4, kinetic = 0.1, factors = [{{ {FALLING} }}] }}"
    law = the_case(tmp_path, f"{text}\n{ONE}").friction
    assert isinstance(law, FrictionLaw)
    falling = LinearFalling(static=0.4, kinetic=0.2, half_velocity=30.0, velocity=1e3)
    assert law.factors == (falling,)


def test_a_wheel_set_has_the_friction_of_each_rail(tmp_path):
    """Laws of other classes with the same numbers are other cases."""
    texts = [
        f"side = 'set'\nfriction = [0.3, {{ {FALLING.replace('linear', kind)} }}]\n{ONE}"
        for kind in ("linear", "rational")
    ]
    linear, rational = (read(tmp_path, text) for text in texts)
    falling = LinearFalling(static=0.4, kinetic=0.2, half_velocity=30.0, velocity=1e3)
    assert linear.cases[0].friction == (0.3, falling)
    assert _identities(linear) != _identities(rational)


def test_bodies_of_rail_and_wheel_are_tables(tmp_path):
    soft = "{ kind = 'viscoelastic', G = 8e4, nu = 0.3, relaxations = [[1.0, 0.01]] }"
    case = the_case(
        tmp_path, f"bodies = {{ rail = {{ G = 82e3, nu = 0.28 }}, wheel = {soft} }}\n{ONE}"
    )
    wheel = Viscoelastic(G=8e4, nu=0.3, relaxations=[(1.0, 0.01)])
    assert case.bodies.both == (Bodies(G=82e3, nu=0.28), wheel)
    elastic = "{ E = 200e3, nu = 0.25 }"
    case = the_case(
        tmp_path, f"bodies = {{ rail = {{ G = 82e3, nu = 0.28 }}, wheel = {elastic} }}\n{ONE}"
    )
    assert case.bodies == Bodies(G=(82e3, 80e3), nu=(0.28, 0.25))


def test_slices_and_several_rails_are_tables(tmp_path):
    """Two rails under one wheel, of which one sinks; and a wheel with a dent."""
    sinking = "{ profiles = ['60e1', '60e1'], positions = [-100.0, 100.0], z = [0.0, 2.0] }"
    text = ONE.replace('"60e1"', f"['60e1', {sinking}]").replace(
        '"s1002"', "{ profiles = 's1002', positions = [-0.1, 0.0, 0.1], z = [0.0, -0.1, 0.0] }"
    )
    case = the_case(tmp_path, text)
    rail, slices = case.track.rail
    assert np.array_equal(rail.z, Profile.rail_60e1().z)
    assert slices.positions.tolist() == [-100.0, 100.0]
    assert slices.z.tolist() == [0.0, 2.0]
    python = ProfileSlices(profiles=Profile.s1002(), positions=[-0.1, 0.0, 0.1], z=[0.0, -0.1, 0.0])
    wheelset = dataclasses.replace(case.wheelset, wheel=python)
    assert case.touching == dataclasses.replace(case, wheelset=wheelset).touching


def test_wear_may_have_a_map(tmp_path):
    text = "wear = { kind = 'archard-map', hardness = 3000.0 }\n"
    assert read(tmp_path, text + ONE).archard == ArchardMap(hardness=3000.0)
    assert read(tmp_path, "wear = { k = 1e-4, hardness = 3e3 }\n" + ONE).archard == Archard(
        k=1e-4, hardness=3e3
    )


@pytest.mark.parametrize(("entry", "said"), [
    ("third_body = 3", r"^third_body = 3 .* a table, \[third_body\]"),
    ("third_body = { G = -1.0, h = 0.02 }", "^third_body.G = -1.0"),
    ("third_body = { G = 8000.0, k = 0.02 }", "^third_body.k: there is no such key"),
    (f"thermal = {{ {STEEL.replace('50.0', '-50.0')} }}", "^thermal.conductivity = -50"),
    (f"thermal = {{ rail = {{ {STEEL} }} }}", "^thermal.wheel is missing"),
    (f"thermal = {{ rail = {{ {STEEL} }}, wheel = {{ {STEEL.replace('50.0', '-50.0')} }} }}", "^thermal.wheel.conductivity = -50"),
    ("bodies = { upper = { G = 82e3, nu = 0.28 } }", "^bodies.upper: there is no such key; there are rail, wheel"),
    ("bodies = { rail = { G = 82e3, nu = 0.28 }, wheel = { G = 82e3, nu = 0.7 } }", "^bodies.wheel.nu = 0.7"),
    ("bodies = { kind = 'layered', layers = [] }", "^bodies.kind = 'layered' .* viscoelastic"),
    ("friction = { kind = 'carried' }", "^friction.kind = 'carried' .* by_angle"),
    ("friction = { static = 0.3 }", "^friction.kind is missing"),
    (f"side = 'set'\nfriction = [0.3, {{ {FALLING.replace('0.2', '0.5')} }}]", r"^friction\[1\].kinetic = 0.5"),
    ("wear = { kind = 'map' }", "^wear.kind = 'map'"),
])  # fmt: skip
def test_wrong_entries_of_tables_are_named(tmp_path, entry, said):
    with pytest.raises(SceneError, match=said):
        read(tmp_path, f"{entry}\n{ONE}")


@pytest.mark.parametrize(("entry", "said"), [
    ("left = { y = 'far' }", "^track.left.y = 'far' .* a finite number"),
    ("right = { roll = 0.9 }", "^track.right.roll = 0.9"),
    ("left = { x = 1.0 }", "^track.left.x: there is no such key"),
    ("left = 1.0", r"^track.left = 1.0 .* a table, \[track.left\]"),
    ("left_rail = ['60e1', 3]", r"^track.left_rail\[1\] = 3"),
    ("left_rail = { profiles = ['60e1', 'no.csv'], positions = [0.0, 1.0] }", r"^track.left_rail.profiles\[1\] = 'no.csv'"),
    ("left_rail = { profiles = '60e1', positions = [1.0, 0.0] }", "^track.left_rail.positions: slice 2"),
])  # fmt: skip
def test_wrong_entries_of_the_track_are_named(tmp_path, entry, said):
    with pytest.raises(SceneError, match=said) as refused:
        read(tmp_path, with_track(entry))
    assert refused.value.field in str(refused.value)


@pytest.mark.long
def test_many_wheels_side_by_side_have_the_rows_of_each_alone(tmp_path):
    """Both sides, and one beside the rail among them."""
    text = CASE.replace("[1.0, 2.0, 9e2]", f"[{', '.join(f'{0.3 * k}' for k in range(20))}, 9e2]")
    found = read(tmp_path, text.replace("1e-3 }", '1e-3 }\nside = "both"\nsolve = { tol = 1e-9 }'))
    assert len(found.cases) > SIDE_BY_SIDE
    table = solve_cases(found).groupby("side")
    for k in (0, 1, 26, 27, 40, 41):
        row = table.get_group(found.cases[k].side).query(f"position == {found.numbers[k]}").iloc[0]
        if found.numbers[k] == 21:
            assert (row["outcome"], "beside the rail" in row["reason"]) == ("refused", True)
            continue
        own = found.cases[k].solve(tol=1e-9)
        (each,) = own.patches
        assert (row["outcome"], row["z"]) == ("solved", pytest.approx(own.z, abs=1e-9))
        wanted = [each.normal_force, *each.force[:2]]
        assert row[["FN", "Fx", "Fs"]].tolist() == pytest.approx(
            wanted, abs=1e-7 * each.normal_force
        )
        assert row["Mz"] == pytest.approx(each.moment, rel=1e-6)


@pytest.mark.long
def test_the_table_has_the_numbers_of_the_solution_and_goes_on(tmp_path):
    """A wheel that cannot be solved has a row with the reason; Ctrl-C keeps the finished ones; none
    is solved twice.
    """
    found, store = read(tmp_path, CASE), tmp_path / "table.csv"
    told = []

    def stopping(text):
        told.append(text)
        if len(told) == 2:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted, match="interrupted after 1 of 3 wheels") as stopped:
        solve_cases(found, store, stopping)
    assert stopped.value.partial["y"].tolist() == [1.0]
    table = solve_cases(found, store, told.append)
    assert told == [
        f"{done} of 3 wheels, y = {y} mm, right" for done, y in ((0, 1), (1, 2), (1, 2), (2, 900))
    ]
    assert tuple(table.columns) == columns(of_sets=False)
    assert table["outcome"].tolist() == ["solved", "solved", "refused"]
    assert "the wheel is beside the rail" in table["reason"][2]
    again = solve_cases(found, store, told.append)
    assert len(told) == 4
    assert again.to_csv() == table.to_csv()
    own = found.cases[1].solve()
    (each,) = own.patches
    row = table.loc[1]
    assert (row["FN"], row["Fx"], row["Fs"], row["Mz"]) == (
        each.normal_force,
        *each.force[:2],
        each.moment,
    )
    assert tuple(row[["track_Fx", "track_Fy", "track_Fz"]]) == tuple(own.force)
    assert (row["vx"], row["spin"], row["z"]) == (
        each.patch.creepage.vx,
        each.patch.creepage.spin,
        own.z,
    )
    assert row["T_gamma"] == each.solution.power


@pytest.mark.long
def test_a_table_goes_on_where_positions_come_again(tmp_path):
    """There and back: each position has its rows once, and the numbers of the case file as it is
    now.
    """
    there_and_back, store = (
        read(tmp_path, CASE.replace("[1.0, 2.0, 9e2]", "[1.0, 2.0, 1.0]")),
        tmp_path / "table.csv",
    )
    table = solve_cases(there_and_back, store)
    assert table[["position", "y"]].to_numpy().tolist() == [[1, 1.0], [2, 2.0], [3, 1.0]]
    assert solve_cases(there_and_back, store).to_csv() == table.to_csv()
    longer = read(tmp_path, CASE.replace("[1.0, 2.0, 9e2]", "[0.0, 1.0, 2.0, 1.0]"))
    assert solve_cases(longer, store)[["position", "y"]].to_numpy().tolist() == [
        [1, 0],
        [2, 1],
        [3, 2],
        [4, 1],
    ]


def interrupted(file, store, wheels):
    """Begin a table, and stop it once so many wheels are in it."""

    def stop(words):
        if words.startswith(f"{wheels} of"):
            raise KeyboardInterrupt

    with pytest.raises(Interrupted):
        solve_cases(file, store, stop)


def many_wheels(folder):
    """Wheels that are solved three side by side in two groups, of which some begin from each
    other.
    """
    positions = np.round(np.linspace(0.0, 3.6, 10), 1).tolist()
    return read(folder, CASE.replace("[1.0, 2.0, 9e2]", str(positions)))


@pytest.mark.long
def test_a_resumed_table_of_many_wheels_has_the_same_bytes(tmp_path, monkeypatch):
    """Interrupted twice, in either group."""
    monkeypatch.setattr(case_file, "GROUP", 6)
    for module in (case_file, side_by_side):
        monkeypatch.setattr(module, "SIDE_BY_SIDE", 3)
    file, store, whole = many_wheels(tmp_path), tmp_path / "table.csv", tmp_path / "whole.csv"
    solve_cases(file, whole)
    for wheels in (1, 7):
        interrupted(file, store, wheels)
    solve_cases(file, store)
    assert store.read_bytes() == whole.read_bytes()


@pytest.mark.long
def test_a_resumed_table_of_refused_and_solved_wheels_has_the_same_bytes(tmp_path):
    """Columns that have no figures yet, or whole numbers only, when the table is interrupted."""
    text = CASE.replace("[1.0, 2.0, 9e2]", "[9e2, 0, 2, 8e2]").replace("yaw = 1e-3", "yaw = 0")
    file, whole = dataclasses.replace(read(tmp_path, text), fast=True), tmp_path / "whole.csv"
    file.options.clear()
    solve_cases(file, whole)
    for wheels in (1, 2, 3):
        store = tmp_path / f"{wheels}.csv"
        interrupted(file, store, wheels)
        solve_cases(file, store)
        assert store.read_bytes() == whole.read_bytes(), wheels


def test_a_table_of_other_cases_is_refused(tmp_path):
    one = CASE.replace("[1.0, 2.0, 9e2]", "1.0")
    solve_cases(read(tmp_path, one), tmp_path / "table.csv")
    with pytest.raises(
        SceneError,
        match=r"has a wheel that is not in the case file as it is now \(position 1, y = 1 mm",
    ):
        solve_cases(read(tmp_path, "friction = 0.2" + one), tmp_path / "table.csv")


def test_the_identity_of_a_wheel_is_that_of_its_case_alone(tmp_path):
    """Whatever wheels it shares a track with, and whichever: tables are continued by it."""
    text = CASE.replace("[1.0, 2.0, 9e2]", "[1.0, 2.0, 3.0]")
    cases = list(read(tmp_path, text).cases)
    again = read(tmp_path, text)
    flatter = dataclasses.replace(cases[0].track, cant=0.02)
    cases += [dataclasses.replace(cases[0], track=flatter), again.cases[1]]
    file = dataclasses.replace(again, cases=tuple(cases), numbers=tuple(range(1, 6)))
    found = _identities(file)
    alone = [_identities(dataclasses.replace(file, cases=(each,))) for each in cases]
    assert found == [name for (name,) in alone]
    assert found[4] == found[1]
    assert len(set(found)) == 4
    assert not set(_identities(dataclasses.replace(file, options={"tol": 1e-3}))) & set(found)


def test_one_wheel_alone_says_what_is_wrong_with_it(tmp_path):
    with pytest.raises(SceneError, match="beside the rail"):
        solve_cases(read(tmp_path, CASE.replace("[1.0, 2.0, 9e2]", "900.0")))


@pytest.mark.parametrize("count", [1, 2, SIDE_BY_SIDE + 1])
def test_a_wheel_that_is_refused_keeps_its_warnings(tmp_path, count):
    """Which may say why: a gauge in metres puts wheels beside the rail. Alone, one after the other
    and side by side.
    """
    places = [0.1 * k for k in range(count)]
    text = CASE.replace("[1.0, 2.0, 9e2]", str(places)).replace("0.025", "0.025, gauge = 1.435")
    file = read(tmp_path, text)
    if count == 1:
        with (
            pytest.warns(PlausibilityWarning, match="gauge = 1.435 mm"),
            pytest.raises(SceneError, match="beside the rail"),
        ):
            solve_cases(file)
        return
    table = solve_cases(file)
    assert (table["outcome"] == "refused").all()
    assert table["warnings"].str.contains("gauge = 1.435 mm").all()


def test_options_that_wheels_do_not_have_are_refused_once(tmp_path):
    """Before any is solved for, and without a table."""
    file = read(tmp_path, CASE)
    asked = dataclasses.replace(file, options={"accuracy": 0.1})
    with pytest.raises(SceneError, match=r"^dx: the grids are chosen for the accuracy"):
        solve_cases(asked, tmp_path / "table.csv")
    assert not (tmp_path / "table.csv").exists()


def test_solutions_are_handed_on_and_their_warnings_are_in_the_table(tmp_path):
    rail = Profile.rail_60e1()
    noise = 2e-3 * np.random.default_rng(1).normal(size=rail.z.size)
    np.savetxt(tmp_path / "rough.csv", np.column_stack([rail.y, rail.z + noise]), delimiter=",")
    file = read(tmp_path, CASE.replace('"60e1"', '"rough.csv"').replace("[1.0, 2.0, 9e2]", "1.0"))
    seen = []
    table = solve_cases(file, tmp_path / "table.csv", solved=seen.append)
    assert [found.z for found in seen] == table["z"].tolist()
    assert "a profile is rough there" in table["warnings"][0]
    assert seen[0].patches[0].solution.warnings[0] in table["warnings"][0]
    solve_cases(file, tmp_path / "table.csv", solved=seen.append)
    assert len(seen) == 1  # the table had it


@pytest.mark.long
def test_the_picture_over_the_positions(tmp_path):
    table = solve_cases(read(tmp_path, CASE))
    figure = plot_positions(table)
    assert len(figure.axes) == 12
    drawn = {ax.get_ylabel(): ax.lines[0].get_ydata() for ax in figure.axes}
    solved = table[table["outcome"] == "solved"]
    assert drawn["Contact angle [mrad]"] == pytest.approx(1e3 * solved["angle"].to_numpy())
    assert figure.axes[0].lines[0].get_xdata() == pytest.approx([1.0, 2.0])
