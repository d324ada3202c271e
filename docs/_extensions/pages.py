"""A page is a session: its blocks run from top to bottom, and print, draw and write what the page
says.

In a page, ``python`` blocks share their names; ``sh`` blocks call the command line; a ``toml``
block that begins with ``# name.toml`` is that file. A ``text`` block behind another is what that
prints, where ``...`` stands for anything.

Run: python docs/_extensions/pages.py page.md folder
"""

import contextlib
import doctest
import hashlib
import io
import os
import re
import shlex
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$(?:\s*^```text\n(.*?)^```$)?", re.MULTILINE | re.DOTALL)
LOOSE = {
    r"\d(?:\.\d+)?e-(?:0[7-9]|[1-9]\d)": "~0",
    r"-(0(?:\.0+)?)(?![\d.])": r"\1",
    r"^  time  .*": "  time",
    r"\(\d+ iterations\)": "(iterations)",
}
"""What may differ between machines, and what takes its place."""
MATCHING = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


@dataclass(frozen=True)
class Block:
    """A block of code.

    Attributes
    ----------
    language : str
    code : str
    output : str or None
        What it prints, if the page says so.
    line : int
        Of the page, on which the code begins.
    """

    language: str
    code: str
    output: str | None
    line: int


class Wrong(Exception):
    """A block does not do what its page says."""


def blocks(page: Path) -> Iterator[Block]:
    """All blocks of a page.

    Parameters
    ----------
    page : Path
    """
    text = page.read_text()
    for found in BLOCK.finditer(text):
        yield Block(found[1], found[2], found[3], text[: found.start(2)].count("\n") + 1)


def run(page: Path, begun: dict[str, Any] | None = None) -> dict[str, Any]:
    """Run a page in the current folder.

    Parameters
    ----------
    page : Path
    begun : dict, optional
        Names that a session has to begin with.

    Returns
    -------
    dict
        The names of the session.

    Raises
    ------
    Wrong
        If a block prints something else.
    """
    names = {"__name__": "__main__"} if begun is None else begun
    for block in blocks(page):
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            execute(block, page, names)
        if block.output is not None and not same(block.output, printed.getvalue()):
            raise Wrong(
                f"{page}:{block.line} prints\n{printed.getvalue()}\nin place of\n{block.output}"
            )
    return names


def stamp(text: str) -> str:
    """What tells one text from another, beside that which was made of it.

    Parameters
    ----------
    text : str
    """
    return hashlib.sha256(text.encode()).hexdigest()


def same(wanted: str, got: str) -> bool:
    """Whether texts say the same, but for seconds, iterations and numbers that are rounding errors.

    Parameters
    ----------
    wanted, got : str
    """
    for pattern, common in LOOSE.items():
        wanted, got = (re.sub(pattern, common, text, flags=re.MULTILINE) for text in (wanted, got))
    return doctest.OutputChecker().check_output(wanted, got, MATCHING)


def execute(block: Block, page: Path, names: dict[str, Any]) -> None:
    """Do what a block says, if it is code of this package.

    Parameters
    ----------
    block : Block
    page : Path
        For messages.
    names : dict
        Of the session.
    """
    if block.language == "python":
        exec(compile("\n" * (block.line - 1) + block.code, str(page), "exec"), names)
    elif block.language == "toml" and (file := re.match(r"# (\w+\.toml)\n", block.code)):
        Path(file[1]).write_text(block.code)
    elif block.language == "sh":
        for line in block.code.splitlines():
            if line.startswith("varcontact "):
                command(shlex.split(line, comments=True))


def command(words: list[str]) -> None:
    """Call the command line in this process.

    Parameters
    ----------
    words : list of str
        The command and its arguments.

    Raises
    ------
    Wrong
        With the messages of a command that fails.
    """
    from varcontact import cli

    messages = io.StringIO()
    with mock.patch.object(sys, "argv", words), contextlib.redirect_stderr(messages):
        try:
            cli.main()
        except SystemExit as done:
            if done.code:
                raise Wrong(
                    f"{' '.join(words)} ends with {done.code}: {messages.getvalue()}"
                ) from None


if __name__ == "__main__":
    page = Path(sys.argv[1]).resolve()
    os.chdir(sys.argv[2])
    run(page)
