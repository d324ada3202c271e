"""The command, as ``varcontact`` and as ``python -m varcontact``."""

import contextlib
import os
import sys


def main() -> None:
    """Entry point. After Ctrl-C the process ends at once, whatever solvers still compute in threads of their own."""
    try:
        from varcontact import cli

        cli.main()
    except KeyboardInterrupt:  # while the command line was imported
        _end()
    except SystemExit as done:
        if done.code == cli.INTERRUPTED:
            _end()
        raise


def _end() -> None:
    """End without the second or so in which the interpreter clears up, while threads go on in it."""
    with contextlib.suppress(OSError):  # a reader that has gone
        sys.stdout.flush()
        sys.stderr.flush()
    os._exit(130)


if __name__ == "__main__":
    main()
