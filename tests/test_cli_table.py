"""The command ``varcontact table make``."""

import pytest

from tests.command import run
from varcontact.theories import TableBook, table_forces

SIZE = ["--least", "0.8", "--greatest", "1.25", "--ratios", "2", "--steps", "2", "--degree", "3"]


@pytest.mark.long
def test_a_book_for_other_bodies(tmp_path):
    done = run("table", "make", "--nu", "0.4", "--out", "book.nc", *SIZE, folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("76 exact solutions by the discretisation of second order")
    assert [file.name for file in tmp_path.iterdir()] == ["book.nc"]
    book = TableBook.read(tmp_path / "book.nc")
    assert table_forces(1.0, 1.0, 1.0, 1.0, (1.0, 0.0, 0.0), nu=0.4, book=book).force[0] < -0.5


@pytest.mark.parametrize(
    ("nu", "name", "words"),
    [
        (
            "0.7",
            "other.nc",
            "bodies.nu = 0.7 is not allowed: must be a Poisson's ratio in (-1, 0.5]",
        ),
        ("0.4", "book.csv", "the name must end in .nc"),
        (
            "0.4",
            "book.nc",
            "exists already and is no table book of varcontact's; name another file, or add --force",
        ),
    ],
)
def test_bad_input(tmp_path, nu, name, words):
    (tmp_path / "book.nc").write_text("words")
    done = run("table", "make", "--nu", nu, "--out", name, *SIZE, folder=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert words in done.stderr
    assert (tmp_path / "book.nc").read_text() == "words"
