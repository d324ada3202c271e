"""The command line: one file a command, in the order of the help."""

from varcontact.cli.app import app
from varcontact.cli.terminal import INTERRUPTED

# isort: off
from varcontact.cli import solve, plan, compare, converge, tradeoff, sweep, scan, table, curve  # noqa: F401 - each adds its command
from varcontact.cli import wheelrail  # noqa: F401

__all__ = ["INTERRUPTED", "app", "main"]


def main() -> None:
    """Entry point."""
    app()
