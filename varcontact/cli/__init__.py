"""The command line: one file a command, in the order of the help."""

from varcontact.cli.app import app
from varcontact.cli.terminal import INTERRUPTED

# isort: off
from varcontact.cli import solve, plan, compare, converge, tradeoff, sweep, scan, table, curve, wheelrail

COMMANDS = (solve, plan, compare, converge, tradeoff, sweep, scan, table, curve, wheelrail)
"""Each adds its command when it is imported."""

__all__ = ["INTERRUPTED", "app", "main"]


def main() -> None:
    """Entry point."""
    app()
