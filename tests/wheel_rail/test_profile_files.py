"""The formats of profiles: each file written here in its own way gives the same profile."""

import os
import re
import warnings
from functools import partial

import numpy as np
import pytest

from tests.scenes import refusals, refused
from tests.wheel_rail.conditions import DATA, RAIL, WHEEL
from varcontact.wheel_rail import DoubtfulProfile, Profile, ProfileSlices


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
    "form",
    ["{:.6f} {:.6f}", "{:.6f},{:.6f}", "{:.6f};{:.6f}", "{:.8e}\t{:.8e}", "  {:.6f}  {:.6f} "],
)
def test_two_columns(tmp_path, form):
    text = "# made by hand\ny z\n" + rows(RAIL_POINTS, form) + "\n\n"
    same(Profile.read(written(tmp_path / "rail.txt", text), "rail"), RAIL)


@pytest.mark.parametrize(
    ("separator", "suffix"), [(";", "csv"), ("\t", "txt"), (" ", "dat"), (" ; ", "csv")]
)
def test_decimal_commas(tmp_path, separator, suffix):
    text = "y;z\n" + rows(RAIL_POINTS, "{:.6f}" + separator + "{:.6f}").replace(".", ",")
    same(Profile.read(written(tmp_path / f"rail.{suffix}", text), "rail"), RAIL)
    miniprof, (_, body) = MINIPROF.replace("rail.ban", "rail") + "\n", text.split("\n", 1)
    same(
        Profile.read(written(tmp_path / "r.ban", miniprof.format(n=1, columns="X,Y", points=body))),
        RAIL,
    )


def test_files_of_other_programs(tmp_path):
    """Windows' ends of lines and letters, quoted numbers, remarks behind points."""
    text = rows(RAIL_POINTS, '"{:.6f}","{:.6f}"').replace("\n", "\r\n")
    same(
        Profile.read(written(tmp_path / "quoted.csv", "y,z\r\n" + text, "utf-8-sig"), "rail"), RAIL
    )
    same(Profile.read(written(tmp_path / "wide.csv", text, "utf-16"), "rail"), RAIL)
    remarks = rows(RAIL_POINTS, "{:.6f} {:.6f}  # measured")
    same(
        Profile.read(written(tmp_path / "remarks.txt", "60E1 new ! rail\n" + remarks), "rail"), RAIL
    )


def test_simpack_of_rails_and_wheels(tmp_path):
    same(Profile.read(written(tmp_path / "rail.prr", simpack(RAIL_POINTS))), RAIL)
    wheel = simpack(WHEEL_POINTS[::-1] / 1000, "{:.9f} {:.9f} 1.0", kind=1, unit=1.0)
    same(Profile.read(written(tmp_path / "wheel.prw", wheel)), WHEEL)
    with_commas = re.sub(r"(\d)[.](\d)", r"\1,\2", wheel)
    same(Profile.read(written(tmp_path / "commas.prw", with_commas)), WHEEL)


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
    same(
        Profile.read(
            written(tmp_path / "c.ban", MINIPROF.format(n=1, columns="A,Y,X,C", points=columns))
        ),
        RAIL,
    )
    old = "MINIPROF 101 148 1994 3 24\nwhl.prd\nStock.......: Å\nWheel ID....:\n32.58 37.11 14.71  (Sd/Sh/qR)\n\n"
    body = rows(np.column_stack([WHEEL_POINTS, 0 * WHEEL.y]), "{:.6f} {:.6f} {:.3f}")
    same(Profile.read(written(tmp_path / "w.whl", old + body, "cp1252")), WHEEL)


def test_a_file_of_miniprof_with_few_of_its_points_is_doubted(tmp_path):
    """Files that CONTACT's users have lack up to 4 % of the points that their header counts."""
    lines = rows(RAIL_POINTS * [1.0, -1.0], "{:.6f}\t{:.6f}").splitlines()
    all_points = MINIPROF.format(n=len(lines), columns="X,Y", points="{points}")
    nearly = all_points.format(points="\n".join(lines[: int(0.96 * len(lines)) + 1]))
    with warnings.catch_warnings():
        warnings.filterwarnings("error", "nearly.ban: XYPoints")
        Profile.read(written(tmp_path / "nearly.ban", nearly), mirror_z=True)
    count = int(0.94 * len(lines))
    cut = all_points.format(points="\n".join(lines[:count]))
    words = f"cut.ban: XYPoints = {len(lines)}, but there are {count} points"
    with pytest.warns(DoubtfulProfile, match=words) as caught:
        Profile.read(written(tmp_path / "cut.ban", cut), mirror_z=True)
    assert {warning.filename for warning in caught} == {__file__}


@pytest.mark.parametrize("count", ["", "9" * 5000, "many"])
def test_a_count_of_points_that_is_none_is_passed_over(tmp_path, count):
    text = MINIPROF.format(n=count, columns="X,Y", points=rows(WHEEL_POINTS))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        same(Profile.read(written(tmp_path / "wheel.whl", text)), WHEEL)


def test_a_unit_of_length_by_hand(tmp_path):
    path = written(tmp_path / "inch.csv", rows(RAIL_POINTS / 25.4, "{:.9f},{:.9f}"))
    same(Profile.read(path, "rail", scale=25.4), RAIL)


def test_z_up_is_turned_when_told(tmp_path):
    path = written(tmp_path / "up.txt", rows(RAIL_POINTS * [1, -1]))
    same(Profile.read(path, "rail", mirror_z=True), RAIL)
    with pytest.warns(
        DoubtfulProfile, match="up.txt: the sign of z is changed, as the profile looks upside down"
    ):
        same(Profile.read(path, "rail"), RAIL)
    with pytest.warns(DoubtfulProfile, match="the rail's profile looks upside down"):
        as_told = Profile.read(path, "rail", mirror_z=False)
    assert as_told.z == pytest.approx(-RAIL.z, abs=2e-6)


def test_what_a_file_says_of_z_is_no_guess(tmp_path):
    """SIMPACK's header, and files that were saved here: a channel, flat at its lowest, looks upside
    down.
    """
    y = np.linspace(-12.0, 12.0, 97)
    with pytest.warns(DoubtfulProfile, match="upside down"):
        channel = Profile(y=y, z=-(np.maximum(np.abs(y) - 10.0, 0.0) ** 2), kind="rail")
    points = np.stack([channel.y, channel.z], axis=1)
    channel.save(tmp_path / "saved.csv")
    said = written(tmp_path / "said.prr", simpack(points, more="  mirror.z = 0\n"))
    for path in (tmp_path / "saved.csv", said):
        with pytest.warns(
            DoubtfulProfile, match=f"{path.name}: the rail's profile looks upside down"
        ):
            same(Profile.read(path, "rail"), channel)
    unsaid = simpack(points)
    with pytest.warns(DoubtfulProfile, match="unsaid.prr: the sign of z is changed"):
        assert Profile.read(written(tmp_path / "unsaid.prr", unsaid)).z.max() == pytest.approx(4.0)


def test_rails_of_miniprof_have_z_up_unless_that_makes_them_hollow(tmp_path):
    """A head of which the crown or one half was measured, and one with a guard rail beside it,
    too.
    """
    crown, half = RAIL_POINTS[np.abs(RAIL.y + 7.5) < 20.0], RAIL_POINTS[RAIL.y < -7.5]
    for name, points in (("head", RAIL_POINTS), ("crown", crown), ("half", half)):
        down, up = (
            written(tmp_path / f"{name}_{sign}.ban", rows(points * [1, sign])) for sign in (1, -1)
        )
        with pytest.warns(
            DoubtfulProfile, match=f"{name}_-1.ban: the sign of z is changed, as .ban has z up"
        ):
            turned = Profile.read(up)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            same(turned, Profile.read(down))
            same(turned, Profile.read(up, mirror_z=True))
    y = np.linspace(-80.0, 80.0, 321)
    # z up, a gap in the middle
    beside = np.stack([y, -48.0 * np.exp(-((y / 20.0) ** 8)) - y**2 / 4000.0], axis=1)
    with pytest.warns(DoubtfulProfile, match="z up"):
        assert Profile.read(written(tmp_path / "guard.ban", rows(beside))).z.max() == pytest.approx(
            48.0, abs=0.1
        )


CROWN_POINTS = RAIL_POINTS[np.abs(RAIL.y + 7.5) < 20.0]
CROWN = Profile(y=CROWN_POINTS[:, 0], z=CROWN_POINTS[:, 1], kind="rail")


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "words", ["# y, z up", "! y and z up [mm]", "% Z UP, y out", "# z down.csv (z up): rail"]
)
def test_words_of_a_file_give_the_direction_of_z(tmp_path, words):
    """Of a crown, whose shape does not tell it; the caller rules, and nothing turns it twice."""
    up = written(
        tmp_path / "crown.csv", words + "\n" + rows(CROWN_POINTS * [1, -1], "{:.6f},{:.6f}")
    )
    same(Profile.read(up, "rail"), CROWN)
    same(Profile.read(up, "rail", mirror_z=True), CROWN)
    assert Profile.read(up, "rail", mirror_z=False).z == pytest.approx(-CROWN.z, abs=2e-6)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "words", ["z up to 8 mm", "z up 8 mm", "z up.csv: y, z down", "z up, once; now z down"]
)
def test_other_words_do_not_turn_z(tmp_path, words):
    path = written(tmp_path / "crown.csv", f"# {words}\n" + rows(CROWN_POINTS, "{:.6f},{:.6f}"))
    for mirror_z in (None, False):
        same(Profile.read(path, "rail", mirror_z=mirror_z), CROWN)


@pytest.mark.filterwarnings("error")
def test_words_do_not_turn_z_on_top_of_a_header(tmp_path):
    """What SIMPACK's header mirrors is the profile; mirror_z=True mirrors that."""
    text = simpack(CROWN_POINTS * [1, -1], more="  mirror.z = 1\n").replace(
        "a profile", "scan, z up"
    )
    path = written(tmp_path / "crown.prr", text)
    for mirror_z in (None, False):
        same(Profile.read(path, mirror_z=mirror_z), CROWN)
    assert Profile.read(path, mirror_z=True).z == pytest.approx(-CROWN.z, abs=2e-6)


def test_a_profile_upside_down_is_not_advised_what_was_given(tmp_path):
    path = written(tmp_path / "rail.csv", rows(RAIL_POINTS))
    with pytest.warns(DoubtfulProfile, match="looks upside down: .* the other mirror_z"):
        Profile.read(path, "rail", mirror_z=True)


def test_simpack_takes_remarks(tmp_path):
    """A point taken out by hand, and a remark behind one."""
    lines = rows(RAIL_POINTS).splitlines()
    text = (
        simpack(RAIL_POINTS)
        .replace(lines[0], f"%  {lines[0]}")
        .replace(lines[5], f"{lines[5]} % dent")
    )
    read = Profile.read(written(tmp_path / "remarks.prr", text))
    same(read, Profile(y=RAIL.y[1:], z=RAIL.z[1:], kind="rail"))


OLD = """#MINIWHEELPROF
Car_T(R).whl
Stock.......:
{numbers}
(Sd/Sh/qR)

{points}
"""


@pytest.mark.parametrize(
    "numbers", ["32.58 37.11 14.71", '" 32.58 37.11 14.71', "32.58 37.11 14.71 (mm)"]
)
def test_numbers_in_a_heading_of_miniprof_are_no_points(tmp_path, numbers):
    text = OLD.format(numbers=numbers, points=rows(WHEEL_POINTS))
    same(Profile.read(written(tmp_path / "old.whl", text)), WHEEL)


@pytest.mark.parametrize("line", [0, 3, -1])
@pytest.mark.parametrize(
    "remark", ['" zig-zag pattern', "% dent = 1", "! dent", "# dent", "added by hand"]
)
def test_remarks_behind_the_numbers_of_miniprof_are_passed_over(tmp_path, line, remark):
    """The point of the first line was lost, as part of the heading."""
    lines = rows(
        np.column_stack([RAIL_POINTS, 0 * RAIL_POINTS]), "{:.6f} {:.6f} {:.1f} {:.1f}"
    ).splitlines()
    lines[line] += f"   {remark}"
    lines.insert(7, f'" {lines[7]}')
    text = MINIPROF.format(n=len(lines), columns="X,Y,A,C", points="\n".join(lines))
    same(Profile.read(written(tmp_path / "remarks.ban", text)), RAIL)


def test_a_column_that_counts_the_points_is_left_out(tmp_path):
    for first in (0, 1):
        numbered = np.column_stack([np.arange(first, first + len(RAIL_POINTS)), RAIL_POINTS])
        text = "i,y,z\n" + rows(numbered, "{:.0f},{:.6f},{:.6f}")
        same(Profile.read(written(tmp_path / "numbered.csv", text), "rail"), RAIL)
    text = text.replace("\n7,", "\n9,")
    refused(
        lambda: Profile.read(written(tmp_path / "numbered.csv", text), "rail"),
        match="line 8: .* not '9,",
    )


def test_files_of_several_profiles(tmp_path):
    """MiniProf's .mpt: of one profile it is read, several are refused, with what to do."""
    section = "[Profile{}Info]\nProgramName=any\nColumnDef=X,Y\n\n[Profile{}Points]\n{}\n\n"
    one = "[FileInfo]\nProgramName=any\n\n" + section.format(1, 1, rows(RAIL_POINTS))
    same(Profile.read(written(tmp_path / "one.mpt", one), "rail"), RAIL)
    two = written(tmp_path / "two.mpt", one + section.format(2, 2, rows(RAIL_POINTS)))
    refused(
        lambda: Profile.read(two, "rail"),
        match="two.mpt has 2 profiles: copy the lines of each into a file .ban",
    )
    refused(lambda: Profile.read(two), match="two.mpt does not show it")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="named pipes are of Unix")
@pytest.mark.parametrize("suffix", ["csv", "prr", "ban", "slcs"])
def test_named_pipes_and_devices_are_refused(tmp_path, suffix):
    """Reading them would wait for ever."""
    pipe, device = tmp_path / f"pipe.{suffix}", tmp_path / f"device.{suffix}"
    os.mkfifo(pipe)
    device.symlink_to("/dev/zero")
    reader = ProfileSlices.read if suffix == "slcs" else Profile.read
    for path in (pipe, device):
        refused(lambda path=path: reader(path, "rail"), words="is not a regular file")


@pytest.mark.parametrize(("name", "text", "kind", "field", "words"), [
    ("rail.stl", "solid", "rail", "path", "rail.stl: unknown format; known formats are two columns .* MiniProf"),
    ("rail.txt", "1 2\n", None, "kind", "rail.txt does not show it"),
    ("rail.prr", "1 2\n", "wheel", "kind", "by its suffix rail.prr is a rail's"),
    ("rail.prr", "1 2\n", None, "path", "rail.prr has no points; known formats"),
    ("rail.csv", "y,z\n1,2\n3\n", "rail", "path", "rail.csv, line 3: two numbers, y and z, are needed, not '3'"),
    ("rail.csv", "1,2\n3,four\n", "rail", "path", "rail.csv, line 2: .* not '3,four'"),
    ("rail.csv", "y,z\n1,5,2,5\n", "rail", "path", "rail.csv, line 2: .* not '1,5,2,5'"),
    ("rail.csv", "x,y,z\n3,1,2\n", "rail", "path", "rail.csv, line 2: .* not '3,1,2'"),
    ("rail.csv", "nan,nan\n1,2\n", "rail", "path", "rail.csv, line 1: .* not 'nan,nan'"),
    ("rail.csv", "y;z;n\n1,5;2;\n1,5;;2\n", "rail", "path", "rail.csv, line 3: .* not '1,5;;2'"),
    ("rail.csv", "y,z,n\n1,,2\n", "rail", "path", "rail.csv, line 2: .* not '1,,2'"),
    ("rail.csv", "1,2,good\n3,4,5\n", "rail", "path", "rail.csv, line 2: .* not '3,4,5'"),
    ("rail.ban", "1 2\n3 four\n", None, "path", "rail.ban, line 2: .* not '3 four'"),
    ("rail.prr", "units.len.f = 0\n", None, "path", "line 1: units.len.f must be a positive number, not '0'"),
    ("rail.prr", "shift.y = 0,5,1\n", None, "path", "line 1: shift.y must be a number, not '0,5,1'"),
    ("rail.prr", "point.begin\n1 two\npoint.end\n", None, "path", "rail.prr, line 2: .* not '1 two'"),
    ("rail.prr", "point.begin\n1 2\n2 3\n", None, "path", "rail.prr is cut off: point.end, .* is missing"),
    ("rail.ban", "ColumnDef=X,A\n\n1 2\n", None, "path", "X and Y are needed in each line, and ColumnDef = X,A"),
    ("rail.ban", "ColumnDef=X,A,Y\n\n1 2\n", None, "path", "rail.ban: X and Y are needed in each line"),
])  # fmt: skip
def test_what_is_no_profile_is_refused(tmp_path, name, text, kind, field, words):
    refused(lambda: Profile.read(written(tmp_path / name, text), kind), field, match=words)


@pytest.mark.parametrize("heading", ["z,y", "Z;Y", "z (mm), y (mm)", "No.,z,y"])
def test_a_heading_may_name_z_before_y(tmp_path, heading):
    text = heading + "\n" + rows(RAIL_POINTS[:, ::-1], "{:.6f},{:.6f}")
    same(Profile.read(written(tmp_path / "rail.csv", text), "rail"), RAIL)


@pytest.mark.parametrize(
    "heading",
    [
        "z down, y to the field side",
        "height z over y",
        "height z over y\ny z",
        "z y\ny [mm] z [mm]",
        "scan of the z y plane",
    ],
)
def test_prose_does_not_order_columns(tmp_path, heading):
    text = heading + "\n" + rows(RAIL_POINTS)
    same(Profile.read(written(tmp_path / "rail.csv", text), "rail"), RAIL)


@pytest.mark.parametrize(
    "heading", ["z [mm]\ty [mm]\n[mm]\t[mm]", "z_mm y_mm", "y over z\nZ,Y,flag"]
)
def test_the_last_list_of_names_orders_columns(tmp_path, heading):
    text = heading + "\n" + rows(RAIL_POINTS[:, ::-1])
    same(Profile.read(written(tmp_path / "rail.csv", text), "rail"), RAIL)


@pytest.mark.parametrize("flagged", [range(20), [100], [0, 200]])
@pytest.mark.parametrize("flag", ["x", "dent 3", "n/a"])
def test_points_with_words_behind_them_are_read(tmp_path, flagged, flag):
    """The first ones were left out as headings, those further on were refused."""
    lines = rows(RAIL_POINTS, "{:.6f};{:.6f};").splitlines()
    lines = [line + flag if k in flagged else line for k, line in enumerate(lines)]
    for text in ("y;z;flag\n" + "\n".join(lines), "\n".join(lines)):
        same(Profile.read(written(tmp_path / "rail.csv", text), "rail"), RAIL)


@pytest.mark.parametrize("empty", [";", ",", ";;", " ; ", '"","'])
def test_lines_of_separators_alone_are_empty(tmp_path, empty):
    text = f"{empty}\ny;z\n" + rows(RAIL_POINTS, "{:.6f};{:.6f}") + f"\n{empty}\n{empty}\n"
    same(Profile.read(written(tmp_path / "rail.csv", text), "rail"), RAIL)


@pytest.mark.parametrize("form", ['"{}","{}"', "{}, {}", "{} , {}", ' "{}" ;"{}"'])
def test_decimal_commas_between_commas(tmp_path, form):
    text = "y, z\n" + "\n".join(
        form.format(*(f"{value:.6f}".replace(".", ",") for value in point)) for point in RAIL_POINTS
    )
    same(Profile.read(written(tmp_path / "rail.csv", text), "rail"), RAIL)


def test_numbers_are_quoted_only_where_they_have_a_decimal_comma(tmp_path):
    lines = [f'{n},"{n * n},5"' for n in range(-12, 13)]
    found = Profile.read(written(tmp_path / "rail.csv", "\n".join(lines)), "rail")
    assert found.y == pytest.approx(np.arange(-12.0, 13.0))
    assert found.z == pytest.approx(np.arange(-12.0, 13.0) ** 2 + 0.5)


def test_both_rails_in_one_file_and_micrometres_are_refused(tmp_path):
    other = RAIL_POINTS + np.array([1500.0, 0.0])
    both = np.vstack([RAIL_POINTS, other])
    for points in (both, 1e3 * RAIL_POINTS):
        path = written(tmp_path / "rail.csv", rows(points))
        refused(lambda path=path: Profile.read(path, "rail"), "profile.y", match="give millimetres")
    same(Profile.read(path, "rail", scale=1e-3), RAIL)


test_mirrors_are_true_or_false = refusals(
    ({"mirror_y": "yes"}, "^mirror_y.* true or false"),
    ({"mirror_z": "false"}, "^mirror_z.* true or false"),
    ({"mirror_z": 0}, "^mirror_z.* true or false"),
    of=partial(Profile.read, DATA / "profiles" / "rail_UIC60.csv", "rail"),
)


def test_a_minus_of_a_typesetter_is_a_minus(tmp_path):
    text = rows(RAIL_POINTS).replace("-", "\N{MINUS SIGN}")
    same(Profile.read(written(tmp_path / "rail.txt", text), "rail"), RAIL)
