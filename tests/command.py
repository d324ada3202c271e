"""The command line, called in this process: a new one for each call takes a second to import what
it needs.
"""

import contextlib
import io
import subprocess
import sys
from unittest import mock

from varcontact import cli


def scene_file(motion="vx = 0.05", axes=(1.0, 1.0), cells=8):
    """A scene in steady rolling, as TOML."""
    return f"""
normal_force = 1.0
friction = 0.3
[bodies]
G = 1.0
nu = 0.28
[surface]
kind = "ellipse"
a = {axes[0]}
b = {axes[1]}
[motion]
kind = "steady"
{motion}
[grid]
nx = {cells}
ny = {cells}
"""


ROLLING_SPHERES = """
normal_force = 1.0
friction = 0.3
bodies = { G = 1.0, nu = 0.28 }
surface = { kind = "paraboloids", Rx = 100.0, Ry = 100.0 }
grid = { nx = 6, ny = 6 }
motion = { kind = "steady", vx = 0.05 }
"""


def run(*arguments, folder):
    """What ``varcontact`` does with these arguments in that folder: status, output and messages, as
    of a process.
    """
    words, output, messages = ["varcontact", *map(str, arguments)], io.StringIO(), io.StringIO()
    with (
        contextlib.chdir(folder),
        contextlib.redirect_stdout(output),
        contextlib.redirect_stderr(messages),
        mock.patch.object(sys, "argv", words),
    ):
        try:
            cli.main()
            status = 0
        except SystemExit as done:
            status = done.code or 0
    return subprocess.CompletedProcess(words, status, output.getvalue(), messages.getvalue())


def assert_bad_input(done, words):
    """Assert that a call was refused, with these words and nothing printed."""
    assert (done.returncode, done.stdout) == (2, "")
    assert words in done.stderr, done.stderr
    assert "Traceback" not in done.stderr
