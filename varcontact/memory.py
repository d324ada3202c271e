"""Refuse before the work starts what would not fit into memory."""

from __future__ import annotations

import os

from varcontact.errors import TooLarge


def available() -> float:
    """Bytes of memory that programs can still take; infinite where the system does not tell."""
    try:
        with open("/proc/meminfo") as lines:
            for line in lines:
                if line.startswith("MemAvailable:"):
                    return 1024.0 * int(line.split()[1])
    except OSError:
        pass
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, ValueError, OSError):
        return float("inf")


def need(what: str, size: float, fits: str) -> None:
    """Raise `TooLarge` if `size` bytes are not there."""
    there = available()
    if size > there:
        raise TooLarge(what, size, there, fits)
