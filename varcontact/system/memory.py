"""The memory that is left, and a refusal before the work starts where it is too little."""

from __future__ import annotations

import math
from pathlib import Path

from varcontact.errors import TooLarge

SMALLER = "a grid with fewer elements would fit"
"""What would fit, where it is the grid that takes the memory."""


LITTLE = 2.0**24
"""Bytes that are there in any case: to ask takes half a millisecond, a part of a small solve that would be seen."""


def available() -> float:
    """Bytes of memory that this process can still take.

    The least of what the machine has, of what the control groups of the process leave (containers and batch systems
    set their limits there), and of what ``ulimit -v`` leaves.
    """
    import psutil

    return max(0.0, min(float(psutil.virtual_memory().available), left_by_control_groups(), _left_by_ulimit()))


def left_by_control_groups(root: Path = Path("/")) -> float:
    """Bytes that the control groups of this process leave to it, those above it included; infinite without limits."""
    left = [math.inf]
    for line in _lines(root / "proc/self/cgroup"):
        _, controllers, name = line.split(":", 2)
        if controllers not in ("", "memory"):
            continue
        top = root / "sys/fs/cgroup" / controllers
        limit, usage, files = _NAMES[controllers]
        group = Path(name.lstrip("/"))
        for folder in (top / group, *(top / each for each in group.parents)):
            most, taken = _lines(folder / limit), _lines(folder / usage)
            if most and taken and most[0] != "max":
                statistics = dict(entry.split() for entry in _lines(folder / "memory.stat"))
                dropped = int(statistics.get(files, 0))  # copies of files, which make room when it is needed
                left.append(float(most[0]) - float(taken[0]) + dropped)
    return min(left)


_NAMES = {
    "": ("memory.max", "memory.current", "inactive_file"),
    "memory": ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"),
}
"""Files of the limit and of what is taken, and the entry of `memory.stat`, by version: 2 has no controller's name."""


def _lines(path: Path) -> list[str]:
    """Lines of a small file; none where there is no such file."""
    try:
        return path.read_text().splitlines()
    except OSError:
        return []


def _left_by_ulimit() -> float:
    """Bytes of address space that are left; infinite without a limit."""
    import psutil

    try:
        import resource
    except ImportError:  # there is none on Windows
        return math.inf
    most, _ = resource.getrlimit(resource.RLIMIT_AS)
    return math.inf if most == resource.RLIM_INFINITY else float(most - psutil.Process().memory_info().vms)


def fits(size: float) -> bool:
    """Whether so many bytes are there."""
    return size < LITTLE or size <= available()


def need(what: str, size: float, fits: str) -> None:
    """Raise `TooLarge` if `size` bytes are not there."""
    if size < LITTLE:
        return
    there = available()
    if size > there:
        raise TooLarge(what, size, there, fits)
