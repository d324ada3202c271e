"""A solution as a web page: what it shows, what it needs, and whether its command repeats the answer."""

import html
import re
import subprocess
import sys

import pytest

import varcontact as vc


def test_page_stands_alone_and_repeats_the_answer(tmp_path):
    scene = vc.Scene(
        bodies=vc.Bodies(G=82e9, nu=0.28),
        surface=vc.Paraboloids(0.46, 0.3),
        normal_force=1e5,
        friction=0.3,
        motion=vc.Steady(vx=1e-3, spin=0.2),
        units=vc.Units(length="m", force="N"),
    )
    sol = vc.solve(scene, accuracy=0.05)
    sol.to_html(tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    assert "data:image/png;base64" in page
    assert not re.findall(r'(?:src|href)="(?!data:)', page), "it asks for another file"
    row = next(line for line in sol.report().splitlines() if "tangential force" in line)
    assert row.split("force", 1)[1].strip() in html.unescape(page)

    toml, command = (html.unescape(text) for text in re.findall("<pre>(.*?)</pre>", page, re.DOTALL))
    (tmp_path / "scene.toml").write_text(toml)
    words = [sys.executable, "-m", *command.split()]
    printed = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert row in printed


def test_only_html_and_no_foreign_file(tmp_path):
    sol = vc.solve(vc.Scene(bodies=vc.Bodies(1.0, 0.3), surface=vc.Ellipse(1.0, 1.0), normal_force=1.0))
    with pytest.raises(vc.OutputError):
        sol.to_html(tmp_path / "report.txt")
    for name in (None, 5, b"report.html", ""):
        with pytest.raises(vc.SceneError, match="path"):
            sol.to_html(name)
    other = tmp_path / "other.html"
    other.write_text("<html>mine</html>")
    with pytest.raises(vc.OutputError):
        sol.to_html(other)
    assert other.read_text() == "<html>mine</html>"
    sol.to_html(other, overwrite=True)
    sol.to_html(other)  # its own file is replaced
    assert "Normal contact" in other.read_text()


@pytest.mark.parametrize("name", ["history", "estimate", "certificate", "profile"])
def test_notebooks_show_values(name):
    from varcontact.wheel_rail import Profile

    scene = vc.Scene(
        bodies=vc.Bodies(1.0, 0.3),
        surface=vc.Ellipse(1.0, 1.0),
        normal_force=1.0,
        friction=0.3,
        motion=vc.Transient(steps=2, dq=0.2, vx=0.01),
    )
    history = vc.solve(scene, accuracy=0.1)
    last = history[-1]
    shown, value = {
        "history": (history, f"{history.rolled[-1]:.5g}"),
        "estimate": (last.error_estimate, f"{last.error_estimate.errors['Fx']:.1e}"),
        "certificate": (last.certificate, f"{last.certificate.residual:.2e}"),
        "profile": (Profile.s1002(), f"{Profile.s1002().y.size} points"),
    }[name]
    assert value in shown._repr_html_()
