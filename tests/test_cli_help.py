"""Help of every command, in this process: no text breaks it, and it names what can be asked for."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

import varcontact as vc
from varcontact.cli import whole_app
from varcontact.solvers.registry import normal_methods, tangential_methods
from varcontact.solving.methods import COUPLINGS, FORMULATIONS, METHODS
from varcontact.theories.on_grid import THEORIES

METHODS_PAGE = (Path(__file__).parents[1] / "docs/methods.md").read_text()
APP = whole_app()
COMMANDS = sorted(typer.main.get_command(APP).commands)


def said(*arguments):
    done = CliRunner().invoke(APP, arguments)
    assert done.exit_code == 0, done.output
    return done.stdout


@pytest.mark.long
def test_commands():
    assert {"compare", "converge", "plan", "solve", "sweep"} <= set(COMMANDS)
    assert all(f"\n  {command} " in said("--help") for command in COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_help(command):
    """Usage, every option with its words, an example."""
    text = said(command, "--help")
    assert text.splitlines()[0].split()[0] == "Usage:"
    assert f"Example: varcontact {command} " in text
    for option in typer.main.get_command(APP).commands[command].params:
        assert option.hidden or all(name in text for name in option.opts if name.startswith("--"))
        assert option.hidden or option.help.split()[0] in text


def test_brackets_are_not_markup():
    assert "[normal|]tangential[/formulation][+polish]" in said("compare", "--help")
    assert "[default: polish]" in " ".join(said("solve", "--help").split())


@pytest.mark.parametrize(
    "command", ["solve", "plan", "compare", "converge", "sweep", "scan", "curve"]
)
def test_help_fits_a_screen_and_says_where_all_methods_are(command):
    text = said(command, "--help")
    assert len(text.splitlines()) <= 45
    assert "docs/methods.md" in text


def test_the_page_names_all_methods():
    """Those of other packages as `qpsolvers:<name>`, with the names in its row."""
    every = [
        *METHODS,
        *normal_methods(),
        *tangential_methods(),
        *THEORIES,
        *COUPLINGS,
        *FORMULATIONS,
    ]
    words = {word for name in every for word in name.split(":")}
    lines = "\n".join(line for line in METHODS_PAGE.splitlines() if line.startswith("|"))
    assert not [word for word in words if f"`{word}" not in lines]


def test_version():
    assert said("--version") == f"varcontact {vc.__version__}\n"


@pytest.mark.long
def test_completion_is_installed_and_completes(tmp_path):
    """By bash itself, in a home of its own: commands, and options of a command."""
    scripts = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    inside = {"HOME": str(tmp_path), "PATH": scripts}

    def bash(commands):
        done = subprocess.run(
            ["bash", "-c", commands], env=inside, capture_output=True, text=True, check=True
        )
        return done.stdout.split()

    assert "installed" in bash("varcontact --install-completion; true")
    complete = f". {tmp_path}/.bashrc; COMP_WORDS=(varcontact {{}}); COMP_CWORD={{}}; _varcontact_completion varcontact"
    show = "; echo ${COMPREPLY[@]}"
    assert set(bash(complete.format("s", 1) + show)) == {
        name for name in COMMANDS if name.startswith("s")
    }
    assert bash(complete.format("solve --tang", 2) + show) == ["--tangential"]
