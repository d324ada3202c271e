"""The command, as ``varcontact`` and as ``python -m varcontact``."""

import contextlib
import os
import sys


def main() -> None:
    """Entry point. After Ctrl-C the process ends at once, even while solvers still compute in their
    own threads.
    """
    try:
        from varcontact import cli

        cli.main()
    except KeyboardInterrupt:  # Ctrl-C while the command line is imported
        _end()
    except SystemExit as done:
        if done.code == cli.INTERRUPTED:
            _end()
        raise


def _end() -> None:
    """End without the second or so in which the interpreter clears up, while threads go on in it.

    Only semaphores of pools are taken away, by the finalizers that run at an exit (those below 0
    would wait).
    """
    if "multiprocessing.util" in sys.modules:
        sys.modules["multiprocessing.util"]._run_finalizers(0)
    with contextlib.suppress(OSError):  # the reader of a pipe has gone
        sys.stdout.flush()
        sys.stderr.flush()
    os._exit(130)


if __name__ == "__main__":
    main()
