"""The formats of profiles: each file written here in its own way gives the same profile."""

from functools import partial

import numpy as np
import pytest

from tests.scenes import refusals, refused
from tests.wheel_rail.conditions import DATA, RAIL, WHEEL
from varcontact.wheel_rail import Profile


def simpack(points, form="{:.6f} {:.6f}", kind=0, unit=1000.0, more=""):
    """A file of SIMPACK's, of a rail (0) or a wheel (1), with so many units in a metre."""
    return SIMPACK.format(type=kind, unit=unit, more=more, points=rows(points, form))


SIMPACK = """header.begin
  version  = 1
  type     = {type}
header.end
spline.begin
  approx.smooth = 0.000000
  comment       = 'a profile'
  units.len.f   = {unit}
{more}  point.begin
{points}
  point.end
spline.end
"""

MINIPROF = """Filename=rail.ban
ProgramName=MiniProf for Windows
XYPoints={n}
ColumnDef={columns}

{points}
"""


def written(path, text, encoding="utf-8"):
    path.write_text(text, encoding=encoding)
    return path


def rows(points, form="{:.6f} {:.6f}"):
    return "\n".join(form.format(*point) for point in points)


def same(profile, other, within=2e-6):
    assert profile.kind == other.kind
    assert profile.y == pytest.approx(other.y, abs=within)
    assert profile.z == pytest.approx(other.z, abs=within)


RAIL_POINTS = np.stack([RAIL.y, RAIL.z], axis=1)
WHEEL_POINTS = np.stack([WHEEL.y, WHEEL.z], axis=1)


@pytest.mark.parametrize(
    "form", ["{:.6f} {:.6f}", "{:.6f},{:.6f}", "{:.6f};{:.6f}", "{:.8e}\t{:.8e}", "  {:.6f}  {:.6f} "]
)
def test_two_columns(tmp_path, form):
    text = "# made by hand\ny z\n" + rows(RAIL_POINTS, form) + "\n\n"
    same(Profile.read(written(tmp_path / "rail.txt", text), "rail"), RAIL)


@pytest.mark.parametrize(("separator", "suffix"), [(";", "csv"), ("\t", "txt"), (" ", "dat"), (" ; ", "csv")])
def test_decimal_commas(tmp_path, separator, suffix):
    text = "y;z\n" + rows(RAIL_POINTS, "{:.6f}" + separator + "{:.6f}").replace(".", ",")
    same(Profile.read(written(tmp_path / f"rail.{suffix}", text), "rail"), RAIL)
    miniprof, (_, body) = MINIPROF.replace("rail.ban", "rail") + "\n", text.split("\n", 1)
    same(Profile.read(written(tmp_path / "r.ban", miniprof.format(n=1, columns="X,Y", points=body))), RAIL)


def test_files_of_other_programs(tmp_path):
    """Windows' ends of lines and letters, quoted numbers, remarks behind points."""
    text = rows(RAIL_POINTS, '"{:.6f}","{:.6f}"').replace("\n", "\r\n")
    same(Profile.read(written(tmp_path / "quoted.csv", "y,z\r\n" + text, "utf-8-sig"), "rail"), RAIL)
    same(Profile.read(written(tmp_path / "wide.csv", text, "utf-16"), "rail"), RAIL)
    remarks = rows(RAIL_POINTS, "{:.6f} {:.6f}  # measured")
    same(Profile.read(written(tmp_path / "remarks.txt", "60E1 new ! rail\n" + remarks), "rail"), RAIL)


def test_simpack_of_rails_and_wheels(tmp_path):
    same(Profile.read(written(tmp_path / "rail.prr", simpack(RAIL_POINTS))), RAIL)
    wheel = simpack(WHEEL_POINTS[::-1] / 1000, "{:.9f} {:.9f} 1.0", kind=1, unit=1.0)
    same(Profile.read(written(tmp_path / "wheel.prw", wheel)), WHEEL)


def test_simpack_shifts_mirrors_and_cuts_as_its_header_says(tmp_path):
    def read(points, more):
        return Profile.read(written(tmp_path / "changed.prr", simpack(points, more=more)))

    moved = "  shift.y = 2.5\n  shift.z = -1.0 ! a remark\n  mirror.y = 1\n"
    same(read(RAIL_POINTS * [-1, 1] + [-2.5, 1.0], moved), RAIL)
    cut = read(RAIL_POINTS, "  bound.y.min = -20\n  bound.y.max = 10\n")
    assert cut.y[0] >= -20
    assert cut.y[-1] <= 10
    above = float(RAIL_POINTS[:, 1].mean())
    top = read(RAIL_POINTS, f"  bound.z.max = {above}\n")
    assert 0 < len(top.y) < len(RAIL.y)
    assert np.max(top.z) <= above
    turned = read(np.stack([np.arange(-10.0, 11.0), np.zeros(21)], 1), "  rotate = 0.025\n")
    assert turned.angle_at(0.0) == pytest.approx(0.025)


def test_miniprof_old_and_new(tmp_path):
    lines = rows(RAIL_POINTS, "{:.6f}\t{:.6f}").splitlines()
    new = MINIPROF.format(n=len(lines), columns="X,Y", points="\n".join([*lines, '"  1.0\t2.0']))
    same(Profile.read(written(tmp_path / "rail.ban", new)), RAIL)
    columns = "\n".join(f"0.1, {z:.6f}, {y:.6f}, 0.5" for y, z in RAIL_POINTS)
    same(Profile.read(written(tmp_path / "c.ban", MINIPROF.format(n=1, columns="A,Y,X,C", points=columns))), RAIL)
    old = "MINIPROF 101 148 1994 3 24\nwhl.prd\nStock.......: Å\nWheel ID....:\n32.58 37.11 14.71  (Sd/Sh/qR)\n\n"
    body = rows(np.column_stack([WHEEL_POINTS, 0 * WHEEL.y]), "{:.6f} {:.6f} {:.3f}")
    same(Profile.read(written(tmp_path / "w.whl", old + body, "cp1252")), WHEEL)


def test_a_unit_of_length_by_hand(tmp_path):
    path = written(tmp_path / "inch.csv", rows(RAIL_POINTS / 25.4, "{:.9f},{:.9f}"))
    same(Profile.read(path, "rail", scale=25.4), RAIL)


def test_z_up_is_turned_when_told(tmp_path):
    path = written(tmp_path / "up.txt", rows(RAIL_POINTS * [1, -1]))
    same(Profile.read(path, "rail", mirror_z=True), RAIL)
    refused(lambda: Profile.read(path, "rail"), words="up.txt: the rail's profile is upside down")


@pytest.mark.parametrize(("name", "text", "kind", "field", "words"), [
    ("rail.stl", "solid", "rail", "path", "rail.stl: unknown format; known formats are two columns .* MiniProf"),
    ("rail.txt", "1 2\n", None, "kind", "rail.txt does not show it"),
    ("rail.prr", "1 2\n", "wheel", "kind", "by its suffix rail.prr is a rail's"),
    ("rail.prr", "1 2\n", None, "path", "rail.prr has no points; known formats"),
    ("rail.csv", "y,z\n1,2\n3\n", "rail", "path", "rail.csv, line 3: two numbers, y and z, are needed, not '3'"),
    ("rail.csv", "1,2\n3,four\n", "rail", "path", "rail.csv, line 2: .* not '3,four'"),
    ("rail.csv", "y,z\n1,5,2,5\n", "rail", "path", "rail.csv, line 2: .* not '1,5,2,5'"),
    ("rail.csv", "i,y,z\n0,1,2\n", "rail", "path", "rail.csv, line 2: .* not '0,1,2'"),
    ("rail.csv", "nan,nan\n1,2\n", "rail", "path", "rail.csv, line 1: .* not 'nan,nan'"),
    ("rail.ban", "1 2\n3 four\n", None, "path", "rail.ban, line 2: .* not '3 four'"),
    ("rail.prr", "units.len.f = 0\n", None, "path", "line 1: units.len.f must be a positive number, not '0'"),
    ("rail.prr", "shift.y = 0,5\n", None, "path", "line 1: shift.y must be a number, not '0,5'"),
    ("rail.prr", "point.begin\n1 two\npoint.end\n", None, "path", "rail.prr, line 2: .* not '1 two'"),
    ("rail.ban", "ColumnDef=X,A\n\n1 2\n", None, "path", "X and Y are needed in each line, and ColumnDef = X,A"),
    ("rail.ban", "ColumnDef=X,A,Y\n\n1 2\n", None, "path", "rail.ban: X and Y are needed in each line"),
])  # fmt: skip
def test_what_is_no_profile_is_refused(tmp_path, name, text, kind, field, words):
    refused(lambda: Profile.read(written(tmp_path / name, text), kind), field, match=words)


test_mirrors_are_true_or_false = refusals(
    ({"mirror_y": "yes"}, "^mirror_y.* true or false"),
    ({"mirror_z": "false"}, "^mirror_z.* true or false"),
    of=partial(Profile.read, DATA / "profiles" / "rail_UIC60.csv", "rail"),
)


def test_a_minus_of_a_typesetter_is_a_minus(tmp_path):
    text = rows(RAIL_POINTS).replace("-", "\N{MINUS SIGN}")
    same(Profile.read(written(tmp_path / "rail.txt", text), "rail"), RAIL)
